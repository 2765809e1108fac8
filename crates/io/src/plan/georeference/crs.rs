//! Which coordinates are these? Degrees on the globe, or metres of a UTM zone.

use std::fmt;
use std::str::FromStr;

use super::super::mercator::Utm;
use super::super::projection::Point;

/// A coordinate system of a world file, or of a plan's own metres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Crs {
    /// Longitude and latitude, degrees.
    Degrees,
    /// Metres of a zone.
    Utm {
        /// From 1 at 180° west, 6° each.
        zone: u8,
        /// Whether it is of the southern half.
        south: bool,
    },
}

/// A coordinate system that is not known.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{name}\" is no coordinate system that is known here: EPSG:4326 (degrees), EPSG:326zz or EPSG:327zz (UTM zone zz, north or south), \
     EPSG:258zz (ETRS89 UTM); reproject others with a GIS, or give points"
)]
pub struct CrsError {
    /// What was given.
    pub name: String,
}

impl Crs {
    pub(super) fn grid(self) -> Option<Utm> {
        match self {
            Self::Degrees => None,
            Self::Utm { zone, south } => Some(Utm { zone, south }),
        }
    }

    /// Longitude and latitude of its coordinates; `None` where it does not reach.
    pub(super) fn degrees(self, at: Point) -> Option<Point> {
        match self.grid() {
            None => (at[0].abs() <= 180.0 && at[1].abs() <= 90.0).then_some(at),
            Some(grid) => grid.degrees(at),
        }
    }
}

impl FromStr for Crs {
    type Err = CrsError;

    fn from_str(name: &str) -> Result<Self, CrsError> {
        let upper = name.trim().to_ascii_uppercase();
        let code = upper.rsplit(':').next().unwrap_or("");
        match code {
            "4326" | "4258" | "CRS84" => Ok(Self::Degrees),
            _ => Utm::of_epsg(code)
                .map(|Utm { zone, south }| Self::Utm { zone, south })
                .ok_or_else(|| CrsError { name: crate::text::short(name) }),
        }
    }
}

impl fmt::Display for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.grid() {
            None => f.write_str("WGS 84 degrees"),
            Some(grid) => write!(f, "UTM zone {}", grid.name()),
        }
    }
}
