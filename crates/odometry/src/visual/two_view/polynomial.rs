//! Where is a polynomial zero? All real roots by Sturm's theorem, then bisection and Newton.

/// Highest degree.
pub const DEGREE: usize = 10;

/// A polynomial, lowest power first.
#[derive(Debug, Clone, Copy)]
struct Poly {
    coefficients: [f64; DEGREE + 1],
    /// Coefficients that count: the degree and one.
    len: usize,
}

impl Poly {
    /// Largest coefficient ±1; leading coefficients that are round-off (1e-13 of it) are dropped. `None` for zero.
    fn scaled(coefficients: [f64; DEGREE + 1], len: usize) -> Option<Self> {
        let largest = coefficients[..len].iter().fold(0.0f64, |m, c| m.max(c.abs()));
        if !(largest > 0.0 && largest.is_finite()) || coefficients.iter().any(|c| c.is_nan()) {
            return None;
        }
        let coefficients = coefficients.map(|c| c / largest);
        let len = coefficients[..len].iter().rposition(|c| c.abs() >= 1e-13)? + 1;
        Some(Self { coefficients, len })
    }

    fn of(&self) -> &[f64] {
        &self.coefficients[..self.len]
    }

    fn at(&self, x: f64) -> f64 {
        self.of().iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    /// Value and slope by Horner's scheme.
    fn with_slope(&self, x: f64) -> (f64, f64) {
        self.of().iter().rev().fold((0.0, 0.0), |(value, slope), c| (value * x + c, slope * x + value))
    }

    fn derivative(&self) -> Option<Self> {
        let coefficients = std::array::from_fn(|i| if i < DEGREE { (i + 1) as f64 * self.coefficients[i + 1] } else { 0.0 });
        Self::scaled(coefficients, self.len - 1)
    }

    /// Minus the remainder of a division; its scale does not matter to Sturm.
    fn negative_remainder(&self, by: &Self) -> Option<Self> {
        let (mut rest, mut len) = (self.coefficients, self.len);
        while len >= by.len {
            let (factor, shift) = (rest[len - 1] / by.coefficients[by.len - 1], len - by.len);
            for (i, c) in by.of().iter().enumerate() {
                rest[shift + i] -= factor * c;
            }
            len -= 1;
        }
        rest[len..].fill(0.0);
        Self::scaled(rest.map(|c| -c), len)
    }
}

fn sign_changes(chain: &[Poly], x: f64) -> usize {
    let (mut last, mut changes) = (0.0f64, 0);
    for v in chain.iter().map(|p| p.at(x)).filter(|v| *v != 0.0) {
        changes += usize::from(last * v < 0.0);
        last = v;
    }
    changes
}

/// Sturm's chain: the polynomial, its derivative, and the negated remainders.
fn chain(p: Poly) -> Vec<Poly> {
    let mut chain = Vec::with_capacity(DEGREE + 2);
    chain.push(p);
    chain.extend(p.derivative());
    while let [.., before, last] = chain[..] {
        match before.negative_remainder(&last).filter(|_| last.len > 1) {
            Some(next) => chain.push(next),
            None => break,
        }
    }
    chain
}

/// The distinct real roots, ascending. Coefficients: lowest power first.
pub fn real_roots(coefficients: &[f64; DEGREE + 1]) -> Vec<f64> {
    let mut roots = Vec::with_capacity(DEGREE);
    let Some(p) = Poly::scaled(*coefficients, DEGREE + 1).filter(|p| p.len > 1) else { return roots };
    let chain = chain(p);
    // Cauchy's bound on the roots' size.
    let lead = p.coefficients[p.len - 1].abs();
    let bound = 1.0 + p.of()[..p.len - 1].iter().fold(0.0f64, |m, c| m.max(c.abs())) / lead;
    let mut open = Vec::with_capacity(DEGREE);
    // Most roots are small: zero first, so that bisection begins near them.
    let (low, middle, high) = (sign_changes(&chain, -bound), sign_changes(&chain, 0.0), sign_changes(&chain, bound));
    open.extend([(0.0, bound, middle, high), (-bound, 0.0, low, middle)]);
    while let Some((low, high, at_low, at_high)) = open.pop() {
        match at_low.saturating_sub(at_high) {
            0 => {}
            1 => roots.push(polish(&p, low, high)),
            _ => {
                let middle = split(low, high);
                if high - low < 1e-10 * bound.min(1e3) {
                    roots.push(middle);
                    continue;
                }
                let at_middle = sign_changes(&chain, middle);
                open.push((middle, high, at_middle, at_high));
                open.push((low, middle, at_low, at_middle));
            }
        }
    }
    roots.sort_by(f64::total_cmp);
    roots
}

/// Where an interval is cut: in the middle, or, while it is wide and ends at zero, nearer to that.
fn split(low: f64, high: f64) -> f64 {
    match (low, high) {
        (0.0, high) if high > 4.0 => high.sqrt(),
        (low, 0.0) if low < -4.0 => -(-low).sqrt(),
        (low, high) => 0.5 * (low + high),
    }
}

/// The root in (low, high]: bisection while Newton would leave the bracket.
fn polish(p: &Poly, mut low: f64, mut high: f64) -> f64 {
    let rising = p.at(high) >= p.at(low);
    let mut x = split(low, high);
    for _ in 0..80 {
        let (v, slope) = p.with_slope(x);
        if (v > 0.0) == rising {
            high = x;
        } else {
            low = x;
        }
        let newton = x - v / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-14 * (1.0 + x.abs()) {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn with_roots(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |p, r| {
            let mut next = vec![0.0; p.len() + 1];
            for (i, c) in p.iter().enumerate() {
                next[i + 1] += c;
                next[i] -= r * c;
            }
            next
        })
    }

    fn padded(p: &[f64]) -> [f64; DEGREE + 1] {
        std::array::from_fn(|i| p.get(i).copied().unwrap_or(0.0))
    }

    proptest! {
        #[test]
        fn separate_roots_are_all_found(gaps in prop::collection::vec(0.2..1.0f64, 1..7), first in -3.0..0.0f64) {
            let roots: Vec<f64> = gaps.iter().scan(first, |x, g| { *x += g; Some(*x) }).collect();
            // x² + 1 has no real roots and must not add any.
            let p = with_roots(&roots);
            let mut q = vec![0.0; p.len() + 2];
            for (i, c) in p.iter().enumerate() {
                q[i] += c;
                q[i + 2] += c;
            }
            let found = real_roots(&padded(&q));
            prop_assert_eq!(found.len(), roots.len());
            // Wilkinson: roots 0.2 apart in degree 9 lose some 8 of 16 digits.
            prop_assert!(found.iter().zip(&roots).all(|(f, r)| (f - r).abs() < 1e-6), "{:?} for {:?}", found, roots);
        }
    }

    #[test]
    fn polynomials_without_roots_have_none() {
        for p in [&[1.0, 0.0, 1.0][..], &[3.0], &[0.0, 0.0], &[f64::NAN, 1.0], &[f64::INFINITY, 1.0]] {
            assert!(real_roots(&padded(p)).is_empty(), "{p:?}");
        }
    }
}
