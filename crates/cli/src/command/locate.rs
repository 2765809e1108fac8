//! `planwalk locate`: where on the plan was it walked?

use planwalk::evaluate::{AssociateOptions, PlaceOptions, place};
use std::time::Instant;

use planwalk::figure::{ParticlePicture, TrackPicture, gif_of};
use planwalk::locate::LocateError;
use planwalk::result::TruthEntry;
use planwalk::types::{Estimate, FloorPlan, PlanPose, Stamp};
use planwalk::{LocalizeOptions, Run, Walk, tables, words};

use super::video::{Clip, follow};
use super::{Task, name_of};
use crate::args::LocateArgs;
use crate::failure::{self, Failure};
use crate::inputs;

/// Finds a video, or a path from elsewhere, on a plan.
pub fn run(args: &LocateArgs) -> Result<(), Failure> {
    let mut task = Task::begin("locate", &args.common)?;
    // The plan first: it is quickly read, and a bad one should not cost a video's time.
    let plan = inputs::plan(&args.plan)?;
    task.note(plan.notes);
    let options =
        LocalizeOptions { seed: task.result.seed, start: args.start.map(|s| s.prior(args.start_sigma)), method: args.method.into() };
    // A start off the plan is said now, not after minutes of video.
    planwalk::check_start(&plan.value, &options).map_err(refused)?;
    note_options(&mut task, args);
    let (walk, name) = match (&args.video, &args.poses.poses) {
        (Some(video), _) => (from_video(&mut task, args, video)?, name_of(video)),
        (None, Some(poses)) => (from_poses(&mut task, args, poses)?, name_of(poses)),
        (None, None) => return Err(Failure::usage("give a video, or --poses FILE")),
    };
    task.result.inputs.push(inputs::entry("plan", &args.plan.plan)?);
    let title = format!("{name} on {}", name_of(&args.plan.plan));
    match localize(&mut task, &walk, &plan.value, &options, &title, &[], args.animation) {
        Ok(()) => task.end(),
        Err(failure) => {
            // No answer, but what was found on the way is kept, with the reason.
            task.result.error = Some(failure.message.clone());
            task.end().and(Err(failure))
        }
    }
}

fn note_options(task: &mut Task, args: &LocateArgs) {
    if args.video.is_some() {
        args.reading.note(task);
    }
    args.plan.note(task);
    task.option("start", args.start);
    task.option("start-sigma", args.start.map(|_| args.start_sigma));
    args.poses.note(task);
    task.option("animation", args.animation.then_some(""));
    task.option("method", Some(planwalk::Method::from(args.method)));
}

fn from_video(task: &mut Task, args: &LocateArgs, path: &std::path::Path) -> Result<Walk, Failure> {
    let video = inputs::video(path, &args.reading, task.voice, task.result.seed)?;
    task.note(video.notes);
    task.result.inputs.push(inputs::entry("video", path)?);
    if let Some(file) = &args.reading.camera {
        task.result.inputs.push(inputs::entry("camera", file)?);
    }
    let inputs::Video { source, camera } = video.value;
    let (count, name) = (source.frame_count(), name_of(path));
    let clip = Clip { frames: source, count, camera: &camera, solver: args.reading.solver, name: &name };
    Ok(Walk::from(&follow(task, clip)?))
}

fn from_poses(task: &mut Task, args: &LocateArgs, file: &std::path::Path) -> Result<Walk, Failure> {
    let poses = inputs::poses(file, &args.poses)?;
    task.note(poses.notes);
    task.result.inputs.push(inputs::entry("poses", file)?);
    let (path, scale) = poses.value;
    let sightings = match &args.sightings {
        Some(file) => {
            task.result.inputs.push(inputs::entry("sightings", file)?);
            let seen = inputs::sightings(file)?;
            task.note(seen.notes);
            seen.value
        }
        None => Vec::new(),
    };
    let steps = path.poses().iter().zip(path.stamps()).map(|(pose, stamp)| (stamp, tables::upright(pose))).collect::<Vec<_>>();
    task.output.write_by("odometry.tum", |path| planwalk_io::trajectory::write_tum(path, steps))?;
    task.output.write_by("sightings.csv", |path| planwalk_io::sightings::write(path, &sightings))?;
    Ok(Walk { path, sightings, scale })
}

/// Localises a walk and writes tables, pictures and report; `truth` is empty where it is not known, `animation` asks for one.
pub fn localize(
    task: &mut Task,
    walk: &Walk,
    plan: &FloorPlan,
    options: &LocalizeOptions,
    title: &str,
    truth: &[(Stamp, PlanPose)],
    animation: bool,
) -> Result<(), Failure> {
    let bar = task.voice.bar("localising", Some(1000));
    let began = Instant::now();
    let run = planwalk::localize(walk, plan, options, &mut |share| bar.set_position((1000.0 * share) as u64)).map_err(refused)?;
    bar.finish_and_clear();
    let found = &run.localization;
    task.timing.locate_s = Some(began.elapsed().as_secs_f64());
    task.timing.walk_s = found.track.first().zip(found.track.last()).map_or(0.0, |(a, b)| b.stamp.secs_since(a.stamp));
    task.result.set_localization(found);
    if !truth.is_empty() {
        task.result.truth = truth_entry(&found.track, truth);
    }
    task.output.write("track.csv", tables::estimates_csv(&found.track))?;
    task.output.write("filter.csv", tables::estimates_csv(&found.filter))?;
    let poses = found.track.iter().map(|e| (e.stamp, tables::upright(&e.pose)));
    task.output.write_by("track.tum", |path| planwalk_io::trajectory::write_tum(path, poses))?;
    draw(task, &run, plan, title, truth)?;
    if animation && !run.clouds.is_empty() {
        animate(task, &run, plan, title)?;
    }
    summary(task, &run);
    Ok(())
}

