//! What is scored, against what, and how are both brought together?

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use planwalk::evaluate::Alignment;
use planwalk_io::trajectory::{PosesFormat, PosesFrame};

/// Arguments of `eval`.
#[derive(Debug, Args)]
pub struct EvalArgs {
    /// Output folder of locate, track or demo; or a trajectory file
    #[arg(value_name = "DIR|FILE")]
    pub result: PathBuf,
    /// The truth: TUM, KITTI, EuRoC, CARMEN, or CSV (t_s,x_m,y_m and perhaps yaw_rad)
    #[arg(long, value_name = "FILE")]
    pub truth: PathBuf,
    /// Format of the truth: tum, kitti, euroc, carmen, csv [default: by content]
    #[arg(long, value_name = "FORMAT")]
    pub truth_format: Option<PosesFormat>,
    /// Frame of the truth: body, or camera (x right, y down, z forward) [default: body; camera for KITTI]
    #[arg(long, value_name = "FRAME")]
    pub truth_frame: Option<PosesFrame>,
    /// Times of KITTI poses, seconds, one a line [default: TRUTH_times.txt or times.txt beside the truth, else 10 Hz]; of a
    /// robot's corrected log: the raw log of the same drive, whose scans say when
    #[arg(long, value_name = "FILE")]
    pub truth_times: Option<PathBuf>,
    /// Format of a trajectory file [default: by content]
    #[arg(long, value_name = "FORMAT")]
    pub poses_format: Option<PosesFormat>,
    /// Frame of a trajectory file: body or camera [default: body; camera for KITTI]
    #[arg(long, value_name = "FRAME")]
    pub poses_frame: Option<PosesFrame>,
    /// What is free when odometry is laid over the truth; none also scores a trajectory file as a track on the plan
    /// [default: sim3; sim2 for odometry from --poses, se2 where that was metric]
    #[arg(long, value_enum)]
    pub align: Option<AlignName>,
    /// Most seconds between an estimate and its true pose
    #[arg(long, value_name = "S", default_value_t = 0.01)]
    pub max_diff: f64,
    /// Interpolate the truth between poses at most so many seconds apart [default: take the nearest pose]
    #[arg(long, value_name = "GAP_S")]
    pub interpolate_truth: Option<f64>,
    /// Seconds to add to the stamps of what is scored
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true)]
    pub time_offset: f64,
    /// Folder for eval.json and its pictures [default: DIR, or where FILE is]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Print eval.json on standard output; everything else goes to standard error
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Alignments by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AlignName {
    /// Nothing: one frame
    None,
    /// Shift and turn on the floor
    Se2,
    /// Shift, turn and scale on the floor
    Sim2,
    /// Shift and turn in space
    Se3,
    /// Shift, turn and scale in space
    Sim3,
}

impl From<AlignName> for Alignment {
    fn from(name: AlignName) -> Self {
        match name {
            AlignName::None => Alignment::None,
            AlignName::Se2 => Alignment::Se2,
            AlignName::Sim2 => Alignment::Sim2,
            AlignName::Se3 => Alignment::Se3,
            AlignName::Sim3 => Alignment::Sim3,
        }
    }
}
