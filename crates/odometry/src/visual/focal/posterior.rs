//! What do pictures and turns say of the focal length together, and how sure is that?
//!
//! curves of each cue ─▶ tempered, each with a bounded say ─▶ sum + prior ─▶ mean and variance, and their spread between stretches

/// Points of a likelihood are not independent: what a hundred of them say counts as what this share of them would.
const EDGES_COUNT: f64 = 0.1;
const TURNS_COUNT: f64 = 0.05;
/// Most that one picture or turn may say against a lens, as a logarithm: two sigmas, nearly. More of them must say the same.
const SAY: f64 = 1.8;
/// What one must say to be counted.
const COUNTED: f64 = 0.5;
/// Fewest, of both cues together, that are listened to.
const FEWEST: usize = 6;
/// Stretches of the video of which each is left out once (the jackknife: Efron 1982).
const STRETCHES: usize = 6;
/// Points between two focal lengths of the grid.
const FINER: usize = 8;
/// The least sigma of a measured focal length: a lens that is 3 % off a pinhole at the border, a principal point that is 2 % off centre.
const FLOOR: f64 = 0.02;
/// Share of the prior's sigma over which nothing was learned.
const LEARNED: f64 = 0.8;

/// The curves of a cue, in the order of the video.
pub(super) struct Cue {
    curves: Vec<Vec<f64>>,
}

impl Cue {
    /// Of pictures with edges.
    pub fn of_edges(curves: Vec<Vec<f64>>) -> Self {
        Self::tempered(curves, EDGES_COUNT)
    }

    /// Of turns.
    pub fn of_turns(curves: Vec<Vec<f64>>) -> Self {
        Self::tempered(curves, TURNS_COUNT)
    }

    /// Logarithm of a mixture: the curve, or else nothing.
    fn tempered(curves: Vec<Vec<f64>>, count: f64) -> Self {
        let least = libm::exp(-SAY);
        let bounded = |curve: Vec<f64>| {
            let most = curve.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            curve.iter().map(|v| libm::log((1.0 - least) * libm::exp(count * (v - most)) + least)).collect::<Vec<f64>>()
        };
        let sound = |curve: &Vec<f64>| curve.iter().all(|v| v.is_finite());
        Self { curves: curves.into_iter().map(bounded).filter(sound).collect() }
    }

    /// How many say something.
    fn count(&self) -> usize {
        let range = |c: &[f64]| c.iter().copied().fold(f64::NEG_INFINITY, f64::max) - c.iter().copied().fold(f64::INFINITY, f64::min);
        self.curves.iter().filter(|curve| range(curve) > COUNTED).count()
    }

    /// The sum of all, without those of one stretch.
    fn sum(&self, size: usize, without: Option<usize>) -> Vec<f64> {
        let mut sum = vec![0.0; size];
        for (i, curve) in self.curves.iter().enumerate() {
            if without != Some(i * STRETCHES / self.curves.len()) {
                sum.iter_mut().zip(curve).for_each(|(s, v)| *s += v);
            }
        }
        sum
    }
}

/// The logarithm of the focal length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Posterior {
    pub log: f64,
    pub sigma: f64,
    /// Pictures and turns that were listened to.
    pub said: [usize; 2],
}

impl Posterior {
    /// Of edges and turns, on this even grid of logarithms; the prior is normal with this mean and sigma.
    pub fn of(cues: &[Cue; 2], logs: &[f64], prior: (f64, f64)) -> Self {
        let unknown = Self { log: prior.0, sigma: prior.1, said: [0, 0] };
        let said = [cues[0].count(), cues[1].count()];
        if said[0] + said[1] < FEWEST {
            return unknown;
        }
        let sums = |without: Option<usize>| [0, 1].map(|k: usize| cues[k].sum(logs.len(), without));
        let both = |[a, b]: [Vec<f64>; 2]| a.iter().zip(&b).map(|(a, b)| a + b).collect::<Vec<f64>>();
        let (log, sigma) = moments(&both(sums(None)), logs, prior);
        let spread = jackknife(log, (0..STRETCHES).map(|k| moments(&both(sums(Some(k))), logs, prior).0));
        let sigma = libm::hypot(libm::hypot(sigma, spread), disagreement(&sums(None), logs, prior)).max(FLOOR);
        if sigma < LEARNED * prior.1 { Self { log, sigma, said } } else { unknown }
    }
}

/// The standard error of a mean that becomes these when one stretch is left out.
fn jackknife(log: f64, without: impl Iterator<Item = f64>) -> f64 {
    let share = (STRETCHES - 1) as f64 / STRETCHES as f64;
    (share * without.map(|other| (other - log).powi(2)).sum::<f64>()).sqrt()
}

