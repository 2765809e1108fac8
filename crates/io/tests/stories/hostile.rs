//! Files that are cut off, garbled or made to hurt are read or refused; nothing panics.

use std::path::{Path, PathBuf};

use planwalk_io::plan::{self, PlanOptions, native};

use super::folder;

/// Where the fuzz targets keep what they learned from.
fn kept(what: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz").join(what)
}

/// Files of each target below a folder, in the order of their names.
fn files(folder: &Path) -> Vec<(String, PathBuf)> {
    let entries = |folder: &Path| {
        let mut entries: Vec<PathBuf> =
            std::fs::read_dir(folder).map(|entries| entries.map(|entry| entry.unwrap().path()).collect()).unwrap_or_default();
        entries.sort();
        entries
    };
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    entries(folder).iter().flat_map(|target| entries(target).into_iter().map(|file| (name(target), file))).collect()
}

/// Reads bytes as a file of a target, and writes what was made of it.
fn try_out(dir: &Path, target: &str, bytes: &[u8]) -> bool {
    // A map names its picture, which lies beside it.
    let name = if target == "ros_map" { "map.yaml" } else { "file" };
    std::fs::write(dir.join("map.pgm"), b"P5\n4 3\n255\n\x50\x00\x00\x00\x00\xfe\xfe\x00\x00\xcd\xfe\x00").unwrap();
    std::fs::write(dir.join(name), bytes).unwrap();
    [None, Some(0.05)].into_iter().any(|metres_per_pixel| {
        let options = PlanOptions { metres_per_pixel, ..PlanOptions::default() };
        match plan::import(&dir.join(name), &options) {
            Ok(document) => {
                std::fs::write(dir.join("again.plan.json"), native::write(&document)).unwrap();
                plan::import(&dir.join("again.plan.json"), &PlanOptions::default()).unwrap();
                true
            }
            Err(why) => {
                assert!(why.to_string().len() > 20, "{target}: {why}");
                false
            }
        }
    })
}

#[test]
fn files_of_every_format_may_be_cut_off_anywhere() {
    let (dir, seeds) = (folder(), files(&kept("seeds")));
    let mut targets: Vec<&str> = seeds.iter().map(|(target, _)| target.as_str()).collect();
    targets.dedup();
    assert_eq!(targets.len(), 10, "{targets:?}");
    for (target, path) in &seeds {
        let bytes = std::fs::read(path).unwrap();
        assert!(try_out(dir.path(), target, &bytes), "{} is whole", path.display());
        // About a hundred places in each.
        for cut in (0..bytes.len()).step_by(bytes.len() / 100 + 1) {
            try_out(dir.path(), target, &bytes[..cut]);
        }
    }
}

#[test]
fn what_fuzzing_found_stays_found() {
    let dir = folder();
    for (target, path) in files(&kept("corpus")).iter().chain(&files(&kept("found"))) {
        try_out(dir.path(), target, &std::fs::read(path).unwrap());
    }
}
