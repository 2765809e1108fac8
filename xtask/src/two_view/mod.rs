//! How well, and how fast, is the motion between two pictures found? `cargo xtask two-view FILE.npz`.
//!
//! The score is that of the field's benchmarks (e.g. Jin et al. 2021, "Image Matching Across Wide Baselines", IJCV): of each problem
//! the larger of rotation error and direction error, in degrees; of each scenario the area under the curve of its recall up to 5, 10
//! and 20°, in per cent. Where the camera only turned there is no direction, and the rotation counts alone.

mod problems;

use std::path::PathBuf;

use cpu_time::ProcessTime;
use nalgebra::{Matrix3, Vector2, Vector3};
use planwalk_odometry::Solver;
use planwalk_odometry::visual::two_view::{RayPair, RelativePoseOptions, estimate_relative_pose};
use planwalk_types::Seed;
use problems::Problem;
use rand::RngExt;
use serde::Serialize;

/// What is wanted.
pub struct Wish {
    file: PathBuf,
    solver: Solver,
    /// How far up is off in each picture, where the solver asks for it.
    up_noise_deg: f64,
    json: bool,
}

impl Wish {
    /// From the words behind `two-view`.
    pub fn of(words: &[&str]) -> Result<Self, String> {
        let (mut file, mut solver, mut up_noise_deg, mut json) = (None, Solver::FivePoint, 0.5, false);
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--json" => json = true,
                "--solver" => {
                    solver = match words.next() {
                        Some(&"five-point") => Solver::FivePoint,
                        Some(&"eight-point") => Solver::EightPoint,
                        Some(&"upright") => Solver::UprightThreePoint,
                        other => return Err(format!("--solver is five-point, eight-point or upright, not {other:?}")),
                    }
                }
                "--up-noise" => {
                    let degrees = words.next().and_then(|word| word.parse().ok()).filter(|degrees| (0.0..90.0).contains(degrees));
                    up_noise_deg = degrees.ok_or("--up-noise is how far up is off, in degrees")?;
                }
                option if option.starts_with('-') => {
                    return Err(format!("there is no option {option}; there are --solver, --up-noise and --json"));
                }
                path if file.is_none() => file = Some(PathBuf::from(path)),
                more => return Err(format!("one file at a time: what is {more}?")),
            }
        }
        Ok(Self { file: file.ok_or("give a file of problems: two-view FILE.npz")?, solver, up_noise_deg, json })
    }
}

/// A scenario's figures.
#[derive(Debug, Serialize)]
struct Row {
    scenario: String,
    /// Area under the recall up to 5°, per cent.
    auc5: f64,
    auc10: f64,
    auc20: f64,
    /// Time of a processor for one problem, milliseconds: the median …
    median_ms: f64,
    /// … and what 95 % stay under.
    p95_ms: f64,
}

/// A problem's error in degrees, and what it took.
struct Outcome {
    scenario: usize,
    error_deg: f64,
    cpu_ms: f64,
}

/// The table, or its JSON.
pub fn run(wish: &Wish) -> Result<String, String> {
    let all = problems::read(&wish.file)?;
    let inverse = all.camera.try_inverse().ok_or("the camera K has no inverse")?;
    let focal_px = 0.5 * (all.camera[(0, 0)] + all.camera[(1, 1)]);
    let options = RelativePoseOptions { solver: wish.solver, ..RelativePoseOptions::for_focal(focal_px) };
    let solve = |(i, problem): (usize, &Problem)| {
        let ups = Some(ups(problem, wish.up_noise_deg, &mut Seed(0).derive("up", i as u64)));
        solve(problem, &inverse, &RelativePoseOptions { ups, ..options }, Seed(0).derive("two-view", i as u64))
    };
    let outcomes: Vec<Outcome> = all.problems.iter().enumerate().map(solve).collect();
    let rows: Vec<Row> = all.scenarios.iter().enumerate().filter_map(|(i, name)| row(name, i, &outcomes)).collect();
    if wish.json { serde_json::to_string_pretty(&rows).map_err(|why| why.to_string()) } else { Ok(table(&rows)) }
}

fn solve(problem: &Problem, inverse: &Matrix3<f64>, options: &RelativePoseOptions, mut rng: planwalk_types::StreamRng) -> Outcome {
    let ray = |pixel: &Vector2<f64>| (inverse * pixel.push(1.0)).normalize();
    let pairs: Vec<RayPair> = problem.matches.iter().map(|(a, b)| RayPair { a: ray(a), b: ray(b) }).collect();
    let started = ProcessTime::now();
    let found = estimate_relative_pose(&pairs, options, &mut rng);
    let cpu_ms = 1e3 * started.elapsed().as_secs_f64();
    let error_deg = found.map_or(180.0, |fit| {
        let turn = fit.pose.rotation.angle_to(&problem.rotation).to_degrees();
        let is_turn_only = problem.translation.norm() < 1e-9;
        let direction = if is_turn_only { 0.0 } else { angle_deg(&fit.pose.direction, &problem.translation) };
        turn.max(direction)
    });
    Outcome { scenario: problem.scenario, error_deg, cpu_ms }
}

