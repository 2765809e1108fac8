//! What goes in? Files and folders opened, each refusal with its remedy and its path.

use std::path::Path;

use planwalk::result::InputEntry;
use planwalk::types::path::StepNoise;
use planwalk::types::{Camera, FloorPlan, IntrinsicsSource, OdometryScale, Sighting};
use planwalk_io::trajectory::PosesOptions;
use planwalk_io::video::{VideoOptions, VideoSource};

use crate::args::{PlanArgs, PlanReadingArgs, PosesArgs, VideoOptionsArgs};
use crate::failure::Failure;

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

/// Opens a video, and the camera file that goes with it or a phone's usual camera.
pub fn video(path: &Path, options: &VideoOptionsArgs) -> Result<Read<Video>, Failure> {
    let source =
        planwalk_io::video::open(path, &VideoOptions { fps: options.fps }).map_err(|why| Failure::input("the video", why, path))?;
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
        None => Camera::phone_prior(width, height),
    };
    if let IntrinsicsSource::PhonePrior { relative_sigma } = camera.source {
        let (focal, percent) = (camera.focal_px(), 100.0 * relative_sigma);
        notes.push(format!(
            "no camera file: a phone's usual focal length is assumed, {focal:.0} px ± {percent:.0} %; --camera makes turns exact"
        ));
    }
    Ok(Read { value: Video { source, camera }, notes })
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
