//! Which very file was this? SHA-256 of a file, or of everything in a folder.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// SHA-256 in lower-case hex: of a file's bytes (as `sha256sum` prints it), or of a folder.
///
/// A folder's hash covers the relative names of its files, sorted by bytes and with `/` between the parts, and for each its
/// length and contents; it does not change when the folder is moved or its files' dates change. Files are streamed.
///
/// # Errors
/// What the file system says, when a file cannot be read.
pub fn sha256_of(path: &Path) -> io::Result<String> {
    let mut hasher = Sha256::new();
    if std::fs::metadata(path)?.is_dir() {
        for (name, file) in files_below(path)? {
            hasher.update(name.as_bytes());
            hasher.update([0]);
            hasher.update(std::fs::metadata(&file)?.len().to_le_bytes());
            feed(&mut hasher, &file)?;
        }
    } else {
        feed(&mut hasher, path)?;
    }
    Ok(hex(hasher))
}

/// SHA-256 of bytes, in lower-case hex.
pub fn sha256_of_bytes(bytes: &[u8]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(bytes);
    hex(hasher)
}

fn hex(hasher: Sha256) -> String {
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn feed(hasher: &mut Sha256, path: &Path) -> io::Result<()> {
    let mut file = File::open(path)?;
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(n) => hasher.update(&buffer[..n]),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
}

/// Relative name and path of every file below `root`, sorted by name. Links to folders are not followed: they may go round.
fn files_below(root: &Path) -> io::Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    let mut folders = vec![(String::new(), root.to_path_buf())];
    while let Some((prefix, folder)) = folders.pop() {
        for entry in std::fs::read_dir(folder)? {
            let entry = entry?;
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if entry.file_type()?.is_dir() {
                folders.push((format!("{name}/"), entry.path()));
            } else if std::fs::metadata(entry.path()).is_ok_and(|m| m.is_file()) {
                found.push((name, entry.path()));
            }
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_files_hash_is_the_published_one() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("abc"), "abc").unwrap();
        // FIPS 180-2, appendix B.1.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_of(&dir.path().join("abc")).unwrap(), expected);
    }

    #[test]
    fn a_folders_hash_sees_names_and_contents_but_not_the_place() {
        let make = |files: &[(&str, &str)]| {
            let dir = tempfile::tempdir().unwrap();
            std::fs::create_dir(dir.path().join("sub")).unwrap();
            for (name, content) in files {
                std::fs::write(dir.path().join(name), content).unwrap();
            }
            sha256_of(dir.path()).unwrap()
        };
        let one = make(&[("a", "1"), ("sub/b", "2")]);
        assert_eq!(one, make(&[("sub/b", "2"), ("a", "1")]));
        assert_ne!(one, make(&[("a", "2"), ("sub/b", "1")]));
        assert_ne!(one, make(&[("c", "1"), ("sub/b", "2")]));
        assert_ne!(one, make(&[("a", "1sub/b"), ("sub/b", "2")]));
    }

    #[test]
    fn no_file_is_an_error() {
        assert_eq!(sha256_of(Path::new("no such file")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
