//! What localisation promises, one claim a test: simulated walks with known truth, then real plans.

use nalgebra::Matrix3;
use planwalk_locate::{
    ContradictedKind, Localization, Localizer, LocateError, LocateOptions, PlaceOptions, ScalePrior, StartPrior, localize,
    localize_observed, place,
};
use planwalk_types::path::StepNoise;
use planwalk_types::{
    Cell, FloorPlan, Odom, OdometryScale, Path, PlanPose, Pt2, Rigid2, Seed, Sighting, Stamp, Status, Step, Wall, wrap_angle,
};
use rand::Rng;

#[path = "parts/report.rs"]
mod report;

#[path = "parts/real.rs"]
mod real;

/// Metres in a unit of the simulated odometry.
const SCALE: f64 = 1.25;

fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Wall {
    Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) }
}

/// An office of 16 m × 10 m: a corridor, rooms of different widths on both sides, doors, no symmetry.
fn office() -> FloorPlan {
    let mut walls = vec![wall(0.0, 0.0, 16.0, 0.0), wall(16.0, 0.0, 16.0, 10.0), wall(16.0, 10.0, 0.0, 10.0), wall(0.0, 10.0, 0.0, 0.0)];
    let doors = |y: f64, xs: &[(f64, f64)]| xs.iter().map(|(a, b)| wall(*a, y, *b, y)).collect::<Vec<_>>();
    walls.extend(doors(4.0, &[(0.0, 1.5), (2.5, 7.0), (8.0, 12.5), (13.5, 16.0)]));
    walls.extend(doors(5.8, &[(0.0, 4.0), (5.0, 10.2), (11.2, 16.0)]));
    walls.extend([wall(4.2, 0.0, 4.2, 4.0), wall(10.6, 0.0, 10.6, 4.0), wall(6.5, 5.8, 6.5, 10.0), wall(12.8, 5.8, 12.8, 10.0)]);
    FloorPlan::from_walls(&walls, 0.1, 1.0).unwrap()
}

/// A walk through the office: out of a room, along the corridor, into another room and back.
const WALK: [(f64, f64); 9] =
    [(1.0, 1.0), (2.0, 2.5), (2.0, 4.9), (7.5, 4.9), (7.5, 2.0), (9.5, 1.0), (7.5, 4.9), (10.7, 4.9), (10.7, 8.5)];

struct Walk {
    path: Path,
    sightings: Vec<Sighting>,
    truth: Vec<PlanPose>,
}

/// What is simulated and how badly.
#[derive(Clone, Copy)]
struct World {
    /// Frames a second.
    rate: f64,
    /// Share of sightings that stop short on furniture.
    clutter: f64,
    /// Heading drift, radians per √m.
    drift: f64,
}

const WORLD: World = World { rate: 5.0, clutter: 0.4, drift: 0.005 };

