//! What can be asked of a plan by itself?

use std::path::PathBuf;

use clap::{Args, Subcommand};
use planwalk::types::Seed;
use planwalk_io::plan::Measure;

use super::PlanArgs;

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanCommandArgs {
    /// What to do with the plan.
    #[command(subcommand)]
    pub command: PlanCommand,
}

/// What can be done with a plan.
#[derive(Debug, Subcommand)]
pub enum PlanCommand {
    /// Says what is on a plan: size, floor, walls, doors; and where it would fool anyone
    #[command(after_help = "Examples:
  planwalk plan info floor2.png --metres-per-pixel 0.02
  planwalk plan info scan.jpg --measure 100,200,400,200=6m --json
  planwalk plan info map.yaml --ambiguity -o out

--ambiguity walks 32 m from places all over the floor and compares what a camera would see of the walls with every other place, at
scales from ×0.7 to ×1.3. It writes ambiguity.png: how far one must walk to know where one is, and the pairs that are confused longest.
Furniture is not on the plan and does not count.")]
    Info(PlanInfoArgs),
}

/// Arguments of `plan info`.
#[derive(Debug, Args)]
pub struct PlanInfoArgs {
    /// Floor plan: an image, a ROS map.yaml, GeoJSON, or a CSV of walls x0,y0,x1,y1[,kind]
    #[arg(value_name = "PLAN")]
    pub plan: PathBuf,
    /// Metres in a pixel of the plan's image
    #[arg(long, value_name = "M")]
    pub metres_per_pixel: Option<f64>,
    /// Two pixels of the plan's image and their distance, e.g. 100,200,400,200=6m
    #[arg(long, value_name = "U1,V1,U2,V2=LENGTH")]
    pub measure: Option<Measure>,
    /// Find out how far one must walk to know where one is, and which places are confused
    #[arg(long)]
    pub ambiguity: bool,
    /// Folder for plan_info.json and the picture; it must be empty or new [default: nothing is written]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write into a folder that is not empty
    #[arg(long, requires = "output")]
    pub force: bool,
    /// Number that the directions of the walks grow from; the same seed gives the same bytes
    #[arg(long, value_name = "N", requires = "ambiguity")]
    pub seed: Option<u64>,
    /// Threads to use [default: all cores]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), requires = "ambiguity")]
    pub threads: Option<u16>,
    /// Print everything as JSON on standard output; everything else goes to standard error
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

impl PlanInfoArgs {
    /// The plan as other commands take it.
    pub fn plan(&self) -> PlanArgs {
        PlanArgs { plan: self.plan.clone(), metres_per_pixel: self.metres_per_pixel, measure: self.measure }
    }

    /// The seed, 0 where none was given.
    pub fn seed(&self) -> Seed {
        Seed(self.seed.unwrap_or(0))
    }
}
