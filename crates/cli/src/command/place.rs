//! `planwalk place`: where does a trajectory fit without touching a wall?

use planwalk::figure::PlacementPicture;
use planwalk::locate::{LocateError, PlaceOptions, Placement, PlacementMode, ScalePrior, Tolerance, place};
use planwalk::result::{EndModeEntry, PlacementEntry, PlacementModeEntry, PoseEntry};
use planwalk::types::{Path, PlanPose, Rigid2, Stamp};

use super::{Task, name_of};
use crate::args::PlaceArgs;
use crate::failure::Failure;
use crate::inputs;

/// Placements that are drawn, of the largest modes.
const SHOWN: usize = 3;

/// Shows every placement of a trajectory.
pub fn run(args: &PlaceArgs) -> Result<(), Failure> {
    let mut task = Task::begin("place", &args.common)?;
    let Some(file) = &args.poses.poses else { return Err(Failure::usage("give the trajectory: --poses FILE")) };
    let plan = inputs::plan(&args.plan)?;
    task.note(plan.notes);
    let poses = inputs::poses(file, &args.poses)?;
    task.note(poses.notes);
    let (path, scale) = poses.value;
    let scales = args.scale_range.unwrap_or_else(|| {
        let prior = ScalePrior::of(scale, &path);
        let spread = (2.0 * prior.relative_sigma).exp();
        (prior.metres_per_unit / spread, prior.metres_per_unit * spread)
    });
    args.plan.note(&mut task);
    args.poses.note(&mut task);
    task.option("heading", args.heading);
    task.option("scale-range", Some(format!("{},{}", scales.0, scales.1)));
    task.option("drift", Some(args.drift));
    task.option("length-error", Some(args.length_error));
    let tolerance = Tolerance { drift_rad_per_sqrt_m: args.drift.to_radians(), length_error: 0.01 * args.length_error };
    let options = PlaceOptions { heading_rad: args.heading.map(f64::to_radians), scales, tolerance, ..PlaceOptions::default() };
    let bar = task.voice.bar("placing", Some(1000));
    let placement = place(&path, &plan.value, &options, &mut |share| bar.set_position((1000.0 * share) as u64)).map_err(refused)?;
    bar.finish_and_clear();
    task.result.placement = Some(entry(&placement));
    task.result.inputs = vec![inputs::entry("poses", file)?, inputs::entry("plan", &args.plan.plan)?];
    let best: Vec<_> = placement.modes.iter().take(SHOWN).map(|mode| at(&path, mode)).collect();
    let headings = args.heading.map_or_else(|| "all headings".to_owned(), |h| format!("heading {h:.0}°"));
    let drift = if tolerance.is_none() {
        String::new()
    } else {
        format!(", drift {}° per root metre, length ± {} %", args.drift, args.length_error)
    };
    let conditions = format!("{headings}, {:.2} to {:.2} m a unit{drift}", scales.0, scales.1);
    let title = format!("{} on {}", name_of(file), name_of(&args.plan.plan));
    let picture = PlacementPicture {
        title: &title,
        plan: &plan.value,
        start_region: &placement.start_region,
        area_m2: placement.area_m2,
        end_region: &placement.end_region,
        end_area_m2: placement.end_area_m2,
        best: &best,
        drifts: !tolerance.is_none(),
        conditions: &conditions,
    };
    task.draw("place", &picture.svg())?;
    if placement.modes.is_empty() {
        let why = format!(
            "the trajectory fits nowhere on this plan without touching a wall ({conditions}): try a wider --scale-range, leave \
             --heading away, say how it drifts (--drift 0.5 --length-error 2), or use planwalk locate, which also forgives walls that \
             were never built"
        );
        task.result.error = Some(why.clone());
        task.end()?;
        return Err(Failure::no_answer(why));
    }
    let places = |n: usize| if n == 1 { "one place".to_owned() } else { format!("{n} separate places") };
    let (starts, ends) = (places(placement.modes.len()), places(placement.end_modes.len()));
    task.voice.say(&format!(
        "the trajectory can start in {:.2} m² of the plan, in {starts}, and end in {:.2} m², in {ends} ({conditions})",
        placement.area_m2, placement.end_area_m2
    ));
    task.voice.say(&format!("picture: {}", task.output.path("place.png").display()));
    task.end()
}

fn refused(why: LocateError) -> Failure {
    match why {
        LocateError::BadScaleRange { .. } => Failure::usage(format!("the scales make no sense: {why}")),
        LocateError::BadTolerance { .. } => Failure::usage(format!("--drift and --length-error make no sense: {why}")),
        why => Failure::no_answer(format!("the trajectory was not placed: {why}")),
    }
}

fn entry(placement: &Placement) -> PlacementEntry {
    let start = |m: &PlacementMode| PlacementModeEntry { start: PoseEntry::from(&m.pose), metres_per_unit: m.scale, share: m.share };
    let end = |m: &PlacementMode| EndModeEntry { end: PoseEntry::from(&m.pose), metres_per_unit: m.scale, share: m.share };
    PlacementEntry {
        area_m2: placement.area_m2,
        tried: placement.tried,
        modes: placement.modes.iter().map(start).collect(),
        end_area_m2: placement.end_area_m2,
        end_modes: placement.end_modes.iter().map(end).collect(),
    }
}

/// The path as it was measured, from a start that was found.
fn at(path: &Path, mode: &PlacementMode) -> Vec<(Stamp, PlanPose)> {
    let scale = mode.example_scale;
    let pose = |odom: &Rigid2<_, _>| mode.example * Rigid2::new(scale * odom.x, scale * odom.y, odom.heading_rad);
    path.stamps().zip(path.poses().iter().map(pose)).collect()
}