fn uniform(rng: &mut impl Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

fn normal(rng: &mut impl Rng) -> f64 {
    let (u, v) = (1.0 - uniform(rng), uniform(rng));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Metres to the first wall, looked up every centimetre.
fn cast(plan: &FloorPlan, x: f64, y: f64, angle: f64) -> f64 {
    let mut range = 0.0;
    while range < 12.0 && plan.at(Pt2::new(x + range * angle.cos(), y + range * angle.sin())) != Cell::Wall {
        range += 0.01;
    }
    range
}

/// Poses at 1 m/s through the corners; turns take 0.1 s a 10°.
fn poses(corners: &[(f64, f64)], rate: f64) -> Vec<PlanPose> {
    let mut poses: Vec<PlanPose> = Vec::new();
    for pair in corners.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let heading = (y1 - y0).atan2(x1 - x0);
        if let Some(last) = poses.last().copied() {
            let turn = wrap_angle(heading - last.heading_rad);
            let frames = (turn.abs().to_degrees() / 100.0 * rate).ceil();
            for i in 1..frames as usize {
                poses.push(PlanPose::new(x0, y0, last.heading_rad + turn * i as f64 / frames));
            }
        }
        let frames = ((x1 - x0).hypot(y1 - y0) * rate).ceil();
        for i in 0..=frames as usize {
            let t = i as f64 / frames;
            poses.push(PlanPose::new(x0 + t * (x1 - x0), y0 + t * (y1 - y0), heading));
        }
    }
    poses
}

/// Simulated odometry of unit 1/SCALE m, and sightings of what `seen` shows.
fn walk(corners: &[(f64, f64)], seen: &FloorPlan, world: World, seed: u64) -> Walk {
    let mut rng = Seed(seed).derive("simulated walk", 0);
    let truth = poses(corners, world.rate);
    let at = |i: usize| Stamp((i as f64 / world.rate * 1e9) as i64);
    let mut path = Path::default();
    let mut sightings = Vec::new();
    for (i, pair) in truth.windows(2).enumerate() {
        let moved = pair[0].inverse() * pair[1];
        let (length, noise) = (moved.x.hypot(moved.y), 1.0 + 0.02 * normal(&mut rng));
        let turn = moved.heading_rad + world.drift * length.sqrt() * normal(&mut rng) + 0.01 * moved.heading_rad * normal(&mut rng);
        path.steps.push(StepNoise::default().step(at(i), at(i + 1), noise * moved.x / SCALE, noise * moved.y / SCALE, turn));
    }
    for (i, pose) in truth.iter().enumerate().step_by((world.rate / 2.5) as usize) {
        for k in 0..20 {
            let bearing_rad = (f64::from(k) - 9.5) * 3f64.to_radians();
            let mut range = cast(seen, pose.x, pose.y, pose.heading_rad + bearing_rad);
            if uniform(&mut rng) < world.clutter {
                range *= 0.1 + 0.85 * uniform(&mut rng);
            }
            let range = (range / SCALE * (1.0 + 0.04 * normal(&mut rng))).max(0.05);
            sightings.push(Sighting { stamp: at(i), bearing_rad, range, sigma: 0.04 * range });
        }
    }
    Walk { path, sightings, truth }
}

fn options(seed: u64) -> LocateOptions {
    thrifty(LocateOptions::new(Seed(seed), ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.3 }))
}

/// Fewer particles than by default: the simulated floors are small, and the tests many.
fn thrifty(options: LocateOptions) -> LocateOptions {
    LocateOptions { particles_per_m2: 400.0, particles_min: 2000, ..options }
}

fn run(walk: &Walk, plan: &FloorPlan, options: &LocateOptions) -> Localization {
    localize(&walk.path, &walk.sightings, plan, options, &mut |_| {}).unwrap()
}

fn blind(walk: &Walk, plan: &FloorPlan, options: &LocateOptions) -> Localization {
    localize(&walk.path, &[], plan, options, &mut |_| {}).unwrap()
}

fn start_of(walk: &Walk) -> StartPrior {
    let pose = walk.truth[0];
    StartPrior { x: pose.x, y: pose.y, heading_rad: Some(pose.heading_rad), sigma_m: 0.3, sigma_rad: 0.1 }
}

