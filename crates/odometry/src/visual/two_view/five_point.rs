//! Which essential matrices fit five pairs exactly? Nistér 2004 (TPAMI 26(6)), with a tenth-degree polynomial.
//!
//! pairs ─▶ null space E = xX + yY + zZ + W ─▶ ten cubics ─▶ elimination ─▶ 3×3 of polynomials in z ─▶ real roots ─▶ E

use nalgebra::{Matrix3, Vector3};

use super::matches::Match;
use super::polynomial::{self, DEGREE};

/// Adds up to ten essential matrices, of norm √2, that fit the first five of these matches.
pub(crate) fn solve_into(sample: &[Match], found: &mut Vec<Matrix3<f64>>) {
    let Some(basis) = null_space(sample) else { return };
    let Some(reduced) = eliminate(&constraints(&basis)) else { return };
    // Rows of the reduced system (Nistér's e..j): leading monomials x²z, x², y²z, y², xyz, xy.
    let k = subtract_shifted(&reduced[4], &reduced[5]);
    let l = subtract_shifted(&reduced[6], &reduced[7]);
    let m = subtract_shifted(&reduced[8], &reduced[9]);
    let roots = polynomial::real_roots(&determinant(&k, &l, &m));
    found.extend(roots.iter().filter_map(|z| essential_at(&basis, [&k, &l, &m], *z)));
}

/// The four 3×3 matrices that span the solutions of b·E·a = 0: what Householder's reflections of the five rows leave.
fn null_space(sample: &[Match]) -> Option<[Matrix3<f64>; 4]> {
    let mut rows = [[0.0; 9]; 5];
    for (row, m) in rows.iter_mut().zip(sample.get(..5)?) {
        let (a, b) = ([m.a[0], m.a[1], 1.0], [m.b[0], m.b[1], 1.0]);
        *row = std::array::from_fn(|i| b[i / 3] * a[i % 3]);
        let norm = row.iter().map(|v| v * v).sum::<f64>().sqrt();
        row.iter_mut().for_each(|v| *v /= norm);
    }
    let mut mirrors = [[0.0; 9]; 5];
    for k in 0..5 {
        let length = rows[k][k..].iter().map(|v| v * v).sum::<f64>().sqrt();
        // A row that depends on those before.
        if !(length > 1e-9) {
            return None;
        }
        let mut mirror = [0.0; 9];
        mirror[k..].copy_from_slice(&rows[k][k..]);
        mirror[k] += length.copysign(mirror[k]);
        let norm = mirror.iter().map(|v| v * v).sum::<f64>().sqrt();
        mirror.iter_mut().for_each(|v| *v /= norm);
        rows[k + 1..].iter_mut().for_each(|row| reflect(row, &mirror));
        mirrors[k] = mirror;
    }
    Some([5, 6, 7, 8].map(|axis| {
        let mut column = [0.0; 9];
        column[axis] = 1.0;
        mirrors.iter().rev().for_each(|mirror| reflect(&mut column, mirror));
        Matrix3::from_fn(|r, c| column[3 * r + c])
    }))
}

fn reflect(v: &mut [f64; 9], mirror: &[f64; 9]) {
    let along: f64 = v.iter().zip(mirror).map(|(v, m)| v * m).sum();
    v.iter_mut().zip(mirror).for_each(|(v, m)| *v -= 2.0 * along * m);
}

/// Linear in (x, y, z, 1).
type Linear = [f64; 4];
/// Quadratic: xx xy xz x yy yz y zz z 1.
type Quadratic = [f64; 10];
/// Cubic, in Nistér's order: x³ y³ x²y xy² x²z x² y²z y² xyz xy | xz² xz x yz² yz y z³ z² z 1.
type Cubic = [f64; 20];

/// Index of the product of two of (x, y, z, 1) in [`Quadratic`].
const QUADRATIC: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]];
/// Index of the product of a monomial of [`Quadratic`] with one of (x, y, z, 1) in [`Cubic`].
const CUBIC: [[usize; 4]; 10] = [
    [0, 2, 4, 5],     // xx
    [2, 3, 8, 9],     // xy
    [4, 8, 10, 11],   // xz
    [5, 9, 11, 12],   // x
    [3, 1, 6, 7],     // yy
    [8, 6, 13, 14],   // yz
    [9, 7, 14, 15],   // y
    [10, 13, 16, 17], // zz
    [11, 14, 17, 18], // z
    [12, 15, 18, 19], // 1
];

