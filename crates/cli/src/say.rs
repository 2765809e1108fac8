//! What does the person at the terminal see? Notes, progress with an estimate of the time left, and the summary.

use std::io::Write;
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
pub fn stdout_text(text: &str) {
    // Whoever closed the pipe does not want to read on; `print!` would panic.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}

/// A line for the person.
pub fn stderr_line(line: &str) {
    // Nobody is there to be told that nobody listens.
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
