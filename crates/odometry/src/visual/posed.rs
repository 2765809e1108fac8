//! Where was the camera at each frame, once the keyframes are settled?
//!
//! frames on keyframes ─▶ [`place`] ─▶ smoothed ([`super::filter`]): what was only guessed on the way lies between what was seen
//! before and after

use nalgebra::Matrix6;
use planwalk_types::{CameraPose, Rigid3, Stamp, TrackingState};

use super::filter::{Measured, noise_of, sigmas, smooth};
use super::map::{KeyframeId, Map, Pose};
use super::outcome::FrameQuality;

/// A frame's pose relative to a keyframe, so that it moves along when the keyframe is adjusted.
#[derive(Debug, Clone)]
pub(super) struct Posed {
    pub stamp: Stamp,
    pub reference: Option<KeyframeId>,
    pub reference_from_camera: Pose,
    pub state: TrackingState,
    pub inliers: usize,
    /// Whether the frame showed the picture before it once more: its pose is then found between its neighbours'.
    pub repeat: bool,
    /// How well it was followed.
    pub quality: FrameQuality,
    /// Why nothing was, if nothing was.
    pub blind: Option<String>,
}

/// Longest gap that is bridged, seconds: in a longer one the walk as it was guessed says more than a straight line.
const BRIDGED_S: f64 = 2.0;

/// A frame's pose, and how well it is known against the map around it, one standard deviation of an axis: radians and units.
pub(super) struct Placed {
    pub pose: CameraPose,
    pub turn_sigma_rad: f64,
    pub shift_sigma: f64,
}

/// The poses of all frames: each from its keyframe, and all together as a camera moves ([`smooth`]), which bridges gaps and finds
/// repeats between their neighbours. A cut parts what comes before it from what comes after.
pub(super) fn place(posed: &[Posed], map: &Map) -> Vec<Placed> {
    let poses = as_posed(posed, map);
    let measured = measured(posed, &poses);
    let cuts = (0..=poses.len()).filter(|i| *i == 0 || *i == poses.len() || poses[*i].state == TrackingState::Cut);
    let cuts: Vec<usize> = cuts.collect();
    let smoothed = cuts.windows(2).flat_map(|ends| smooth(&measured[ends[0]..ends[1]]));
    let placed = |(pose, (found, covariance)): (CameraPose, (Pose, Matrix6<f64>))| {
        let (turn_sigma_rad, shift_sigma) = sigmas(&covariance);
        Placed { pose: CameraPose { odom_from_camera: Rigid3::new(found), ..pose }, turn_sigma_rad, shift_sigma }
    };
    poses.into_iter().zip(smoothed).map(placed).collect()
}

/// What was found of each frame, and how well. What was only guessed on the way is left out, where it can be bridged.
fn measured(posed: &[Posed], poses: &[CameraPose]) -> Vec<Measured> {
    use TrackingState::{Cut, Mapped, Propagated};
    // Rotations are known in more frames.
    let turned = bridged(poses, |i| poses[i].state != Propagated && !posed[i].repeat);
    let placed = bridged(poses, |i| matches!(poses[i].state, Mapped | Cut) && !posed[i].repeat);
    let frame = |i: usize| {
        let pose = &poses[i];
        let (turn, shift) = noise_of(pose.state);
        let (turn_rad, shift) = ((!turned[i]).then_some(turn), (!placed[i]).then_some(shift));
        Measured { stamp: pose.stamp, pose: pose.odom_from_camera.iso, turn_rad, shift }
    };
    (0..poses.len()).map(frame).collect()
}

/// Which frames are not known themselves, but lie between two that are, and that are no further apart than [`BRIDGED_S`].
fn bridged(poses: &[CameraPose], known: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut bridged = vec![false; poses.len()];
    let mut before: Option<usize> = None;
    for after in (0..poses.len()).filter(|i| known(*i)) {
        if let Some(before) = before.replace(after).filter(|b| poses[after].stamp.secs_since(poses[*b].stamp) <= BRIDGED_S) {
            bridged[before + 1..after].fill(true);
        }
    }
    bridged
}

