//! Which relative motions agree with the matches' epipolar geometry? The essential matrix as a [`Kind`] of model.
//!
//! Residual: Sampson's, at distance 1 (Hartley & Zisserman 2003, eq. 11.9): to first order how far both points are from the nearest
//! pair that fits exactly. Improvement: Gauss–Newton over rotation and direction, five parameters, with Tukey's weights.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use wide::f32x8;

use super::epipolar::tangent_basis;
use super::matches::{Lanes, Match, Matches};
use super::robust::Kind;
use super::upright::Uprights;
use super::{RayPair, Solver, eight_point, five_point};

/// Essential matrices from minimal samples.
pub(crate) enum Epipolar {
    /// See [`Solver::FivePoint`].
    FivePoint,
    /// See [`Solver::EightPoint`].
    EightPoint,
    /// See [`Solver::UprightThreePoint`].
    Upright(Uprights),
}

impl Epipolar {
    /// The wanted solver, or five-point where that needs to know up and it is not known.
    pub fn of(solver: Solver, ups: Option<&[Vector3<f64>; 2]>) -> Self {
        match solver {
            Solver::FivePoint => Self::FivePoint,
            Solver::EightPoint => Self::EightPoint,
            Solver::UprightThreePoint => ups.and_then(Uprights::of).map_or(Self::FivePoint, Self::Upright),
        }
    }
}

/// How many times the limit of 2.5 px a motion may be off that takes up from others: half a degree is 4.4 px at a focal length of 500 px,
/// and three pairs magnify it. Without this, such an up costs 8 of 96 % (AUC@5°, general motion), with it 2; from 3 to 6 it is the same.
const UPRIGHT_SLACK: f64 = 4.0;

/// Noise levels over which the cost is averaged, as shares of the limit, squared and inverted.
pub(super) const LEVELS: [f32; 3] = [1.0, 4.0, 16.0];

impl Kind for Epipolar {
    type Model = Matrix3<f64>;

    fn sample_size(&self) -> usize {
        match self {
            Self::FivePoint => 5,
            Self::EightPoint => 8,
            Self::Upright(_) => 3,
        }
    }

    fn solve(&self, sample: &[Match], found: &mut Vec<Matrix3<f64>>) {
        match self {
            Self::FivePoint => five_point::solve_into(sample, found),
            Self::EightPoint => found.extend(eight_point::solve_matches(sample)),
            Self::Upright(uprights) => uprights.solve_matches(sample, found),
        }
    }

    fn slack(&self) -> f64 {
        match self {
            Self::FivePoint | Self::EightPoint => 1.0,
            Self::Upright(_) => UPRIGHT_SLACK,
        }
    }

    fn cost(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64, enough: f64) -> f64 {
        let e = [0, 1, 2].map(|r| [0, 1, 2].map(|c| f32x8::splat(model[(r, c)] as f32)));
        sum_costs(&matches.lanes, limit, enough, |lanes| sampson_squared(&e, lanes))
    }

    fn agree(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64) -> Vec<bool> {
        matches.list.iter().map(|m| residual(model, m).abs() < limit).collect()
    }

    fn improve(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64, steps: usize) -> Option<Matrix3<f64>> {
        let mut pose = Twisted::of(model)?;
        for _ in 0..steps {
            let step = pose.step(matches.list.iter(), limit)?;
            if step < 1e-8 {
                break;
            }
        }
        Some(pose.essential())
    }
}

/// Weighted truncated costs; stops when they exceed `enough`.
pub(super) fn sum_costs(lanes: &[Lanes], limit: f64, enough: f64, squared: impl Fn(&Lanes) -> f32x8) -> f64 {
    let (inverse, mut sum) = (f32x8::splat((limit * limit).recip() as f32), 0.0f64);
    let (one, share_of_level) = (f32x8::ONE, f32x8::splat(1.0 / LEVELS.len() as f32));
    for lanes in lanes {
        let share = squared(lanes) * inverse;
        let gain = LEVELS.iter().fold(f32x8::ZERO, |gain, level| gain + (one - share * *level).fast_max(f32x8::ZERO));
        sum += f64::from((lanes.weight * (one - gain * share_of_level)).reduce_add());
        if sum > enough {
            break;
        }
    }
    sum
}

fn sampson_squared(e: &[[f32x8; 3]; 3], lanes: &Lanes) -> f32x8 {
    let ([x, y], [u, v]) = (lanes.a, lanes.b);
    let line = |r: usize| e[r][0] * x + e[r][1] * y + e[r][2];
    let back = |c: usize| e[0][c] * u + e[1][c] * v + e[2][c];
    let (l0, l1, k0, k1) = (line(0), line(1), back(0), back(1));
    let product = u * l0 + v * l1 + line(2);
    product * product / (l0 * l0 + l1 * l1 + k0 * k0 + k1 * k1 + f32x8::splat(1e-20))
}

/// Signed Sampson residual of one match.
pub(crate) fn residual(essential: &Matrix3<f64>, m: &Match) -> f64 {
    let (a, b) = (Vector3::new(m.a[0], m.a[1], 1.0), Vector3::new(m.b[0], m.b[1], 1.0));
    let (line, back) = (essential * a, essential.tr_mul(&b));
    b.dot(&line) / (line.xy().norm_squared() + back.xy().norm_squared() + 1e-30).sqrt()
}

/// Rotation and direction of an essential matrix; any of the four that share it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Twisted {
    pub rotation: Matrix3<f64>,
    pub direction: Vector3<f64>,
}

