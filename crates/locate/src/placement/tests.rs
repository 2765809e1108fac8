use super::*;
use nalgebra::Matrix3;
use planwalk_types::{Pt2, Stamp, Step, Wall};
use proptest::prelude::*;

fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Wall {
    Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) }
}

/// Two rooms and a corridor with a corner, 7 m × 5 m, coarse cells.
fn plan() -> FloorPlan {
    let walls = [
        wall(0.0, 0.0, 7.0, 0.0),
        wall(7.0, 0.0, 7.0, 5.0),
        wall(7.0, 5.0, 0.0, 5.0),
        wall(0.0, 5.0, 0.0, 0.0),
        wall(0.0, 1.5, 5.5, 1.5),
        wall(3.0, 1.5, 3.0, 5.0),
    ];
    FloorPlan::from_walls(&walls, 0.1, 0.5).unwrap()
}

fn path(legs: &[(f64, f64)]) -> Path {
    let step = |(i, (forward, turn_rad)): (usize, &(f64, f64))| Step {
        from: Stamp(i as i64),
        to: Stamp(i as i64 + 1),
        forward: *forward,
        left: 0.0,
        turn_rad: *turn_rad,
        covariance: Matrix3::zeros(),
        unit_change: 0.0,
    };
    Path { steps: legs.iter().enumerate().map(step).collect() }
}

/// A corner: 4 m ahead, left, 2 m ahead.
fn corner() -> Path {
    path(&[(4.0, std::f64::consts::FRAC_PI_2), (2.0, 0.0)])
}

fn quiet() -> impl FnMut(f64) {
    |_| {}
}

/// Starts and ends by trying everything, cell by cell: slow and plain.
fn by_trying_all(path: &Path, plan: &FloorPlan, options: &PlaceOptions) -> [Vec<bool>; 2] {
    let (width, height) = (plan.width() as i64, plan.height() as i64);
    let mut regions = [vec![false; plan.cells().len()], vec![false; plan.cells().len()]];
    let corners = points_of(path).unwrap();
    let Some(scales) = possible_scales(options, &corners, plan).unwrap() else { return regions };
    let candidates = candidates(options, &corners, scales, plan.cell_m());
    let index = |c: i64, r: i64| (c >= 0 && r >= 0 && c < width && r < height).then_some((r * width + c) as usize);
    for scale in &candidates.scales {
        for heading in &candidates.headings {
            let turn = libm::sincos(*heading);
            let cells: Vec<_> = candidates.points.iter().map(|p| search::offset(*p, turn, scale / plan.cell_m())).collect();
            for start in (0..plan.cells().len()).filter(|i| may_start(plan, options, *i)) {
                let (column, row) = (start as i64 % width, start as i64 / width);
                let at = |(dx, dy): &(i64, i64)| index(column + dx, row + dy);
                if cells.iter().all(|cell| at(cell).is_some_and(|i| may_pass(plan, options, i))) {
                    regions[0][start] = true;
                    regions[1][cells.last().and_then(at).unwrap()] = true;
                }
            }
        }
    }
    regions
}

#[test]
fn the_bounds_agree_with_trying_everything() {
    let options = PlaceOptions { heading_step_rad: 0.1, scales: (0.8, 1.2), scale_ratio: 1.05, inside: 0.0, ..Default::default() };
    let placement = place(&corner(), &plan(), &options, &mut quiet()).unwrap();
    let [starts, ends] = by_trying_all(&corner(), &plan(), &options);
    assert!(starts.iter().any(|r| *r), "a test that finds nothing tests nothing");
    assert!(placement.start_region == starts && placement.end_region == ends);
}

/// Random walls in a 4 m × 3 m building, some of the floor unknown.
fn random_plan(walls: &[(f64, f64, f64, f64)], unknown: usize) -> FloorPlan {
    let mut all = vec![wall(0.0, 0.0, 4.0, 0.0), wall(4.0, 0.0, 4.0, 3.0), wall(4.0, 3.0, 0.0, 3.0), wall(0.0, 3.0, 0.0, 0.0)];
    all.extend(walls.iter().map(|(x, y, dx, dy)| wall(*x, *y, x + dx, y + dy)));
    let plan = FloorPlan::from_walls(&all, 0.1, 0.4).unwrap();
    let cell = |(i, cell): (usize, &Cell)| if *cell == Cell::Free && i % 97 < unknown { Cell::Unknown } else { *cell };
    let cells = plan.cells().iter().enumerate().map(cell).collect();
    FloorPlan::new(plan.origin(), plan.cell_m(), plan.width(), plan.height(), cells).unwrap()
}

