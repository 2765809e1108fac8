//! What comes out of a clip: poses, path, sightings, gaps; or why there is none.

use super::posed::Posed;
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

/// How well one frame was followed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrameQuality {
    /// Points followed into it.
    pub points: usize,
    /// Share of the map's points in view that contradict its motion: people, doors, reflections, slips.
    pub movers: f64,
    /// How fast points at a usual distance go by, the turn aside, radians/s.
    pub parallax_rad_s: f64,
    /// Steepness of the picture at full size over that at a quarter: 0.6 to 1 if sharp, half of that if smeared over ten pixels.
    pub sharpness: f64,
    /// Standard deviation of the direction of gravity, radians.
    pub tilt_sigma_rad: f64,
    /// Standard deviation of its turn, and of its position, against the map around it, an axis each: radians, and units of the path.
    /// From the smoother, so that a gap between two known places is known best at its ends.
    pub turn_sigma_rad: f64,
    /// See `turn_sigma_rad`.
    pub shift_sigma: f64,
}

impl FrameQuality {
    /// The same with lengths times `scale`.
    pub(super) fn scaled(&self, scale: f64) -> Self {
        Self { shift_sigma: self.shift_sigma * scale, ..*self }
    }
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
    /// How well each frame was followed; as many as poses.
    pub quality: Vec<FrameQuality>,
    /// How sure it is, by the walking body, that a unit is a metre.
    pub unit: MetricScale,
}

/// Runs of frames in which nothing was followed, with what their first frame lacked; and cuts.
pub(super) fn gaps(posed: &[Posed]) -> Vec<Gap> {
    let mut gaps: Vec<Gap> = Vec::new();
    let mut open = false;
    for frame in posed {
        let blind = frame.state == TrackingState::Propagated;
        match (gaps.last_mut().filter(|_| open), frame.state) {
            (_, TrackingState::Cut) => {
                let cause = "a cut: nothing of the picture before is in this one".to_owned();
                gaps.push(Gap { from: frame.stamp, to: frame.stamp, cause });
            }
            (Some(gap), TrackingState::Propagated) => gap.to = frame.stamp,
            (None, TrackingState::Propagated) => {
                let cause = frame.blind.clone().unwrap_or_else(|| "nothing could be followed".to_owned());
                gaps.push(Gap { from: frame.stamp, to: frame.stamp, cause });
            }
            _ => {}
        }
        open = blind;
    }
    gaps
}
