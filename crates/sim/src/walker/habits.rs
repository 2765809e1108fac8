//! What else do walkers do? They stop, look about, tilt the phone, turn on the spot; and their hands tremble.
//!
//! Each habit draws from a stream of its own, so that turning one on leaves the others as they are. A rate or strength of 0 turns
//! it off.

use std::f64::consts::TAU;

use planwalk_types::{Seed, StreamRng};
use rand::RngExt;

use super::WalkOptions;

/// Least time between two events of one kind, seconds.
const PAUSE_S: f64 = 1.5;
/// How fast heads and hands start to move and come to rest: seconds for a glance, and for a tilt.
const GLANCE_RAMP_S: f64 = 0.55;
const TILT_RAMP_S: f64 = 0.9;

/// Something done from one moment to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Event {
    pub from_s: f64,
    pub to_s: f64,
    /// By how much and to which side.
    pub size: f64,
}

/// A wave of the hand's tremor or wandering.
#[derive(Debug, Clone, Copy)]
struct Wave {
    hertz: f64,
    phase: f64,
    share: f64,
}

/// What this walker does when.
#[derive(Debug, Clone)]
pub(super) struct Habits {
    pub pace_mps: f64,
    pub stops: Vec<Event>,
    glances: Vec<Event>,
    tilts: Vec<Event>,
    tremor_rad: f64,
    /// Yaw, pitch and roll.
    tremor: [[Wave; 4]; 3],
    hand_drift_rad: f64,
    /// Pitch and roll.
    drift: [[Wave; 2]; 2],
}

impl Habits {
    pub fn new(options: &WalkOptions, seed: Seed) -> Self {
        let spread = options.speed_spread_mps;
        let drawn = if spread > 0.0 { seed.derive("speed", 0).random_range(-spread..spread) } else { 0.0 };
        let events = |name: &str, per_minute: f64, lasts_s: [f64; 2], size: f64, both: bool| {
            draw(&mut seed.derive(name, 0), options.duration_s, per_minute, lasts_s, size, both)
        };
        let mut rng = seed.derive("tremor", 0);
        // Octaves from a breath's sway to a muscle's tremble, weaker upwards; variances add up to one.
        let tremor = std::array::from_fn(|_| {
            [(0.6, 1.2, 0.8), (1.4, 2.4, 0.45), (3.0, 5.0, 0.32), (6.0, 10.0, 0.22)].map(|(low, high, share)| Wave {
                hertz: rng.random_range(low..high),
                phase: rng.random_range(0.0..TAU),
                share,
            })
        });
        let mut rng = seed.derive("hand", 0);
        let drift = std::array::from_fn(|_| {
            [(0.04, 0.12, 0.8), (0.2, 0.5, 0.6)].map(|(low, high, share)| Wave {
                hertz: rng.random_range(low..high),
                phase: rng.random_range(0.0..TAU),
                share,
            })
        });
        Self {
            pace_mps: options.speed_mps + drawn,
            stops: events("stops", options.stops_per_minute, [1.0, 4.0], 1.0, false),
            glances: events("glances", options.glances_per_minute, [1.0, 2.2], options.glance_rad, true),
            tilts: events("tilts", options.tilts_per_minute, [2.0, 6.0], options.tilt_rad, false),
            tremor_rad: options.tremor_rad,
            tremor,
            hand_drift_rad: options.hand_drift_rad,
            drift,
        }
    }

    /// Whether one stands still at this moment.
    pub fn stands(&self, time_s: f64) -> bool {
        at(&self.stops, time_s).is_some()
    }

    /// How far the head is turned to the left by glances, radians.
    pub fn glance_rad(&self, time_s: f64) -> f64 {
        at(&self.glances, time_s).map_or(0.0, |event| event.size * bump(event, time_s, GLANCE_RAMP_S))
    }

    /// How far the phone is tilted down, radians.
    pub fn tilt_rad(&self, time_s: f64) -> f64 {
        at(&self.tilts, time_s).map_or(0.0, |event| event.size * bump(event, time_s, TILT_RAMP_S))
    }

    /// Trembling in yaw, pitch and roll, radians.
    pub fn tremor_rad(&self, time_s: f64) -> [f64; 3] {
        if self.tremor_rad == 0.0 { [0.0; 3] } else { self.tremor.map(|waves| swing(&waves, self.tremor_rad, time_s)) }
    }

    /// Slow wandering of the hand in pitch and roll, radians.
    pub fn drift_rad(&self, time_s: f64) -> [f64; 2] {
        if self.hand_drift_rad == 0.0 { [0.0; 2] } else { self.drift.map(|waves| swing(&waves, self.hand_drift_rad, time_s)) }
    }
}

