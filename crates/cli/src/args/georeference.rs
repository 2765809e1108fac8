//! How is it said where on the globe a plan lies?

use std::path::PathBuf;
use std::str::FromStr;

use clap::{ArgGroup, Args};
use planwalk_io::plan::georeference::Crs;

use super::PlanFileArgs;

/// Arguments of `plan georeference`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("place").required(true).multiple(true).args(["point", "pixel", "world_file", "crs", "anchor"]))]
pub struct PlanGeoreferenceArgs {
    /// The plan and the file, a .plan.json.
    #[command(flatten)]
    pub file: PlanFileArgs,
    /// A point of the plan, in its metres, and its latitude and longitude in degrees; twice or more often
    #[arg(long, value_name = "X,Y=LAT,LON", allow_hyphen_values = true, conflicts_with_all = ["pixel", "world_file", "crs", "anchor"])]
    pub point: Vec<Known>,
    /// The same for a picture: pixels from its top left corner
    #[arg(long, value_name = "U,V=LAT,LON", allow_hyphen_values = true, conflicts_with_all = ["world_file", "crs", "anchor"])]
    pub pixel: Vec<Known>,
    /// World file of a picture (.pgw, .jgw, .tfw, .wld); it also gives the scale if none is given
    #[arg(long, value_name = "FILE", requires = "crs", conflicts_with = "anchor")]
    pub world_file: Option<PathBuf>,
    /// What the world file's numbers are; without one, the grid of the plan's own metres: EPSG:4326 (degrees), EPSG:326zz or EPSG:327zz
    /// (UTM zone zz, north or south), EPSG:258zz
    #[arg(long, value_name = "EPSG:N", conflicts_with = "anchor")]
    pub crs: Option<Crs>,
    /// Latitude and longitude of the plan's (0, 0), degrees
    #[arg(long, value_name = "LAT,LON", allow_hyphen_values = true, requires = "bearing", value_parser = pair)]
    pub anchor: Option<[f64; 2]>,
    /// Direction of the plan's y axis, degrees from north, clockwise
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, requires = "anchor")]
    pub bearing: Option<f64>,
}

/// A point of the plan and where it is: `x,y=latitude,longitude`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Metres, or pixels.
    pub at: [f64; 2],
    /// Degrees.
    pub latitude_deg: f64,
    /// Likewise.
    pub longitude_deg: f64,
}

impl FromStr for Known {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (at, globe) = text.split_once('=').ok_or_else(|| format!("\"{text}\" is no point: write x,y=latitude,longitude"))?;
        let (at, [latitude_deg, longitude_deg]) = (pair(at)?, pair(globe)?);
        Ok(Self { at, latitude_deg, longitude_deg })
    }
}

/// Two numbers with a comma between them.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let number = |part: &str| part.trim().parse().ok().filter(|v: &f64| v.is_finite());
    let pair = text.split_once(',').and_then(|(a, b)| Some([number(a)?, number(b)?]));
    pair.ok_or_else(|| format!("\"{text}\" is no pair of numbers such as 53.54083,9.99412"))
}
