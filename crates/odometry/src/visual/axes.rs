//! Which directions do the building's edges have, and how is the camera turned against them?
//!
//! edges of the first second ─▶ [`Axes::find`] (up, and two level directions at right angles) ─▶ edges of a frame ─▶ [`Axes::fix`]
//!
//! Coughlan & Yuille 1999 (edges vote for a Manhattan world); Košecká & Zhang 2002 (vanishing directions from segments, by
//! iterated least squares). Where most level edges keep to no two directions there are no axes.
//!
//! Pitfall: people and furniture have edges as well, 5–15° off: hence the gate, which narrows, and the robust weights.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::lines::Edge;
use super::two_view::epipolar::tangent_basis;

/// How far the direction of an edge that a building made may be off, besides its noise: 0.3°.
const BUILT_RAD: f64 = 0.005;
/// An edge further than this from every axis, before anything is corrected, belongs to none: 6°.
const GATE_RAD: f64 = 0.1;
/// The same when the correction is found: 2°.
const NEAR_RAD: f64 = 0.035;
/// An axis that lies within this angle of two is no witness for either.
const APART_RAD: f64 = 0.05;
/// Fewest edges of an axis, and least sum of their lengths, that say something of it.
const FEWEST: usize = 3;
const LEAST_LENGTH_RAD: f64 = 0.4;
/// Half the width of the peak that the building's directions make among those of all level edges: 4°.
const PEAK_RAD: f64 = 0.07;
/// Fewest edges that make an axis.
const LEAST_COUNT: usize = 20;
/// How far up may be from where people hold it: 17°.
const FARTHEST_RAD: f64 = 0.3;
/// Share of the level edges, by length, within 4° of the building's directions that makes a compass; by chance it is 9 %.
const LEAST_SHARE: f64 = 0.35;

/// Directions that a building's edges have, odom's frame: up, and two level ones at right angles; right-handed.
#[derive(Debug, Clone, Copy)]
pub struct Axes(pub [Vector3<f64>; 3]);

/// A camera's rotation as the building's edges say it.
#[derive(Debug, Clone, Copy)]
pub struct Fix {
    /// `odom ← camera`.
    pub rotation: UnitQuaternion<f64>,
    /// Information on a turn in the camera frame, rad⁻².
    pub information: Matrix3<f64>,
    /// Edges that agree.
    pub edges: usize,
    /// Of these, upright ones.
    pub upright: usize,
    /// Whether level edges speak, so that heading is known.
    pub heading: bool,
}

impl Fix {
    /// How a camera at this rotation is turned against the fix, camera frame, radians.
    pub fn error(&self, rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
        (self.rotation.inverse() * rotation).scaled_axis()
    }

    /// The same in squared standard deviations.
    pub fn cost(&self, rotation: &UnitQuaternion<f64>) -> f64 {
        let error = self.error(rotation);
        error.dot(&(self.information * error))
    }
}

impl Axes {
    /// The axes that most edges have; the edges are in odom's frame, and `up` is where up is, within some 15°.
    pub fn find(edges: &[Edge], up: &Vector3<f64>) -> Option<Self> {
        let up = vertical(edges, up)?;
        let (east, north) = tangent_basis(&up);
        // The level direction in the plane of each edge, modulo a quarter turn; edges at eye level have none, upright ones any.
        let slanted = edges.iter().filter(|e| (0.1..0.97).contains(&e.normal.dot(&up).abs()));
        let level = slanted.map(|e| {
            let direction = e.normal.cross(&up);
            (quarter(libm::atan2(direction.dot(&north), direction.dot(&east))), e.length * direction.norm_squared())
        });
        let level: Vec<(f64, f64)> = level.collect();
        let total: f64 = level.iter().map(|l| l.1).sum();
        let near = |to: f64, reach: f64| level.iter().filter(move |(a, _)| quarter(a - to).abs() < reach);
        let weight = |to: f64| near(to, PEAK_RAD).map(|(_, w)| w).sum::<f64>();
        let candidates = (0..90).map(|i| f64::from(i).to_radians());
        let mut best = candidates.max_by(|a, b| weight(*a).total_cmp(&weight(*b)))?;
        if !(weight(best) > LEAST_SHARE * total && near(best, PEAK_RAD).count() >= LEAST_COUNT) {
            return None;
        }
        for _ in 0..10 {
            let (sum, all) = near(best, 0.7 * PEAK_RAD).fold((0.0, 0.0), |(s, w), (a, l)| (s + l * quarter(a - best), w + l));
            best += if all > 0.0 { sum / all } else { 0.0 };
        }
        let (s, c) = libm::sincos(best);
        let first = east * c + north * s;
        Some(Self([up, first, up.cross(&first)]).refined(edges))
    }

