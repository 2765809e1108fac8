//! What can be asked for? The command line, with units: metres and degrees.

mod bench;
mod eval;
mod georeference;
mod plan;
mod sim;

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};
use planwalk::Method;
use planwalk::locate::StartPrior;
use planwalk::odometry::Solver;
use planwalk::types::{OdometryScale, Seed};
use planwalk_io::plan::{Measure, PlanOptions};
use planwalk_io::trajectory::{PosesFormat, PosesFrame};

use crate::command::Task;

pub use bench::BenchArgs;
pub use eval::EvalArgs;
pub use georeference::{Known, PlanGeoreferenceArgs};
pub use plan::{PlanCommand, PlanCommandArgs, PlanExportArgs, PlanFileArgs, PlanInfoArgs};
pub use sim::{NoiseName, SimArgs, SimKind};

/// Tells where on a floor plan a first-person video was walked, how sure it is, and where else it could have been.
#[derive(Debug, Parser)]
#[command(name = "planwalk", version, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "Examples:
  planwalk demo
  planwalk locate walk.mp4 --plan floor2.png --metres-per-pixel 0.02 -o out
  planwalk locate frames/ --fps 12 --camera camera.yaml --plan map.yaml --start 1.5,2,90 -o out
  planwalk locate --poses odometry.tum --odometry-scale metric --plan map.yaml -o out
  planwalk track walk.mp4 --solver eight-point -o out
  planwalk eval out --truth truth.tum

Exit codes: 0 done (an ambiguous verdict is an answer), 2 usage, 4 input unusable, 5 no answer at all.";

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulates a building and a walk through it, and finds the walk again from the video alone
    #[command(mut_arg("output", |output| output.required(false).default_value("planwalk-demo")), after_help = "Examples:
  planwalk demo
  planwalk demo -o out --seed 7 --json")]
    Demo(DemoArgs),
    /// Follows the camera through a video: odometry, without any plan
    #[command(after_help = "Examples:
  planwalk track walk.mp4 -o out
  planwalk track frames/ --fps 12 --camera camera.yaml --solver eight-point -o out")]
    Track(TrackArgs),
    /// Finds where on a plan a video, or a path from elsewhere, was walked
    #[command(after_help = "Examples:
  planwalk locate walk.mp4 --plan floor2.png --metres-per-pixel 0.02 -o out
  planwalk locate walk.mp4 --plan scan.jpg --measure 100,200,400,200=6m --start 3.5,2 -o out
  planwalk locate --poses odometry.tum --sightings sightings.csv --plan map.yaml -o out
  planwalk locate --poses robot.clf --sightings robot.clf --odometry-scale metric --plan map.yaml -o out
  planwalk locate --poses steps.tum --odometry-scale 0.1 --plan floor4.geojson -o out")]
    Locate(LocateArgs),
    /// Shows every place of a plan where a trajectory fits without touching a wall
    #[command(after_help = "Examples:
  planwalk place --poses walk.tum --plan map.yaml --odometry-scale metric -o out
  planwalk place --poses walk.tum --plan map.yaml --heading 90 --scale-range 0.8,1.2 -o out
  planwalk place --poses wheels.tum --plan map.yaml --odometry-scale metric --drift 0.5 --length-error 2 -o out

Without --drift and --length-error the trajectory is taken as perfect: one that drifts by half a corridor's width fits nowhere. With
them it may bend within what they allow, and no such walk is missed; the regions then hold more than those walks.")]
    Place(PlaceArgs),
    /// Says what is on a plan, and how far one must walk on it to know where one is
    #[command(after_help = "Examples:
  planwalk plan info floor2.png --metres-per-pixel 0.02
  planwalk plan info map.yaml --ambiguity -o out --json")]
    Plan(PlanCommandArgs),
    /// Scores a result, or a trajectory from elsewhere, against the truth
    #[command(after_help = "Examples:
  planwalk eval out --truth truth.tum
  planwalk eval out --truth camera-truth.tum --truth-frame camera
  planwalk eval out --truth clicked.csv --interpolate-truth 1.5
  planwalk eval orb-slam.txt --truth 00.txt --truth-times times.txt --align se3 -o scores")]
    Eval(EvalArgs),
    /// Simulates a walk with known truth: a building or any plan, a walker or a given path, a phone's camera
    #[command(after_help = "Examples:
  planwalk sim -o office                                  (a video, its camera, its truth, its plan)
  planwalk sim --building loop --lively --phone --people 0.3 -o hard
  planwalk sim --plan floor2.png --metres-per-pixel 0.01 --path truth.tum --mount 0,0,180 -o again
  planwalk sim --scene office/scene.toml --seed 7 -o like-it
  planwalk sim odometry --building open_plan --walks 100 -o walks

