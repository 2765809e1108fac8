//! What comes out of a clip: poses, path, sightings, gaps; or why there is none.

use crate::metres::MetricScale;
use planwalk_types::{CameraPose, Path, Sighting, Stamp, TrackingState};

/// Why there is no odometry.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OdometryError {
    /// A frame has another size than the camera's images.
    #[error("frame {index} has {width}×{height} px, but the camera's images have {camera_width}×{camera_height} px")]
    SizeChanged {
        /// Which frame, counted from 0.
        index: usize,
        /// Its columns.
        width: usize,
        /// Its rows.
        height: usize,
        /// Columns that the camera has.
        camera_width: usize,
        /// Rows that the camera has.
        camera_height: usize,
    },
    /// A frame is not later than the one before.
    #[error("frame {index} at {at_s:.6} s does not come after the one before")]
    StampsGoBack {
        /// Which frame, counted from 0.
        index: usize,
        /// Its stamp, seconds.
        at_s: f64,
    },
    /// A motion needs two frames.
    #[error("{got} frames, but a motion needs at least 2: is the clip cut off, or the wrong folder?")]
    TooFewFrames {
        /// Frames seen.
        got: usize,
    },
    /// No frame has anything that can be followed.
    #[error("nothing to follow in any of {frames} frames (at most {most} points, 8 are needed): is the video black, or the lens covered?")]
    NothingToTrack {
        /// Frames seen.
        frames: usize,
        /// Most points that were followed at once.
        most: usize,
    },
}

/// What became of one frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameReport {
    /// When it was taken.
    pub stamp: Stamp,
    /// How its pose is known.
    pub state: TrackingState,
    /// Points that were followed into it.
    pub tracks: usize,
    /// Of these, points that agree with its pose.
    pub inliers: usize,
}

/// A stretch of video in which nothing usable was seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// First frame of it.
    pub from: Stamp,
    /// Last frame of it.
    pub to: Stamp,
    /// What was missing.
    pub cause: String,
}

/// The odometry of a whole clip.
#[derive(Debug, Clone)]
pub struct Odometry {
    /// One pose a frame: `odom ← camera`, odom's z up, its x where the first frame looks; in units of about a metre.
    pub poses: Vec<CameraPose>,
    /// The same on the floor: one step between consecutive frames.
    pub path: Path,
    /// Points of the map as seen from keyframes.
    pub sightings: Vec<Sighting>,
    /// Where nothing was seen.
    pub gaps: Vec<Gap>,
    /// How sure it is, by the walking body, that a unit is a metre.
    pub unit: MetricScale,
}

/// Runs of frames whose whole motion is propagated.
pub(super) fn gaps(poses: &[CameraPose]) -> Vec<Gap> {
    let mut gaps: Vec<Gap> = Vec::new();
    let mut open = false;
    for pose in poses {
        let blind = pose.state == TrackingState::Propagated;
        match gaps.last_mut().filter(|_| open) {
            Some(gap) if blind => gap.to = pose.stamp,
            _ if blind => {
                let cause = format!("only {} points could be followed (blank wall, blur or darkness)", pose.inliers);
                gaps.push(Gap { from: pose.stamp, to: pose.stamp, cause });
            }
            _ => {}
        }
        open = blind;
    }
    gaps
}
