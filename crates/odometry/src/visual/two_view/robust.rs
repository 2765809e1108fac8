//! Which model do most matches agree on? One search for any kind of model: sample, compare, improve.
//!
//! matches, likeliest first ─▶ samples that grow (PROSAC) ─▶ minimal solver ─▶ cost over all, cut short ─▶ local optimisation
//!
//! * Samples: PROSAC, Chum & Matas 2005 (CVPR), with the order of [`super::matches`].
//! * Cost: that of MSAC (Torr & Zisserman 2000), averaged over noise levels as MAGSAC does (Barath et al. 2019): nobody knows the
//!   noise beforehand. It only grows from match to match, so a comparison stops as soon as it exceeds the best.
//! * Local optimisation: LO-RANSAC, Chum, Matas & Kittler 2003 (DAGM), on every new best.
//!
//! The same `rng` state gives the same answer.

use rand::{Rng, RngExt};

use super::matches::{Match, Matches};

/// A kind of model.
pub(crate) trait Kind {
    /// One model.
    type Model: Clone;
    /// Matches that a minimal solver needs.
    fn sample_size(&self) -> usize;
    /// All models that fit a sample.
    fn solve(&self, sample: &[Match], found: &mut Vec<Self::Model>);
    /// How many times the limit a model of right matches may be off, because its solver was told more than it can know. Over 1, models
    /// are compared with each other at so wide a limit, and improved before they are compared with those that already are.
    fn slack(&self) -> f64 {
        1.0
    }
    /// Weighted cost of all matches, at most their weight; any number over `enough` once it is sure to be more.
    fn cost(&self, model: &Self::Model, matches: &Matches, limit: f64, enough: f64) -> f64;
    /// Whether each match agrees, in their order.
    fn agree(&self, model: &Self::Model, matches: &Matches, limit: f64) -> Vec<bool>;
    /// A better model near this one: a few steps of reweighted least squares.
    fn improve(&self, model: &Self::Model, matches: &Matches, limit: f64, steps: usize) -> Option<Self::Model>;
}

/// How long to search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Residual from which on a match disagrees, at distance 1.
    pub limit: f64,
    /// Wanted probability that one sample was all right.
    pub confidence: f64,
    /// Fewest samples.
    pub least: usize,
    /// Most samples.
    pub most: usize,
}

/// A model and its cost.
#[derive(Debug, Clone)]
pub(crate) struct Candidate<M> {
    pub model: M,
    pub cost: f64,
}

/// Models that are kept: the best, and those that may yet become it.
const KEPT: usize = 4;

/// The best models, best first; empty where no sample gave any.
pub(crate) fn search<K: Kind>(kind: &K, matches: &Matches, effort: &Effort, rng: &mut impl Rng) -> Vec<Candidate<K::Model>> {
    let mut best: Vec<Candidate<K::Model>> = Vec::new();
    let size = kind.sample_size();
    if matches.list.len() < size {
        return best;
    }
    let (mut growth, mut found, mut sample) = (Growth::new(size, matches.list.len(), effort.most), Vec::new(), Vec::with_capacity(size));
    let mut agree: Vec<bool> = Vec::new();
    let mut rough = Rough([f64::INFINITY; KEPT]);
    let mut drawn = 0;
    while drawn < effort.least || drawn < effort.most && drawn < samples_needed(&agree, growth.pool, size, effort.confidence) {
        drawn += 1;
        growth.draw(matches, rng, &mut sample);
        found.clear();
        kind.solve(&sample, &mut found);
        found.retain_mut(|model| rough.admits(kind, model, matches, effort.limit));
        for model in &found {
            let enough = if best.len() < KEPT { f64::INFINITY } else { best[KEPT - 1].cost };
            let cost = kind.cost(model, matches, effort.limit, enough);
            if !(cost < enough) {
                continue;
            }
            let is_best = best.first().is_none_or(|b| cost < b.cost);
            insert(&mut best, Candidate { model: model.clone(), cost });
            if is_best {
                if let Some(better) = improved(kind, &best[0], matches, effort.limit) {
                    best[0] = better;
                }
                agree = kind.agree(&best[0].model, matches, effort.limit);
            }
        }
    }
    best
}

