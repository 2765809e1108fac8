//! Which places does the cloud speak for, and how surely?
//!
//! particles ──bins of (x, y, heading)──▶ connected heaps of mass ──▶ modes: mass, mean, covariance, 95 % radius, scale
//!
//! A mode is a connected component of the bins that hold at least 2 % of the heaviest bin's mass. What lies in lighter bins
//! belongs to no mode, so that masses need not sum to one.

use nalgebra::{Matrix3, Vector3};
use planwalk_types::wrap_angle;
use rayon::prelude::*;

use crate::drift::UNIT_RAD;
use crate::particles::{CHUNK, Particles};

/// Side of a bin: parallel corridors are at least this far apart plus a wall.
const SIDE_M: f64 = 0.5;
/// Bins of heading: 15° each.
const HEADINGS: usize = 24;
/// Most bins; sides grow on sites where it takes more.
const BIN_LIMIT: f64 = 4e6;
/// Ground beyond the grid that has bins of its own, metres.
const MARGIN_M: f64 = 5.0;
/// Share of the heaviest bin's mass from which a bin joins a mode.
const JOIN: f64 = 0.02;
/// Most modes that are told apart.
pub(crate) const MODES_MAX: usize = 16;
/// The label of bins in no mode.
const NO_MODE: u8 = u8::MAX;

/// A grid over (x, y, heading).
#[derive(Debug, Clone)]
pub(crate) struct Bins {
    side_m: f64,
    columns: usize,
    rows: usize,
}

/// One heap of mass. Local metres.
#[derive(Debug, Clone)]
pub(crate) struct Mode {
    /// Share of the whole mass.
    pub mass: f64,
    pub mean: Vector3<f64>,
    pub covariance: Matrix3<f64>,
    pub radius95_m: f64,
    pub log_scale: f64,
    pub log_scale_sigma: f64,
    /// By how much the odometry turns by itself, radians a metre.
    pub drift_rad_per_m: f64,
}

/// The modes of a cloud, heaviest first, and to which of them each bin belongs.
#[derive(Debug, Clone)]
pub(crate) struct Modes {
    pub modes: Vec<Mode>,
    labels: Vec<u8>,
    /// How many bins the mass fills: the exponential of its entropy.
    pub filled_bins: f64,
}

impl Bins {
    /// Bins over a grid of this size in metres.
    pub(crate) fn new((size_x, size_y): (f64, f64)) -> Self {
        let (size_x, size_y) = (size_x + 2.0 * MARGIN_M, size_y + 2.0 * MARGIN_M);
        let side_m = SIDE_M.max((size_x * size_y * HEADINGS as f64 / BIN_LIMIT).sqrt());
        let count = |size: f64| (size / side_m).ceil().max(1.0) as usize;
        Self { side_m, columns: count(size_x), rows: count(size_y) }
    }

    fn len(&self) -> usize {
        self.columns * self.rows * HEADINGS
    }

    #[inline]
    pub(crate) fn index(&self, x: f32, y: f32, heading: f32) -> usize {
        // Casts to usize clamp: whoever walked off the grid is counted at its edge.
        let column = (((f64::from(x) + MARGIN_M) / self.side_m) as usize).min(self.columns - 1);
        let row = (((f64::from(y) + MARGIN_M) / self.side_m) as usize).min(self.rows - 1);
        let turn = f64::from(heading) / std::f64::consts::TAU;
        let sector = ((turn - turn.floor()) * HEADINGS as f64) as usize % HEADINGS;
        (sector * self.rows + row) * self.columns + column
    }

