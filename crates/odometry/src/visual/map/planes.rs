//! How far is a point if it lies on the floor, or under the ceiling? The level planes that keep the unit of length.
//!
//! points with a distance, and where up is ─▶ [`Planes::learn`] (heights that many points share) ─▶ [`Planes::inverse_distance`]
//!
//! A single camera has no unit of its own: what it has is lost before a blank wall, where everything in view is replaced. But a
//! walker's eyes keep their height over the floor, and the floor is seen again behind every corner (Song & Chandraker 2014 on
//! cars; here with the ceiling, and without knowing the height in metres).
//!
//! Pitfall: tables are level, too. The floor is the lowest height that many points share: hardly any point lies under it.

use nalgebra::Vector3;

/// Rays flatter than this hit no level plane soon enough to measure with: sine of 9°; an error of 1° in gravity is 11 % there.
pub const LEAST_SINE: f64 = 0.16;
/// Bins of the histogram: heights of 0.05 to 20 units, 3 % each.
const BINS: usize = 200;
const BIN: f64 = 0.03;
const LOWEST: f64 = 0.05;
/// Half the width of a peak, bins: a camera sways by 5 % of its height, and gravity errs by a degree.
const HALF_PEAK: usize = 3;
/// Share that what was learnt keeps from one keyframe to the next: a plane is forgotten in some fifty keyframes, ten seconds.
const KEEPS: f64 = 0.98;
/// Points that make a plane believable, summed over keyframes: a floor with twenty points in view is one after half a second.
const ENOUGH: f64 = 60.0;
/// Least share of a plane among all points below (or above) the camera.
const LEAST_SHARE: f64 = 0.3;
/// Most points beyond a plane, as a share of those on it: reflections, and errors of the distance.
const MOST_BEYOND: f64 = 0.35;
/// How far from the plane a point may seem and still be on it, as a share of its inverse distance; its own error comes on top.
const NEAR: f64 = 0.15;
/// How well a point on a plane keeps to it: the camera's sway and gravity's error, as a share of its inverse distance.
const FLAT: f64 = 0.05;
/// A new point in the plane's direction: it may be on the plane, or on what stands before it. Inverse distance and its standard
/// deviation, as shares of the plane's. (On eight simulated walks the median error was 0.5 % of the path with 0.7 to 0.8,
/// and 2.3 % where points were born on the plane itself within 0.4: walls then bend the floor.)
const BORN: (f64, f64) = (1.3, 0.7);
/// Logarithm of two heights' ratio up to which they are one plane; the first height found stays, because it is the unit.
const SAME_PLANE: f64 = 0.2;

/// Heights under and over the camera that many points share.
#[derive(Debug, Clone)]
pub struct Planes {
    below: Heights,
    above: Heights,
}

impl Default for Planes {
    fn default() -> Self {
        let heights = Heights { histogram: vec![0.0; BINS], height: None };
        Self { below: heights.clone(), above: heights }
    }
}

#[derive(Debug, Clone)]
struct Heights {
    histogram: Vec<f64>,
    height: Option<f64>,
}

/// The height that most points have, a camera's sway aside.
#[derive(Debug, Clone, Copy)]
pub struct SharedHeight {
    /// Units, under or over the camera.
    pub height: f64,
    /// Points at it, in the sense of probability.
    pub points: f64,
    /// Of so many in all.
    pub of: f64,
    /// Points farther from the camera than it.
    pub beyond: f64,
}

/// The height that most of these points have, each (height, its standard deviation over it); `None` without points.
pub fn shared_height(points: impl Iterator<Item = (f64, f64)>) -> Option<SharedHeight> {
    let mut heights = Heights { histogram: vec![0.0; BINS], height: None };
    points.for_each(|(height, relative)| heights.add(height, relative));
    heights.shared()
}

