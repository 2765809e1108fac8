//! What can be asked of a plan by itself?

use std::path::PathBuf;

use clap::{Args, Subcommand};
use planwalk::types::Seed;

use super::{PlanGeoreferenceArgs, PlanReadingArgs};

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
    /// Says what is on a plan: storeys, rooms, doors, stairs; what on it looks wrong; and where it would fool anyone
    #[command(after_help = "Examples:
  planwalk plan info floor2.png --metres-per-pixel 0.02
  planwalk plan info scan.jpg --measure 100,200,400,200=6m --json
  planwalk plan info map.yaml --ambiguity -o out

Everything that looks wrong is listed at once, with its place, its size and what to do: gaps in the outline, floor that nobody gets to,
doors and a scale of no usual size, letters taken for walls, walls drawn twice. plan render marks the same numbers. Where rooms are not
drawn they are found between the walls.

--ambiguity walks 32 m from places all over the floor and compares what a camera would see of the walls with every other place, at
scales from ×0.7 to ×1.3. It writes ambiguity.png: how far one must walk to know where one is, and the pairs that are confused longest.
Furniture is not on the plan and does not count.")]
    Info(PlanInfoArgs),
    /// Reads a plan of any format, and keeps what was made of it: all storeys, walls, doors, windows, rooms
    #[command(after_help = "Formats, known by content:
  images (PNG, JPEG, TIFF, WebP, BMP, PGM), ROS map.yaml, SVG, PDF (drawn or scanned), DXF,
  GeoJSON, IMDF archives, OpenStreetMap (indoor tags, else roads), CSV of walls x0,y0,x1,y1[,kind], .plan.json

Examples:
  planwalk plan import floor2.png --metres-per-pixel 0.02 -o floor2.plan.json
  planwalk plan import office.dxf -o office.plan.json
  planwalk plan import mall.pdf --page 2 --drawing-scale 200 -o mall.plan.json
  planwalk locate walk.mp4 --plan office.plan.json -o out")]
    Import(PlanFileArgs),
    /// Writes a plan in another format, by the ending of the file: .svg, .geojson, .csv, .yaml (with a .pgm beside it) or .plan.json
    #[command(after_help = "Examples:
  planwalk plan export office.dxf -o office.svg
  planwalk plan export venue.imdf.zip --level 1 -o floor1.geojson
  planwalk plan export floor2.png --metres-per-pixel 0.02 -o map.yaml

GeoJSON is in degrees (RFC 7946) where the plan says where on the globe it is, unless --metres is given.")]
    Export(PlanExportArgs),
    /// Draws what was taken for what: rooms in colours with names, numbered findings, a legend, a scale bar; .png or .svg
    #[command(after_help = "Example:
  planwalk plan render office.dxf -o office.png")]
    Render(PlanFileArgs),
    /// Says where on the globe a plan lies, and keeps it: by known points, a world file, a grid, or an anchor and a bearing
    #[command(after_help = "Examples:
  planwalk plan georeference office.dxf --point 0,0=53.54083,9.99412 --point 42.5,0=53.54088,9.99476 --point 0,18=53.54099,9.99408 -o office.plan.json
  planwalk plan georeference floor2.png --metres-per-pixel 0.02 --pixel 10,12=53.541,9.994 --pixel 900,15=53.541,9.9945 -o floor2.plan.json
  planwalk plan georeference scan.png --world-file scan.pgw --crs EPSG:32632 -o scan.plan.json
  planwalk plan georeference site.csv --crs EPSG:25832 -o site.plan.json
  planwalk plan georeference office.dxf --anchor 53.54083,9.99412 --bearing 20 -o office.plan.json
  planwalk plan export office.plan.json -o office.geojson

Latitude comes first, as web maps show it; corners of the building that are seen on an aerial picture are good points. Two points place a
plan, three tell how well they agree, four or more who of them lies. The points' scale is told beside the plan's own, and the plan
keeps its own metres.")]
    Georeference(PlanGeoreferenceArgs),
}

/// A plan in, a file out.
#[derive(Debug, Clone, Args)]
pub struct PlanFileArgs {
    /// Floor plan of any format
    #[arg(value_name = "PLAN")]
    pub plan: PathBuf,
    /// How it is to be read.
    #[command(flatten)]
    pub reading: PlanReadingArgs,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Overwrite the file if it is there
    #[arg(long)]
    pub force: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `plan export`.
#[derive(Debug, Args)]
pub struct PlanExportArgs {
    /// The plan and the file.
    #[command(flatten)]
    pub file: PlanFileArgs,
    /// GeoJSON in the plan's own metres, even if its place on the globe is known
    #[arg(long)]
    pub metres: bool,
}

/// Arguments of `plan info`.
#[derive(Debug, Args)]
pub struct PlanInfoArgs {
    /// Floor plan of any format (see planwalk plan import --help)
    #[arg(value_name = "PLAN")]
    pub plan: PathBuf,
    /// How it is to be read.
    #[command(flatten)]
    pub reading: PlanReadingArgs,
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
    /// The seed, 0 where none was given.
    pub fn seed(&self) -> Seed {
        Seed(self.seed.unwrap_or(0))
    }
}