    /// The axes turned so that these edges, in odom's frame, agree with all three together.
    fn refined(self, edges: &[Edge]) -> Self {
        let turn = self.fix(edges, &UnitQuaternion::identity()).map_or_else(UnitQuaternion::identity, |f| f.rotation.inverse());
        Self(self.0.map(|a| turn * a))
    }

    /// The rotation near `predicted` that puts a frame's edges on the axes; `None` where too few say anything.
    pub fn fix(&self, edges: &[Edge], predicted: &UnitQuaternion<f64>) -> Option<Fix> {
        let mut rotation = *predicted;
        let mut gate = GATE_RAD;
        for _ in 0..8 {
            let (information, pull, _) = self.normal_equations(edges, &rotation, gate);
            // A turn that nothing speaks of stays as predicted: 3°.
            let step = (information + Matrix3::identity() * 400.0).try_inverse()? * pull;
            rotation *= UnitQuaternion::from_scaled_axis(step);
            gate = (0.7 * gate).max(NEAR_RAD);
        }
        let (information, _, said) = self.normal_equations(edges, &rotation, NEAR_RAD);
        let speaks = |i: usize| said[i].0 >= FEWEST && said[i].1 > LEAST_LENGTH_RAD;
        let heading = speaks(1) || speaks(2);
        (heading || speaks(0)).then(|| Fix { rotation, information, edges: said.iter().map(|s| s.0).sum(), upright: said[0].0, heading })
    }

    /// Gauss–Newton on a turn in the camera frame: information, pull, and what speaks for each axis (edges, length).
    fn normal_equations(
        &self,
        edges: &[Edge],
        rotation: &UnitQuaternion<f64>,
        gate: f64,
    ) -> (Matrix3<f64>, Vector3<f64>, [(usize, f64); 3]) {
        let axes = self.0.map(|a| rotation.inverse() * a);
        let (mut information, mut pull, mut said) = (Matrix3::zeros(), Vector3::zeros(), [(0, 0.0); 3]);
        for edge in edges {
            let off = axes.map(|a| edge.normal.dot(&a));
            let mut order = [0, 1, 2];
            order.sort_by(|a, b| off[*a].abs().total_cmp(&off[*b].abs()));
            let (axis, second) = (order[0], order[1]);
            let noise = edge.noise_towards(&axes[axis]).hypot(BUILT_RAD);
            if off[axis].abs() > gate || off[second].abs() < off[axis].abs() + APART_RAD.max(2.0 * noise) || noise > 0.5 * GATE_RAD {
                continue;
            }
            // n · exp(−ω) a = n · a − ω · (a × n).
            let slope = -axes[axis].cross(&edge.normal);
            let squared = (off[axis] / noise).powi(2);
            let weight = 1.0 / (noise * noise) * (9.0 / (9.0 + squared)).powi(2);
            information += slope * slope.transpose() * weight;
            pull -= slope * (off[axis] * weight);
            said[axis].0 += 1;
            said[axis].1 += edge.length;
        }
        (information, pull, said)
    }
}

/// An angle modulo a quarter turn, −45°..45°.
fn quarter(angle: f64) -> f64 {
    let quarter = std::f64::consts::FRAC_PI_2;
    angle - quarter * (angle / quarter).round()
}