impl Planes {
    /// Learns from points with a distance: (sine over the horizon, inverse distance, its standard deviation over it).
    ///
    /// Returns what lengths are to be multiplied by to be in the old unit, where the floor says so.
    pub fn learn(&mut self, points: impl Iterator<Item = (f64, f64, f64)>) -> Option<f64> {
        self.below.forget();
        self.above.forget();
        for (sine, rho, relative) in points.filter(|p| p.0.abs() > LEAST_SINE) {
            let heights = if sine < 0.0 { &mut self.below } else { &mut self.above };
            heights.add(sine.abs() / rho, relative);
        }
        let (floor, ceiling) = (self.below.settle(), self.above.settle());
        // Another room has another ceiling.
        if let Some(found) = ceiling.filter(|found| self.above.height.is_none_or(|h| libm::log(found / h).abs() > SAME_PLANE)) {
            self.above.height = Some(found);
        }
        let factor = self.below.height? / floor?;
        if libm::log(factor).abs() < SAME_PLANE {
            return Some(1.0);
        }
        self.lose();
        self.above.height = None;
        Some(factor)
    }

    /// Forgets where points were, but not how high the camera is: nothing with a distance is in view any more, and what comes
    /// will be in another unit.
    pub fn lose(&mut self) {
        self.below.histogram.fill(0.0);
        self.above.histogram.fill(0.0);
    }

    /// What to assume of a new point's inverse distance: mean and standard deviation.
    pub fn at_birth(&self, up: &Vector3<f64>, direction: &Vector3<f64>) -> Option<(f64, f64)> {
        self.inverse_distance(up, direction).map(|rho| (BORN.0 * rho, BORN.1 * rho))
    }

    /// What to assume of a point that seems to be on a plane: inverse distance and standard deviation; `None` if it is on none.
    pub fn laid(&self, up: &Vector3<f64>, direction: &Vector3<f64>, rho: f64, sigma_rho: f64) -> Option<(f64, f64)> {
        let plane = self.inverse_distance(up, direction)?;
        let near = NEAR * plane + sigma_rho.min(0.1 * plane);
        ((rho - plane).abs() < near).then_some((plane, FLAT * plane))
    }

    /// Inverse distance of a point on the floor or the ceiling in this direction; `None` where there is none in sight.
    pub fn inverse_distance(&self, up: &Vector3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        let sine = up.dot(direction);
        let height = if sine < 0.0 { self.below.height } else { self.above.height };
        Some(sine.abs() / height?).filter(|_| sine.abs() > LEAST_SINE)
    }

    /// Height of the camera over the floor, units.
    pub fn camera_height(&self) -> Option<f64> {
        self.below.height
    }
}

fn bin(height: f64) -> f64 {
    libm::log(height / LOWEST) / BIN
}

impl Heights {
    fn forget(&mut self) {
        self.histogram.iter_mut().for_each(|b| *b *= KEEPS);
    }

    fn add(&mut self, height: f64, relative: f64) {
        let (centre, spread) = (bin(height), (relative / BIN).max(1.0));
        if !(centre > 0.0 && centre < BINS as f64) {
            return;
        }
        let reach = (3.0 * spread) as usize + 1;
        let (from, to) = ((centre as usize).saturating_sub(reach), (centre as usize + reach).min(BINS - 1));
        for i in from..=to {
            let off = (i as f64 + 0.5 - centre) / spread;
            self.histogram[i] += libm::exp(-0.5 * off * off) / (spread * 2.5066);
        }
    }

    fn shared(&self) -> Option<SharedHeight> {
        let of: f64 = self.histogram.iter().sum();
        let window = |i: usize| self.histogram[i.saturating_sub(HALF_PEAK)..(i + HALF_PEAK + 1).min(BINS)].iter().sum::<f64>();
        let peak = (0..BINS).max_by(|a, b| window(*a).total_cmp(&window(*b)))?;
        let points = window(peak);
        let beyond: f64 = self.histogram[(peak + HALF_PEAK + 2).min(BINS)..].iter().sum();
        let (from, to) = (peak.saturating_sub(HALF_PEAK), (peak + HALF_PEAK + 1).min(BINS));
        let mean = (from..to).map(|i| self.histogram[i] * (i as f64 + 0.5)).sum::<f64>() / points;
        (points > 0.0).then(|| SharedHeight { height: LOWEST * libm::exp(mean * BIN), points, of, beyond })
    }

