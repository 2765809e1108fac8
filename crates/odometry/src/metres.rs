//! How many metres are in a unit of odometry? What a walking body says: how high it holds the camera, how it steps, how fast it goes.
//!
//! levelled poses, height over the floor ─▶ [`Evidence`] of each [`Cue`] ─▶ [`MetricScale`]: their product, wider where they disagree
//!
//! After Hu et al. 2013, who take the human walking model into monocular odometry; they count steps with an inertial sensor, here
//! the camera's own bobbing counts them.
//!
//! Pitfall: a stabilised clip does not bob, and a trolley has another height. A cue that does not show says nothing; cues that
//! contradict each other widen the answer.

use planwalk_types::{CameraPose, TrackingState};

/// What speaks for a length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cue {
    /// Height of the camera over the floor, units.
    CameraHeight,
    /// Steps a second, by the camera's bobbing.
    Gait,
    /// Usual speed while moving, units/s.
    WalkingSpeed,
}

/// What one cue says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Which one.
    pub cue: Cue,
    /// What was measured: see [`Cue`].
    pub measured: f64,
    /// Metres in a unit by this cue alone: median.
    pub metres_per_unit: f64,
    /// Standard deviation of its logarithm.
    pub relative_sigma: f64,
}

/// Metres in a unit of odometry: a log-normal distribution, and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct MetricScale {
    /// Median.
    pub metres_per_unit: f64,
    /// Standard deviation of its logarithm.
    pub relative_sigma: f64,
    /// The cues that showed.
    pub evidence: Vec<Evidence>,
}

impl MetricScale {
    /// The same of lengths that were multiplied by its metres per unit.
    pub fn applied(self) -> Self {
        let metres = self.metres_per_unit;
        let applied = |e: Evidence| {
            let measured = if e.cue == Cue::Gait { e.measured } else { e.measured * metres };
            Evidence { measured, metres_per_unit: e.metres_per_unit / metres, ..e }
        };
        Self { metres_per_unit: 1.0, evidence: self.evidence.into_iter().map(applied).collect(), ..self }
    }
}

/// How high people hold a camera that films where they go, metres: from the belt to the eyes.
const CAMERA_HEIGHT: (f64, f64) = (1.4, 0.15);
/// Step length over steps a second, m·s: 0.0064 m·min in adults at all speeds (Sekiya & Nagasaki 1998). With cameras in their hands
/// people differ more than on a treadmill: six real walks have 0.23 (slow, filming) to 0.50 (brisk).
const WALK_RATIO: (f64, f64) = (0.38, 0.25);
/// Standard deviation of the logarithm of a person's indoor walking speed.
const WALKING_SPEED_SIGMA: f64 = 0.35;
/// Of a camera that never moved nothing is known.
const NOTHING_SIGMA: f64 = 0.7;
/// How far the unit at any moment differs from that of the whole walk: logarithm.
const LOCAL_SIGMA: f64 = 0.06;

/// Seconds over which a speed is measured; stretches under a quarter of the fastest ones' speed are stops.
const STRETCH_S: f64 = 1.0;
const MOVING: f64 = 0.25;

/// Steps are counted in windows of so many seconds, at these frequencies (strolling to hurrying), hertz.
const WINDOW_S: f64 = 4.0;
const LEAST_HZ: f64 = 1.3;
const MOST_HZ: f64 = 2.6;
const STEP_HZ: f64 = 0.025;
/// What is slower than this is no bobbing: seconds of the mean that is taken from each height.
const SLOW_S: f64 = 0.8;
/// Share of a window's bobbing that one frequency must explain, and windows that must agree (within [`ALIKE`]).
const EXPLAINED: f64 = 0.5;
const WINDOWS: usize = 3;
const ALIKE: f64 = 0.12;

/// What levelled poses, and the camera's height over the floor where it showed, say of a unit's metres.
pub fn metric_scale(poses: &[CameraPose], camera_height: Option<f64>, walking_speed_m_s: f64) -> MetricScale {
    let evidence = |cue: Cue, measured: f64, metres: f64, relative_sigma: f64| {
        let metres_per_unit = metres / measured;
        (metres_per_unit.is_finite() && metres_per_unit > 0.0).then_some(Evidence { cue, measured, metres_per_unit, relative_sigma })
    };
    let height = camera_height.and_then(|h| evidence(Cue::CameraHeight, h, CAMERA_HEIGHT.0, CAMERA_HEIGHT.1));
    let speed = usual_speed(poses).and_then(|v| evidence(Cue::WalkingSpeed, v, walking_speed_m_s, WALKING_SPEED_SIGMA));
    fused([height, gait(poses), speed].into_iter().flatten().collect())
}

