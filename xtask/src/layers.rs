//! Does each crate know only what it may? The crate walls of ARCHITECTURE.md, checked against `cargo metadata`.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Each crate with the workspace crates that it may use, and those that only its tests may.
const ALLOWED: [(&str, &[&str], &[&str]); 8] = [
    ("planwalk-types", &[], &[]),
    ("planwalk-odometry", &["planwalk-types"], &["planwalk-sim"]),
    ("planwalk-locate", &["planwalk-types"], &["planwalk-sim"]),
    ("planwalk-sim", &["planwalk-types"], &[]),
    ("planwalk-io", &["planwalk-types"], &["planwalk-sim"]),
    ("planwalk", &["planwalk-types", "planwalk-odometry", "planwalk-locate"], &["planwalk-sim", "planwalk-io"]),
    (
        "planwalk-cli",
        &["planwalk-types", "planwalk-odometry", "planwalk-locate", "planwalk-io", "planwalk-sim", "planwalk"],
        &["planwalk-sim"],
    ),
    ("xtask", &["planwalk-types", "planwalk-odometry"], &[]),
];

/// Crates that touch no file, no clock, no entropy, no terminal.
const PURE: [&str; 4] = ["types", "odometry", "locate", "sim"];

/// What would touch them.
const IMPURE: [&str; 11] = [
    "std::fs",
    "std::env",
    "std::net",
    "std::process",
    "std::time",
    "Instant::now",
    "SystemTime",
    "rand::rng(",
    "thread_rng",
    "getrandom",
    "println!(",
];

/// What was checked, or every breach.
pub fn check() -> Result<String, Vec<String>> {
    let mut faults = dependency_faults().map_err(|why| vec![why])?;
    for name in PURE {
        purity_faults(&Path::new("crates").join(name).join("src"), &mut faults);
    }
    if faults.is_empty() { Ok(format!("layers: {} crates, {} of them pure, no breach", ALLOWED.len(), PURE.len())) } else { Err(faults) }
}

fn dependency_faults() -> Result<Vec<String>, String> {
    let output = Command::new(env!("CARGO")).args(["metadata", "--no-deps", "--format-version", "1"]).output();
    let output = output.map_err(|why| format!("cargo metadata did not run: {why}"))?;
    let metadata: Value = serde_json::from_slice(&output.stdout).map_err(|why| format!("cargo metadata said nothing readable: {why}"))?;
    let packages = metadata["packages"].as_array().ok_or("cargo metadata lists no packages")?;
    let names: Vec<&str> = packages.iter().filter_map(|p| p["name"].as_str()).collect();
    let mut faults: Vec<String> = Vec::new();
    for package in packages {
        let name = package["name"].as_str().unwrap_or_default();
        let Some((_, normal, test_only)) = ALLOWED.iter().find(|(n, _, _)| *n == name) else {
            faults.push(format!("{name}: not in the list of xtask/src/layers.rs; add it with what it may use"));
            continue;
        };
        for dependency in package["dependencies"].as_array().into_iter().flatten() {
            let used = dependency["name"].as_str().unwrap_or_default();
            let for_tests = dependency["kind"].as_str() == Some("dev");
            let allowed = normal.contains(&used) || (for_tests && test_only.contains(&used));
            if names.contains(&used) && !allowed {
                let kind = if for_tests { " (in its tests)" } else { "" };
                faults.push(format!("{name} must not know {used}{kind}"));
            }
        }
    }
    Ok(faults)
}

fn purity_faults(folder: &Path, faults: &mut Vec<String>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        faults.push(format!("cannot read {}; run this in the workspace's root", folder.display()));
        return;
    };
    let mut paths: Vec<_> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            purity_faults(&path, faults);
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        for (number, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            for word in IMPURE.iter().filter(|w| code.contains(**w)) {
                faults.push(format!("{}:{}: a pure crate uses {word}", path.display(), number + 1));
            }
        }
    }
}