    /// The outermost height that many points share, if it is clear; the first one stays.
    fn settle(&mut self) -> Option<f64> {
        let SharedHeight { height, points, of, beyond } = self.shared()?;
        if !(points > ENOUGH && points > LEAST_SHARE * of && beyond < MOST_BEYOND * points) {
            return None;
        }
        self.height.get_or_insert(height);
        Some(height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene::uniform;
    use planwalk_types::Seed;

    const UP: Vector3<f64> = Vector3::new(0.0, -1.0, 0.0);

    /// Points seen from 1.5 over a floor: a share of them on it, the others anywhere above it.
    fn learnt(seed: u64, on_floor: f64, keyframes: usize) -> Planes {
        let mut rng = Seed(seed).derive("planes", 0);
        let mut planes = Planes::default();
        for _ in 0..keyframes {
            let points: Vec<_> = (0..40)
                .map(|_| {
                    let sine = -uniform(&mut rng, 0.17, 0.6);
                    let height = if uniform(&mut rng, 0.0, 1.0) < on_floor { 1.5 } else { uniform(&mut rng, 0.2, 1.45) };
                    (sine, -sine / (height * uniform(&mut rng, 0.96, 1.04)), 0.03)
                })
                .collect();
            planes.learn(points.into_iter());
        }
        planes
    }

    #[test]
    fn the_floor_is_found_among_what_stands_on_it() {
        for seed in 0..10 {
            let height = learnt(seed, 0.5, 10).camera_height().unwrap();
            // Points just above the floor are in its bins, too: they pull by a bin at most.
            assert!((height - 1.5).abs() < 0.05, "seed {seed}: {height}");
        }
    }

    #[test]
    fn where_no_height_is_shared_there_is_no_floor() {
        for seed in 0..10 {
            assert_eq!(learnt(seed, 0.0, 10).camera_height(), None, "seed {seed}");
        }
        assert_eq!(learnt(1, 0.9, 1).camera_height(), None, "forty points are not enough");
    }

    #[test]
    fn a_table_over_the_floor_is_not_the_floor() {
        let mut planes = Planes::default();
        for _ in 0..10 {
            // Thirty on a table 0.7 under the camera, twenty on the floor 1.5 under it.
            planes.learn((0..50).map(|i| (-0.3, 0.3 / if i < 30 { 0.7 } else { 1.5 }, 0.03)));
        }
        assert_eq!(planes.camera_height(), None, "it cannot be told which: neither is taken");
    }

    #[test]
    fn a_point_of_the_floor_is_as_far_as_the_floor() {
        let planes = learnt(1, 0.7, 10);
        let height = planes.camera_height().unwrap();
        let direction = Vector3::new(0.1, 0.4, 1.0).normalize();
        let rho = planes.inverse_distance(&UP, &direction).unwrap();
        assert!(((direction / rho).y - height).abs() < 1e-12);
        assert!(planes.laid(&UP, &direction, 1.1 * rho, 0.01 * rho).is_some());
        assert_eq!(planes.laid(&UP, &direction, 1.5 * rho, 0.01 * rho), None);
        assert_eq!(planes.inverse_distance(&UP, &Vector3::z()), None, "level rays hit no floor");
        assert_eq!(planes.inverse_distance(&UP, &-direction), None, "no ceiling was seen");
    }

    #[test]
    fn a_floor_that_seems_to_have_moved_tells_how_the_unit_has_changed() {
        let mut planes = learnt(1, 0.9, 10);
        let first = planes.camera_height().unwrap();
        let mut told = |height: f64| (0..200).find_map(|_| planes.learn((0..40).map(|_| (-0.3, 0.3 / height, 0.03))).filter(|f| *f != 1.0));
        assert_eq!(told(1.65), None, "a camera held a little higher");
        let factor = told(0.9).unwrap();
        // Bins of 3 %.
        assert!((factor * 0.9 - first).abs() < 0.03 * first, "{factor}");
        assert_eq!(planes.camera_height(), Some(first), "the height is the unit");
    }
}