fn off(estimate: &PlanPose, truth: &PlanPose) -> f64 {
    (estimate.x - truth.x).hypot(estimate.y - truth.y)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn an_unknown_start_and_scale_are_found_by_walking() {
    let plan = office();
    for seed in 1..3 {
        let walk = walk(&WALK, &plan, WORLD, seed);
        let found = run(&walk, &plan, &options(seed));
        assert_eq!(found.status, Status::Tracking, "seed {seed}: {:?}", found.quality);
        let (end, truth) = (&found.filter[found.filter.len() - 1], &walk.truth[walk.truth.len() - 1]);
        // Half a door's width tells the rooms apart.
        assert!(off(&end.pose, truth) < 0.4, "seed {seed}: ends {} m off", off(&end.pose, truth));
        assert!(wrap_angle(end.pose.heading_rad - truth.heading_rad).abs() < 5f64.to_radians(), "seed {seed}");
        assert!((found.scale.metres_per_unit / SCALE - 1.0).abs() < 0.05, "seed {seed}: {:?}", found.scale);
    }
}

#[test]
fn the_track_knows_the_beginning_that_the_filter_could_not_know() {
    let plan = office();
    let walk = walk(&WALK, &plan, WORLD, 1);
    let found = run(&walk, &plan, &options(1));
    assert_eq!((found.track.len(), found.filter.len()), (walk.truth.len(), walk.truth.len()), "one estimate a moment");
    let first_ten =
        |estimates: &[planwalk_types::Estimate]| median(estimates.iter().zip(&walk.truth).take(10).map(|(e, t)| off(&e.pose, t)).collect());
    assert!(first_ten(&found.track) < 0.3, "the track begins {} m off", first_ten(&found.track));
    assert!(first_ten(&found.filter) > 1.0, "the filter cannot know its first place");
    assert_eq!(found.hypotheses[0].track.len(), walk.truth.len());
    assert!(found.filter[0].status != Status::Tracking);
}

#[test]
fn regions_hold_the_truth_about_as_often_as_they_say() {
    let plan = office();
    let (mut filter, mut track, mut all) = (0.0, 0.0, 0.0);
    for seed in 10..16 {
        let walk = walk(&WALK, &plan, WORLD, seed);
        let found = run(&walk, &plan, &LocateOptions { start: Some(start_of(&walk)), ..options(seed) });
        // Moments of a walk hang together: every tenth is plenty.
        for i in (10..walk.truth.len()).step_by(10) {
            all += 1.0;
            filter += f64::from(u8::from(off(&found.filter[i].pose, &walk.truth[i]) < found.filter[i].radius95_m));
            track += f64::from(u8::from(off(&found.track[i].pose, &walk.truth[i]) < found.track[i].radius95_m));
        }
    }
    // 95 % regions. Tempering makes them wide rather than narrow; 6 walks of some five independent moments each are
    // good to 2 σ = 8 %.
    assert!(filter / all > 0.87, "filter: {}", filter / all);
    assert!(track / all > 0.87, "track: {}", track / all);
}

#[test]
fn a_straight_corridor_walk_does_not_shrink() {
    // Small walks hit no walls: with nothing seen, that must not speak for them.
    let corridor = [wall(0.0, 0.0, 40.0, 0.0), wall(40.0, 0.0, 40.0, 2.0), wall(40.0, 2.0, 0.0, 2.0), wall(0.0, 2.0, 0.0, 0.0)];
    let plan = FloorPlan::from_walls(&corridor, 0.1, 1.0).unwrap();
    let walk = walk(&[(3.0, 1.0), (23.0, 1.0)], &plan, WORLD, 1);
    for start in [None, Some(start_of(&walk))] {
        let prior = ScalePrior { metres_per_unit: SCALE, relative_sigma: 0.3 };
        let found = blind(&walk, &plan, &LocateOptions { start, ..thrifty(LocateOptions::new(Seed(1), prior)) });
        let sunk = (SCALE / found.scale.metres_per_unit).ln();
        // The far wall excludes the largest scales: 40 m are 0.53 (1.8 σ) above; a cut there lowers the mean by 0.1 σ. Half a
        // sigma is the line.
        assert!(sunk < 0.15, "start {start:?}: scale sank by {sunk} to {:?}", found.scale);
    }
}

#[test]
fn scale_does_not_collapse_among_rooms_when_nothing_is_seen() {
    let plan = office();
    for seed in 1..4 {
        let walk = walk(&WALK, &plan, WORLD, seed);
        let prior = ScalePrior { metres_per_unit: SCALE, relative_sigma: 0.3 };
        let found = blind(&walk, &plan, &thrifty(LocateOptions::new(Seed(seed), prior)));
        let sunk = (SCALE / found.scale.metres_per_unit).ln();
        assert!(sunk < 0.3, "seed {seed}: scale sank by {sunk}, a sigma of its prior, to {:?}", found.scale);
        assert_ne!(found.status, Status::Tracking, "seed {seed}: nothing was seen, and nobody said where the walk began");
    }
}

#[test]
fn a_symmetric_building_has_two_answers() {
    let walls = [
        wall(0.0, 0.0, 12.0, 0.0),
        wall(12.0, 0.0, 12.0, 6.0),
        wall(12.0, 6.0, 0.0, 6.0),
        wall(0.0, 6.0, 0.0, 0.0),
        wall(4.0, 0.0, 4.0, 2.5),
        wall(8.0, 6.0, 8.0, 3.5),
    ];
    let plan = FloorPlan::from_walls(&walls, 0.1, 1.0).unwrap();
    let walk = walk(&[(2.0, 2.0), (2.0, 4.0), (6.0, 3.0), (10.0, 2.0), (10.0, 4.5)], &plan, WORLD, 3);
    let found = run(&walk, &plan, &options(3));
    assert_eq!(found.status, Status::Ambiguous);
    assert!(!found.apart.is_empty() && found.apart[0].first == 0 && found.apart[0].second == 1);
    let truth = walk.truth[walk.truth.len() - 1];
    let mirrored = PlanPose::new(12.0 - truth.x, 6.0 - truth.y, truth.heading_rad + std::f64::consts::PI);
    for place in [truth, mirrored] {
        let near = found.hypotheses.iter().find(|h| off(&h.pose, &place) < 0.5);
        assert!(
            near.is_some_and(|h| h.probability > 0.1),
            "{place:?} is missing among {:?}",
            found.hypotheses.iter().map(|h| (h.pose, h.probability)).collect::<Vec<_>>()
        );
    }
}

#[test]
fn a_planned_wall_that_was_never_built_is_crossed_and_counted() {
    let built = office();
    // The plan closes the door from the corridor into the upper room at the walk's end.
    let mut cells = built.cells().to_vec();
    let (left, row) = built.cell_at(Pt2::new(10.2, 5.8)).unwrap();
    let (right, _) = built.cell_at(Pt2::new(11.2, 5.8)).unwrap();
    for column in left..=right {
        cells[row * built.width() + column] = Cell::Wall;
    }
    let plan = FloorPlan::new(built.origin(), built.cell_m(), built.width(), built.height(), cells).unwrap();
    let walk = walk(&WALK, &built, WORLD, 4);
    let found = run(&walk, &plan, &options(4));
    let (end, truth) = (&found.filter[found.filter.len() - 1], &walk.truth[walk.truth.len() - 1]);
    assert!(off(&end.pose, truth) < 0.5, "ends {} m off", off(&end.pose, truth));
    assert_eq!(found.quality.wall_crossings, 1);
    let crossed: Vec<_> = found.contradicted.iter().filter(|w| w.kind == ContradictedKind::Crossed).collect();
    assert_eq!(crossed.len(), 1, "{:?}", found.contradicted);
    // The walk goes through the middle of the door that is not drawn; a track is good to two decimetres.
    assert!(crossed[0].place.distance(Pt2::new(10.7, 5.8)) < 0.4 && crossed[0].crossed == 1, "{crossed:?}");
}

#[test]
fn an_honest_plan_is_not_contradicted() {
    let plan = office();
    for seed in 1..4 {
        let walk = walk(&WALK, &plan, WORLD, seed);
        let found = run(&walk, &plan, &LocateOptions { start: Some(start_of(&walk)), ..options(seed) });
        assert!(found.contradicted.is_empty(), "seed {seed}: {:?}", found.contradicted);
    }
}

#[test]
fn the_polish_measures_how_far_off_a_plan_draws() {
    // The drawn office is the built one: what is left is half a cell of drawing, a prior, and what the noise lets through.
    let plan = office();
    let walk = walk(&WALK, &plan, WORLD, 2);
    let found = run(&walk, &plan, &LocateOptions { start: Some(start_of(&walk)), ..options(2) });
    assert!(found.quality.plan_sigma_m.is_some_and(|s| s > 0.005 && s < 0.1), "{:?}", found.quality);
    let track_off = median(found.track.iter().zip(&walk.truth).map(|(e, t)| off(&e.pose, t)).collect());
    assert!(track_off < 0.1, "{track_off} m off in the median");
    let end = &found.hypotheses[0];
    assert!((end.radius95_m - found.track[found.track.len() - 1].radius95_m).abs() < 1e-9, "a hypothesis and the track agree on the end");
    assert_eq!(blind(&walk, &plan, &options(2)).quality.plan_sigma_m, None, "nothing was seen");
}

#[test]
fn another_buildings_plan_is_not_believed() {
    // A hall of 40 m × 25 m with four pillars.
    let mut walls = vec![wall(0.0, 0.0, 40.0, 0.0), wall(40.0, 0.0, 40.0, 25.0), wall(40.0, 25.0, 0.0, 25.0), wall(0.0, 25.0, 0.0, 0.0)];
    walls.extend([(10.0, 8.0), (30.0, 8.0), (10.0, 17.0), (30.0, 17.0)].map(|(x, y)| wall(x, y, x + 0.4, y)));
    let other = FloorPlan::from_walls(&walls, 0.1, 1.0).unwrap();
    for seed in 1..3 {
        let walk = walk(&WALK, &office(), WORLD, seed);
        let found = run(&walk, &other, &LocateOptions { particles_per_m2: 100.0, ..options(seed) });
        assert_ne!(found.status, Status::Tracking, "seed {seed}: {:?}", found.quality);
    }
}

#[test]
fn whoever_is_carried_elsewhere_is_found_again() {
    let plan = office();
    let mut here = walk(&WALK, &plan, WORLD, 6);
    let on = [(2.0, 9.0), (4.5, 7.0), (4.5, 4.9), (13.0, 4.9), (13.0, 2.0), (15.0, 1.0), (13.0, 2.0), (13.0, 4.9), (7.5, 4.9), (7.5, 2.0)];
    let there = walk(&on, &plan, WORLD, 7);
    // Carried within one frame: the odometry felt nothing.
    let carried = here.path.steps[here.path.steps.len() - 1].to.0 + 200_000_000;
    let later = |stamp: Stamp| Stamp(stamp.0 + carried);
    let pause = StepNoise::default().step(Stamp(carried - 200_000_000), Stamp(carried), 0.0, 0.0, 0.0);
    here.path.steps.push(pause);
    here.path.steps.extend(there.path.steps.iter().map(|s| Step { from: later(s.from), to: later(s.to), ..*s }));
    here.sightings.extend(there.sightings.iter().map(|s| Sighting { stamp: later(s.stamp), ..*s }));
    let found = run(&here, &plan, &options(6));
    let (end, truth) = (&found.filter[found.filter.len() - 1], &there.truth[there.truth.len() - 1]);
    assert!(off(&end.pose, truth) < 0.6 || found.status != Status::Tracking, "tracking {} m off", off(&end.pose, truth));
    let found_again = found.hypotheses.iter().any(|h| off(&h.pose, truth) < 0.6);
    assert!(found_again, "{truth:?} is missing among {:?}", found.hypotheses.iter().map(|h| (h.pose, h.probability)).collect::<Vec<_>>());
}

#[test]
fn one_thread_and_two_give_the_same_bytes() {
    let plan = office();
    let walk = walk(&WALK[..5], &plan, WORLD, 8);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&walk, &plan, &options(8)))
    };
    let print = |found: &Localization| format!("{:?} {:?} {:?} {:?}", found.filter, found.track, found.hypotheses, found.scale);
    assert_eq!(print(&on(1)), print(&on(2)));
}

