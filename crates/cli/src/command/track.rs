//! `planwalk track`: how did the camera move?

use super::video::{Clip, follow};
use super::{Task, name_of};
use crate::args::TrackArgs;
use crate::failure::Failure;
use crate::inputs;

/// Follows the camera through a video.
pub fn run(args: &TrackArgs) -> Result<(), Failure> {
    let mut task = Task::begin("track", &args.common)?;
    let video = inputs::video(&args.video, &args.reading, task.voice, task.result.seed)?;
    task.note(video.notes);
    let inputs::Video { source, camera } = video.value;
    let (count, name) = (source.frame_count(), name_of(&args.video));
    let clip = Clip { frames: source, count, camera: &camera, solver: args.reading.solver, name: &name };
    args.reading.note(&mut task);
    follow(&mut task, clip)?;
    task.result.inputs.push(inputs::entry("video", &args.video)?);
    if let Some(file) = &args.reading.camera {
        task.result.inputs.push(inputs::entry("camera", file)?);
    }
    task.voice.say(&format!("picture: {}", task.output.path("trajectory.png").display()));
    task.end()
}
