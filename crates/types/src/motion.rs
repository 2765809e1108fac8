//! Where was the camera, frame by frame, in the odometry's own frame?

use crate::rigid::Rigid3;
use crate::space::{Cam, Odom};
use crate::time::Stamp;

/// How a frame's pose came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackingState {
    /// Posed against the map of points.
    Mapped,
    /// Only a rotation was seen (pure turning, or no map yet); the translation is propagated.
    RotationOnly,
    /// Nothing usable was seen; the whole motion is propagated and its covariance inflated.
    Propagated,
    /// Nothing connects this picture with the one before it: the video was cut. The walk goes on here, anywhere.
    Cut,
}

/// The pose of one frame.
#[derive(Debug, Clone)]
pub struct CameraPose {
    /// When the frame was taken.
    pub stamp: Stamp,
    /// Where the camera was.
    pub odom_from_camera: Rigid3<Odom, Cam>,
    /// How that is known.
    pub state: TrackingState,
    /// Map points or tracks that agree with this pose.
    pub inliers: usize,
}