    /// The 26 neighbours of a bin, headings around the circle.
    fn neighbours(&self, index: usize, mut visit: impl FnMut(usize)) {
        let (column, row, sector) = (index % self.columns, index / self.columns % self.rows, index / self.columns / self.rows);
        for turn in [HEADINGS - 1, 0, 1] {
            let sector = (sector + turn) % HEADINGS;
            for row in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
                for column in column.saturating_sub(1)..=(column + 1).min(self.columns - 1) {
                    visit((sector * self.rows + row) * self.columns + column);
                }
            }
        }
    }

    /// The modes of a normalised cloud.
    pub(crate) fn modes(&self, cloud: &Particles) -> Modes {
        let mut mass = vec![0.0f64; self.len()];
        let poses = cloud.x.par_iter().zip(&cloud.y).zip(&cloud.heading);
        let bins: Vec<u32> = poses.with_min_len(CHUNK).map(|((x, y), heading)| self.index(*x, *y, *heading) as u32).collect();
        for (bin, weight) in bins.iter().zip(&cloud.weight) {
            mass[*bin as usize] += f64::from(*weight);
        }
        // A gathered cloud fills some hundred of a million bins.
        let filled: Vec<usize> = (0..mass.len()).filter(|bin| mass[*bin] > 0.0).collect();
        let (labels, masses) = self.label(&mass, &filled);
        let entropy: f64 = filled.iter().map(|bin| -mass[*bin] * libm::log(mass[*bin])).sum();
        let mut sums = vec![Sums::default(); masses.len()];
        for (i, bin) in bins.iter().enumerate() {
            let label = labels[*bin as usize];
            if let Some(sum) = sums.get_mut(usize::from(label)) {
                sum.add(cloud, i);
            }
        }
        let mut spreads: Vec<Spread> = sums.iter().map(Spread::around).collect();
        for (i, bin) in bins.iter().enumerate() {
            let label = labels[*bin as usize];
            if let Some(spread) = spreads.get_mut(usize::from(label)) {
                spread.add(cloud, i);
            }
        }
        let modes = spreads.into_iter().map(Spread::into_mode).collect();
        Modes { modes, labels, filled_bins: libm::exp(entropy) }
    }

    /// Label of every bin, and the masses of the labelled components, heaviest first; `filled` are the bins with mass.
    fn label(&self, mass: &[f64], filled: &[usize]) -> (Vec<u8>, Vec<f64>) {
        let threshold = JOIN * filled.iter().map(|bin| mass[*bin]).fold(0.0, f64::max);
        let mut component = vec![0u32; mass.len()];
        let mut masses = Vec::new();
        let mut open = Vec::new();
        for seed in filled.iter().copied() {
            if mass[seed] <= threshold || component[seed] != 0 {
                continue;
            }
            masses.push(0.0);
            let name = masses.len() as u32;
            component[seed] = name;
            open.push(seed);
            while let Some(bin) = open.pop() {
                masses[name as usize - 1] += mass[bin];
                self.neighbours(bin, |other| {
                    if mass[other] > threshold && component[other] == 0 {
                        component[other] = name;
                        open.push(other);
                    }
                });
            }
        }
        let mut order: Vec<usize> = (0..masses.len()).collect();
        order.sort_by(|a, b| masses[*b].total_cmp(&masses[*a]).then(a.cmp(b)));
        order.truncate(MODES_MAX);
        let mut rank = vec![NO_MODE; masses.len() + 1];
        for (i, name) in order.iter().enumerate() {
            rank[name + 1] = i as u8;
        }
        let mut labels = vec![NO_MODE; mass.len()];
        for bin in filled {
            labels[*bin] = rank[component[*bin] as usize];
        }
        (labels, order.into_iter().map(|i| masses[i]).collect())
    }
}

impl Modes {
    /// The mode that a pose belongs to.
    pub(crate) fn of(&self, bins: &Bins, x: f32, y: f32, heading: f32) -> Option<usize> {
        let label = self.labels[bins.index(x, y, heading)];
        (label != NO_MODE).then_some(usize::from(label))
    }
}

#[derive(Debug, Clone, Default)]
struct Sums {
    weight: f64,
    x: f64,
    y: f64,
    sin: f64,
    cos: f64,
    log_scale: f64,
    drift: f64,
    count: usize,
}

impl Sums {
    fn add(&mut self, cloud: &Particles, i: usize) {
        let w = f64::from(cloud.weight[i]);
        let (s, c) = libm::sincosf(cloud.heading[i]);
        self.weight += w;
        self.x += w * f64::from(cloud.x[i]);
        self.y += w * f64::from(cloud.y[i]);
        self.sin += w * f64::from(s);
        self.cos += w * f64::from(c);
        self.log_scale += w * f64::from(cloud.log_scale[i]);
        self.drift += w * f64::from(cloud.drift[i]);
        self.count += 1;
    }
}

/// Second moments and distances around a mean.
struct Spread {
    mass: f64,
    mean: Vector3<f64>,
    log_scale: f64,
    drift_rad_per_m: f64,
    moment: Matrix3<f64>,
    scale_moment: f64,
    /// (distance, weight) of every `stride`-th member.
    distances: Vec<(f64, f64)>,
    stride: usize,
    seen: usize,
}

