//! Where does a world file (`.pgw`, `.jgw`, `.tfw`, `.wld`) put a picture? Six numbers: A, D, B, E, C, F, a line each.
//!
//! x = A·column + B·row + C, y = D·column + E·row + F: of pixel **centres**, rows from the top, in a coordinate system that the file
//! does not name. In degrees A and E differ by the cosine of the latitude.

use std::str::FromStr;

use planwalk_types::Pt2;

use super::super::projection::LocalMap;
use super::{ControlPoint, Crs};

/// Where the pixels of a picture are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldFile {
    /// A, D, B, E, C, F.
    numbers: [f64; 6],
}

/// Why a world file is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WorldFileError {
    /// Not six numbers.
    #[error("the world file has {got} finite numbers, one a line, and not six: A, D, B, E, C, F")]
    NotSix {
        /// Numbers found.
        got: usize,
    },
    /// Pixels without a size.
    #[error("the world file gives pixels no size: A·E − B·D is 0")]
    Flat,
    /// Somewhere else.
    #[error("by the world file the picture's corner is at ({x}, {y}), which is not on {crs}: give the --crs that its numbers are in")]
    OffMap {
        /// Easting or longitude.
        x: f64,
        /// Northing or latitude.
        y: f64,
        /// What was said.
        crs: Crs,
    },
}

impl FromStr for WorldFile {
    type Err = WorldFileError;

    fn from_str(text: &str) -> Result<Self, WorldFileError> {
        let found: Vec<f64> = text.split_whitespace().map_while(|word| word.parse().ok().filter(|v: &f64| v.is_finite())).collect();
        let numbers: [f64; 6] = found.try_into().map_err(|found: Vec<f64>| WorldFileError::NotSix { got: found.len() })?;
        let [a, d, b, e, ..] = numbers;
        if !((a * e - b * d).abs() > 0.0) {
            return Err(WorldFileError::Flat);
        }
        Ok(Self { numbers })
    }
}

impl WorldFile {
    /// Longitude and latitude of a point of the picture, pixels from its top left corner.
    fn degrees(&self, [u, v]: [f64; 2], crs: Crs) -> Result<[f64; 2], WorldFileError> {
        let [a, d, b, e, c, f] = self.numbers;
        let (column, row) = (u - 0.5, v - 0.5);
        let [x, y] = [a * column + b * row + c, d * column + e * row + f];
        crs.degrees([x, y]).ok_or(WorldFileError::OffMap { x, y, crs })
    }

    /// Metres on the ground in a pixel of a picture of this size: the mean over its two directions.
    ///
    /// # Errors
    /// [`WorldFileError::OffMap`].
    pub fn metres_per_pixel(&self, crs: Crs, [width, height]: [f64; 2]) -> Result<f64, WorldFileError> {
        let middle = [0.5 * width, 0.5 * height];
        let map = LocalMap::around(self.degrees(middle, crs)?);
        let side = |ends: [[f64; 2]; 2], length: f64| {
            let [from, to] = [map.metres(self.degrees(ends[0], crs)?), map.metres(self.degrees(ends[1], crs)?)];
            Ok::<f64, WorldFileError>((to[0] - from[0]).hypot(to[1] - from[1]) / length)
        };
        let across = side([[0.0, middle[1]], [width, middle[1]]], width)?;
        let along = side([[middle[0], 0.0], [middle[0], height]], height)?;
        Ok(0.5 * (across + along))
    }

    /// The picture's corners on the plan and on the globe.
    ///
    /// # Errors
    /// [`WorldFileError::OffMap`].
    pub fn control(&self, crs: Crs, [width, height]: [f64; 2], metres_per_pixel: f64) -> Result<Vec<ControlPoint>, WorldFileError> {
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        let point = |[u, v]: [f64; 2]| {
            let [longitude_deg, latitude_deg] = self.degrees([u, v], crs)?;
            let plan = Pt2::new(u * metres_per_pixel, (height - v) * metres_per_pixel);
            Ok(ControlPoint { plan, longitude_deg, latitude_deg })
        };
        corners.into_iter().map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit;
    use super::*;

    const UTM_32N: Crs = Crs::Utm { zone: 32, south: false };

    #[test]
    fn a_picture_on_a_grid_lies_where_its_world_file_says() {
        // 10 cm a pixel, the centre of the top left one at 566 600.05, 5 932 899.95: its corner on whole metres.
        let world: WorldFile = "0.1\n0\n0\n-0.1\n566600.05\n5932899.95\n".parse().unwrap();
        let size = [1000.0, 500.0];
        let metres = world.metres_per_pixel(UTM_32N, size).unwrap();
        // Grid metres are 0.35 ‰ longer than the ground's there.
        assert!((metres / 0.1 - 1.000_35).abs() < 1e-5, "{metres}");
        let found = fit(&world.control(UTM_32N, size, metres).unwrap()).unwrap();
        assert!(found.off_m.iter().all(|off| *off < 1e-3) && found.suspect.is_none(), "{found:?}");
        // The bottom left corner is the plan's origin.
        let [longitude, latitude] = super::super::degrees(&found.place, Pt2::new(0.0, 0.0));
        let [x, y] = UTM_32N.grid().unwrap().metres([longitude, latitude]);
        assert!((x - 566_600.0).hypot(y - 5_932_850.0) < 1e-3, "{x}, {y}");
        assert!((found.place.scale - 1.0).abs() < 1e-6);
    }

    #[test]
    fn degrees_have_pixels_of_two_sizes_and_are_square_on_the_ground() {
        // 1e-6° of latitude are 0.111 m; of longitude, at 60°, half as much.
        let world: WorldFile = "2e-6 0 0 -1e-6 10 60".parse().unwrap();
        let found = fit(&world.control(Crs::Degrees, [800.0, 600.0], 0.1115).unwrap()).unwrap();
        assert!((found.place.bearing_rad).abs() < 1e-3 && found.off_m.iter().all(|off| *off < 0.05), "{found:?}");
    }

    #[test]
    fn what_is_no_world_file_is_refused() {
        let error = |text: &str| text.parse::<WorldFile>().unwrap_err().to_string();
        for text in ["", "1 2 3", "1 0 0 1 0 x", "1 0 0 1 0 nan", "1 0 0 1 0 0 7"] {
            assert!(error(text).contains("not six"), "{text}");
        }
        assert!(error("0 0 0 0 1 1").contains("no size"));
        let world: WorldFile = "0.1 0 0 -0.1 566600 5932900".parse().unwrap();
        let error = world.control(Crs::Degrees, [10.0, 10.0], 0.1).unwrap_err().to_string();
        assert!(error.contains("566599.95") && error.contains("--crs"), "{error}");
        assert!("EPSG:31467".parse::<Crs>().unwrap_err().to_string().contains("GIS"));
        assert_eq!("urn:ogc:def:crs:EPSG::32632".parse::<Crs>(), Ok(UTM_32N));
    }
}
