//! Which walk agrees best with everything at once: odometry, scale, the walls seen and the walls kept off?
//!
//! smoothed walk ──associate sightings with wall faces──▶ normal equations ──a damped step──▶ … ──▶ mean, covariance a moment
//!
//! Unknown is (x, y, heading, log scale) at every update of the filter: a chain, solved in time that grows with its length
//! (Levenberg–Marquardt; Nocedal & Wright 2006, §10.3). Sightings pull point to line (Chen & Medioni 1992), each by how likely
//! it lies on a wall at all in the mixture of [`crate::likelihood`]; how much all of them together are worth is measured, see
//! [`crate::calibrate`]. Departs from the filter in one thing: a sighting's density per *measured* range, ln scale, is left out;
//! it moves the scale by a thousandth, and the mode of a whole chain by more than its mean.
//! Pitfall: the polish climbs the nearest hill. It is started from several draws of the posterior; what does not merge is spread.

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use planwalk_types::{FloorPlan, wrap_angle};
use rayon::prelude::*;

use crate::banded::{Chain, Covariances};
use crate::calibrate::{Calibration, Grouped};
use crate::faces::Field;
use crate::likelihood::Ray;
use crate::motion::Motion;
use crate::options::LocateOptions;
use crate::smooth::{Smoothed, radius95};
use crate::walls::Walls;

/// Rounds of polishing and measuring; the measured spreads change by a few per cent after the third.
const ROUNDS: usize = 3;
/// Most damped steps a round, and most dampings that a step tries.
const STEPS: usize = 10;
const TRIES: usize = 4;
/// A round ends when a step gains less than this, nats: far below what tells two walks apart.
const GAIN_NATS: f64 = 0.05;
/// Half the width of a body, metres, and how softly it keeps off walls.
const BODY_M: f64 = 0.2;
const BODY_SIGMA_M: f64 = 0.1;
/// Smallest noise of a motion: metres, radians, and of the logarithm of scale.
const MOTION_M: f64 = 0.005;
const MOTION_RAD: f64 = 0.002;
const MOTION_LOG_SCALE: f64 = 1e-4;
/// Residuals that the stated noise of the odometry is worth before any is measured, and how much worse it may be found to be.
const SURPLUS_PRIOR: f64 = 20.0;
const SURPLUS_MAX: f64 = 25.0;
/// Fewest sightings on walls, for each metre of the walk and in all, below which there is nothing to polish against.
const TOUCHES_PER_M: f64 = 0.5;
const TOUCHES: f64 = 20.0;

/// One unknown of the chain and what ties it to the one before.
#[derive(Debug, Clone)]
pub(crate) struct Link<'a> {
    pub motion: Motion,
    pub rays: &'a [Ray],
}

/// The least squares of one walk. Local metres.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    links: Vec<Link<'a>>,
    walls: &'a Walls,
    field: Field,
    options: &'a LocateOptions,
    /// Of the start, local metres.
    start: Option<(f64, f64)>,
    /// Precision of the motion to each link (metres, radians) and of the change of scale.
    ties: Vec<(Matrix3<f64>, f64)>,
    /// Metres walked up to each link.
    way_m: Vec<f64>,
    /// Variance of the motions over the stated one, as measured; it is in the ties already.
    surplus: f64,
}

/// A walk polished.
#[derive(Debug, Clone)]
pub(crate) struct Polished {
    pub walk: Vec<Smoothed>,
    /// What the residuals say of plan and sightings.
    pub calibration: Calibration,
}

/// A sighting and the face that it lies on, if on any.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch {
    pub link: usize,
    /// Unit direction out of the wall.
    pub normal: (f64, f64),
    /// Metres out of the wall, negative within or behind.
    pub residual_m: f64,
    /// Derivative of the residual by (x, y, heading, log scale).
    pub slope: Vector4<f64>,
    pub sigma_m: f64,
    /// How likely this is the wall, 0..=1.
    pub share: f64,
}

/// What one sighting costs, and where it pulls.
struct Fate {
    nats: f64,
    touch: Option<Touch>,
}

