//! Where is a polynomial zero? All real roots by Sturm's theorem, then bisection and Newton.

/// A polynomial's coefficients, lowest power first.
type Poly = Vec<f64>;

fn value(p: &[f64], x: f64) -> f64 {
    p.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

fn derivative(p: &[f64]) -> Poly {
    p.iter().enumerate().skip(1).map(|(i, c)| i as f64 * c).collect()
}

/// Minus the remainder of a / b, scaled to largest coefficient 1 (signs are all that Sturm needs).
fn negative_remainder(a: &[f64], b: &[f64]) -> Poly {
    let mut r = a.to_vec();
    while r.len() >= b.len() {
        let factor = r[r.len() - 1] / b[b.len() - 1];
        let shift = r.len() - b.len();
        for (i, c) in b.iter().enumerate() {
            r[shift + i] -= factor * c;
        }
        r.pop();
    }
    r.iter_mut().for_each(|c| *c = -*c);
    scaled(r)
}

/// Largest coefficient ±1; leading coefficients that are round-off (1e-13 of it) are dropped.
fn scaled(mut p: Poly) -> Poly {
    let largest = p.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if !(largest > 0.0) || !largest.is_finite() {
        return Vec::new();
    }
    p.iter_mut().for_each(|c| *c /= largest);
    while p.last().is_some_and(|c| c.abs() < 1e-13) {
        p.pop();
    }
    p
}

fn sign_changes(chain: &[Poly], x: f64) -> usize {
    let mut last = 0.0f64;
    let mut changes = 0;
    for v in chain.iter().map(|p| value(p, x)).filter(|v| *v != 0.0) {
        if last * v < 0.0 {
            changes += 1;
        }
        last = v;
    }
    changes
}

/// The distinct real roots, ascending. Coefficients: lowest power first.
pub fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let p = scaled(coefficients.to_vec());
    if p.len() < 2 {
        return Vec::new();
    }
    let mut chain = vec![p.clone(), scaled(derivative(&p))];
    while chain[chain.len() - 1].len() > 1 {
        let next = negative_remainder(&chain[chain.len() - 2], &chain[chain.len() - 1]);
        if next.is_empty() {
            break;
        }
        chain.push(next);
    }
    // Cauchy's bound on the roots' size.
    let lead = p[p.len() - 1].abs();
    let bound = 1.0 + p[..p.len() - 1].iter().fold(0.0f64, |m, c| m.max(c.abs())) / lead;
    let mut roots = Vec::new();
    let mut open = vec![(-bound, bound, sign_changes(&chain, -bound), sign_changes(&chain, bound))];
    while let Some((low, high, at_low, at_high)) = open.pop() {
        match at_low.saturating_sub(at_high) {
            0 => {}
            1 => roots.push(polish(&p, low, high)),
            _ => {
                let middle = 0.5 * (low + high);
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

/// The root in (low, high]: bisection while Newton would leave the bracket.
fn polish(p: &[f64], mut low: f64, mut high: f64) -> f64 {
    let slope = derivative(p);
    let rising = value(p, high) >= value(p, low);
    let mut x = 0.5 * (low + high);
    for _ in 0..80 {
        let v = value(p, x);
        if (v > 0.0) == rising {
            high = x;
        } else {
            low = x;
        }
        let newton = x - v / value(&slope, x);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-15 * (1.0 + x.abs()) {
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

    fn with_roots(roots: &[f64]) -> Poly {
        roots.iter().fold(vec![1.0], |p, r| {
            let mut next = vec![0.0; p.len() + 1];
            for (i, c) in p.iter().enumerate() {
                next[i + 1] += c;
                next[i] -= r * c;
            }
            next
        })
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
            let found = real_roots(&q);
            prop_assert_eq!(found.len(), roots.len());
            // Wilkinson: roots 0.2 apart in degree 9 lose some 8 of 16 digits.
            prop_assert!(found.iter().zip(&roots).all(|(f, r)| (f - r).abs() < 1e-6), "{:?} for {:?}", found, roots);
        }
    }

    #[test]
    fn polynomials_without_roots_have_none() {
        assert!(real_roots(&[1.0, 0.0, 1.0]).is_empty());
        assert!(real_roots(&[3.0]).is_empty());
        assert!(real_roots(&[0.0, 0.0]).is_empty());
        assert!(real_roots(&[f64::NAN, 1.0]).is_empty());
    }
}
