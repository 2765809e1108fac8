//! Where do results go? A folder that was empty; each file appears whole or not at all.

use std::cell::Cell;
use std::io;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// The output folder.
#[derive(Debug)]
pub struct Output {
    folder: PathBuf,
    /// Whether results of an earlier run may still lie there.
    stale: Cell<bool>,
}

/// Results that would contradict those of another run. Files that may be somebody's input (odometry, sightings, cameras, plans,
/// truths) are not among them: they are only ever overwritten.
const RESULTS: [&str; 25] = [
    "result.json",
    "timing.json",
    "track.csv",
    "filter.csv",
    "track.tum",
    "track.svg",
    "track.png",
    "trajectory.svg",
    "trajectory.png",
    "particles.svg",
    "particles.png",
    "place.svg",
    "place.png",
    "plan_info.json",
    "ambiguity.svg",
    "ambiguity.png",
    "report.html",
    "eval.json",
    "eval-curves.csv",
    "eval-error.svg",
    "eval-error.png",
    "eval-calibration.svg",
    "eval-calibration.png",
    "eval-odometry.svg",
    "eval-odometry.png",
];

impl Output {
    /// Makes the folder, or takes an empty one; a full one only with `force`.
    pub fn open(folder: &Path, force: bool) -> Result<Self, Failure> {
        let mut stale = false;
        match std::fs::read_dir(folder) {
            Ok(mut entries) => {
                stale = entries.next().is_some();
                if stale && !force {
                    let why = "the output folder is not empty; give a new one, or --force to write into it";
                    return Err(Failure::usage(format!("{why}\n  {}", folder.display())));
                }
            }
            Err(why) if why.kind() == io::ErrorKind::NotFound => {
                std::fs::create_dir_all(folder).map_err(|why| Failure::output(why, folder))?
            }
            Err(why) => return Err(Failure::usage(format!("the output folder cannot be used: {why}\n  {}", folder.display()))),
        }
        Ok(Self { folder: folder.to_owned(), stale: Cell::new(stale) })
    }

    /// Takes a folder as it is, or makes it: what is written goes beside what is there.
    pub fn beside(folder: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(|why| Failure::output(why, folder))?;
        Ok(Self { folder: folder.to_owned(), stale: Cell::new(false) })
    }

    /// Removes the results of an earlier run, so that two runs do not mix; only once there is something to put in their place,
    /// so that a mistyped input costs no result.
    fn clear(&self) -> Result<(), Failure> {
        if !self.stale.replace(false) {
            return Ok(());
        }
        for path in RESULTS.map(|name| self.path(name)) {
            match std::fs::remove_file(&path) {
                Err(why) if why.kind() != io::ErrorKind::NotFound => return Err(Failure::output(why, &path)),
                _ => (),
            }
        }
        Ok(())
    }

    /// Path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file: first beside its place, then moved there, so that an interrupted run leaves no half file.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
        self.write_by(name, |path| std::fs::write(path, bytes.as_ref()))
    }

    /// As [`Output::write`], by a writer that wants a path.
    pub fn write_by<E: std::fmt::Display>(&self, name: &str, write: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), Failure> {
        self.clear()?;
        let (part, whole) = (self.path(&format!(".{name}.part")), self.path(name));
        write(&part).map_err(|why| Failure::output(why, &whole))?;
        std::fs::rename(&part, &whole).map_err(|why| Failure::output(why, &whole))
    }
}