/// The direction near `up` that most planes hold; `None` with too few of them.
fn vertical(edges: &[Edge], up: &Vector3<f64>) -> Option<Vector3<f64>> {
    let mut vertical = *up;
    for gate in [0.25, 0.2, 0.15, 0.1, 0.07, 0.05, 0.05, 0.05] {
        let mut quadratic = Matrix3::zeros();
        let mut count = 0;
        for edge in edges.iter().filter(|e| e.normal.dot(&vertical).abs() < gate) {
            quadratic += edge.normal * edge.normal.transpose() * edge.length;
            count += 1;
        }
        if count < LEAST_COUNT {
            return None;
        }
        // All planes hold it: the direction with the least square along their normals.
        let eigen = quadratic.symmetric_eigen();
        let found: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        vertical = if found.dot(up) < 0.0 { -found } else { found };
    }
    (vertical.angle(up) < FARTHEST_RAD).then_some(vertical)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::visual::two_view::scene::uniform;
    use planwalk_types::Seed;

    /// Directions and places of straight edges around a camera in a box-shaped world whose up is −y; a share of them askew.
    pub(crate) fn box_edges(seed: u64, count: usize, askew: f64) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let mut rng = Seed(seed).derive("box edges", 0);
        let mut vector = || Vector3::from_fn(|_, _| uniform(&mut rng, -1.0, 1.0));
        (0..count)
            .map(|i| {
                let direction = if (i as f64) < askew * count as f64 { vector().normalize() } else { Vector3::ith(i % 3, 1.0) };
                let place = vector();
                (direction, place.normalize() * 4.0)
            })
            .collect()
    }

    /// The edges that lie before a camera at this rotation, a unit long, with noise at their ends.
    pub(crate) fn seen_from(world: &[(Vector3<f64>, Vector3<f64>)], rotation: &UnitQuaternion<f64>, noise: f64, seed: u64) -> Vec<Edge> {
        let mut rng = Seed(seed).derive("seen edges", 0);
        let mut end = |p: Vector3<f64>| {
            let ray = rotation.inverse() * p.normalize();
            (ray + Vector3::from_fn(|_, _| uniform(&mut rng, -1.7, 1.7) * noise)).normalize()
        };
        let edge = |(direction, place): &(Vector3<f64>, Vector3<f64>)| {
            let (a, b) = (end(place - direction * 0.5), end(place + direction * 0.5));
            let normal = a.cross(&b).try_normalize(1e-3)?;
            Some(Edge { normal, middle: (a + b).normalize(), length: a.angle(&b), sigma_rad: noise })
        };
        world.iter().filter_map(edge).collect()
    }

    fn axes() -> Axes {
        Axes([-Vector3::y(), Vector3::x(), -Vector3::z()])
    }

    #[test]
    fn a_fix_is_good_to_a_third_of_a_degree_though_half_of_the_edges_are_askew() {
        let mut off: Vec<f64> = Vec::new();
        for seed in 0..40 {
            let truth = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.05 * seed as f64, -0.05));
            let edges = seen_from(&box_edges(seed, 60, 0.5), &truth, 1e-3, seed);
            let predicted = truth * UnitQuaternion::from_scaled_axis(Vector3::new(0.02, -0.05, 0.03));
            let fix = axes().fix(&edges, &predicted).unwrap();
            off.push(fix.rotation.angle_to(&truth).to_degrees());
        }
        off.sort_by(f64::total_cmp);
        // Thirty edges whose ends are good to 1 mrad over a quarter of a radian: 0.3° each.
        assert!(off[20] < 0.3 && off[37] < 1.0, "median {}°, 95 % {}°", off[20], off[37]);
    }

    #[test]
    fn the_axes_of_a_box_are_found_and_a_heap_has_none() {
        let turned = UnitQuaternion::from_scaled_axis(Vector3::new(0.05, 0.4, 0.0));
        for seed in 0..10 {
            let edges = seen_from(&box_edges(seed, 300, 0.4), &turned.inverse(), 1e-3, seed);
            let found = Axes::find(&edges, &-Vector3::y()).unwrap();
            assert!(found.0[0].angle(&(turned * -Vector3::y())) < 0.009, "seed {seed}: up to half a degree");
            let north = turned * Vector3::x();
            let along = found.0[1].dot(&north).abs().max(found.0[2].dot(&north).abs());
            assert!(along > 0.9999, "seed {seed}: level axes to 0.8°, {along}");
            let heap = seen_from(&box_edges(seed, 300, 1.0), &turned, 1e-3, seed);
            assert!(Axes::find(&heap, &-Vector3::y()).is_none(), "seed {seed}");
        }
    }

    #[test]
    fn too_few_edges_say_nothing_and_upright_ones_leave_the_heading() {
        assert!(axes().fix(&[], &UnitQuaternion::identity()).is_none());
        let upright: Vec<_> = box_edges(1, 90, 0.0).into_iter().filter(|(d, _)| d.y == 1.0).collect();
        let turned = UnitQuaternion::from_scaled_axis(Vector3::y() * 0.05);
        let fix = axes().fix(&seen_from(&upright, &UnitQuaternion::identity(), 1e-3, 1), &turned).unwrap();
        assert!(!fix.heading && fix.rotation.angle_to(&turned) < 0.01, "{}", fix.rotation.angle_to(&turned));
    }
}