#[test]
fn the_work_does_not_grow_with_the_frame_rate() {
    let plan = office();
    let updates = |rate: f64| {
        let walk = walk(&WALK[..5], &plan, World { rate, ..WORLD }, 9);
        run(&walk, &plan, &LocateOptions { start: Some(start_of(&walk)), ..options(9) }).quality.updates
    };
    let (slow, fast) = (updates(5.0), updates(60.0));
    assert!(fast < 2 * slow, "{fast} updates at 60 Hz, {slow} at 5 Hz");
}

#[test]
fn a_start_far_outside_of_what_was_scanned_may_still_walk_in() {
    // The right end of the corridor is open, and the walk begins 1.7 m beyond the last wall.
    let walls = [wall(0.0, 0.0, 12.0, 0.0), wall(12.0, 2.0, 4.0, 2.0), wall(0.0, 0.0, 0.0, 6.0), wall(4.0, 2.0, 4.0, 6.0)];
    let plan = FloorPlan::from_walls(&walls, 0.1, 0.5).unwrap();
    let walk = walk(&[(13.7, 1.0), (2.0, 1.0), (2.0, 5.5)], &plan, WORLD, 11);
    let found = run(&walk, &plan, &LocateOptions { start: Some(start_of(&walk)), ..options(11) });
    let last = found.filter.len() - 1;
    assert!(off(&found.filter[last].pose, &walk.truth[last]) < 0.5, "ends {} m off", off(&found.filter[last].pose, &walk.truth[last]));
    let unknown = run(&walk, &plan, &options(11));
    let near = unknown.hypotheses.iter().any(|h| off(&h.pose, &walk.truth[last]) < 1.0);
    assert!(near, "{:?}", unknown.hypotheses.iter().map(|h| (h.pose, h.probability)).collect::<Vec<_>>());
}