impl Spread {
    fn around(sums: &Sums) -> Self {
        let w = sums.weight.max(f64::MIN_POSITIVE);
        let mean = Vector3::new(sums.x / w, sums.y / w, libm::atan2(sums.sin, sums.cos));
        // A few thousand distances give the 95 % radius to a per cent.
        let stride = (sums.count / 4096).max(1);
        let (log_scale, drift_rad_per_m) = (sums.log_scale / w, f64::from(UNIT_RAD) * sums.drift / w);
        let (moment, distances) = (Matrix3::zeros(), Vec::new());
        Self { mass: sums.weight, mean, log_scale, drift_rad_per_m, moment, scale_moment: 0.0, distances, stride, seen: 0 }
    }

    fn add(&mut self, cloud: &Particles, i: usize) {
        let w = f64::from(cloud.weight[i]);
        let off = Vector3::new(
            f64::from(cloud.x[i]) - self.mean.x,
            f64::from(cloud.y[i]) - self.mean.y,
            wrap_angle(f64::from(cloud.heading[i]) - self.mean.z),
        );
        self.moment += off * off.transpose() * w;
        self.scale_moment += w * (f64::from(cloud.log_scale[i]) - self.log_scale).powi(2);
        if self.seen.is_multiple_of(self.stride) {
            self.distances.push((off.x.hypot(off.y), w));
        }
        self.seen += 1;
    }

    fn into_mode(mut self) -> Mode {
        let w = self.mass.max(f64::MIN_POSITIVE);
        Mode {
            mass: self.mass,
            mean: self.mean,
            covariance: self.moment / w,
            radius95_m: weighted_quantile(&mut self.distances, 0.95),
            log_scale: self.log_scale,
            log_scale_sigma: (self.scale_moment / w).max(0.0).sqrt(),
            drift_rad_per_m: self.drift_rad_per_m,
        }
    }
}

/// The smallest value below which `share` of the weight lies; 0 for none.
pub(crate) fn weighted_quantile(values: &mut [(f64, f64)], share: f64) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|v| v.1).sum();
    let mut swept = 0.0;
    for (value, weight) in values.iter() {
        swept += weight;
        if swept >= share * total {
            return *value;
        }
    }
    values.last().map_or(0.0, |v| v.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::normal;
    use planwalk_types::Seed;

    fn heaps(of: &[(f32, f32, f32, usize)]) -> Particles {
        let mut rng = Seed(9).derive("heaps", 0);
        let mut cloud = Particles::default();
        for (x, y, heading, count) in of {
            for _ in 0..*count {
                let draw = [0.3, 0.3, 0.05].map(|sigma: f32| sigma * normal(&mut rng));
                cloud.push(x + draw[0], y + draw[1], heading + draw[2], 0.1);
            }
        }
        cloud.set_equal_weights();
        cloud
    }

    #[test]
    fn two_places_are_two_modes_with_their_masses() {
        let cloud = heaps(&[(5.0, 5.0, 3.1, 3000), (25.0, 5.0, 0.0, 1000)]);
        let modes = Bins::new((30.0, 10.0)).modes(&cloud).modes;
        assert_eq!(modes.len(), 2);
        assert!((modes[0].mass - 0.75).abs() < 0.02 && (modes[1].mass - 0.25).abs() < 0.02, "{modes:?}");
        assert!((modes[0].mean.x - 5.0).abs() < 0.03 && wrap_angle(modes[0].mean.z - 3.1).abs() < 0.01, "{:?}", modes[0].mean);
    }

    #[test]
    fn the_same_place_looking_the_other_way_is_another_mode() {
        let cloud = heaps(&[(5.0, 5.0, 0.0, 1000), (5.0, 5.0, 3.1, 900)]);
        assert_eq!(Bins::new((10.0, 10.0)).modes(&cloud).modes.len(), 2);
    }

    #[test]
    fn the_radius_holds_95_percent_of_a_normal_heap() {
        let cloud = heaps(&[(5.0, 5.0, 1.0, 20_000)]);
        let mode = &Bins::new((10.0, 10.0)).modes(&cloud).modes[0];
        // √(χ²₂(0.95)) = 2.448; the tails in light bins are left out, which takes 5 %, and sampling gives 1 %.
        assert!((mode.radius95_m / (0.3 * 2.448) - 1.0).abs() < 0.06, "{}", mode.radius95_m);
        assert!((mode.covariance[(0, 0)].sqrt() / 0.3 - 1.0).abs() < 0.06, "{}", mode.covariance);
    }

    #[test]
    fn whoever_walks_off_the_grid_is_counted_at_its_edge() {
        let bins = Bins::new((10.0, 10.0));
        for (x, y, heading) in [(-1e9, 3.0, 0.0), (1e9, 1e9, -4.0), (f32::NAN, f32::INFINITY, f32::NAN)] {
            assert!(bins.index(x, y, heading) < bins.len());
        }
    }
}
