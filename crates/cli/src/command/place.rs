//! `planwalk place`: where does a trajectory fit without touching a wall?

use planwalk::figure::PlacementPicture;
use planwalk::locate::{LocateError, PlaceOptions, Placement, ScalePrior, place};
use planwalk::result::{PlacementEntry, PlacementModeEntry, PoseEntry};
use planwalk::types::{Path, PlanPose, Rigid2, Stamp};

use super::{Task, name_of};
use crate::args::PlaceArgs;
use crate::failure::Failure;
use crate::inputs;

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
    let options = PlaceOptions { heading_rad: args.heading.map(f64::to_radians), scales, ..PlaceOptions::default() };
    let bar = task.voice.bar("placing", Some(1000));
    let placement = place(&path, &plan.value, &options, &mut |share| bar.set_position((1000.0 * share) as u64)).map_err(refused)?;
    bar.finish_and_clear();
    task.result.placement = Some(entry(&placement));
    task.result.inputs = vec![inputs::entry("poses", file)?, inputs::entry("plan", &args.plan.plan)?];
    let best = at_best(&path, &placement);
    let headings = args.heading.map_or_else(|| "all headings".to_owned(), |h| format!("heading {h:.0}°"));
    let conditions = format!("{headings}, {:.2} to {:.2} m a unit", scales.0, scales.1);
    let title = format!("{} on {}", name_of(file), name_of(&args.plan.plan));
    let picture = PlacementPicture {
        title: &title,
        plan: &plan.value,
        start_region: &placement.start_region,
        area_m2: placement.area_m2,
        best: &best,
        conditions: &conditions,
    };
    task.draw("place", &picture.svg())?;
    if placement.modes.is_empty() {
        let why = format!(
            "the trajectory fits nowhere on this plan without touching a wall ({conditions}): try a wider --scale-range, leave \
             --heading away, or use planwalk locate, which forgives drift and walls that were never built"
        );
        task.result.error = Some(why.clone());
        task.end()?;
        return Err(Failure::no_answer(why));
    }
    let (area, count) = (placement.area_m2, placement.modes.len());
    task.voice.say(&format!("the trajectory can start anywhere in {area:.2} m² of the plan, in {count} separate places ({conditions})"));
    task.voice.say(&format!("picture: {}", task.output.path("place.png").display()));
    task.end()
}

fn refused(why: LocateError) -> Failure {
    match why {
        LocateError::BadScaleRange { .. } => Failure::usage(format!("the scales make no sense: {why}")),
        why => Failure::no_answer(format!("the trajectory was not placed: {why}")),
    }
}

fn entry(placement: &Placement) -> PlacementEntry {
    let mode = |m: &planwalk::locate::PlacementMode| PlacementModeEntry {
        start: PoseEntry::from(&m.start),
        metres_per_unit: m.scale,
        share: m.share,
    };
    PlacementEntry { area_m2: placement.area_m2, tried: placement.tried, modes: placement.modes.iter().map(mode).collect() }
}

/// The path at its best placement; empty where it fits nowhere.
fn at_best(path: &Path, placement: &Placement) -> Vec<(Stamp, PlanPose)> {
    let Some(best) = placement.modes.first() else { return Vec::new() };
    let pose = |odom: &Rigid2<_, _>| best.start * Rigid2::new(best.scale * odom.x, best.scale * odom.y, odom.heading_rad);
    path.stamps().zip(path.poses().iter().map(pose)).collect()
}