/// Where all sightings stand: costs in nats, and pulls.
struct Associated {
    nats: f64,
    /// Which sighting of which link, and its touch.
    touches: Vec<(usize, Touch)>,
}

/// How much each sighting counts in a round: standard deviation in metres and share of independence.
#[derive(Debug, Clone, Copy)]
struct Worth {
    sigma_m: f64,
    temper: f64,
}

impl<'a> Problem<'a> {
    /// `walk` gives the scale at which motions become metres, and the part of the plan that matters.
    pub(crate) fn new(links: Vec<Link<'a>>, walk: &[Vector4<f64>], plan: &FloorPlan, walls: &'a Walls, options: &'a LocateOptions) -> Self {
        let (low, high) = span(&links, walk);
        let field = Field::new(plan, low, high);
        let start = options.start.as_ref().map(|s| (s.x - plan.origin().x, s.y - plan.origin().y));
        let mut way_m = Vec::with_capacity(links.len());
        let mut ties = Vec::with_capacity(links.len());
        let mut way = 0.0;
        for (i, link) in links.iter().enumerate() {
            let scale = libm::exp(walk[i.saturating_sub(1)][3]);
            way += scale * link.motion.length;
            way_m.push(way);
            ties.push(tie(&link.motion, scale, options));
        }
        Self { links, walls, field, options, start, ties, way_m, surplus: 1.0 }
    }

    /// What the walk costs in all, nats.
    fn cost(&self, walk: &[Vector4<f64>], worth: &[Vec<Worth>]) -> (f64, Associated) {
        let mut seen = self.associate(walk, worth);
        let mut nats = seen.nats;
        for i in 0..walk.len() {
            if i > 0 {
                let (residual, stretch) = self.motion_residual(walk, i);
                nats += 0.5 * (residual.dot(&(self.ties[i].0 * residual)) + stretch * stretch * self.ties[i].1);
                let [x0, y0, x1, y1] = [walk[i - 1].x, walk[i - 1].y, walk[i].x, walk[i].y].map(|v| v as f32);
                nats -= f64::from(self.walls.crossings(x0, y0, x1, y1)) * libm::log(self.options.leak.clamp(1e-9, 1.0));
            }
            nats += 0.5 * self.body(&walk[i]).map_or(0.0, |(residual, _)| residual * residual);
        }
        nats += self.priors(&walk[0]).iter().flatten().map(|(residual, ..)| 0.5 * residual * residual).sum::<f64>();
        seen.nats = nats;
        (nats, seen)
    }

