//! By how much is a picture laid askew? The turn at which its ink gathers in the fewest rows and columns (Postl 1986).
//!
//! ink ─▶ some of its places ─▶ for each angle, how unevenly rows and columns are filled ─▶ the best angle, if both say so
//!
//! Nothing is turned: places in a picture are given in its own pixels. What is found is told.

/// Turns that are looked at, degrees either way: nobody lays a sheet more askew.
const MOST_DEG: f64 = 10.0;
/// Turns that are smaller are nobody's concern: a wall of 10 m ends 9 cm aside.
const LEAST_DEG: f64 = 0.5;
/// Steps of the search, and of its refinement, degrees.
const STEPS_DEG: [f64; 2] = [0.5, 0.05];
/// Ink is gathered in strips this wide, as shares of the picture's longer side: thick enough for a scan's wavy lines.
const STRIPS: f64 = 1200.0;
/// Most places of ink that are looked at: a quarter of a second.
const MOST_PLACES: usize = 150_000;
/// Fewer say nothing.
const LEAST_PLACES: usize = 2_000;
/// Rows and columns agree on the turn to this, degrees; in a building with a slanted wing they do not.
const AGREE_DEG: f64 = 0.5;
/// At the turn found, strips are filled this much more unevenly than at none, for both.
const CLEARER: f64 = 1.2;

/// The turn of most strokes against the picture's sides, degrees, anticlockwise as the picture is seen; `None` where there is none to
/// speak of.
pub(in crate::plan) fn of(is_ink: &[bool], width: usize) -> Option<f64> {
    let ink = is_ink.iter().filter(|ink| **ink).count();
    if ink < LEAST_PLACES || 2 * ink > is_ink.len() {
        return None;
    }
    // Every so many-th place of ink, by a step without a common measure with the rows.
    let step = ink.div_ceil(MOST_PLACES);
    let side = width.max(is_ink.len() / width.max(1)) as f64;
    let places = is_ink.iter().enumerate().filter(|(_, ink)| **ink).map(|(place, _)| place).step_by(step);
    let places: Vec<[f64; 2]> = places.map(|i| [(i % width) as f64, (i / width) as f64].map(|x| x * STRIPS / side)).collect();
    let [rows, columns] = [0, 1].map(|axis| best(&places, axis));
    let is_clear = |(_, at, level): (f64, f64, f64)| at >= CLEARER * level;
    // y runs down, so that what is turned clockwise on paper has a positive slope.
    let deg = -0.5 * (rows.0 + columns.0);
    let is_turn = (LEAST_DEG..MOST_DEG).contains(&deg.abs()) && (rows.0 - columns.0).abs() <= AGREE_DEG;
    (is_turn && is_clear(rows) && is_clear(columns)).then_some(deg)
}

/// The best turn for rows (0) or columns (1), how unevenly their strips are filled there, and at no turn.
fn best(places: &[[f64; 2]], axis: usize) -> (f64, f64, f64) {
    let at = |deg: f64| unevenness(places, axis, deg);
    let level = at(0.0);
    let search = |centre: f64, reach: f64, step: f64| {
        let count = (reach / step).round() as i32;
        let tried = (-count..=count).map(|k| centre + step * f64::from(k)).map(|deg| (deg, at(deg)));
        // The first of equals.
        tried.fold((centre, f64::NEG_INFINITY), |best, one| if one.1 > best.1 { one } else { best })
    };
    let (rough, _) = search(0.0, MOST_DEG, STEPS_DEG[0]);
    let (deg, found) = search(rough, STEPS_DEG[0], STEPS_DEG[1]);
    (deg, found, level)
}

/// Sum of squares of what the strips hold, beyond an even spread.
fn unevenness(places: &[[f64; 2]], axis: usize, deg: f64) -> f64 {
    let (s, c) = libm::sincos(deg.to_radians());
    // Strips of a sheet that is turned about its corner lie within its diagonal of it, on either side.
    let count = 3 * STRIPS as usize;
    let mut strips = vec![0.0f64; count];
    for [x, y] in places {
        let across = if axis == 0 { c * y - s * x } else { c * x + s * y };
        if let Some(strip) = strips.get_mut((across + STRIPS) as usize) {
            *strip += 1.0;
        }
    }
    strips.iter().map(|n| n * n).sum::<f64>() - (places.len() as f64).powi(2) / STRIPS
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: usize = 700;

    /// Walls of rooms of 90 px × 120 px, 4 px thick, turned anticlockwise about the middle; `wing`: right half, turned by this besides.
    fn rooms(deg: f64, wing: f64) -> Vec<bool> {
        let middle = W as f64 / 2.0;
        let is = |i: usize| {
            let [x, y] = [(i % W) as f64 - middle, middle - (i / W) as f64];
            let (s, c) = (deg + if x > 0.0 { wing } else { 0.0 }).to_radians().sin_cos();
            let (x, y) = (c * x + s * y, c * y - s * x);
            x.abs() < 272.0 && y.abs() < 242.0 && (x.rem_euclid(90.0) < 4.0 || y.rem_euclid(120.0) < 4.0)
        };
        (0..W * W).map(is).collect()
    }

    #[test]
    fn a_sheet_that_lies_askew_is_told_with_its_angle() {
        for deg in [-9.0, -3.0, 1.5, 2.3, 6.0] {
            let found = of(&rooms(deg, 0.0), W).unwrap_or(f64::NAN);
            // A pixel in the 480 px of a wall is 0.12°.
            assert!((found - deg).abs() < 0.12, "{deg}°: {found}°");
        }
    }

    #[test]
    fn level_plans_slanted_wings_and_scribbles_are_not_askew() {
        assert_eq!(of(&rooms(0.0, 0.0), W), None);
        assert_eq!(of(&rooms(0.2, 0.0), W), None);
        assert_eq!(of(&rooms(0.0, 7.0), W), None);
        assert_eq!(of(&rooms(35.0, 0.0), W), None);
        let ring = |i: usize| (((i % W) as f64 - 350.0).hypot((i / W) as f64 - 350.0) - 200.0).abs() < 4.0;
        assert_eq!(of(&(0..W * W).map(ring).collect::<Vec<_>>(), W), None);
        assert_eq!(of(&[], 0), None);
        assert_eq!(of(&[true; 90_000], 300), None);
    }
}