fn times(a: &Linear, b: &Linear) -> Quadratic {
    let mut product = [0.0; 10];
    for (i, p) in a.iter().enumerate() {
        for (j, q) in b.iter().enumerate() {
            product[QUADRATIC[i][j]] += p * q;
        }
    }
    product
}

fn add_times(sum: &mut Cubic, a: &Quadratic, b: &Linear, sign: f64) {
    for (i, p) in a.iter().enumerate() {
        for (j, q) in b.iter().enumerate() {
            sum[CUBIC[i][j]] += sign * p * q;
        }
    }
}

fn plus(a: &Quadratic, b: &Quadratic, sign: f64) -> Quadratic {
    std::array::from_fn(|i| a[i] + sign * b[i])
}

/// The ten cubics: E Eᵀ E − ½ tr(E Eᵀ) E = 0 and det E = 0 (Nistér 2004, eqs. 5, 6).
fn constraints(basis: &[Matrix3<f64>; 4]) -> [Cubic; 10] {
    let e = |r: usize, c: usize| -> Linear { std::array::from_fn(|i| basis[i][(r, c)]) };
    let mut square = [[[0.0; 10]; 3]; 3];
    for (r, row) in square.iter_mut().enumerate() {
        for (c, cell) in row.iter_mut().enumerate() {
            *cell = (0..3).fold([0.0; 10], |sum, k| plus(&sum, &times(&e(r, k), &e(c, k)), 1.0));
        }
    }
    let trace = plus(&plus(&square[0][0], &square[1][1], 1.0), &square[2][2], 1.0);
    for (r, row) in square.iter_mut().enumerate() {
        row[r] = plus(&row[r], &trace, -0.5);
    }
    let mut all = [[0.0; 20]; 10];
    for r in 0..3 {
        for c in 0..3 {
            for (k, term) in square[r].iter().enumerate() {
                add_times(&mut all[3 * r + c], term, &e(k, c), 1.0);
            }
        }
    }
    for c in 0..3 {
        let (i, j) = ((c + 1) % 3, (c + 2) % 3);
        let minor = plus(&times(&e(1, i), &e(2, j)), &times(&e(1, j), &e(2, i)), -1.0);
        add_times(&mut all[9], &minor, &e(0, c), 1.0);
    }
    all
}

/// Gauss–Jordan with row pivoting on the first ten columns; `None` when the system is singular.
fn eliminate(system: &[Cubic; 10]) -> Option<[Cubic; 10]> {
    let mut m = *system;
    for column in 0..10 {
        let pivot = (column..10).max_by(|a, b| m[*a][column].abs().total_cmp(&m[*b][column].abs()))?;
        m.swap(column, pivot);
        let scale = m[column][column];
        if !(scale.abs() > 1e-14) {
            return None;
        }
        m[column].iter_mut().for_each(|v| *v /= scale);
        let lead = m[column];
        for (row, other) in m.iter_mut().enumerate() {
            if row != column {
                let factor = other[column];
                for (o, l) in other.iter_mut().zip(&lead) {
                    *o -= factor * l;
                }
            }
        }
    }
    Some(m)
}

/// Polynomials in z that multiply x, y and 1, lowest power first.
struct Row {
    x: [f64; 4],
    y: [f64; 4],
    one: [f64; 5],
}

/// ⟨first⟩ − z ⟨second⟩: the leading monomials cancel (Nistér 2004, eqs. 10–12).
fn subtract_shifted(first: &Cubic, second: &Cubic) -> Row {
    let three = |at: usize| -> [f64; 4] {
        let (f, s) = (|i: usize| first[at + i], |i: usize| second[at + i]);
        [f(2), f(1) - s(2), f(0) - s(1), -s(0)]
    };
    let (f, s) = (|i: usize| first[16 + i], |i: usize| second[16 + i]);
    Row { x: three(10), y: three(13), one: [f(3), f(2) - s(3), f(1) - s(2), f(0) - s(1), -s(0)] }
}