Everything that can be said of a scene stands in the scene.toml that is written; --scene reads it back.")]
    Sim(SimArgs),
    /// Scores localisers on many walks: real ones, simulated ones, or those of a suite of your own
    #[command(mut_arg("output", |output| output.required(false).default_value("planwalk-bench")), after_help = "Suites that come along: smoke (under a minute), sim, real, odometry, speed.

Examples:
  planwalk bench smoke -o out
  planwalk bench real --data ~/walks -o out --method planwalk --method report
  planwalk bench sim -o out --shard 2/8          (then put the shards' results.jsonl together)
  planwalk bench sim -o out --resume             (goes on where it was stopped)
  planwalk bench sim -o new --compare old/results.jsonl
  planwalk bench sim --only office/0/3 --seed 0 --method planwalk -o one
  planwalk bench mine.toml --data . -o out")]
    Bench(BenchArgs),
}

/// What every command takes.
#[derive(Debug, Args)]
pub struct Common {
    /// Folder for the results; it must be empty or new
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Write into a folder that is not empty
    #[arg(long)]
    pub force: bool,
    /// Number that chance grows from; the same seed gives the same bytes
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Threads to use [default: all cores]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Print the summary as JSON on standard output; everything else goes to standard error
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

impl Common {
    /// The seed, 0 where none was given.
    pub fn seed(&self) -> Seed {
        Seed(self.seed.unwrap_or(0))
    }
}

/// Arguments of `demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Shared arguments; here the seed also chooses the building
    #[command(flatten)]
    pub common: Common,
}

/// How a video is read.
#[derive(Debug, Args)]
pub struct VideoOptionsArgs {
    /// Frames per second of a folder of images
    #[arg(long, value_name = "FPS", conflicts_with = "poses")]
    pub fps: Option<f64>,
    /// Camera file, ROS camera_info or Kalibr layout [default: the focal length is measured from the video]
    #[arg(long, value_name = "FILE", conflicts_with = "poses")]
    pub camera: Option<PathBuf>,
    /// Solver of the relative pose between two views
    #[arg(long, value_enum, default_value_t = SolverName::FivePoint, conflicts_with = "poses")]
    pub solver: SolverName,
}

impl VideoOptionsArgs {
    /// Writes down what is in force.
    pub fn note(&self, task: &mut Task) {
        task.option("fps", self.fps);
        task.option("solver", self.solver.to_possible_value().map(|v| v.get_name().to_owned()));
    }
}

/// Arguments of `track`.
#[derive(Debug, Args)]
pub struct TrackArgs {
    /// Video file, or folder of images in name order
    #[arg(value_name = "VIDEO")]
    pub video: PathBuf,
    /// How the video is read.
    #[command(flatten)]
    pub reading: VideoOptionsArgs,
    /// Shared arguments.
    #[command(flatten)]
    pub common: Common,
}

/// A path from elsewhere.
#[derive(Debug, Args)]
pub struct PosesArgs {
    /// Poses instead of a video: TUM, KITTI, EuRoC, CARMEN or CSV
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    /// Format of the poses: tum, kitti, euroc, carmen, csv [default: by content]
    #[arg(long, value_name = "FORMAT", requires = "poses")]
    pub poses_format: Option<PosesFormat>,
    /// Frame of the poses: body, or camera (x right, y down, z forward) [default: body; camera for KITTI]
    #[arg(long, value_name = "FRAME", requires = "poses")]
    pub poses_frame: Option<PosesFrame>,
    /// Metres in a unit of the poses: metric, unknown, or a relative standard deviation such as 0.1 [default: unknown]
    #[arg(long, value_name = "SCALE", value_parser = odometry_scale, requires = "poses")]
    pub odometry_scale: Option<OdometryScale>,
}

impl PosesArgs {
    /// Writes down what was said of them.
    pub fn note(&self, task: &mut Task) {
        task.option("poses-format", self.poses_format.map(|f| format!("{f:?}").to_lowercase()));
        task.option("poses-frame", self.poses_frame.map(|f| format!("{f:?}").to_lowercase()));
        task.option(
            "odometry-scale",
            self.odometry_scale.map(|s| match s {
                OdometryScale::Metric => "metric".to_owned(),
                OdometryScale::Unknown => "unknown".to_owned(),
                OdometryScale::Relative(sigma) => sigma.to_string(),
            }),
        );
    }
}