/// The product of what the cues say.
fn fused(evidence: Vec<Evidence>) -> MetricScale {
    let information: f64 = evidence.iter().map(|e| e.relative_sigma.powi(-2)).sum();
    if evidence.is_empty() {
        return MetricScale { metres_per_unit: 1.0, relative_sigma: NOTHING_SIGMA, evidence };
    }
    let mean = evidence.iter().map(|e| libm::log(e.metres_per_unit) * e.relative_sigma.powi(-2)).sum::<f64>() / information;
    let squared: f64 = evidence.iter().map(|e| ((libm::log(e.metres_per_unit) - mean) / e.relative_sigma).powi(2)).sum();
    // Birge 1932: cues that disagree by more than they say err by more than they say.
    let birge = (squared / (evidence.len() - 1).max(1) as f64).sqrt().max(1.0);
    let relative_sigma = (birge * birge / information + LOCAL_SIGMA * LOCAL_SIGMA).sqrt();
    MetricScale { metres_per_unit: libm::exp(mean), relative_sigma, evidence }
}

/// Median speed while moving, units/s; `None` of a camera that never moved.
fn usual_speed(poses: &[CameraPose]) -> Option<f64> {
    let mut speeds = Vec::new();
    let mut start = 0;
    for (end, pose) in poses.iter().enumerate() {
        let seconds = pose.stamp.secs_since(poses[start].stamp);
        if seconds >= STRETCH_S || (end + 1 == poses.len() && speeds.is_empty() && seconds > 0.0) {
            speeds.push(speed(&poses[start..=end]));
            start = end;
        }
    }
    speeds.sort_by(f64::total_cmp);
    let fast = *speeds.get(speeds.len() * 9 / 10)?;
    speeds.retain(|s| *s >= MOVING * fast);
    Some(speeds[speeds.len() / 2]).filter(|usual| *usual > 1e-6)
}

/// From the first pose to the last one, units/s.
fn speed(poses: &[CameraPose]) -> f64 {
    let (first, last) = (&poses[0], &poses[poses.len() - 1]);
    let way = last.odom_from_camera.origin().coords - first.odom_from_camera.origin().coords;
    way.norm() / last.stamp.secs_since(first.stamp)
}

/// What steps say: whoever takes f of them a second has a speed of f² times the walk ratio.
fn gait(poses: &[CameraPose]) -> Option<Evidence> {
    let bobbing = bobbing(poses);
    let mut windows = Vec::new();
    let mut start = 0;
    for end in 0..poses.len() {
        if poses[end].state != TrackingState::Mapped {
            start = end + 1;
        } else if poses[end].stamp.secs_since(poses[start].stamp) >= WINDOW_S {
            let cadence = cadence(&poses[start..=end], &bobbing[start..=end]);
            let seconds = poses[end].stamp.secs_since(poses[start].stamp);
            windows.extend(cadence.map(|hertz| (hertz, way(&poses[start..=end]) / seconds)));
            start = (start + end) / 2;
        }
    }
    let hertz = middle(windows.iter().map(|w| w.0))?;
    windows.retain(|w| libm::log(w.0 / hertz).abs() < ALIKE);
    if windows.len() < WINDOWS {
        return None;
    }
    let metres_per_unit = middle(windows.iter().map(|(hertz, speed)| WALK_RATIO.0 * hertz * hertz / speed))?;
    metres_per_unit.is_finite().then_some(Evidence { cue: Cue::Gait, measured: hertz, metres_per_unit, relative_sigma: WALK_RATIO.1 })
}