/// Angles within what drift allows over any stretch of a walk: a random walk of small turns, tamed to the law.
fn drifting(turns: &[f64], step_m: f64, drift: f64) -> Vec<f64> {
    let mut errors = vec![0.0];
    for turn in turns {
        let k = errors.len();
        // Whatever would break the law against an earlier moment is cut back to it.
        let (low, high) = errors.iter().enumerate().fold((f64::NEG_INFINITY, f64::INFINITY), |(low, high), (i, e)| {
            let most = 0.999 * drift * ((k - i) as f64 * step_m).sqrt();
            (low.max(e - most), high.min(e + most))
        });
        errors.push((errors[k - 1] + turn).clamp(low, high.max(low)));
    }
    errors
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn the_bounds_agree_with_trying_everything_on_random_plans(
        walls in prop::collection::vec((0.0..4.0f64, 0.0..3.0f64, -2.0..2.0f64, -2.0..2.0f64), 0..6),
        legs in prop::collection::vec((0.1..1.5f64, -2.0..2.0f64), 1..6),
        unknown in 0..6usize,
        heading in prop::option::of(-3.0..3.0f64),
        high in 0.7..1.4f64,
    ) {
        let plan = random_plan(&walls, unknown);
        let options = PlaceOptions { heading_rad: heading, scales: (0.7, high), heading_step_rad: 0.3, inside: 0.3, ..Default::default() };
        let placement = place(&path(&legs), &plan, &options, &mut quiet()).unwrap();
        let [starts, ends] = by_trying_all(&path(&legs), &plan, &options);
        prop_assert!(placement.start_region == starts, "starts differ");
        prop_assert!(placement.end_region == ends, "ends differ");
    }

    #[test]
    fn no_walk_within_the_tolerance_is_missed(
        walls in prop::collection::vec((0.0..4.0f64, 0.0..3.0f64, -2.0..2.0f64, -2.0..2.0f64), 0..5),
        start in (0.2..3.8f64, 0.2..2.8f64, -3.1..3.1f64),
        turns in prop::collection::vec(-0.5..0.5f64, 20..120),
        noise in prop::collection::vec((-0.2..0.2f64, -1.0..1.0f64), 120),
        drift_deg in prop::sample::select(vec![0.0, 1.5, 4.0, 8.0]),
        length_error in prop::sample::select(vec![0.0, 0.05, 0.2]),
        scale in 0.95..1.05f64,
        known in any::<bool>(),
    ) {
        let (plan, drift) = (random_plan(&walls, 0), f64::to_radians(drift_deg));
        let step_m = 0.05;
        let (mut x, mut y, mut heading) = start;
        let errors = drifting(&noise[..turns.len()].iter().map(|n| n.0).collect::<Vec<_>>(), step_m, drift);
        // What the walker does, and what the odometry says of it: as it was, but for its error of heading, of length and its unit.
        let mut said = Vec::new();
        let free = |x: f64, y: f64| plan.at(Pt2::new(x, y)) == Cell::Free;
        prop_assume!(free(x, y));
        let (first, mut moved) = (heading, 0);
        for (i, turn) in turns.iter().enumerate() {
            let next = (x + step_m * heading.cos(), y + step_m * heading.sin());
            // At a wall the walker stands still and turns on.
            let blocked = (0..=10).any(|k| !free(x + (next.0 - x) * f64::from(k) / 10.0, y + (next.1 - y) * f64::from(k) / 10.0));
            let forward = if blocked { 0.0 } else { step_m / scale / (1.0 + length_error * noise[i].1) };
            heading += turn;
            if blocked {
                said.push((forward, *turn));
            } else {
                // Drift is a matter of metres: it rests where the walker does.
                (x, y) = next;
                moved += 1;
                said.push((forward, turn - (errors[moved] - errors[moved - 1])));
            }
        }
        let tolerance = Tolerance { drift_rad_per_sqrt_m: drift, length_error };
        prop_assume!(!tolerance.is_none());
        let options = PlaceOptions { scales: (0.95, 1.05), inside: 0.0, tolerance, heading_rad: known.then_some(first), ..Default::default() };
        let placement = place(&path(&said), &plan, &options, &mut quiet()).unwrap();
        let held = |region: &[bool], x: f64, y: f64| {
            let (column, row) = plan.cell_at(Pt2::new(x, y)).unwrap();
            region[row * plan.width() + column]
        };
        prop_assert!(held(&placement.start_region, start.0, start.1), "the start is lost");
        prop_assert!(held(&placement.end_region, x, y), "the end is lost");
    }
}