/// Costs of the best models as their samples gave them, at the wide limit of a kind that has slack, least first.
struct Rough([f64; KEPT]);

impl Rough {
    /// Whether a model may compete; if its kind has slack, only the best may, and are improved for it.
    fn admits<K: Kind>(&mut self, kind: &K, model: &mut K::Model, matches: &Matches, limit: f64) -> bool {
        const STEPS: usize = 3;
        let wide = kind.slack() * limit;
        if wide <= limit {
            return true;
        }
        let cost = kind.cost(model, matches, wide, self.0[KEPT - 1]);
        if !(cost < self.0[KEPT - 1]) {
            return false;
        }
        self.0[KEPT - 1] = cost;
        self.0.sort_by(f64::total_cmp);
        kind.improve(model, matches, wide, STEPS).map(|better| *model = better).is_some()
    }
}

fn insert<M>(best: &mut Vec<Candidate<M>>, candidate: Candidate<M>) {
    let at = best.partition_point(|b| b.cost <= candidate.cost);
    best.insert(at, candidate);
    best.truncate(KEPT);
}

/// A candidate after local optimisation, if it helped.
pub(crate) fn improved<K: Kind>(kind: &K, from: &Candidate<K::Model>, matches: &Matches, limit: f64) -> Option<Candidate<K::Model>> {
    const STEPS: usize = 5;
    let model = kind.improve(&from.model, matches, limit, STEPS)?;
    let cost = kind.cost(&model, matches, limit, from.cost);
    (cost < from.cost).then_some(Candidate { model, cost })
}

/// Local optimisation until it no longer helps.
pub(crate) fn finished<K: Kind>(kind: &K, from: Candidate<K::Model>, matches: &Matches, limit: f64) -> K::Model {
    let mut best = from;
    while let Some(better) = improved(kind, &best, matches, limit).filter(|better| better.cost < 0.999 * best.cost) {
        best = better;
    }
    best.model
}

/// Samples from a pool until one is all right with this confidence (Fischler & Bolles 1981), if those of it that agree are right.
fn samples_needed(agree: &[bool], pool: usize, size: usize, confidence: f64) -> usize {
    let Some(agree) = agree.get(..pool) else { return usize::MAX };
    let share = agree.iter().filter(|agree| **agree).count() as f64 / pool as f64;
    let all_right = share.clamp(1e-3, 1.0 - 1e-9).powi(size as i32);
    ((1.0 - confidence).ln() / (1.0 - all_right).ln()).ceil() as usize
}

/// PROSAC's growing pool: samples come from the first `pool` matches, and the newest of them is always in.
struct Growth {
    size: usize,
    count: usize,
    pool: usize,
    drawn: f64,
    /// Samples after which the pool grows (T'_n), and the expected number with this pool (T_n).
    until: f64,
    expected: f64,
}

impl Growth {
    /// After `most` samples the pool is nearly everything.
    fn new(size: usize, count: usize, most: usize) -> Self {
        let expected = (0..size).fold(most as f64, |t, i| t * (size - i) as f64 / (count - i) as f64);
        Self { size, count, pool: size, drawn: 0.0, until: 1.0, expected }
    }

    fn draw(&mut self, matches: &Matches, rng: &mut impl Rng, sample: &mut Vec<Match>) {
        self.drawn += 1.0;
        while self.drawn > self.until && self.pool < self.count {
            let next = self.expected * (self.pool + 1) as f64 / (self.pool + 1 - self.size) as f64;
            self.until += (next - self.expected).ceil();
            self.expected = next;
            self.pool += 1;
        }
        let newest = self.drawn <= self.until && self.pool < self.count;
        let from = if newest { self.pool - 1 } else { self.pool };
        let mut chosen = [usize::MAX; 8];
        let mut have = 0;
        if newest {
            chosen[0] = self.pool - 1;
            have = 1;
        }
        while have < self.size {
            let i = rng.random_range(0..from);
            if !chosen[..have].contains(&i) {
                chosen[have] = i;
                have += 1;
            }
        }
        sample.clear();
        sample.extend(chosen[..self.size].iter().map(|i| matches.list[*i]));
    }
}
