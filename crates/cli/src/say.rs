//! What does the person at the terminal see? Notes, progress with an estimate of the time left, and the summary.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The voice of a command: standard error for people, standard output for `--json`.
#[derive(Debug, Clone, Copy)]
pub struct Voice {
    /// Nothing but errors.
    pub quiet: bool,
}

impl Voice {
    /// A line for the person.
    pub fn say(self, line: &str) {
        if !self.quiet {
            stderr_line(line);
        }
    }

    /// A bar for a stage; `length` is its number of steps, if known. Nothing is drawn where no person looks.
    pub fn bar(self, stage: &str, length: Option<u64>) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let bar = length.map_or_else(ProgressBar::new_spinner, ProgressBar::new);
        bar.set_draw_target(ProgressDrawTarget::stderr());
        let template = match length {
            Some(_) => "{msg:>12} {bar:32} {pos}/{len}  {eta} left",
            None => "{msg:>12} {spinner} {pos} done in {elapsed}",
        };
        // A template of ours that does not parse is drawn in the default style.
        bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(stage.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

/// The machine's summary.
#[expect(clippy::print_stdout, reason = "what --json asked for goes to standard output")]
pub fn stdout_text(text: &str) {
    print!("{text}");
}

/// A line for the person.
#[expect(clippy::print_stderr, reason = "notes and errors go to standard error")]
pub fn stderr_line(line: &str) {
    eprintln!("{line}");
}