#[test]
fn the_true_start_is_in_the_region_and_the_corner_has_one_place() {
    let plan = plan();
    // From the corridor's left end, 5.5 m along it, then left through the gap and up.
    let walk = path(&[(5.5, std::f64::consts::FRAC_PI_2), (2.5, 0.0)]);
    let placement = place(&walk, &plan, &PlaceOptions { heading_rad: Some(0.0), ..Default::default() }, &mut quiet()).unwrap();
    let (column, row) = plan.cell_at(Pt2::new(0.7, 0.7)).unwrap();
    assert!(placement.start_region[row * plan.width() + column]);
    assert_eq!((placement.modes.len(), placement.end_modes.len()), (1, 1), "{:?}", placement.modes);
    let mode = placement.modes[0];
    assert!(mode.pose.origin().distance(Pt2::new(0.8, 0.75)) < 0.6, "{mode:?}");
    assert!((mode.share - 1.0).abs() < 1e-12);
    let end = placement.end_modes[0].pose;
    assert!(end.origin().distance(Pt2::new(6.3, 3.25)) < 0.6 && (end.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{end:?}");
    // The example is a placement and not a mean of them.
    let (column, row) = plan.cell_at(mode.example.origin()).unwrap();
    assert!(placement.start_region[row * plan.width() + column]);
    let area = placement.start_region.iter().filter(|r| **r).count() as f64 * 0.01;
    assert!((placement.area_m2 - area).abs() < 1e-9);
}

#[test]
fn more_tolerance_means_more_places_and_walls_still_count() {
    let walk = path(&[(5.5, std::f64::consts::FRAC_PI_2), (2.5, 0.0)]);
    let areas = [(0.0, 0.01), (1.0, 0.01), (1.0, 0.04)].map(|(drift_deg, length_error)| {
        let tolerance = Tolerance { drift_rad_per_sqrt_m: f64::to_radians(drift_deg), length_error };
        let options = PlaceOptions { heading_rad: Some(0.0), tolerance, ..Default::default() };
        place(&walk, &plan(), &options, &mut quiet()).unwrap().area_m2
    });
    assert!(areas[0] > 0.0 && areas[0] < areas[1] && areas[1] < areas[2], "{areas:?}");
    // Of 27 m² of floor.
    assert!(areas[2] < 13.0, "{areas:?}");
}

#[test]
fn a_walk_longer_than_the_building_has_no_place() {
    let placement = place(&path(&[(30.0, 0.0)]), &plan(), &PlaceOptions::default(), &mut quiet()).unwrap();
    assert!(placement.modes.is_empty() && placement.area_m2 == 0.0 && placement.end_area_m2 == 0.0);
    let scaled = PlaceOptions { scales: (0.05, 1.0), ..Default::default() };
    let placement = place(&path(&[(30.0, 0.0)]), &plan(), &scaled, &mut quiet()).unwrap();
    assert!(placement.area_m2 > 0.0, "at a small enough scale it fits");
    assert!(placement.modes.iter().all(|m| m.scale < 0.25), "{:?}", placement.modes);
}

#[test]
fn what_cannot_be_tried_is_refused() {
    let run = |path: &Path, scales: (f64, f64)| place(path, &plan(), &PlaceOptions { scales, ..Default::default() }, &mut quiet());
    assert!(matches!(run(&Path::default(), (1.0, 1.0)), Err(LocateError::EmptyPath { .. })));
    assert!(matches!(run(&path(&[(f64::NAN, 0.0)]), (1.0, 1.0)), Err(LocateError::NotFinite { index: 0 })));
    assert!(matches!(run(&corner(), (2.0, 1.0)), Err(LocateError::BadScaleRange { .. })));
    assert!(matches!(run(&corner(), (f64::NAN, 1.0)), Err(LocateError::BadScaleRange { .. })));
    for (drift_rad_per_sqrt_m, length_error) in [(f64::NAN, 0.0), (9.0, 0.0), (0.0, -0.1), (0.0, 0.9)] {
        let options = PlaceOptions { tolerance: Tolerance { drift_rad_per_sqrt_m, length_error }, ..Default::default() };
        assert!(matches!(place(&corner(), &plan(), &options, &mut quiet()), Err(LocateError::BadTolerance { .. })));
    }
}

#[test]
fn progress_ends_at_one_and_threads_do_not_matter() {
    let options = PlaceOptions { scales: (0.9, 1.1), ..Default::default() };
    let on = |threads: usize, options: &PlaceOptions| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut last = 0.0;
        let placement = pool.install(|| place(&corner(), &plan(), options, &mut |share| last = share).unwrap());
        assert!((last - 1.0f64).abs() < 1e-12, "{last}");
        placement
    };
    assert_eq!(on(1, &options), on(3, &options));
    let drifting = PlaceOptions { tolerance: Tolerance { drift_rad_per_sqrt_m: 0.02, length_error: 0.02 }, ..options };
    assert_eq!(on(1, &drifting), on(3, &drifting));
}