fn as_posed(posed: &[Posed], map: &Map) -> Vec<CameraPose> {
    let own = |p: &Posed| p.reference.map_or(p.reference_from_camera, |k| map.pose(k) * p.reference_from_camera);
    let pose = |p: &Posed| CameraPose { stamp: p.stamp, odom_from_camera: Rigid3::new(own(p)), state: p.state, inliers: p.inliers };
    posed.iter().map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeat_lies_between_its_neighbours_and_the_last_one_stays() {
        let posed: Vec<Posed> = [(0, 0.0, false), (1, 0.0, true), (3, 6.0, false), (4, 6.0, true)]
            .map(|(t, x, repeat)| Posed {
                stamp: Stamp(t * 500_000_000),
                reference: None,
                reference_from_camera: Pose::translation(x, 0.0, 0.0),
                state: TrackingState::Mapped,
                inliers: 50,
                repeat,
                quality: FrameQuality::default(),
                blind: None,
            })
            .to_vec();
        let x: Vec<f64> = place(&posed, &Map::default()).iter().map(|p| p.pose.odom_from_camera.origin().coords.x).collect();
        // A third of the way in time; the camera then stands, so it was faster at first: a twelfth further on.
        assert!((x[1] - 2.0).abs() < 0.5, "{x:?}");
        // Good poses stay, to a ten-thousandth of the way.
        assert!(x[0].abs() < 1e-3 && (x[2] - 6.0).abs() < 1e-3 && (x[3] - 6.0).abs() < 1e-3, "{x:?}");
    }

    #[test]
    fn a_gap_is_bridged_between_what_was_seen_but_neither_a_long_one_nor_a_cut() {
        use TrackingState::{Cut, Mapped, Propagated, RotationOnly};
        let placed = |frames: &[(f64, f64, TrackingState)]| -> Vec<f64> {
            let posed: Vec<Posed> = frames
                .iter()
                .map(|(seconds, x, state)| Posed {
                    stamp: Stamp((seconds * 1e9) as i64),
                    reference: None,
                    reference_from_camera: Pose::translation(*x, 0.0, 0.0),
                    state: *state,
                    inliers: 0,
                    repeat: false,
                    quality: FrameQuality::default(),
                    blind: None,
                })
                .collect();
            place(&posed, &Map::default()).iter().map(|p| p.pose.odom_from_camera.origin().coords.x).collect()
        };
        // The smoother leaves good poses where they are, to a thousandth of a unit.
        let near = |found: &[f64], expected: &[f64]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3);
        // A guess that ran away, and came back when something was seen.
        let gap = placed(&[(0.0, 0.0, Mapped), (0.5, 9.0, Propagated), (1.0, 20.0, RotationOnly), (2.0, 2.0, Mapped)]);
        // On the way from here to there, a little late as who sets off from standing.
        assert!(near(&[gap[0], gap[3]], &[0.0, 2.0]) && (gap[1] - 0.5).abs() < 0.2 && (gap[2] - 1.0).abs() < 0.2, "{gap:?}");
        let long = placed(&[(0.0, 0.0, Mapped), (1.5, 1.0, Propagated), (3.0, 2.5, Mapped)]);
        assert!(near(&long, &[0.0, 1.0, 2.5]), "in three seconds a walk is no line: {long:?}");
        let cut = placed(&[(0.0, 0.0, Mapped), (0.1, 0.1, Cut), (0.2, 5.0, Propagated), (0.3, 0.5, Mapped)]);
        assert!(near(&[cut[0], cut[1], cut[3]], &[0.0, 0.1, 0.5]) && (cut[2] - 0.3).abs() < 0.05, "{cut:?}");
    }
}