/// Half of how far the cues are apart, as far as that is more than they admit themselves.
fn disagreement(sums: &[Vec<f64>; 2], logs: &[f64], prior: (f64, f64)) -> f64 {
    let [(a, sigma_a), (b, sigma_b)] = [0, 1].map(|k: usize| moments(&sums[k], logs, prior));
    let (apart, admitted) = (a - b, libm::hypot(sigma_a, sigma_b));
    if sigma_a.max(sigma_b) > LEARNED * prior.1 { 0.0 } else { 0.5 * (apart * apart - admitted * admitted).max(0.0).sqrt() }
}

/// Mean and standard deviation of a log-likelihood times the prior.
fn moments(curve: &[f64], logs: &[f64], prior: (f64, f64)) -> (f64, f64) {
    let fine: Vec<(f64, f64)> = (0..(logs.len() - 1) * FINER).map(|i| between(curve, logs, i as f64 / FINER as f64)).collect();
    let height = |(log, value): &(f64, f64)| value - 0.5 * ((log - prior.0) / prior.1).powi(2);
    let most = fine.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = fine.iter().map(|point| libm::exp(height(point) - most)).collect();
    let total: f64 = weights.iter().sum();
    let mean = fine.iter().zip(&weights).map(|(point, w)| w * point.0).sum::<f64>() / total;
    let square = fine.iter().zip(&weights).map(|(point, w)| w * (point.0 - mean).powi(2)).sum::<f64>() / total;
    (mean, square.sqrt())
}

/// The curve between its points, by a cubic through four of them (Catmull & Rom 1974).
fn between(curve: &[f64], logs: &[f64], at: f64) -> (f64, f64) {
    let (i, t) = (at as usize, at.fract());
    let p = |k: usize| curve[(i + k).saturating_sub(1).min(curve.len() - 1)];
    let slope = |k: usize| 0.5 * (p(k + 1) - p(k - 1));
    let (t2, t3) = (t * t, t * t * t);
    let value = (2.0 * t3 - 3.0 * t2 + 1.0) * p(1) + (t3 - 2.0 * t2 + t) * slope(1) + (3.0 * t2 - 2.0 * t3) * p(2) + (t3 - t2) * slope(2);
    (logs[i] + t * (logs[i + 1] - logs[i]), value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: (f64, f64) = (6.2, 0.15);

    fn logs() -> Vec<f64> {
        (0..33).map(|i| 5.5 + 0.053 * f64::from(i)).collect()
    }

    /// So many curves with their peak here, as a picture makes them: 5 % wide once they are tempered.
    fn peaks(at: f64, count: usize) -> Vec<Vec<f64>> {
        let curve: Vec<f64> = logs().iter().map(|log| -0.5 * ((log - at) / 0.05).powi(2) / EDGES_COUNT).collect();
        vec![curve; count]
    }

    fn of(edges: Vec<Vec<f64>>, turns: Vec<Vec<f64>>) -> Posterior {
        Posterior::of(&[Cue::tempered(edges, EDGES_COUNT), Cue::tempered(turns, EDGES_COUNT)], &logs(), PRIOR)
    }

    #[test]
    fn where_nothing_speaks_the_prior_comes_back() {
        let flat = vec![vec![3.0; 33]; 50];
        for posterior in [of(vec![], vec![]), of(flat.clone(), flat), of(peaks(6.0, 3), vec![]), of(vec![vec![f64::NAN; 33]; 9], vec![])] {
            assert_eq!((posterior.log, posterior.sigma, posterior.said), (PRIOR.0, PRIOR.1, [0, 0]));
        }
    }

    #[test]
    fn what_most_say_holds_and_a_few_others_are_outvoted() {
        let mut edges = peaks(6.5, 30);
        edges.extend(peaks(5.8, 8));
        let posterior = of(edges, peaks(6.5, 20));
        // The grid is 5 % wide and interpolated by a cubic: a tenth of that.
        assert!((posterior.log - 6.5).abs() < 0.01 && posterior.sigma < 0.05, "{posterior:?}");
        assert_eq!(posterior.said, [38, 20]);
    }

    #[test]
    fn cues_that_contradict_each_other_are_not_sure() {
        let agreed = of(peaks(6.3, 20), peaks(6.3, 20)).sigma;
        let posterior = of(peaks(6.25, 20), peaks(6.45, 20));
        // They are 20 % apart: half of it is the sigma, or nothing was learned.
        assert!(posterior.sigma > 0.09 && agreed < 0.03, "{} and {agreed}", posterior.sigma);
    }
}
