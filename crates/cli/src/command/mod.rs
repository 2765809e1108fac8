//! One file a subcommand; what they share is here.

pub mod bench;
pub mod demo;
pub mod eval;
mod georeference;
pub mod locate;
pub mod place;
pub mod plan;
mod plan_audit;
mod plan_file;
pub mod sim;
pub mod track;
pub mod video;

use planwalk::evaluate::Timing;
use planwalk::figure::png_of;
use planwalk::result::{OptionEntry, ResultFile};

use crate::args::Common;
use crate::failure::Failure;
use crate::output::Output;
use crate::say::{self, Voice};

/// A command under way: its output folder, its voice, and the result that it writes at the end.
pub struct Task {
    /// Where files go.
    pub output: Output,
    /// Who is told.
    pub voice: Voice,
    /// What `result.json` will say.
    pub result: ResultFile,
    /// The drawing of the camera's path, where there was a video; for the report.
    pub trajectory: Option<String>,
    /// How long things took: for `timing.json`.
    pub timing: Timing,
    json: bool,
}

impl Task {
    /// Checks the output folder before any work is done.
    pub fn begin(command: &str, common: &Common) -> Result<Self, Failure> {
        let output = Output::open(&common.output, common.force)?;
        if let Some(threads) = common.threads {
            // Built once a process; a second build can only fail in tests that call commands in one process.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global();
        }
        let result = ResultFile::new(command, common.seed());
        let timing = Timing { threads: rayon::current_num_threads(), walk_s: 0.0, odometry_s: None, locate_s: None };
        Ok(Self { output, voice: Voice { quiet: common.quiet }, result, trajectory: None, timing, json: common.json })
    }

    /// Notes for the person and for `result.json`.
    pub fn note(&mut self, notes: impl IntoIterator<Item = String>) {
        for note in notes {
            self.voice.say(&format!("note: {note}"));
            self.result.notes.push(note);
        }
    }

    /// Writes down an option in force.
    pub fn option(&mut self, name: &str, value: Option<impl ToString>) {
        self.result.options.extend(value.map(|value| OptionEntry { name: name.to_owned(), value: value.to_string() }));
    }

    /// A drawing as `NAME.svg` and `NAME.png`.
    pub fn draw(&self, name: &str, svg: &str) -> Result<(), Failure> {
        self.output.write(&format!("{name}.svg"), svg)?;
        let png = png_of(svg).map_err(|why| Failure::output(why, &self.output.path(&format!("{name}.png"))))?;
        self.output.write(&format!("{name}.png"), png)
    }

    /// Writes `result.json`, and the summary where it was asked for.
    pub fn end(self) -> Result<(), Failure> {
        let json = self.result.to_json();
        self.output.write("result.json", &json)?;
        if self.timing.walk_s > 0.0 {
            // Numbers always become JSON.
            let timing = serde_json::to_string_pretty(&self.timing).unwrap_or_default();
            self.output.write("timing.json", timing + "\n")?;
        }
        if self.json {
            say::stdout_text(&json);
        }
        Ok(())
    }
}

/// What a file or folder is called in titles. A folder of frames is often just `rgb`: its parent says more.
pub fn name_of(path: &std::path::Path) -> String {
    let parts: Vec<_> = path.components().filter(|c| matches!(c, std::path::Component::Normal(_))).collect();
    let last = if path.is_dir() { 2 } else { 1 };
    let name: Vec<_> = parts[parts.len().saturating_sub(last)..].iter().map(|c| c.as_os_str().to_string_lossy()).collect();
    if name.is_empty() { path.display().to_string() } else { name.join("/") }
}
