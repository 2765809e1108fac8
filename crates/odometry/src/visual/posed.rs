//! Where was the camera at each frame, once the keyframes are settled?
//!
//! frames on keyframes ─▶ [`place`] ─▶ gaps are bridged: what was only guessed on the way lies between what was seen before and after

use planwalk_types::{CameraPose, Rigid3, Stamp, TrackingState};

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

/// The poses of all frames: each from its keyframe; a repeat between the frames around it, by time; gaps bridged.
pub(super) fn place(posed: &[Posed], map: &Map) -> Vec<CameraPose> {
    let mut poses = as_posed(posed, map);
    // Rotations first: they are known in more frames.
    bridge(&mut poses, |p| p.state != TrackingState::Propagated, |pose, between| pose.rotation = between.rotation);
    let placed = |p: &CameraPose| matches!(p.state, TrackingState::Mapped | TrackingState::Cut);
    bridge(&mut poses, placed, |pose, between| pose.translation = between.translation);
    poses
}

/// Sets what is not known in a frame between what is known before and after it, by time.
fn bridge(poses: &mut [CameraPose], known: impl Fn(&CameraPose) -> bool, set: impl Fn(&mut Pose, &Pose)) {
    let mut before: Option<usize> = None;
    for after in 0..poses.len() {
        if !known(&poses[after]) {
            continue;
        }
        if let Some(before) = before.replace(after).filter(|b| poses[after].stamp.secs_since(poses[*b].stamp) <= BRIDGED_S) {
            let (from, to) = (poses[before].clone(), poses[after].clone());
            for pose in &mut poses[before + 1..after] {
                let share = pose.stamp.secs_since(from.stamp) / to.stamp.secs_since(from.stamp);
                let between = from.odom_from_camera.iso.lerp_slerp(&to.odom_from_camera.iso, share);
                set(&mut pose.odom_from_camera.iso, &between);
            }
        }
    }
}

fn as_posed(posed: &[Posed], map: &Map) -> Vec<CameraPose> {
    let own = |p: &Posed| p.reference.map_or(p.reference_from_camera, |k| map.pose(k) * p.reference_from_camera);
    let at = |i: usize| {
        let p = &posed[i];
        let before = posed[..i].iter().rfind(|q| !q.repeat);
        let after = posed[i..].iter().find(|q| !q.repeat);
        let pose = match (p.repeat, before, after) {
            (true, Some(before), Some(after)) => {
                let share = p.stamp.secs_since(before.stamp) / after.stamp.secs_since(before.stamp);
                own(before).lerp_slerp(&own(after), share)
            }
            (true, Some(before), None) => own(before),
            _ => own(p),
        };
        CameraPose { stamp: p.stamp, odom_from_camera: Rigid3::new(pose), state: p.state, inliers: p.inliers }
    };
    (0..posed.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeat_lies_between_its_neighbours_and_the_last_one_stays() {
        let posed: Vec<Posed> = [(0, 0.0, false), (1, 0.0, true), (3, 6.0, false), (4, 6.0, true)]
            .map(|(t, x, repeat)| Posed {
                stamp: Stamp(t * 1_000_000_000),
                reference: None,
                reference_from_camera: Pose::translation(x, 0.0, 0.0),
                state: TrackingState::Mapped,
                inliers: 50,
                repeat,
                quality: FrameQuality::default(),
                blind: None,
            })
            .to_vec();
        let x: Vec<f64> = place(&posed, &Map::default()).iter().map(|p| p.odom_from_camera.origin().coords.x).collect();
        // A third of the way from 0 s to 3 s, to round-off.
        assert!(x.iter().zip([0.0, 2.0, 6.0, 6.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{x:?}");
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
            place(&posed, &Map::default()).iter().map(|p| p.odom_from_camera.origin().coords.x).collect()
        };
        let near = |found: &[f64], expected: &[f64]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
        // A guess that ran away, and came back when something was seen.
        let gap = placed(&[(0.0, 0.0, Mapped), (0.5, 9.0, Propagated), (1.0, 20.0, RotationOnly), (2.0, 2.0, Mapped)]);
        assert!(near(&gap, &[0.0, 0.5, 1.0, 2.0]), "{gap:?}");
        let long = placed(&[(0.0, 0.0, Mapped), (1.5, 1.0, Propagated), (3.0, 2.5, Mapped)]);
        assert!(near(&long, &[0.0, 1.0, 2.5]), "in three seconds a walk is no line: {long:?}");
        let cut = placed(&[(0.0, 0.0, Mapped), (0.1, 0.1, Cut), (0.2, 5.0, Propagated), (0.3, 0.5, Mapped)]);
        assert!(near(&cut, &[0.0, 0.1, 0.3, 0.5]), "{cut:?}");
    }
}
