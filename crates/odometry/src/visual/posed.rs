//! Where was the camera at each frame, once the keyframes are settled?

use planwalk_types::{CameraPose, Rigid3, Stamp, TrackingState};

use super::map::{KeyframeId, Map, Pose};

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
}

/// The poses of all frames: each from its keyframe; a repeat between the frames around it, by time.
pub(super) fn place(posed: &[Posed], map: &Map) -> Vec<CameraPose> {
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
            })
            .to_vec();
        let x: Vec<f64> = place(&posed, &Map::default()).iter().map(|p| p.odom_from_camera.origin().coords.x).collect();
        // A third of the way from 0 s to 3 s, to round-off.
        assert!(x.iter().zip([0.0, 2.0, 6.0, 6.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{x:?}");
    }
}
