//! What can be said of a simulated walk? Metres, degrees, shares.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use planwalk_io::trajectory::PosesFrame;
use planwalk_sim::BuildingKind;

use super::{Common, PlanReadingArgs, numbers};

/// What is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SimKind {
    /// Pictures, and all that goes with them
    Video,
    /// Odometry and sightings straight from the truth, without any picture
    Odometry,
}

/// Noise of simulated odometry, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NoiseName {
    /// Exact, in metres
    None,
    /// As a hand-held camera errs: unknown unit, drift, half of what is seen on no plan
    Monocular,
}

/// Arguments of `sim`.
#[derive(Debug, Args)]
pub struct SimArgs {
    /// What is made
    #[arg(value_enum, value_name = "WHAT", default_value_t = SimKind::Video)]
    pub what: SimKind,
    /// Options of the scene, as a scene.toml of an earlier run has them; what is said beside it counts more
    #[arg(long, value_name = "TOML")]
    pub scene: Option<PathBuf>,
    /// Building that is generated: office, open_plan, flat, loop or round
    #[arg(long, value_name = "KIND", conflicts_with = "plan")]
    pub building: Option<BuildingKind>,
    /// Its width and depth, metres
    #[arg(long, value_name = "W,D", value_parser = pair, conflicts_with = "plan")]
    pub size: Option<(f64, f64)>,
    /// A plan that is built as it is drawn, instead of a generated building: any floor plan
    #[arg(long, value_name = "PLAN")]
    pub plan: Option<PathBuf>,
    /// How the plan is to be read.
    #[command(flatten)]
    pub reading: PlanReadingArgs,
    /// Share of the inner walls on the plan that were never built, 0 to 1
    #[arg(long, value_name = "SHARE")]
    pub missing_walls: Option<f64>,
    /// Walls that were built and are not on the plan
    #[arg(long, value_name = "N")]
    pub extra_walls: Option<usize>,
    /// A given path of the camera on the plan, instead of a walker's: TUM, or any poses file
    #[arg(long, value_name = "FILE")]
    pub path: Option<PathBuf>,
    /// Frame of the path: camera (x right, y down, z forward), or body
    #[arg(long, value_name = "FRAME", requires = "path", default_value = "camera")]
    pub path_frame: PosesFrame,
    /// How the camera is turned on what the path is of: about its right, down and forward axes, degrees, in this order
    #[arg(long, value_name = "X,Y,Z", requires = "path", value_parser = triple, allow_hyphen_values = true)]
    pub mount: Option<[f64; 3]>,
    /// How long the walker walks, seconds
    #[arg(long, value_name = "S", conflicts_with = "path")]
    pub duration: Option<f64>,
    /// A walker with every habit that real ones have: own pace, stops, glances, tilts, a trembling hand
    #[arg(long, conflicts_with = "path")]
    pub lively: bool,
    /// A phone held upright, with rolling shutter, motion blur, hunting exposure and dark corners
    #[arg(long)]
    pub phone: bool,
    /// A fisheye lens
    #[arg(long)]
    pub fisheye: bool,
    /// Field of view along the long side, degrees
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f64>,
    /// Columns and rows
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    pub resolution: Option<(usize, usize)>,
    /// Frames per second
    #[arg(long, value_name = "FPS")]
    pub fps: Option<f64>,
    /// A camera file instead of a lens
    #[arg(long, value_name = "FILE", conflicts_with_all = ["fisheye", "fov", "resolution"])]
    pub camera: Option<PathBuf>,
    /// Share of the view that walking people fill, 0 to 0.5
    #[arg(long, value_name = "SHARE")]
    pub people: Option<f64>,
    /// How much there is to see on walls: 0 blank, 1 an ordinary office, up to 3
    #[arg(long, value_name = "AMOUNT")]
    pub texture: Option<f64>,
    /// How much stands about that no plan knows: 0 nothing, 1 an ordinary amount, up to 3
    #[arg(long, value_name = "AMOUNT")]
    pub furniture: Option<f64>,
    /// Noise of simulated odometry [default: none beside a video, monocular for odometry]
    #[arg(long, value_enum, value_name = "NAME")]
    pub noise: Option<NoiseName>,
    /// Poses a second of simulated odometry
    #[arg(long, value_name = "HZ", default_value_t = 5.0)]
    pub odometry_hz: f64,
    /// Walks through the same building; for odometry only
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub walks: u64,
    /// Shared arguments; the seed chooses building, walk and every noise
    #[command(flatten)]
    pub common: Common,
}

fn pair(text: &str) -> Result<(f64, f64), String> {
    match numbers(text)?[..] {
        [one, other] => Ok((one, other)),
        _ => Err("give two numbers, e.g. 40,25".to_owned()),
    }
}

fn triple(text: &str) -> Result<[f64; 3], String> {
    numbers(text)?.try_into().map_err(|_| "give three angles in degrees, e.g. 0,0,180".to_owned())
}

fn resolution(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once(['x', '×']).and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    parts.ok_or_else(|| "give columns and rows, e.g. 640x480".to_owned())
}