    /// The motion to link `i` against the odometry (ahead, aside: metres; turn), and the change of log scale against none.
    fn motion_residual(&self, walk: &[Vector4<f64>], i: usize) -> (Vector3<f64>, f64) {
        let (a, b, motion) = (&walk[i - 1], &walk[i], &self.links[i].motion);
        let (s, c) = libm::sincos(a[2]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let scale = libm::exp(a[3]);
        let moved = (c * dx + s * dy, -s * dx + c * dy);
        let turn = wrap_angle(b[2] - a[2] - motion.turn_rad);
        (Vector3::new(moved.0 - scale * motion.forward, moved.1 - scale * motion.left, turn), b[3] - a[3])
    }

    /// Derivatives of [`Problem::motion_residual`] by the link before and by link `i`.
    fn motion_slopes(&self, walk: &[Vector4<f64>], i: usize) -> (nalgebra::Matrix3x4<f64>, nalgebra::Matrix3x4<f64>) {
        let (a, b, motion) = (&walk[i - 1], &walk[i], &self.links[i].motion);
        let (s, c) = libm::sincos(a[2]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let scale = libm::exp(a[3]);
        let moved = (c * dx + s * dy, -s * dx + c * dy);
        #[rustfmt::skip]
        let before = nalgebra::Matrix3x4::new(
            -c, -s, moved.1, -scale * motion.forward,
            s, -c, -moved.0, -scale * motion.left,
            0.0, 0.0, -1.0, 0.0,
        );
        #[rustfmt::skip]
        let here = nalgebra::Matrix3x4::new(
            c, s, 0.0, 0.0,
            -s, c, 0.0, 0.0,
            0.0, 0.0, 1.0, 0.0,
        );
        (before, here)
    }

    /// How far a body is pressed against a wall, in sigmas, and the derivative by (x, y). Who is within a wall crosses it: no pull.
    fn body(&self, at: &Vector4<f64>) -> Option<(f64, (f64, f64))> {
        let face = self.field.face(at[0], at[1])?;
        if face.signed_m >= BODY_M {
            return None;
        }
        let residual = (BODY_M - face.signed_m.max(0.0)) / BODY_SIGMA_M;
        let slope = if face.signed_m > 0.0 { -1.0 / BODY_SIGMA_M } else { 0.0 };
        Some((residual, (slope * face.normal.0, slope * face.normal.1)))
    }

    /// Prior residuals of the first link in sigmas: of scale, x, y, heading; each with the unknown that it concerns.
    fn priors(&self, first: &Vector4<f64>) -> [Option<(f64, usize, f64)>; 4] {
        let sigma = self.options.scale.relative_sigma.max(1e-3);
        let of = |off: f64, sigma: f64, index: usize| Some((off / sigma, index, 1.0 / sigma));
        let mut all = [of(first[3] - self.options.scale.log_mean(), sigma, 3), None, None, None];
        if let (Some(start), Some((x, y))) = (&self.options.start, self.start) {
            let sigma_m = start.sigma_m.max(0.01);
            all[1] = of(first[0] - x, sigma_m, 0);
            all[2] = of(first[1] - y, sigma_m, 1);
            all[3] = start.heading_rad.and_then(|heading| of(wrap_angle(first[2] - heading), start.sigma_rad.max(1e-3), 2));
        }
        all
    }

    fn associate(&self, walk: &[Vector4<f64>], worth: &[Vec<Worth>]) -> Associated {
        let mut all = Associated { nats: 0.0, touches: Vec::new() };
        for (i, link) in self.links.iter().enumerate() {
            for (k, ray) in link.rays.iter().enumerate() {
                let fate = self.fate(i, ray, &walk[i], worth[i][k].sigma_m);
                all.nats += worth[i][k].temper * fate.nats;
                all.touches.extend(fate.touch.map(|touch| (k, touch)));
            }
        }
        all
    }

    /// What becomes of a sighting from this pose: on the face that it meets, on something before it, or a mistake.
    fn fate(&self, link: usize, ray: &Ray, at: &Vector4<f64>, sigma_m: f64) -> Fate {
        let model = &self.options.sightings;
        let scale = libm::exp(at[3]);
        let (s, c) = libm::sincos(at[2]);
        let turned = |(x, y): (f64, f64)| (scale * (c * x - s * y), scale * (s * x + c * y));
        let (from, to) = (turned(ray.from), turned(ray.to));
        let range = (to.0 - from.0).hypot(to.1 - from.1).max(1e-9);
        let direction = ((to.0 - from.0) / range, (to.1 - from.1) / range);
        let (eye, end) = ((at[0] + from.0, at[1] + from.1), (at[0] + to.0, at[1] + to.1));
        let met = self.walls.cast(eye.0 as f32, eye.1 as f32, direction.0 as f32, direction.1 as f32, range as f32);
        let met = f64::from(met);
        let total = model.wall + model.clutter + model.through;
        let other = |share: f64| share / model.spread_m / total;
        let cell_m = f64::from(self.walls.cell_m());
        // The filter's own widths: what is a mistake to it must not become a wall here.
        let wide_m = model.wall_sigma_m.hypot(scale * ray.sigma);
        if met < range - 2.5 * wide_m - cell_m {
            return Fate { nats: -libm::log(other(model.through)), touch: None };
        }
        let behind = met < range;
        // Behind a face that is met, it is that face; before all, the nearest one.
        let probe = if behind {
            let short = (met - 0.5 * cell_m).max(0.0);
            (eye.0 + short * direction.0, eye.1 + short * direction.1)
        } else {
            end
        };
        let other = other(if behind { model.through } else { model.clutter });
        let face = self.field.face(probe.0, probe.1);
        // A face is seen from its front; along it, next to nothing is learned.
        let Some(face) = face.filter(|f| f.normal.0 * direction.0 + f.normal.1 * direction.1 < if behind { -0.1 } else { 0.3 }) else {
            return Fate { nats: -libm::log(other), touch: None };
        };
        let residual_m = face.signed_m + face.normal.0 * (end.0 - probe.0) + face.normal.1 * (end.1 - probe.1);
        let sigmas = residual_m / sigma_m;
        let wall = model.wall / total * libm::exp(-0.5 * sigmas * sigmas) / (sigma_m * 2.506_628_274_631);
        let share = wall / (wall + other);
        let (n, turned_by) = (face.normal, (-to.1, to.0));
        let slope = Vector4::new(n.0, n.1, n.0 * turned_by.0 + n.1 * turned_by.1, n.0 * to.0 + n.1 * to.1);
        let touch = (share > 1e-4).then_some(Touch { link, normal: n, residual_m, slope, sigma_m, share });
        Fate { nats: -libm::log(wall + other), touch }
    }

    /// Normal equations at this walk (Gauss–Newton, touches by their share).
    fn equations(&self, walk: &[Vector4<f64>], seen: &Associated, worth: &[Vec<Worth>]) -> Chain {
        let mut chain = Chain::zeros(walk.len());
        for (k, touch) in &seen.touches {
            let weight = worth[touch.link][*k].temper * touch.share / (touch.sigma_m * touch.sigma_m);
            chain.diagonal[touch.link] += touch.slope * touch.slope.transpose() * weight;
            chain.right[touch.link] -= touch.slope * (weight * touch.residual_m);
        }
        for i in 0..walk.len() {
            if let Some((residual, slope)) = self.body(&walk[i]) {
                let slope = Vector4::new(slope.0, slope.1, 0.0, 0.0);
                chain.diagonal[i] += slope * slope.transpose();
                chain.right[i] -= slope * residual;
            }
            if i == 0 {
                continue;
            }
            let (residual, stretch) = self.motion_residual(walk, i);
            let (before, here) = self.motion_slopes(walk, i);
            let (precision, of_scale) = self.ties[i];
            chain.diagonal[i - 1] += before.transpose() * precision * before;
            chain.diagonal[i] += here.transpose() * precision * here;
            chain.beside[i - 1] += before.transpose() * precision * here;
            chain.right[i - 1] -= before.transpose() * precision * residual;
            chain.right[i] -= here.transpose() * precision * residual;
            for (row, sign) in [(i - 1, -1.0), (i, 1.0)] {
                chain.diagonal[row][(3, 3)] += of_scale;
                chain.right[row][3] -= sign * of_scale * stretch;
            }
            chain.beside[i - 1][(3, 3)] -= of_scale;
        }
        for (residual, index, slope) in self.priors(&walk[0]).into_iter().flatten() {
            chain.diagonal[0][(index, index)] += slope * slope;
            chain.right[0][index] -= slope * residual;
        }
        for block in &mut chain.diagonal {
            // A kilometre, a turn: keeps what nothing ties down solvable.
            *block += Matrix4::identity() * 1e-6;
        }
        chain
    }

    /// Damped steps from `walk` until nothing is gained. Never worse than where it began.
    fn descend(&self, walk: &mut Vec<Vector4<f64>>, worth: &[Vec<Worth>], steps: usize) -> f64 {
        let (mut nats, mut seen) = self.cost(walk, worth);
        let mut damping = 1e-4;
        for _ in 0..steps {
            let chain = self.equations(walk, &seen, worth);
            let mut gained = 0.0;
            for _ in 0..TRIES {
                let Some(step) = chain.solve(damping) else {
                    damping *= 10.0;
                    continue;
                };
                let mut next = walk.clone();
                for (state, by) in next.iter_mut().zip(&step) {
                    *state += by;
                    state[2] = wrap_angle(state[2]);
                }
                let (next_nats, next_seen) = self.cost(&next, worth);
                if next_nats < nats {
                    gained = nats - next_nats;
                    (nats, seen, *walk) = (next_nats, next_seen, next);
                    damping = (damping * 0.3).max(1e-7);
                    break;
                }
                damping *= 10.0;
            }
            if gained < GAIN_NATS {
                break;
            }
        }
        nats
    }

    /// What each sighting counts, given what was measured so far.
    fn worth(&self, walk: &[Vector4<f64>], calibration: &Calibration) -> Vec<Vec<Worth>> {
        let model = &self.options.sightings;
        let sigma_m = |i: usize, ray: &Ray| {
            let wide = model.wall_sigma_m.hypot(libm::exp(walk[i][3]) * ray.sigma);
            (calibration.noise * wide).max(0.02).max(0.3 * f64::from(self.walls.cell_m()))
        };
        let of = |(i, link): (usize, &Link<'_>)| {
            link.rays.iter().map(|ray| Worth { sigma_m: sigma_m(i, ray), temper: model.temper }).collect::<Vec<_>>()
        };
        let mut worth: Vec<Vec<Worth>> = self.links.iter().enumerate().map(of).collect();
        let seen = self.associate(walk, &worth);
        let groups = Grouped::new(seen.touches.iter().map(|(_, touch)| touch), &self.way_m);
        for (k, touch) in &seen.touches {
            worth[touch.link][*k].temper = groups.independence(touch, calibration);
        }
        worth
    }

    /// How much noisier the odometry was than it said: variance of the motions' residuals over what the fit leaves of the stated
    /// one. Never less than stated: what drifts slowly leaves small residuals.
    fn motion_surplus(&self, walk: &[Vector4<f64>], covariances: &Covariances) -> f64 {
        let (mut sum, mut freedom) = (SURPLUS_PRIOR, SURPLUS_PRIOR);
        for i in 1..walk.len() {
            let (residual, _) = self.motion_residual(walk, i);
            let (before, here) = self.motion_slopes(walk, i);
            let both = before * covariances.beside[i - 1] * here.transpose();
            let taken = before * covariances.diagonal[i - 1] * before.transpose()
                + here * covariances.diagonal[i] * here.transpose()
                + both
                + both.transpose();
            let precision = self.ties[i].0;
            sum += residual.dot(&(precision * residual));
            freedom += (3.0 - (precision * taken).trace()).max(0.0);
        }
        (self.surplus * sum / freedom).clamp(1.0, SURPLUS_MAX)
    }

    /// Polishes `walk`; `draws` are other walks of the same posterior, from which it is tried again. `None` where hardly
    /// anything was seen on walls: then there is nothing to polish against.
    pub(crate) fn polish(&mut self, walk: &[Vector4<f64>], draws: &[Vec<Vector4<f64>>]) -> Option<Polished> {
        let mut calibration = Calibration::prior(f64::from(self.walls.cell_m()));
        let mut best = walk.to_vec();
        let mut worth = self.worth(&best, &calibration);
        let touches: f64 = self.associate(&best, &worth).touches.iter().map(|(_, t)| t.share).sum();
        if touches < TOUCHES || touches < TOUCHES_PER_M * self.way_m.last().copied().unwrap_or(0.0) {
            return None;
        }
        for _ in 0..ROUNDS {
            self.descend(&mut best, &worth, STEPS);
            let (_, seen) = self.cost(&best, &worth);
            let covariances = self.equations(&best, &seen, &worth).covariances()?;
            let groups = Grouped::new(seen.touches.iter().map(|(_, touch)| touch), &self.way_m);
            calibration = groups.measure(&covariances.diagonal, &calibration, f64::from(self.walls.cell_m()));
            let surplus = self.motion_surplus(&best, &covariances);
            self.ties.iter_mut().for_each(|(precision, _)| *precision /= surplus / self.surplus);
            self.surplus = surplus;
            worth = self.worth(&best, &calibration);
        }
        let mut nats = self.descend(&mut best, &worth, STEPS);
        let mut optima: Vec<(f64, Vec<Vector4<f64>>)> = draws
            .par_iter()
            .map(|draw| {
                let mut walk = draw.clone();
                (self.descend(&mut walk, &worth, STEPS), walk)
            })
            .collect();
        // Among equals the first: the order does not depend on threads.
        if let Some(i) = (0..optima.len()).min_by(|a, b| optima[*a].0.total_cmp(&optima[*b].0)).filter(|i| optima[*i].0 < nats) {
            std::mem::swap(&mut optima[i].1, &mut best);
            (nats, optima[i].0) = (optima[i].0, nats);
        }
        if !nats.is_finite() {
            return None;
        }
        let (_, seen) = self.cost(&best, &worth);
        let covariances = self.equations(&best, &seen, &worth).covariances()?;
        let walk = (0..best.len()).map(|i| summarise(i, &best, &covariances.diagonal[i], &optima)).collect();
        Some(Polished { walk, calibration })
    }
}

/// Mean, covariance and region at link `i`: the best walk's own, and how far the other draws ended from it.
fn summarise(i: usize, best: &[Vector4<f64>], covariance: &Matrix4<f64>, optima: &[(f64, Vec<Vector4<f64>>)]) -> Smoothed {
    let own: Matrix3<f64> = covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let mut offsets = vec![Vector3::zeros()];
    for (_, walk) in optima {
        let off = walk[i] - best[i];
        offsets.push(Vector3::new(off[0], off[1], wrap_angle(off[2])));
    }
    let mut total = own;
    for off in &offsets {
        total += off * off.transpose() / offsets.len() as f64;
    }
    let places: Vec<(f64, f64)> = offsets.iter().map(|o| (o.x, o.y)).collect();
    let mean = Vector3::new(best[i][0], best[i][1], best[i][2]);
    let radius95_m = radius95(&places, &own);
    // The motions that are polished have no drift left.
    Smoothed { mean, covariance: total, radius95_m, log_scale: best[i][3], log_scale_variance: covariance[(3, 3)], drift_rad: 0.0 }
}

/// Precision of a motion at this scale: (ahead, aside, turn) in metres and radians, and the change of log scale.
fn tie(motion: &Motion, scale: f64, options: &LocateOptions) -> (Matrix3<f64>, f64) {
    let finite = motion.covariance.map(|v| if v.is_finite() { v } else { 0.0 });
    let stretch = Matrix3::from_diagonal(&Vector3::new(scale, scale, 1.0));
    let mut covariance = stretch * finite * stretch;
    let length_m = scale * motion.length;
    let floor = &options.noise_floor;
    let along = (floor.length_relative * length_m).powi(2) + MOTION_M * MOTION_M;
    covariance[(0, 0)] += along;
    covariance[(1, 1)] += along;
    covariance[(2, 2)] += floor.turn_per_sqrt_m_rad.powi(2) * length_m + MOTION_RAD * MOTION_RAD;
    let precision = covariance.cholesky().map_or_else(
        || Matrix3::from_diagonal(&covariance.diagonal().map(|v| 1.0 / v.max(MOTION_RAD * MOTION_RAD))),
        |root| root.inverse(),
    );
    let drift = options.scale_drift_per_sqrt_m.max(0.0).powi(2) * length_m + motion.unit_variance.max(0.0);
    (precision, 1.0 / (drift + MOTION_LOG_SCALE * MOTION_LOG_SCALE))
}

/// Corners of what the walk and its sightings span, local metres.
fn span(links: &[Link<'_>], walk: &[Vector4<f64>]) -> ((f64, f64), (f64, f64)) {
    let (mut low, mut high) = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));
    let mut add = |x: f64, y: f64| {
        low = (low.0.min(x), low.1.min(y));
        high = (high.0.max(x), high.1.max(y));
    };
    for (link, at) in links.iter().zip(walk) {
        add(at[0], at[1]);
        let (s, c) = libm::sincos(at[2]);
        let scale = libm::exp(at[3]);
        for ray in link.rays {
            add(at[0] + scale * (c * ray.to.0 - s * ray.to.1), at[1] + scale * (s * ray.to.0 + c * ray.to.1));
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests;
