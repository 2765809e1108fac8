//! What goes in? Files and folders opened, each refusal with its remedy and its path.

use std::path::Path;

use planwalk::result::InputEntry;
use planwalk::types::path::StepNoise;
use planwalk::types::{Camera, FloorPlan, IntrinsicsSource, OdometryScale, Seed, Sighting};
use planwalk_io::trajectory::PosesOptions;
use planwalk_io::video::{VideoOptions, VideoSource};

use crate::args::{PlanArgs, PlanReadingArgs, PosesArgs, VideoOptionsArgs};
use crate::failure::Failure;
use crate::say::Voice;

/// What was read, and what a person should know of it.
pub struct Read<T> {
    /// The noun.
    pub value: T,
    /// Assumptions and oddities.
    pub notes: Vec<String>,
}

/// The input's hash for `result.json`.
pub fn entry(role: &str, path: &Path) -> Result<InputEntry, Failure> {
    let sha256 = planwalk_io::inputs::sha256_of(path).map_err(|why| Failure::input(&format!("the {role}"), why, path))?;
    Ok(InputEntry { role: role.to_owned(), path: path.display().to_string(), sha256 })
}

/// A video and its camera.
pub struct Video {
    /// The frames.
    pub source: Box<dyn VideoSource>,
    /// What took them.
    pub camera: Camera,
}

/// Opens a video, and the camera file that goes with it; without one the lens is measured from the video's beginning.
pub fn video(path: &Path, options: &VideoOptionsArgs, voice: Voice, seed: Seed) -> Result<Read<Video>, Failure> {
    let reading = VideoOptions { fps: options.fps };
    let open = || planwalk_io::video::open(path, &reading).map_err(|why| Failure::input("the video", why, path));
    let source = open()?;
    let (width, height) = source.size();
    let mut notes = source.info().notes.clone();
    if source.info().rotation_deg != 0 {
        notes.push(format!("the video is stored turned; its rotation of {}° was applied", source.info().rotation_deg));
    }
    let camera = match &options.camera {
        Some(file) => {
            let camera =
                planwalk_io::camera::read_for(file, (width, height)).map_err(|why| Failure::input("the camera file", why, file))?;
            camera.check_size(width, height).map_err(|why| Failure::input("the camera file", why, file))?;
            camera
        }
        None => {
            // Read a second time: what is measured here is needed before the first frame is followed.
            let bar = voice.bar("measuring the lens", None);
            let lens = planwalk::measure_lens(open()?, (width, height), seed, &mut |done| bar.set_position(done as u64));
            bar.finish_and_clear();
            lens.camera(width, height)
        }
    };
    notes.extend(lens_note(&camera));
    Ok(Read { value: Video { source, camera }, notes })
}

/// What a person should know of a camera that was not stated.
fn lens_note(camera: &Camera) -> Option<String> {
    let (focal, usual) = (camera.focal_px(), Camera::phone_prior(camera.width, camera.height).focal_px());
    match camera.source {
        IntrinsicsSource::Stated => None,
        IntrinsicsSource::Measured { relative_sigma } => Some(format!(
            "no camera file: the focal length was measured from straight edges and turns: {focal:.0} px ± {:.0} % (a phone's usual: \
             {usual:.0}); --camera makes turns exact",
            100.0 * relative_sigma
        )),
        IntrinsicsSource::PhonePrior { relative_sigma } => Some(format!(
            "no camera file, and too few straight edges and turns to measure the lens: a phone's usual focal length is assumed, \
             {focal:.0} px ± {:.0} %; --camera makes turns exact",
            100.0 * relative_sigma
        )),
    }
}

/// A path from a poses file, and what is known of its unit.
pub fn poses(path: &Path, args: &PosesArgs) -> Result<Read<(planwalk::types::Path, OdometryScale)>, Failure> {
    let options = PosesOptions { format: args.poses_format, frame: args.poses_frame, fps: None };
    let file = planwalk_io::trajectory::read(path, &options).map_err(|why| Failure::input("the poses file", why, path))?;
    let scale = args.odometry_scale.unwrap_or(OdometryScale::Unknown);
    Ok(Read { value: (file.trajectory.to_path(&StepNoise::default()), scale), notes: file.notes })
}

/// Sightings from a file: a table, or a robot's laser.
pub fn sightings(path: &Path) -> Result<Read<Vec<Sighting>>, Failure> {
    let file = planwalk_io::sightings::open(path).map_err(|why| Failure::input("the sightings file", why, path))?;
    Ok(Read { value: file.sightings, notes: file.notes })
}

/// A plan.
pub fn plan(args: &PlanArgs) -> Result<Read<FloorPlan>, Failure> {
    plan_at(&args.plan, &args.reading)
}

/// A plan that stands alone on the command line.
pub fn plan_at(path: &Path, reading: &PlanReadingArgs) -> Result<Read<FloorPlan>, Failure> {
    let file = planwalk_io::plan::read(path, &reading.options()).map_err(|why| Failure::input("the plan", why, path))?;
    Ok(Read { value: file.plan, notes: file.notes })
}