/// Which way is up in both pictures: the files do not say how the cameras were held, so the first is upright and the true turn carries it
/// over. Each is then tilted, any way, by an angle whose root mean square is this noise.
fn ups(problem: &Problem, noise_deg: f64, rng: &mut planwalk_types::StreamRng) -> [Vector3<f64>; 2] {
    [-Vector3::y(), problem.rotation * -Vector3::y()].map(|up| {
        // A square of the tilt that is spread as that of two normal numbers (Rayleigh's).
        let tilt = noise_deg.to_radians() * (-(1.0 - rng.random::<f64>()).ln()).sqrt();
        let way = rng.random_range(0.0..std::f64::consts::TAU);
        let level = up.cross(&Vector3::z()).normalize();
        (up + tilt.tan() * (level * way.cos() + up.cross(&level) * way.sin())).normalize()
    })
}

fn angle_deg(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}

fn row(name: &str, scenario: usize, outcomes: &[Outcome]) -> Option<Row> {
    let sorted = |of: fn(&Outcome) -> f64| {
        let mut values: Vec<f64> = outcomes.iter().filter(|outcome| outcome.scenario == scenario).map(of).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (errors, times) = (sorted(|outcome| outcome.error_deg), sorted(|outcome| outcome.cpu_ms));
    let quantile = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize];
    let auc = |limit| 100.0 * area_under_recall(&errors, limit);
    (!times.is_empty()).then(|| Row {
        scenario: name.to_owned(),
        auc5: auc(5.0),
        auc10: auc(10.0),
        auc20: auc(20.0),
        median_ms: quantile(0.5),
        p95_ms: quantile(0.95),
    })
}

/// Area under the share of problems (recall) over the error up to `limit`, as a share of the whole: trapezoids between the errors.
fn area_under_recall(sorted: &[f64], limit: f64) -> f64 {
    let (mut area, mut last, mut recall) = (0.0, 0.0, 0.0);
    for (i, error) in sorted.iter().copied().take_while(|error| *error < limit).enumerate() {
        let next = (i + 1) as f64 / sorted.len() as f64;
        area += (error - last) * 0.5 * (recall + next);
        (last, recall) = (error, next);
    }
    (area + (limit - last) * recall) / limit
}

fn table(rows: &[Row]) -> String {
    let head = ["scenario", "AUC@5° %", "AUC@10° %", "AUC@20° %", "median ms", "95 % ms"];
    let cells = |row: &Row| {
        let percent = |v: f64| format!("{v:.1}");
        [
            row.scenario.clone(),
            percent(row.auc5),
            percent(row.auc10),
            percent(row.auc20),
            format!("{:.2}", row.median_ms),
            format!("{:.2}", row.p95_ms),
        ]
    };
    let lines = std::iter::once(head.map(str::to_owned)).chain(rows.iter().map(cells));
    let line = |c: [String; 6]| format!("{:16} {:>9} {:>10} {:>10} {:>10} {:>8}", c[0], c[1], c[2], c[3], c[4], c[5]);
    lines.map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_under_the_recall_is_that_of_the_trapezoids() {
        // All exact: everything. All beyond: nothing. Half of them at 0: a triangle-free half, but for the first step.
        assert_eq!(area_under_recall(&[0.0, 0.0], 5.0), 1.0);
        assert_eq!(area_under_recall(&[5.0, 180.0], 5.0), 0.0);
        assert_eq!(area_under_recall(&[0.0, 180.0], 5.0), 0.5);
        // One of two at 2°: a triangle of 2 × ½ / 2, then 3 × ½.
        assert!((area_under_recall(&[2.0, 180.0], 5.0) - (0.5 + 1.5) / 5.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_understood_is_named() {
        assert!(Wish::of(&[]).is_err_and(|why| why.contains("FILE.npz")));
        assert!(Wish::of(&["a.npz", "--solver", "magic"]).is_err_and(|why| why.contains("five-point, eight-point or upright")));
        assert!(Wish::of(&["a.npz", "--fast"]).is_err_and(|why| why.contains("--fast")));
        assert!(Wish::of(&["a.npz", "--up-noise", "much"]).is_err_and(|why| why.contains("degrees")));
        let wish = Wish::of(&["a.npz", "--solver", "upright", "--up-noise", "1.5"]).unwrap();
        assert!(wish.solver == Solver::UprightThreePoint && wish.up_noise_deg == 1.5);
        let wish = Wish::of(&["--json", "a.npz", "--solver", "eight-point"]).unwrap();
        assert!(wish.json && wish.solver == Solver::EightPoint);
    }
}