/// Waves of this standard deviation together: a sine's own is 1/√2 of its height.
fn swing(waves: &[Wave], deviation: f64, time_s: f64) -> f64 {
    let size = deviation * std::f64::consts::SQRT_2;
    waves.iter().map(|w| size * w.share * libm::sin(TAU * w.hertz * time_s + w.phase)).sum()
}

/// Which corners are turned on the spot: a share of them, each by its own throw.
pub(super) fn chosen(corners: Vec<f64>, share: f64, seed: Seed) -> Vec<f64> {
    let mut rng = seed.derive("spots", 0);
    corners.into_iter().filter(|_| rng.random_range(0.0..1.0) < share).collect()
}

/// Events at random times, the gaps between them exponential.
fn draw(rng: &mut StreamRng, duration_s: f64, per_minute: f64, lasts_s: [f64; 2], size: f64, both: bool) -> Vec<Event> {
    let mut events = Vec::new();
    if per_minute <= 0.0 || size == 0.0 {
        return events;
    }
    let mut now = 0.0;
    loop {
        now += PAUSE_S - 60.0 / per_minute * libm::log(1.0 - rng.random_range(0.0..1.0f64));
        let to_s = now + rng.random_range(lasts_s[0]..lasts_s[1]);
        let side = if both && rng.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 };
        let size = side * size * rng.random_range(0.6..1.0);
        // What does not end before the walk does is left out.
        if to_s > duration_s - 0.5 {
            return events;
        }
        events.push(Event { from_s: now, to_s, size });
        now = to_s;
    }
}

fn at(events: &[Event], time_s: f64) -> Option<&Event> {
    let next = events.partition_point(|event| event.from_s <= time_s);
    events.get(next.checked_sub(1)?).filter(|event| time_s < event.to_s)
}

/// From 0 up to 1 and back, smooth in speed and acceleration.
fn bump(event: &Event, time_s: f64, ramp_s: f64) -> f64 {
    let ramp_s = ramp_s.min(0.5 * (event.to_s - event.from_s));
    let x = ((time_s - event.from_s).min(event.to_s - time_s) / ramp_s).clamp(0.0, 1.0);
    x * x * x * (10.0 - x * (15.0 - 6.0 * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn habits_come_as_often_as_asked_for_and_never_two_of_a_kind_at_once() {
        let options = WalkOptions { duration_s: 3600.0, ..WalkOptions::lively() };
        let habits = Habits::new(&options, Seed(3));
        for (events, per_minute, lasts_s) in
            [(&habits.stops, options.stops_per_minute, 2.5), (&habits.glances, options.glances_per_minute, 1.6)]
        {
            // Each event takes its gap, its pause and itself.
            let wanted = 3600.0 / (60.0 / per_minute + PAUSE_S + lasts_s);
            let got = events.len() as f64;
            // A renewal process: its count deviates by no more than that of a Poisson process.
            assert!((got - wanted).abs() < 4.0 * wanted.sqrt(), "{got} for {wanted}");
            assert!(events.windows(2).all(|w| w[0].to_s < w[1].from_s));
        }
        assert!(habits.glances.iter().any(|g| g.size > 0.0) && habits.glances.iter().any(|g| g.size < 0.0));
    }

    #[test]
    fn the_default_walker_has_no_habits() {
        let habits = Habits::new(&WalkOptions::default(), Seed(3));
        for i in 0..300 {
            let t = 0.1 * f64::from(i);
            assert!(!habits.stands(t) && habits.glance_rad(t) == 0.0 && habits.tilt_rad(t) == 0.0);
            assert!(habits.tremor_rad(t) == [0.0; 3] && habits.drift_rad(t) == [0.0; 2]);
        }
    }

    #[test]
    fn tremor_is_as_strong_as_said_and_one_habit_leaves_the_others_alone() {
        let lively = WalkOptions { duration_s: 600.0, ..WalkOptions::lively() };
        let habits = Habits::new(&lively, Seed(3));
        let n = 60_000;
        let variance: f64 = (0..n).map(|i| habits.tremor_rad(0.01 * f64::from(i))[1].powi(2)).sum::<f64>() / f64::from(n);
        // Shares squared: 0.64 + 0.2025 + 0.1024 + 0.0484 = 0.9933; sines over 600 s average to far better than 2 %.
        assert!((variance.sqrt() / lively.tremor_rad - 1.0).abs() < 0.02);
        let without = Habits::new(&WalkOptions { glances_per_minute: 0.0, ..lively }, Seed(3));
        assert_eq!(without.stops, habits.stops);
    }
}