/// A plan and how it is to be read.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// Floor plan: an image, ROS map.yaml, SVG, PDF, DXF, GeoJSON, IMDF, OpenStreetMap, a CSV of walls x0,y0,x1,y1[,kind] or a .plan.json
    #[arg(long, value_name = "PLAN")]
    pub plan: PathBuf,
    /// How it is to be read.
    #[command(flatten)]
    pub reading: PlanReadingArgs,
}

/// How a plan is to be read.
#[derive(Debug, Clone, Default, Args)]
pub struct PlanReadingArgs {
    /// Metres in a pixel of the plan's image, or in a unit of its drawing
    #[arg(long, value_name = "M")]
    pub metres_per_pixel: Option<f64>,
    /// Two pixels of the plan's image (or points of its drawing) and their distance, e.g. 100,200,400,200=6m; given twice, the two
    /// are compared
    #[arg(long, value_name = "U1,V1,U2,V2=LENGTH")]
    pub measure: Vec<Measure>,
    /// Scale of a plan drawn on paper (PDF, SVG): 100 for 1:100
    #[arg(long, value_name = "N")]
    pub drawing_scale: Option<f64>,
    /// Page of a PDF, from 1 [default: the first with a drawing]
    #[arg(long, value_name = "N")]
    pub page: Option<usize>,
    /// Storey of a plan that has several: its name, or its number from the ground floor [default: the ground floor]
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    pub level: Option<String>,
}

impl PlanReadingArgs {
    /// As readers take it.
    pub fn options(&self) -> PlanOptions {
        PlanOptions {
            metres_per_pixel: self.metres_per_pixel,
            measures: self.measure.clone(),
            level: self.level.clone(),
            page: self.page,
            drawing_scale: self.drawing_scale,
        }
    }

    /// What was said, as options and values.
    pub fn said(&self) -> Vec<(&'static str, String)> {
        let measures = self.measure.iter().map(|measure| ("measure", Some(measure.to_string())));
        let others = [
            ("metres-per-pixel", self.metres_per_pixel.map(|m| m.to_string())),
            ("drawing-scale", self.drawing_scale.map(|n| n.to_string())),
            ("page", self.page.map(|n| n.to_string())),
            ("level", self.level.clone()),
        ];
        others.into_iter().chain(measures).filter_map(|(name, value)| Some((name, value?))).collect()
    }
}

impl PlanArgs {
    /// Writes down what was said of it.
    pub fn note(&self, task: &mut Task) {
        for (name, value) in self.reading.said() {
            task.option(name, Some(value));
        }
    }
}

/// Arguments of `locate`.
#[derive(Debug, Args)]
pub struct LocateArgs {
    /// Video file, or folder of images in name order
    #[arg(value_name = "VIDEO", required_unless_present = "poses", conflicts_with = "poses")]
    pub video: Option<PathBuf>,
    /// How the video is read.
    #[command(flatten)]
    pub reading: VideoOptionsArgs,
    /// A path from elsewhere.
    #[command(flatten)]
    pub poses: PosesArgs,
    /// Sightings to go with the poses: CSV t_s,bearing_rad,range,sigma, or the laser in a CARMEN log
    #[arg(long, value_name = "FILE", requires = "poses")]
    pub sightings: Option<PathBuf>,
    /// The plan.
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Where the walk began, if known: metres on the plan, and the heading in degrees anticlockwise from +x
    #[arg(long, value_name = "X,Y[,HEADING]", allow_hyphen_values = true)]
    pub start: Option<Start>,
    /// How surely the start is known, metres
    #[arg(long, value_name = "M", default_value_t = 0.5, requires = "start")]
    pub start_sigma: f64,
    /// Localiser
    #[arg(long, value_enum, default_value_t = MethodName::Planwalk)]
    pub method: MethodName,
    /// Also draw posterior.gif: how the places that the walker might be at became one
    #[arg(long)]
    pub animation: bool,
    /// Shared arguments.
    #[command(flatten)]
    pub common: Common,
}

