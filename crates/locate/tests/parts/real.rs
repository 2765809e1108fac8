//! Real paths on a real plan, with simulated drift (`simulated_hilti`). Skipped where the data is not there.

use std::path::PathBuf;

use planwalk_locate::{LocateOptions, ScalePrior, localize};
use planwalk_types::path::StepNoise;
use planwalk_types::{Body, Cell, FloorPlan, Odom, Pt2, Rigid3, Seed, Sighting, Stamp, Status, Trajectory};

/// The data folder; `None` (said on stderr) where it is absent and not required.
fn data() -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let folder = PathBuf::from(std::env::var("PLANWALK_DATA").unwrap_or_else(|_| default.to_string()));
    if folder.join("simulated_hilti").is_dir() {
        return Some(folder);
    }
    let required = std::env::var("PLANWALK_REQUIRE_DATA").is_ok_and(|v| v == "1");
    assert!(!required, "PLANWALK_REQUIRE_DATA=1, but there is no simulated_hilti in {}", folder.display());
    #[expect(clippy::print_stderr, reason = "a skipped test says so")]
    {
        eprintln!("skipped: no simulated_hilti in {}", folder.display());
    }
    None
}

fn numbers(line: &str, separator: char) -> Vec<f64> {
    line.split(separator).filter_map(|v| v.trim().parse().ok()).collect()
}

fn poses(file: &std::path::Path) -> Vec<(Stamp, Rigid3<Odom, Body>)> {
    let text = std::fs::read_to_string(file).unwrap();
    let rows = text.lines().map(|line| numbers(line, ' ')).filter(|v| v.len() == 8);
    rows.map(|v| {
        let rotation = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(v[7], v[4], v[5], v[6]));
        (Stamp::from_secs(v[0]).unwrap(), Rigid3::from_parts(nalgebra::Vector3::new(v[1], v[2], v[3]), rotation))
    })
    .collect()
}

/// The plan at 5 cm: a cell is wall where any of its 25 pixels is.
fn plan(file: &std::path::Path) -> FloorPlan {
    let image = image::open(file).unwrap().to_luma8();
    let (width, height) = (image.width() / 5, image.height() / 5);
    let mut cells = vec![Cell::Free; (width * height) as usize];
    for (u, v, pixel) in image.enumerate_pixels() {
        let (column, row) = (u / 5, height.saturating_sub(1 + v / 5));
        if pixel.0[0] < 128 && column < width && v / 5 < height {
            cells[(row * width + column) as usize] = Cell::Wall;
        }
    }
    FloorPlan::new(Pt2::new(0.0, 0.0), 0.05, width as usize, height as usize, cells).unwrap()
}

struct Real {
    plan: FloorPlan,
    path: planwalk_types::Path,
    sightings: Vec<Sighting>,
    end: (f64, f64),
}

/// The first `seconds` of floor 2.
fn floor_2(seconds: f64) -> Option<Real> {
    let data = data()?;
    let base = data.join("simulated_hilti");
    let name = "floor_2_2025-10-28_run_1_seed2";
    let mut odometry = poses(&base.join(format!("{name}.tum")));
    odometry.retain(|p| p.0.as_secs() <= seconds);
    let truth = poses(&base.join(format!("{name}.truth.tum")));
    let end = truth.iter().take_while(|p| p.0.as_secs() <= seconds).last().map(|p| (p.1.iso.translation.x, p.1.iso.translation.y))?;
    let text = std::fs::read_to_string(base.join(format!("{name}.csv"))).unwrap();
    let rows = text.lines().map(|line| numbers(line, ',')).filter(|v| v.len() == 4);
    let sightings =
        rows.map(|v| Sighting { stamp: Stamp::from_secs(v[0]).unwrap(), bearing_rad: v[1], range: v[2], sigma: v[3] }).collect();
    let path = Trajectory::new(odometry).unwrap().to_path(&StepNoise::default());
    Some(Real { plan: plan(&data.join("hilti_trimble_2026/floorplans/masks_with_windows/floor_2.png")), path, sightings, end })
}

const PRIOR: ScalePrior = ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.3 };

#[test]
fn thirty_metres_on_a_real_floor_find_the_place() {
    let Some(real) = floor_2(22.0) else { return };
    let options = LocateOptions { particles_max: 300_000, ..LocateOptions::new(Seed(1), PRIOR) };
    let found = localize(&real.path, &real.sightings, &real.plan, &options, &mut |_| {}).unwrap();
    let end = &found.filter[found.filter.len() - 1];
    let off = (end.pose.x - real.end.0).hypot(end.pose.y - real.end.1);
    assert_eq!(found.status, Status::Tracking, "{:?}", found.quality);
    assert!(off < 0.5, "{off} m off");
}

#[test]
fn without_sightings_scale_does_not_sink_and_no_place_is_believed() {
    let Some(real) = floor_2(60.0) else { return };
    let options = LocateOptions { particles_max: 50_000, ..LocateOptions::new(Seed(1), PRIOR) };
    let found = localize(&real.path, &[], &real.plan, &options, &mut |_| {}).unwrap();
    // With walls that simply kill, it sank to 0.6 here: a sigma and a half of the prior.
    assert!(found.scale.metres_per_unit > 0.85, "{:?}", found.scale);
    assert!(found.filter.iter().all(|e| e.status != Status::Tracking));
}
