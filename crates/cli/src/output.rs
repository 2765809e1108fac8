//! Where do results go? A folder that was empty; each file appears whole or not at all.

use std::io;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// The output folder.
#[derive(Debug)]
pub struct Output {
    folder: PathBuf,
}

impl Output {
    /// Makes the folder, or takes an empty one; a full one only with `force`.
    pub fn open(folder: &Path, force: bool) -> Result<Self, Failure> {
        match std::fs::read_dir(folder) {
            Ok(mut entries) => {
                if entries.next().is_some() && !force {
                    let why = "the output folder is not empty; give a new one, or --force to write into it";
                    return Err(Failure::usage(format!("{why}\n  {}", folder.display())));
                }
            }
            Err(why) if why.kind() == io::ErrorKind::NotFound => {
                std::fs::create_dir_all(folder).map_err(|why| Failure::output(why, folder))?
            }
            Err(why) => return Err(Failure::usage(format!("the output folder cannot be used: {why}\n  {}", folder.display()))),
        }
        Ok(Self { folder: folder.to_owned() })
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
        let (part, whole) = (self.path(&format!(".{name}.part")), self.path(name));
        write(&part).map_err(|why| Failure::output(why, &whole))?;
        std::fs::rename(&part, &whole).map_err(|why| Failure::output(why, &whole))
    }
}
