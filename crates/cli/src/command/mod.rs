//! One file a subcommand; what they share is here.

pub mod demo;
pub mod locate;
pub mod place;
pub mod track;
pub mod video;

use planwalk::figure::png_of;
use planwalk::result::ResultFile;

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
        Ok(Self { output, voice: Voice { quiet: common.quiet }, result, json: common.json })
    }

    /// Notes for the person and for `result.json`.
    pub fn note(&mut self, notes: impl IntoIterator<Item = String>) {
        for note in notes {
            self.voice.say(&format!("note: {note}"));
            self.result.notes.push(note);
        }
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
        if self.json {
            say::stdout_text(&json);
        }
        Ok(())
    }
}

/// The last part of a path, for titles.
pub fn name_of(path: &std::path::Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}
