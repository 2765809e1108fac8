//! What did the camera see while it moved?

use crate::time::Stamp;

/// A point seen from the body at some moment; the air between was empty.
///
/// In the body frame's floor projection: x forward, y left. Lengths are in the odometry's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// When it was seen.
    pub stamp: Stamp,
    /// Direction, anticlockwise from forward, radians.
    pub bearing_rad: f64,
    /// Horizontal distance, in the odometry's unit; positive.
    pub range: f64,
    /// Standard deviation of the range, same unit; positive.
    pub sigma: f64,
}
