//! What are sine, cosine and exponential of a whole cloud, the same bits on every machine?
//!
//! Polynomials in f32 without branches, tables or calls, so that loops over them become SIMD. Only additions, multiplications
//! and bit operations in a fixed order, which IEEE 754 defines to the last bit: nothing here may be contracted to fused ones.
//! Coefficients: minimax on the reduced range (Remez exchange), rounded to f32.

/// Adding it and taking it away rounds to the nearest integer (ties to even); holds for |v| < 2²². Its low bits are that integer.
pub(crate) const ROUND: f32 = 12_582_912.0;

/// π/2 in three parts, of which the first two have so few bits that their small multiples are exact (Cody & Waite 1980).
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
/// 2π in two parts, likewise.
const TURN: [f32; 2] = [6.281_25, 1.935_307_2e-3];
/// ln 2 in two parts, likewise.
const LN_2: [f32; 2] = [0.693_115_23, 3.194_618_4e-5];

/// Sine and cosine, to 1.2e-7 up to a few turns; beyond 10⁴ rad the angle itself is no longer resolved.
#[inline(always)]
pub(crate) fn sin_cos(angle_rad: f32) -> (f32, f32) {
    let quarters = angle_rad * std::f32::consts::FRAC_2_PI + ROUND;
    let which = quarters.to_bits();
    let whole = quarters - ROUND;
    let r = ((angle_rad - whole * QUARTER[0]) - whole * QUARTER[1]) - whole * QUARTER[2];
    let z = r * r;
    let sine = r + r * z * (-0.166_666_51 + z * (8.331_976e-3 + z * -1.949_529_3e-4));
    let cosine = (1.0 - 0.5 * z) + z * z * (0.041_666_646 + z * (-1.388_736_5e-3 + z * 2.443_809e-5));
    let swapped = 0u32.wrapping_sub(which & 1);
    let (s, c) = (sine.to_bits(), cosine.to_bits());
    let (s, c) = ((c & swapped) | (s & !swapped), (s & swapped) | (c & !swapped));
    let (sign_s, sign_c) = ((which & 2) << 30, (which.wrapping_add(1) & 2) << 30);
    (f32::from_bits(s ^ sign_s), f32::from_bits(c ^ sign_c))
}

/// e to this power, to 1.5e-7 of itself; below −87 (and for what is not a number) 0, above 88 as at 88.
#[inline(always)]
pub(crate) fn exp(power: f32) -> f32 {
    let at_least = if power > -87.0 { power } else { -87.0 };
    let held = if at_least < 88.0 { at_least } else { 88.0 };
    let doublings = held * std::f32::consts::LOG2_E + ROUND;
    let whole = doublings - ROUND;
    let r = (held - whole * LN_2[0]) - whole * LN_2[1];
    let tail = 0.499_999_93 + r * (0.166_665_2 + r * (0.041_668_39 + r * (8.368_745e-3 + r * 1.381_454e-3)));
    let value = 1.0 + (r + r * r * tail);
    // ROUND's own low bits are zero, and its high ones are shifted out.
    let power_of_two = f32::from_bits(doublings.to_bits().wrapping_add(127) << 23);
    let some = if power > -87.0 { u32::MAX } else { 0 };
    f32::from_bits((value * power_of_two).to_bits() & some)
}

/// The angle less whole turns, in [−π, π] up to round-off.
#[inline(always)]
pub(crate) fn wrap(angle_rad: f32) -> f32 {
    let whole = (angle_rad * (1.0 / std::f32::consts::TAU) + ROUND) - ROUND;
    (angle_rad - whole * TURN[0]) - whole * TURN[1]
}

/// The integer at or below, for |v| < 2²²; anything for larger ones. A cast, which must saturate, would not become SIMD.
#[inline(always)]
pub(crate) fn floor(value: f32) -> i32 {
    let nearest = value + ROUND;
    let above = i32::from(nearest - ROUND > value);
    (nearest.to_bits().wrapping_sub(ROUND.to_bits()) as i32).wrapping_sub(above)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spaced values, and not on round numbers.
    fn span(from: f64, to: f64) -> impl Iterator<Item = f32> {
        (0..200_001).map(move |i| (from + (to - from) * f64::from(i) / 200_000.3) as f32)
    }

    #[test]
    fn sines_agree_with_double_precision() {
        for angle in span(-20.0, 20.0) {
            let (s, c) = sin_cos(angle);
            let (exact_s, exact_c) = libm::sincos(f64::from(angle));
            let worst = (f64::from(s) - exact_s).abs().max((f64::from(c) - exact_c).abs());
            // Two roundings of a number near 1, and the polynomial's 2e-9.
            assert!(worst < 1.3e-7, "{angle} rad: {s}, {c} are off by {worst:e}");
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        assert!(sin_cos(f32::NAN).0.is_nan() || !sin_cos(f32::INFINITY).0.is_finite());
    }

    #[test]
    fn exponentials_agree_with_double_precision() {
        for power in span(-86.9, 87.9) {
            let exact = libm::exp(f64::from(power));
            let off = (f64::from(exp(power)) / exact - 1.0).abs();
            // Two roundings, and the polynomial's 3e-9.
            assert!(off < 1.6e-7, "exp({power}) is off by {off:e}");
        }
        assert_eq!(exp(0.0), 1.0);
        assert_eq!([exp(f32::NEG_INFINITY), exp(-1e9), exp(f32::NAN)], [0.0; 3]);
        assert!(exp(f32::INFINITY).is_finite() && exp(1e9) > 1e38);
    }

    #[test]
    fn integers_below_are_those_of_the_library() {
        for value in span(-3000.0, 4e6).chain(span(-5.0, 5.0)).chain((-9..9).map(|i| i as f32)) {
            assert_eq!(floor(value), libm::floorf(value) as i32, "{value}");
        }
    }

    #[test]
    fn wrapped_angles_point_the_same_way() {
        for angle in span(-60.0, 60.0) {
            let wrapped = f64::from(wrap(angle));
            let off = planwalk_types::wrap_angle(wrapped - f64::from(angle)).abs();
            // An f32 near π is good to 2.4e-7.
            assert!(off < 5e-7 && wrapped.abs() < std::f64::consts::PI + 1e-6, "{angle} became {wrapped}");
        }
    }
}