#[test]
fn options_matter() {
    let plan = office();
    let walk = walk(&WALK[..5], &plan, WORLD, 12);
    let base = LocateOptions { start: Some(start_of(&walk)), ..options(12) };
    let end = |options: &LocateOptions| run(&walk, &plan, options).filter[walk.truth.len() - 1].clone();
    let reference = end(&base);
    let mut dull = base.clone();
    dull.sightings.temper = 0.005;
    assert!(end(&dull).radius95_m > 1.3 * reference.radius95_m, "sightings that hardly count leave a wide region");
    let mut believer = base.clone();
    believer.sightings.temper = 0.4;
    assert!(end(&believer).radius95_m < reference.radius95_m, "sightings that count more leave a narrow one");
    let mut strict = base.clone();
    strict.verdict.gain_nats = 50.0;
    assert_eq!(end(&strict).status, Status::Ambiguous);
    let mut few = base.clone();
    few.particles_min = 500;
    few.particles_max = 1000;
    assert!(run(&walk, &plan, &few).quality.particles_max <= 1000);
    let mut rare = base.clone();
    rare.update_distance_m = 1.0;
    rare.update_turn_rad = 1.0;
    assert!(run(&walk, &plan, &rare).quality.updates * 2 < run(&walk, &plan, &base).quality.updates);
}

