//! `planwalk demo`: no input at all. A building and a walk are simulated, then the main job is done on them.

use std::convert::Infallible;

use planwalk::types::{FloorPlan, Seed};
use planwalk::{LocalizeOptions, Method, Walk};
use planwalk_sim::Scene;

use super::video::{Clip, follow};
use super::{Task, locate};
use crate::args::{DemoArgs, SolverName};
use crate::failure::Failure;

/// The building that is shown when no seed is given: a walk of some 30 m through rooms and a corridor. Any other seed works
/// too; some meet blank walls and mirrored rooms, and are harder.
const SHOWN: u64 = 11;

/// Simulates, and finds the walk again.
pub fn run(args: &DemoArgs) -> Result<(), Failure> {
    let mut task = Task::begin("demo", &args.common)?;
    let seed = Seed(args.common.seed.unwrap_or(SHOWN));
    task.result.seed = seed;
    task.voice.say("simulating a building and a walk through it; the video is all that the localisation sees, and the plan");
    let scene = Scene::demo(seed);
    let plan = scene.plan();
    write_plan(&task, &plan)?;
    let truth = scene.truth().into_iter();
    task.output.write_by("truth.tum", |path| planwalk_io::trajectory::write_tum(path, truth))?;
    let frames = scene.frames().map(Ok::<_, Infallible>);
    let clip = Clip { frames, count: Some(scene.frame_count()), camera: scene.camera(), solver: SolverName::FivePoint, name: "demo" };
    let walk = Walk::from(&follow(&mut task, clip)?);
    let options = LocalizeOptions { seed, start: None, method: Method::Planwalk };
    locate::localize(&mut task, &walk, &plan, &options, "demo: a simulated walk", &scene.truth_on_floor(), true)?;
    task.end()
}

fn write_plan(task: &Task, plan: &FloorPlan) -> Result<(), Failure> {
    let image = planwalk_io::plan::ros_map_image(plan);
    task.output.write("plan.pgm", image)?;
    task.output.write("plan.yaml", planwalk_io::plan::ros_map_yaml(plan, "plan.pgm"))
}