fn middle(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Length of the way on the floor, in chords of half a second: bobbing and noise are no way.
fn way(poses: &[CameraPose]) -> f64 {
    let (mut length, mut from) = (0.0, &poses[0]);
    for pose in poses {
        if pose.stamp.secs_since(from.stamp) >= 0.5 {
            let step = pose.odom_from_camera.origin().coords - from.odom_from_camera.origin().coords;
            length += step.x.hypot(step.y);
            from = pose;
        }
    }
    length
}

/// Height of each pose over the mean of the poses around it.
fn bobbing(poses: &[CameraPose]) -> Vec<f64> {
    let z = |p: &CameraPose| p.odom_from_camera.origin().coords.z;
    let (mut from, mut to, mut sum) = (0, 0, 0.0);
    poses
        .iter()
        .map(|pose| {
            while to < poses.len() && poses[to].stamp.secs_since(pose.stamp) <= 0.5 * SLOW_S {
                sum += z(&poses[to]);
                to += 1;
            }
            while pose.stamp.secs_since(poses[from].stamp) > 0.5 * SLOW_S {
                sum -= z(&poses[from]);
                from += 1;
            }
            z(pose) - sum / (to - from) as f64
        })
        .collect()
}

/// Steps a second, if one frequency explains most of the bobbing; Hann's window keeps others out.
fn cadence(poses: &[CameraPose], bobbing: &[f64]) -> Option<f64> {
    let seconds: Vec<f64> = poses.iter().map(|p| p.stamp.secs_since(poses[0].stamp)).collect();
    let length = seconds[seconds.len() - 1];
    let weights: Vec<f64> = seconds.iter().map(|t| 0.5 - 0.5 * libm::cos(std::f64::consts::TAU * t / length)).collect();
    let weight: f64 = weights.iter().sum();
    let variance: f64 = bobbing.iter().zip(&weights).map(|(z, w)| w * z * z).sum();
    let explained = |hertz: f64| {
        let (mut real, mut imaginary) = (0.0, 0.0);
        for ((t, z), w) in seconds.iter().zip(bobbing).zip(&weights) {
            let (s, c) = libm::sincos(std::f64::consts::TAU * hertz * t);
            (real, imaginary) = (real + w * z * c, imaginary + w * z * s);
        }
        2.0 * (real * real + imaginary * imaginary) / (weight * variance)
    };
    let tried = (0..).map(|i| LEAST_HZ + f64::from(i) * STEP_HZ).take_while(|hertz| *hertz <= MOST_HZ);
    let (hertz, share) = tried.map(|hertz| (hertz, explained(hertz))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let inside = hertz > LEAST_HZ + STEP_HZ && hertz < MOST_HZ - STEP_HZ;
    (share > EXPLAINED && inside).then_some(hertz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Isometry3;
    use planwalk_types::{Rigid3, Stamp};

    /// A camera at 30 frames/s: `speed` units/s ahead, bobbing by `bob` units with every one of its `hertz` steps a second.
    fn walk(seconds: f64, speed: f64, bob: f64, hertz: f64) -> Vec<CameraPose> {
        let pose = |i: i64| {
            let t = i as f64 / 30.0;
            let z = bob * libm::cos(std::f64::consts::TAU * hertz * t) + 0.1 * libm::sin(0.5 * t);
            let odom_from_camera = Rigid3::new(Isometry3::translation(speed * t, 0.0, z));
            CameraPose { stamp: Stamp(i * 1_000_000_000 / 30), odom_from_camera, state: TrackingState::Mapped, inliers: 50 }
        };
        (0..(30.0 * seconds) as i64).map(pose).collect()
    }

    fn said(scale: &MetricScale, cue: Cue) -> Option<f64> {
        scale.evidence.iter().find(|e| e.cue == cue).map(|e| e.metres_per_unit)
    }

    #[test]
    fn all_cues_of_a_walk_in_half_metres_say_half_a_metre() {
        // 1.8 steps a second are 1.23 m/s by the walk ratio; a camera 1.4 m up.
        let scale = metric_scale(&walk(20.0, 2.4624, 0.05, 1.8), Some(2.8), 1.1);
        assert!((said(&scale, Cue::CameraHeight).unwrap() - 0.5).abs() < 1e-12);
        // A frequency is found to half of its step: 0.7 %, so a speed to 1.4 %.
        assert!((said(&scale, Cue::Gait).unwrap() - 0.5).abs() < 0.01, "{scale:?}");
        assert!((said(&scale, Cue::WalkingSpeed).unwrap() - 1.1 / 2.4624).abs() < 0.001);
        let metric = scale.clone().applied();
        assert!(metric.metres_per_unit == 1.0 && (metric.evidence[0].measured - 1.4).abs() < 0.03, "{metric:?}");
        assert!((scale.metres_per_unit - 0.5).abs() < 0.01 && scale.relative_sigma < 0.14, "{scale:?}");
    }

    #[test]
    fn who_does_not_bob_gives_no_steps_and_a_limp_neither() {
        assert_eq!(said(&metric_scale(&walk(20.0, 1.0, 0.0, 1.8), None, 1.1), Cue::Gait), None, "a trolley");
        let mut shaking = walk(20.0, 1.0, 0.0, 1.8);
        let mut noise = 0x1234_5678_u64;
        for pose in &mut shaking {
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            pose.odom_from_camera.iso.translation.vector.z += 0.02 * ((noise >> 40) as f64 / (1u64 << 23) as f64 - 1.0);
        }
        assert_eq!(said(&metric_scale(&shaking, None, 1.1), Cue::Gait), None, "noise");
        let mut gaps = walk(20.0, 1.0, 0.02, 1.8);
        gaps.iter_mut().step_by(90).for_each(|p| p.state = TrackingState::Propagated);
        assert_eq!(said(&metric_scale(&gaps, None, 1.1), Cue::Gait), None, "never four seconds seen");
    }

    #[test]
    fn cues_that_contradict_each_other_widen_the_answer() {
        let agree = metric_scale(&walk(20.0, 1.1, 0.0, 1.8), Some(1.4), 1.1);
        let contradict = metric_scale(&walk(20.0, 1.1, 0.0, 1.8), Some(4.0), 1.1);
        assert!(contradict.relative_sigma > 1.5 * agree.relative_sigma, "{agree:?} {contradict:?}");
    }

    #[test]
    fn the_usual_speed_is_that_of_walking_though_there_was_a_stop() {
        let mut poses = walk(8.0, 1.0, 0.0, 1.8);
        let last = poses[poses.len() - 1].clone();
        poses.extend((0..240).map(|i| CameraPose { stamp: Stamp(last.stamp.0 + (i + 1) * 33_333_333), ..last.clone() }));
        let scale = metric_scale(&poses, None, 1.1);
        assert!((scale.metres_per_unit - 1.1).abs() < 0.02, "{scale:?}");
        let standing = metric_scale(&poses[240..], None, 1.1);
        assert_eq!((standing.metres_per_unit, standing.relative_sigma), (1.0, NOTHING_SIGMA), "who stands says nothing of metres");
    }
}