#[test]
fn progress_rises_to_one_and_observers_see_a_cloud_that_sums_to_one() {
    let plan = office();
    let walk = walk(&WALK[..4], &plan, WORLD, 13);
    let (mut told, mut seen) = (Vec::new(), 0);
    let mut observe = |run: usize, view: &planwalk_locate::FilterView<'_>| {
        let sum: f64 = view.weight.iter().map(|w| f64::from(*w)).sum();
        // Tens of thousands of weights in f32.
        assert!((sum - 1.0).abs() < 1e-3, "weights sum to {sum}");
        assert_eq!(view.x.len(), view.weight.len());
        seen += usize::from(run == 0);
    };
    let found = localize_observed(&walk.path, &walk.sightings, &plan, &options(13), &mut |done| told.push(done), &mut observe).unwrap();
    assert!(told.windows(2).all(|p| p[0] <= p[1]) && told.last() == Some(&1.0));
    assert!(seen > 5 && seen <= found.quality.updates, "{seen} views of {} updates", found.quality.updates);
}

#[test]
fn what_makes_no_sense_is_refused_with_numbers() {
    let plan = office();
    let good = walk(&WALK[..3], &plan, WORLD, 14);
    let with = |path: &Path, options: &LocateOptions| localize(path, &[], &plan, options, &mut |_| {}).map(|_| ()).unwrap_err();
    assert!(matches!(with(&Path::default(), &options(1)), LocateError::EmptyPath { .. }));
    let mut broken = good.path.clone();
    broken.steps[3].left = f64::NAN;
    assert_eq!(with(&broken, &options(1)), LocateError::NotFinite { index: 3 });
    let mut back = good.path.clone();
    back.steps[4].to = back.steps[4].from;
    assert!(matches!(with(&back, &options(1)), LocateError::StepsGoBack { index: 4, .. }));
    let far = LocateOptions { start: Some(StartPrior { x: 900.0, ..start_of(&good) }), ..options(1) };
    let message = with(&good.path, &far).to_string();
    assert!(message.contains("900") && message.contains("882.9"), "{message}");
    let nowhere = LocateOptions { scale: ScalePrior { metres_per_unit: -1.0, relative_sigma: 0.3 }, ..options(1) };
    assert!(matches!(with(&good.path, &nowhere), LocateError::BadScalePrior { .. }));
}

