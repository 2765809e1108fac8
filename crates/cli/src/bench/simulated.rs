//! Walks whose odometry is simulated: along a given path, or through generated buildings; of a stated length, or kidnapped.

use std::path::Path;

use planwalk::Walk;
use planwalk::evaluate::{self, Alignment, OdometryScoreOptions, scale};
use planwalk::types::{FloorPlan, OdometryScale, PlanPose, Seed, Stamp, Wall};
use planwalk_io::trajectory::{PosesFrame, PosesOptions};
use planwalk_sim::{Building, OdometryNoise, PlanWorldOptions, Scene, SceneOptions, SimulatedOdometry, simulate_carried};

use super::suite::{Case, Job, Simulate};
use super::walk::{Prepared, associate, follow, place_options, plan, poses_options, say};
use crate::simulate::{Site, walk_along};

/// Poses a second of odometry that is simulated along a given path.
const ALONG_HZ: f64 = 5.0;
/// How often a walk that proves too short is drawn again, longer.
const TRIES: usize = 4;

/// True poses on the floor.
type Truth = Vec<(Stamp, PlanPose)>;

/// Odometry simulated along a true path, among the walls of a real plan.
pub fn along(job: &Job<'_>, data: &Path, path: &Path) -> Result<Prepared, String> {
    let case = job.case;
    let plan = plan(case, data)?.ok_or("odometry along a path needs a plan to see")?;
    let PosesOptions { format, frame, .. } = poses_options(case)?;
    // Whoever walks looks along the path where the file does not say.
    let walk = walk_along(&data.join(path), format, frame.unwrap_or(PosesFrame::Body), [0.0; 3]).map_err(say("the path", path))?;
    let truth = on_floor(&walk, ALONG_HZ);
    let seed = Seed(job.seed).child("bench", 0);
    let walls = Building::from_plan(&plan, &PlanWorldOptions::default(), seed).map_err(|why| why.to_string())?.solid_lines();
    let noise = case.noise.unwrap_or_else(OdometryNoise::monocular);
    if case.kidnap {
        return kidnapped(case, &truth, &truth, &walls, &noise, seed, plan);
    }
    prepared(case, simulate_carried(truth, &[], &walls, &noise, seed), &noise, plan)
}

/// A generated building, and a walk through it.
pub fn family(job: &Job<'_>, simulate: &Simulate) -> Result<Prepared, String> {
    let (building, walk) = job.of.unwrap_or_default();
    let family = Seed(job.seed).child(&job.case.name, building);
    // The building is the family's; the walk through it is this one's.
    let seed = family.child("walk", walk);
    let scene = scene(&Site::Generated(simulate.scene.building), family.child("building", 0), simulate, seed)?;
    if simulate.render {
        return filmed(job, &scene);
    }
    let noise = job.case.noise.unwrap_or_else(OdometryNoise::monocular);
    let mut simulated = scene.odometry(&noise, simulate.odometry_hz);
    if let Some(length_m) = simulate.length_m {
        cut(&mut simulated, length_m);
    }
    if job.case.kidnap {
        let site = Site::Built(Box::new(scene.building().clone()));
        let other = self::scene(&site, family.child("building", 0), simulate, seed.child("kidnapped", 0))?;
        let there = on_floor(other.walk(), simulate.odometry_hz);
        return kidnapped(job.case, &simulated.truth, &there, &scene.building().solid_lines(), &noise, seed, scene.plan());
    }
    prepared(job.case, simulated, &noise, scene.plan())
}

/// A scene whose walk is as long as is asked for.
fn scene(site: &Site, building: Seed, simulate: &Simulate, seed: Seed) -> Result<Scene, String> {
    let mut options = simulate.scene(seed);
    let mut scene = site.scene(building, &options).map_err(|why| why.to_string())?;
    let Some(length_m) = simulate.length_m else { return Ok(scene) };
    for _ in 0..TRIES {
        let walked_m = scene.walk().length_m();
        if walked_m >= length_m {
            return Ok(scene);
        }
        // A tenth more than the mean speed asks for: nobody keeps it, and stops come in between.
        let duration_s = 1.1 * options.walk.duration_s * length_m / walked_m.max(1.0);
        options = SceneOptions { walk: planwalk_sim::WalkOptions { duration_s, ..options.walk }, ..options };
        scene = site.scene(building, &options).map_err(|why| why.to_string())?;
    }
    let walked_m = scene.walk().length_m();
    if walked_m >= length_m { Ok(scene) } else { Err(format!("no walk of {length_m} m: the longest of {TRIES} has {walked_m:.0} m")) }
}

/// Where a walk went, so many times a second.
fn on_floor(walk: &planwalk_sim::Walk, hz: f64) -> Truth {
    let count = (walk.duration_s() * hz).floor() as usize + 1;
    let stamp = |i: usize| Stamp((i as f64 / hz * 1e9).round() as i64);
    (0..count).map(|i| (stamp(i), walk.at(stamp(i).as_secs()).on_floor)).collect()
}

/// Ends a walk where it has gone so many metres.
fn cut(simulated: &mut SimulatedOdometry, length_m: f64) {
    let mut walked_m = 0.0;
    let gone = simulated.truth.windows(2).position(|pair| {
        walked_m += pair[0].1.origin().distance(pair[1].1.origin());
        walked_m >= length_m
    });
    let Some(steps) = gone.map(|index| index + 1) else { return };
    simulated.truth.truncate(steps + 1);
    simulated.metres_per_unit.truncate(steps + 1);
    simulated.path.steps.truncate(steps);
    let end = simulated.truth.last().map_or(Stamp(0), |(stamp, _)| *stamp);
    simulated.sightings.retain(|s| s.stamp <= end);
}