impl Twisted {
    /// By cross products instead of a singular value decomposition (Horn 1990, "Recovering baseline and orientation from essential
    /// matrix"). `None` for matrices of rank one.
    pub fn of(essential: &Matrix3<f64>) -> Option<Self> {
        let columns = [0, 1, 2].map(|c| essential.column(c).into_owned());
        let crosses = [columns[0].cross(&columns[1]), columns[1].cross(&columns[2]), columns[2].cross(&columns[0])];
        let longest = crosses.iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
        let direction = longest.try_normalize(1e-12)?;
        // |E|² = 2|t|², which is to be 2.
        let e = essential * (std::f64::consts::SQRT_2 / essential.norm());
        let rows = |m: &Matrix3<f64>, r: usize| m.row(r).transpose();
        let cofactors = Matrix3::from_rows(&[0, 1, 2].map(|r| rows(&e, (r + 1) % 3).cross(&rows(&e, (r + 2) % 3)).transpose()));
        let rotation = cofactors - direction.cross_matrix() * e;
        rotation.iter().all(|v| v.is_finite()).then_some(Self { rotation: orthogonal(&rotation), direction })
    }

    pub fn essential(&self) -> Matrix3<f64> {
        self.direction.cross_matrix() * self.rotation
    }

    /// The other rotation of the same essential matrix: a half turn about the direction, behind this one.
    pub fn twin(&self) -> Matrix3<f64> {
        let half_turn = 2.0 * self.direction * self.direction.transpose() - Matrix3::identity();
        half_turn * self.rotation
    }

    /// One step of Gauss–Newton; its length. `None` where the matches do not determine it.
    pub fn step<'a>(&mut self, matches: impl Iterator<Item = &'a Match>, limit: f64) -> Option<f64> {
        let essential = self.essential();
        let (u, v) = tangent_basis(&self.direction);
        let turns = [Vector3::<f64>::x(), Vector3::y(), Vector3::z()]
            .map(|axis: Vector3<f64>| self.direction.cross_matrix() * (axis.cross_matrix() * self.rotation));
        let moves = [u, v].map(|way| way.cross_matrix() * self.rotation);
        let slopes: [[f64; 9]; 5] = [turns[0], turns[1], turns[2], moves[0], moves[1]].map(|m| std::array::from_fn(|k| m[(k / 3, k % 3)]));
        let (mut normal, mut gradient) = ([[0.0; 5]; 5], [0.0; 5]);
        for m in matches {
            let (a, b) = (Vector3::new(m.a[0], m.a[1], 1.0), Vector3::new(m.b[0], m.b[1], 1.0));
            let (line, back) = (essential * a, essential.tr_mul(&b));
            let length = (line.x * line.x + line.y * line.y + back.x * back.x + back.y * back.y).sqrt().max(1e-12);
            let r = b.dot(&line) / length;
            let share = r * r / (limit * limit);
            if !(share < 1.0) {
                continue;
            }
            let weight = m.weight * (1.0 - share) * (1.0 - share);
            let by_essential = by_essential(&a, &b, &line, &back, r / length, length);
            let row: [f64; 5] = std::array::from_fn(|k| (0..9).map(|i| slopes[k][i] * by_essential[i]).sum());
            for i in 0..5 {
                for j in i..5 {
                    normal[i][j] += weight * row[i] * row[j];
                }
                gradient[i] += weight * row[i] * r;
            }
        }
        let normal = SMatrix::<f64, 5, 5>::from_fn(|i, j| normal[i.min(j)][i.max(j)]);
        let damped = normal + SMatrix::identity() * (1e-7 * normal.trace().max(1e-30));
        let step = -damped.cholesky()?.solve(&SVector::<f64, 5>::from(gradient));
        let turn = Vector3::new(step[0], step[1], step[2]);
        self.rotation = nalgebra::Rotation3::from_scaled_axis(turn).into_inner() * self.rotation;
        self.direction = (self.direction + u * step[3] + v * step[4]).try_normalize(1e-12)?;
        step.norm().is_finite().then(|| step.norm())
    }
}

/// Derivative of the Sampson residual by the nine entries of E, row by row.
fn by_essential(a: &Vector3<f64>, b: &Vector3<f64>, line: &Vector3<f64>, back: &Vector3<f64>, ratio: f64, length: f64) -> [f64; 9] {
    // r = c / s with s² = |(E a)₁₂|² + |(Eᵀ b)₁₂|²; dr = (dc − r ds) / s.
    std::array::from_fn(|k| {
        let (row, column) = (k / 3, k % 3);
        let by_line = if row < 2 { line[row] * a[column] } else { 0.0 };
        let by_back = if column < 2 { back[column] * b[row] } else { 0.0 };
        (b[row] * a[column] - ratio * (by_line + by_back)) / length
    })
}

/// The rotation nearest to a matrix that nearly is one: two steps of Newton's iteration for the polar decomposition (Higham 1986).
fn orthogonal(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let step = |m: Matrix3<f64>| m.try_inverse().map_or(m, |inverse| 0.5 * (m + inverse.transpose()));
    step(step(step(*matrix)))
}

/// Whether a pair's point lies before both cameras of a motion.
pub(crate) fn is_ahead(rotation: &Matrix3<f64>, direction: &Vector3<f64>, pair: &RayPair) -> bool {
    let turned = rotation * pair.a;
    let across = turned.cross(&pair.b);
    // λb·b − λa·Ra = t: crossing with one ray leaves the other's distance.
    turned.cross(direction).dot(&across) > 0.0 && pair.b.cross(direction).dot(&across) > 0.0
}