#[test]
fn broken_covariances_and_standing_still_do_no_harm() {
    let plan = office();
    let mut odd = walk(&WALK[..3], &plan, WORLD, 15);
    for (i, step) in odd.path.steps.iter_mut().enumerate() {
        step.covariance = if i % 2 == 0 { Matrix3::zeros() } else { Matrix3::from_element(-1.0) };
    }
    let found = run(&odd, &plan, &options(15));
    assert!(found.filter.iter().chain(&found.track).all(|e| e.pose.x.is_finite() && e.radius95_m.is_finite()));
    for step in &mut odd.path.steps {
        (step.forward, step.left, step.turn_rad) = (0.0, 0.0, 0.0);
    }
    let standing = run(&odd, &plan, &options(15));
    assert_ne!(standing.status, Status::Tracking, "who stands still sees one view only");
    assert_eq!(standing.track.len(), odd.path.steps.len() + 1);
}

#[test]
fn place_and_filter_agree_on_where_a_perfect_walk_began() {
    let plan = office();
    let truth = poses(&WALK, 10.0);
    let steps = truth.windows(2).enumerate().map(|(i, pair)| {
        let moved: Rigid2<planwalk_types::Body, planwalk_types::Body> = pair[0].inverse() * pair[1];
        let at = |i: usize| Stamp(i as i64 * 100_000_000);
        StepNoise::default().step(at(i), at(i + 1), moved.x, moved.y, moved.heading_rad)
    });
    let path = Path { steps: steps.collect() };
    let placement = place(&path, &plan, &PlaceOptions::default(), &mut |_| {}).unwrap();
    let (column, row) = plan.cell_at(truth[0].origin()).unwrap();
    let near = |c: usize, r: usize| placement.start_region[r * plan.width() + c];
    // Headings are tried every 2°: the walk's own lies up to 1° off, 0.2 m at its far end.
    let found = (column - 2..=column + 2).any(|c| (row - 2..=row + 2).any(|r| near(c, r)));
    assert!(found, "the true start is in the region or within 0.2 m of it");
    assert!(placement.area_m2 < 5.0, "a long walk fits few places: {} m²", placement.area_m2);
    assert!(placement.modes.iter().any(|m| m.pose.origin().distance(truth[0].origin()) < 0.6), "{:?}", placement.modes);
    let odom: Vec<Rigid2<Odom, planwalk_types::Body>> = path.poses();
    assert_eq!(odom.len(), truth.len());
}

#[test]
fn a_prior_of_an_unknown_unit_is_wide_enough_for_its_truth() {
    let walk = walk(&WALK, &office(), WORLD, 16);
    let prior = ScalePrior::of(OdometryScale::Unknown, &walk.path);
    assert!((SCALE / prior.metres_per_unit).ln().abs() < 2.0 * prior.relative_sigma, "{prior:?}");
}

#[test]
fn a_stream_without_end_takes_no_more_memory_and_knows_as_much_now() {
    let plan = office();
    let corners: Vec<(f64, f64)> = (0..2).flat_map(|_| WALK.into_iter().chain(WALK.into_iter().rev())).collect();
    let walk = walk(&corners, &plan, WORLD, 3);
    let start = Some(StartPrior { sigma_rad: 0.1, ..start_of(&walk) });
    let whole = LocateOptions { start, ..thrifty(options(5)) };
    let bounded = LocateOptions { remember_m: Some(10.0), ..whole.clone() };
    let pushed = |options: &LocateOptions| {
        let mut localizer = Localizer::new(&plan, options).unwrap();
        let now: Vec<_> = walk.path.steps.iter().map(|step| localizer.push(step, &[])).collect();
        (now, localizer.finish().unwrap())
    };
    let ((now, all), (now_bounded, recent)) = (pushed(&whole), pushed(&bounded));
    assert!(now.iter().zip(&now_bounded).all(|(a, b)| a.pose == b.pose && a.radius95_m == b.radius95_m));
    // 10 m and a quarter, of some 90.
    assert!(all.track.len() == walk.truth.len() && recent.track.len() * 5 < all.track.len(), "{}", recent.track.len());
    assert_eq!(all.track.last().unwrap().stamp, recent.track.last().unwrap().stamp);
    // What is left is smoothed as it would have been: by other draws of the same past.
    let before = all.track.len() - recent.track.len();
    let apart = recent.track.iter().zip(&all.track[before..]).map(|(a, b)| off(&a.pose, &b.pose));
    assert!(median(apart.collect()) < 0.3);
}