/// Half of one walk, then another from where it is farthest from the first one's end, but with half of its time left at least:
/// from one moment to the next the body is there, and the odometry felt nothing.
fn kidnapped(
    case: &Case,
    here: &[(Stamp, PlanPose)],
    there: &[(Stamp, PlanPose)],
    walls: &[Wall],
    noise: &OdometryNoise,
    seed: Seed,
    plan: FloorPlan,
) -> Result<Prepared, String> {
    let (truth, carried) = joined(here, there).ok_or("the walk is too short to be kidnapped on")?;
    let at = truth[carried].0;
    let mut prepared = prepared(case, simulate_carried(truth, &[carried], walls, noise, seed), noise, plan)?;
    prepared.options.carried_at = Some(at);
    Ok(prepared)
}

/// The joined walk, and the index of the first pose of its second part. `None` of walks of fewer than four poses.
fn joined(here: &[(Stamp, PlanPose)], there: &[(Stamp, PlanPose)]) -> Option<(Truth, usize)> {
    if here.len() < 4 || there.len() < 4 {
        return None;
    }
    let (first, carried) = (&here[..here.len() / 2], here.len() / 2);
    let (end, (until, _)) = (first.last()?, here[carried]);
    let away_m = |i: &usize| there[*i].1.origin().distance(end.1.origin());
    let from = (0..=there.len() / 2).max_by(|a, b| away_m(a).total_cmp(&away_m(b)))?;
    // The clock runs on: the new place takes the stamp of the pose that would have come.
    let later = until.0.saturating_sub(there[from].0.0);
    let second = there[from..].iter().map(|(stamp, pose)| (Stamp(stamp.0.saturating_add(later)), *pose));
    Some((first.iter().copied().chain(second).collect(), carried))
}

fn prepared(case: &Case, simulated: SimulatedOdometry, noise: &OdometryNoise, plan: FloorPlan) -> Result<Prepared, String> {
    // Odometry whose unit is a metre up to what was drawn says so; a localiser is told no more than a user would know.
    let metric = noise.scale_sigma == 0.0 && noise.scale_range.is_none() && noise.metres_per_unit == 1.0;
    let usual = if metric { OdometryScale::Metric } else { OdometryScale::Unknown };
    let scale = if case.odometry_scale.is_some() { case.scale()? } else { usual };
    let SimulatedOdometry { truth, path, sightings, metres_per_unit } = simulated;
    Ok(Prepared {
        walk: Walk { path, sightings, scale },
        plan: Some(plan),
        start: None,
        units: truth.iter().map(|(stamp, _)| *stamp).zip(metres_per_unit).collect(),
        truth,
        options: place_options(None, true),
        odometry_s: None,
        odometry: None,
        place: None,
    })
}

/// A walk whose odometry is made from its pictures.
fn filmed(job: &Job<'_>, scene: &Scene) -> Result<Prepared, String> {
    let frames = scene.frames().map(Ok::<_, std::convert::Infallible>);
    let (odometry, seconds) = follow(frames, scene.camera(), job.seed)?;
    let seen: Vec<_> = odometry.poses.iter().map(|p| (p.stamp, p.odom_from_camera)).collect();
    let options = OdometryScoreOptions { associate: associate(None), ..OdometryScoreOptions::default() };
    let scores = evaluate::odometry::score(&seen, &scene.truth(), Alignment::Sim3, &options).map_err(|why| why.to_string())?;
    let (walk, truth) = (Walk::from(&odometry), scene.truth_on_floor());
    let options = place_options(None, true);
    Ok(Prepared {
        units: scale::by_chords(&walk.path, &truth, &options.associate),
        walk,
        plan: Some(scene.plan()),
        start: None,
        truth,
        options,
        odometry_s: Some(seconds),
        odometry: Some(scores),
        place: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(count: i64, y_m: f64) -> Truth {
        (0..count).map(|i| (Stamp(i * 200_000_000), PlanPose::new(0.2 * i as f64, y_m, 0.0))).collect()
    }

    #[test]
    fn the_kidnapped_walk_goes_on_far_away_and_on_the_same_clock() {
        let (truth, carried) = joined(&straight(100, 0.0), &straight(60, 7.0)).unwrap();
        assert_eq!(carried, 50);
        assert!(truth.windows(2).all(|pair| pair[1].0.0 - pair[0].0.0 == 200_000_000), "a pose every 0.2 s, throughout");
        // The first half ends at 9.8 m; of the first half of the other, its beginning is farthest.
        assert_eq!((truth[49].1.x, truth[50].1.x, truth[50].1.y), (49.0 * 0.2, 0.0, 7.0));
        assert_eq!(truth.len(), 50 + 60);
        assert!(joined(&straight(3, 0.0), &straight(60, 7.0)).is_none());
    }

    #[test]
    fn a_walk_of_a_stated_length_ends_there() {
        let noise = OdometryNoise::none();
        let mut simulated = simulate_carried(straight(100, 0.0), &[], &[], &noise, Seed(1));
        cut(&mut simulated, 5.0);
        // 0.2 m a step: 25 of them.
        assert_eq!((simulated.truth.len(), simulated.path.steps.len(), simulated.metres_per_unit.len()), (26, 25, 26));
        cut(&mut simulated, 900.0);
        assert_eq!(simulated.truth.len(), 26, "what is shorter stays as it is");
    }
}