/// How far off the truth the track is; `None` where they share no time.
fn truth_entry(track: &[Estimate], truth: &[(Stamp, PlanPose)]) -> Option<TruthEntry> {
    // Half a step of a walker: odometry may have left out frames.
    let associate = AssociateOptions { max_diff_s: 0.05, ..AssociateOptions::default() };
    let scores = place::score(track, &[], truth, &PlaceOptions { associate, ..PlaceOptions::default() }).ok()?.track;
    Some(TruthEntry { truth_end_error_m: scores.end_m, truth_median_error_m: scores.median_m, truth_in_region95: scores.end_in_radius95 })
}

/// A start that makes no sense is wrong use; a walk that makes none is no answer.
fn refused(why: LocateError) -> Failure {
    let code = match why {
        LocateError::BadStart { .. } | LocateError::StartOffPlan { .. } => failure::USAGE,
        _ => failure::NO_ANSWER,
    };
    Failure { message: format!("the walk was not localised: {why}"), code }
}

fn draw(task: &Task, run: &Run, plan: &FloorPlan, title: &str, truth: &[(Stamp, PlanPose)]) -> Result<(), Failure> {
    let found = &run.localization;
    let picture = TrackPicture {
        title,
        plan,
        track: &found.track,
        hypotheses: &found.hypotheses,
        status: found.status,
        scale: found.scale,
        truth,
        contradicted: &found.contradicted,
    };
    let svg = picture.svg();
    task.draw("track", &svg)?;
    let walked: Vec<_> = found.track.iter().map(|e| (e.stamp, e.pose)).collect();
    let strip = planwalk::filmstrip(&run.clouds);
    let particles = (!strip.is_empty()).then(|| ParticlePicture { title, plan, track: &walked, moments: &strip }.svg());
    if let Some(particles) = &particles {
        task.draw("particles", particles)?;
    }
    let mut pictures = vec![("The walk on the plan", svg.as_str())];
    pictures.extend(task.trajectory.as_deref().map(|svg| ("The camera's path by itself, before any plan", svg)));
    pictures.extend(particles.as_deref().map(|svg| ("How it was found: where the walker might have been, as the walk went on", svg)));
    let page = planwalk::report::html(title, &pictures, &task.result, &found.track);
    task.output.write("report.html", page)
}

/// How the belief shrank, as moving pictures.
fn animate(task: &Task, run: &Run, plan: &FloorPlan, title: &str) -> Result<(), Failure> {
    /// As wide as fits beside a text.
    const WIDTH_PX: f64 = 720.0;
    let walked: Vec<_> = run.localization.track.iter().map(|e| (e.stamp, e.pose)).collect();
    let frames = ParticlePicture { title, plan, track: &walked, moments: &run.clouds }.frames(WIDTH_PX);
    let gif = gif_of(&frames).map_err(|why| Failure::output(why, &task.output.path("posterior.gif")))?;
    task.output.write("posterior.gif", gif)
}

fn summary(task: &Task, run: &Run) {
    let found = &run.localization;
    let probability = found.hypotheses.first().map_or(0.0, |h| h.probability);
    task.voice.say(&format!("{}: {}", found.status, words::verdict(found.status, probability)));
    if let Some(end) = found.track.last() {
        task.voice.say(&format!("  ends at {}", words::end_pose(end)));
    }
    task.voice.say(&format!("  {}", words::scale(&found.scale)));
    for other in found.hypotheses.iter().skip(1) {
        let (x, y) = (other.pose.x, other.pose.y);
        task.voice.say(&format!("  or, with {}, at ({x:.2}, {y:.2}) m", words::percent(other.probability)));
    }
    for apart in &task.result.apart {
        task.voice.say(&format!("  {}", words::apart(apart)));
    }
    if let Some(contradicted) = words::contradicted(&task.result.contradicted) {
        task.voice.say(&format!("  {contradicted}"));
    }
    if let Some(truth) = &task.result.truth {
        let inside = if truth.truth_in_region95 { "inside" } else { "outside" };
        let (end, median) = (truth.truth_end_error_m, truth.truth_median_error_m);
        task.voice.say(&format!("  truth: {end:.2} m off at the end ({inside} the 95 % region), {median:.2} m in the median"));
    }
    task.voice.say(&format!("picture: {}", task.output.path("track.png").display()));
}