fn convolve<const A: usize, const B: usize, const C: usize>(a: &[f64; A], b: &[f64; B]) -> [f64; C] {
    let mut product = [0.0; C];
    for (i, p) in a.iter().enumerate() {
        for (j, q) in b.iter().enumerate() {
            product[i + j] += p * q;
        }
    }
    product
}

/// det of the 3×3 of polynomials, degree ten.
fn determinant(k: &Row, l: &Row, m: &Row) -> [f64; DEGREE + 1] {
    let minor = |a: &Row, b: &Row| -> [f64; 7] {
        let (p, q): ([f64; 7], [f64; 7]) = (convolve(&a.x, &b.y), convolve(&a.y, &b.x));
        std::array::from_fn(|i| p[i] - q[i])
    };
    let parts: [[f64; DEGREE + 1]; 3] = [convolve(&minor(k, l), &m.one), convolve(&minor(l, m), &k.one), convolve(&minor(m, k), &l.one)];
    std::array::from_fn(|i| parts[0][i] + parts[1][i] + parts[2][i])
}

/// E at a root z: (x, y, 1) spans the null space of the 3×3 there.
fn essential_at(basis: &[Matrix3<f64>; 4], rows: [&Row; 3], z: f64) -> Option<Matrix3<f64>> {
    let at = |p: &[f64]| p.iter().rev().fold(0.0, |sum, c| sum * z + c);
    let lines = rows.map(|r| Vector3::new(at(&r.x), at(&r.y), at(&r.one)));
    // The best conditioned of the three cross products.
    let crosses = [lines[0].cross(&lines[1]), lines[1].cross(&lines[2]), lines[2].cross(&lines[0])];
    let null = crosses.iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    let (x, y) = (null.x / null.z, null.y / null.z);
    let essential = basis[0] * x + basis[1] * y + basis[2] * z + basis[3];
    let norm = essential.norm();
    // Scaled to |E|² = 2, the norm of [t]× R with |t| = 1.
    (norm.is_finite() && norm > 0.0).then(|| essential * (std::f64::consts::SQRT_2 / norm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::{RayPair, epipolar, scene};

    fn solve(pairs: &[RayPair]) -> Vec<Matrix3<f64>> {
        let point = |ray: &Vector3<f64>| [ray.x / ray.z, ray.y / ray.z];
        let sample: Vec<Match> = pairs.iter().map(|p| Match { a: point(&p.a), b: point(&p.b), weight: 1.0, pair: 0 }).collect();
        let mut found = Vec::new();
        solve_into(&sample, &mut found);
        found
    }

    #[test]
    fn the_truth_is_among_the_answers_of_five_exact_pairs() {
        let mut worst = 0.0f64;
        for seed in 0..300 {
            let (pairs, truth) = scene::pairs(seed, 5, 0.7, 0.0, 0.0);
            let expected = epipolar::essential_of(&truth);
            let miss = |e: &Matrix3<f64>| (e - expected).norm().min((e + expected).norm());
            let best = solve(&pairs).iter().map(miss).fold(f64::INFINITY, f64::min);
            worst = worst.max(best);
            // Nistér 2004, fig. 4: errors above 1e-4 are one in some thousands.
            assert!(best < 1e-3, "seed {seed}: the nearest answer is {best:e} off");
        }
        assert!(worst > 0.0);
    }

    #[test]
    fn answers_are_essential_and_fit_the_sample() {
        for seed in 300..330 {
            let (pairs, _) = scene::pairs(seed, 5, 0.7, 0.0, 0.0);
            for e in solve(&pairs) {
                let cubic = 2.0 * e * e.transpose() * e - (e * e.transpose()).trace() * e;
                assert!(cubic.norm() < 1e-3 && pairs.iter().all(|p| epipolar::epipolar_angle(&e, p) < 1e-6), "seed {seed}: {cubic}");
            }
        }
    }

    #[test]
    fn four_pairs_or_one_pair_five_times_give_nothing() {
        let (pairs, _) = scene::pairs(1, 5, 0.7, 0.0, 0.0);
        assert!(solve(&pairs[..4]).is_empty());
        assert!(solve(&[pairs[0]; 5]).is_empty());
    }
}