/// Arguments of `place`.
#[derive(Debug, Args)]
pub struct PlaceArgs {
    /// The trajectory.
    #[command(flatten)]
    pub poses: PosesArgs,
    /// The plan.
    #[command(flatten)]
    pub plan: PlanArgs,
    /// Heading of the first pose on the plan, degrees anticlockwise from +x [default: all headings]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub heading: Option<f64>,
    /// Metres per unit of the poses, from and to [default: as --odometry-scale says]
    #[arg(long, value_name = "LOW,HIGH", value_parser = scale_range)]
    pub scale_range: Option<(f64, f64)>,
    /// How far the trajectory's heading drifts at most, degrees per √metre: over any 4 m by twice, over 100 m by ten times as much
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0)]
    pub drift: f64,
    /// How far the length of any stretch is off at most, per cent, on top of the scale
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    pub length_error: f64,
    /// Shared arguments.
    #[command(flatten)]
    pub common: Common,
}

/// Solvers by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SolverName {
    /// Nistér 2004
    FivePoint,
    /// Hartley 1997, normalised
    EightPoint,
}

impl From<SolverName> for Solver {
    fn from(name: SolverName) -> Self {
        match name {
            SolverName::FivePoint => Solver::FivePoint,
            SolverName::EightPoint => Solver::EightPoint,
        }
    }
}

/// Localisers by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodName {
    /// Walls walked into and walls seen, scale found on the plan
    Planwalk,
    /// The baseline: the recipe of Chu 2013, walls walked into only, scale taken as true
    Report,
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Planwalk => Method::Planwalk,
            MethodName::Report => Method::Report,
        }
    }
}

/// A start in metres and degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Metres on the plan.
    pub x: f64,
    /// Metres on the plan.
    pub y: f64,
    /// Degrees anticlockwise from +x.
    pub heading_deg: Option<f64>,
}

/// How surely a stated heading is known: a person who says "along the corridor" means some 10°.
const START_HEADING_SIGMA_DEG: f64 = 10.0;

impl Start {
    /// As a prior whose place is known within `sigma_m`.
    pub fn prior(&self, sigma_m: f64) -> StartPrior {
        let heading_rad = self.heading_deg.map(f64::to_radians);
        StartPrior { x: self.x, y: self.y, heading_rad, sigma_m, sigma_rad: START_HEADING_SIGMA_DEG.to_radians() }
    }
}

impl std::fmt::Display for Start {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{}", self.x, self.y)?;
        self.heading_deg.map_or(Ok(()), |heading| write!(f, ",{heading}"))
    }
}

impl FromStr for Start {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match numbers(text)?[..] {
            [x, y] => Ok(Self { x, y, heading_deg: None }),
            [x, y, heading_deg] => Ok(Self { x, y, heading_deg: Some(heading_deg) }),
            _ => Err("give x,y in metres on the plan, or x,y,heading with degrees, e.g. 1.5,2,90".to_owned()),
        }
    }
}

fn scale_range(text: &str) -> Result<(f64, f64), String> {
    match numbers(text)?[..] {
        [low, high] if low > 0.0 && high >= low => Ok((low, high)),
        _ => Err("give two positive numbers, the lower first, e.g. 0.8,1.2".to_owned()),
    }
}

pub fn odometry_scale(text: &str) -> Result<OdometryScale, String> {
    match text {
        "metric" => Ok(OdometryScale::Metric),
        "unknown" => Ok(OdometryScale::Unknown),
        _ => match text.parse::<f64>() {
            Ok(sigma) if sigma > 0.0 && sigma <= 2.0 => Ok(OdometryScale::Relative(sigma)),
            _ => Err("give metric, unknown, or a relative standard deviation between 0 and 2, e.g. 0.1".to_owned()),
        },
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| format!("{part:?} is not a number"));
    text.split(',').map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn starts_are_metres_and_degrees() {
        assert_eq!("1.5,-2".parse(), Ok(Start { x: 1.5, y: -2.0, heading_deg: None }));
        assert_eq!("1.5, -2, 90".parse(), Ok(Start { x: 1.5, y: -2.0, heading_deg: Some(90.0) }));
        assert!("1.5".parse::<Start>().is_err() && "1,NaN".parse::<Start>().is_err() && "a,b".parse::<Start>().is_err());
    }

    #[test]
    fn scales_are_named_or_a_spread() {
        assert_eq!(odometry_scale("metric"), Ok(OdometryScale::Metric));
        assert_eq!(odometry_scale("0.1"), Ok(OdometryScale::Relative(0.1)));
        assert!(odometry_scale("-1").is_err() && odometry_scale("feet").is_err());
        assert!(scale_range("1.2,0.8").is_err());
    }
}
