//! From a video to its odometry, with what is written on the way.

use std::fmt::Display;
use std::time::Instant;

use planwalk::figure::TrajectoryPicture;
use planwalk::odometry::{Odometry, OdometryError, OdometryOptions, Solver};
use planwalk::result::{OdometryEntry, SecondEntry, SolverEntry};
use planwalk::types::{Camera, VideoFrame};
use planwalk::words;

use super::Task;
use crate::args::SolverName;
use crate::failure::{self, Failure};

/// What is to be followed.
pub struct Clip<'a, I> {
    /// The frames.
    pub frames: I,
    /// How many there will be, if known.
    pub count: Option<usize>,
    /// Their camera.
    pub camera: &'a Camera,
    /// Solver of the relative pose.
    pub solver: SolverName,
    /// For titles.
    pub name: &'a str,
}

/// Follows the clip and writes `odometry.tum`, `sightings.csv`, `camera.yaml` and the trajectory's picture: whatever comes
/// later, these stay.
pub fn follow<E: Display>(task: &mut Task, clip: Clip<'_, impl Iterator<Item = Result<VideoFrame, E>>>) -> Result<Odometry, Failure> {
    task.output.write_by("camera.yaml", |path| planwalk_io::camera::write(path, clip.camera))?;
    task.result.camera = Some(clip.camera.clone());
    let options = OdometryOptions { solver: Solver::from(clip.solver), seed: task.result.seed, ..OdometryOptions::default() };
    let bar = task.voice.bar("following", clip.count.map(|n| n as u64));
    let began = Instant::now();
    let followed = planwalk::follow(clip.frames, clip.camera, &options, &mut |done| bar.set_position(done as u64));
    bar.finish_and_clear();
    task.timing.odometry_s = Some(began.elapsed().as_secs_f64());
    if let Some(why) = &followed.cut_short {
        task.note([format!("the video ends early, after {} frames: {why}", followed.frames)]);
    }
    let odometry = followed.odometry.map_err(|why| refused(&why, followed.cut_short.as_ref()))?;
    write(task, &odometry, &clip.solver, clip.name)?;
    Ok(odometry)
}

/// A clip too short or cut off is an unusable input; one that shows nothing gives no answer.
fn refused(why: &OdometryError, cut_short: Option<&impl Display>) -> Failure {
    let code = match why {
        OdometryError::NothingToTrack { .. } => failure::NO_ANSWER,
        _ => failure::INPUT,
    };
    let cause = cut_short.map_or_else(String::new, |cause| format!("; the video ended early: {cause}"));
    Failure { message: format!("the video gives no odometry: {why}{cause}"), code }
}

fn write(task: &mut Task, odometry: &Odometry, solver: &SolverName, name: &str) -> Result<(), Failure> {
    let poses = odometry.poses.iter().map(|p| (p.stamp, p.odom_from_camera));
    task.output.write_by("odometry.tum", |path| planwalk_io::trajectory::write_tum(path, poses))?;
    task.output.write_by("sightings.csv", |path| planwalk_io::sightings::write(path, &odometry.sightings))?;
    let (solver, solver_words) = match solver {
        SolverName::FivePoint => (SolverEntry::FivePoint, "five-point"),
        SolverName::EightPoint => (SolverEntry::EightPoint, "eight-point"),
    };
    let title = format!("{name}: trajectory, {solver_words}");
    let picture = TrajectoryPicture { title: &title, poses: &odometry.poses, sightings: &odometry.sightings }.svg();
    task.draw("trajectory", &picture)?;
    task.trajectory = Some(picture);
    let seconds = odometry.poses.first().zip(odometry.poses.last()).map_or(0.0, |(a, b)| b.stamp.secs_since(a.stamp));
    task.timing.walk_s = seconds;
    let (frames, length, sightings) = (odometry.poses.len(), odometry.path.length(), odometry.sightings.len());
    let (unit_sigma, unit_evidence) = (odometry.unit.relative_sigma, odometry.unit.evidence.iter().map(Into::into).collect());
    let quality = SecondEntry::of(odometry);
    let entry = OdometryEntry { frames, seconds, length, sightings, solver, unit_sigma, unit_evidence, quality };
    let unit = words::unit(&entry);
    task.result.odometry = Some(entry);
    task.result.gaps = odometry.gaps.iter().map(Into::into).collect();
    let blind: f64 = odometry.gaps.iter().map(|g| g.to.secs_since(g.from)).sum();
    if !odometry.gaps.is_empty() {
        let (count, plural) = (odometry.gaps.len(), if odometry.gaps.len() == 1 { "" } else { "es" });
        task.note([format!(
            "{count} stretch{plural} of video, {blind:.1} s in all, in which nothing could be followed; see gaps in result.json"
        )]);
    }
    task.voice.say(&format!("followed {frames} frames, {seconds:.1} s: {length:.1} units walked, {sightings} sightings"));
    task.voice.say(&unit);
    Ok(())
}
