//! Do all shapes lie in one place? No building is a hundred kilometres wide, and no town.
//!
//! What every reader of shapes has read is looked at here, before anything is drawn or kept: one point astray, or numbers that are no
//! metres at all, and there is nothing to be seen of the rest.

use planwalk_types::{Building, Element, Plan, Pt2};

use super::PlanFileError;
use crate::text;

/// Widest site, metres.
const WIDEST_M: f64 = 1e5;

/// Refuses a building that is none.
pub(super) fn check(building: &Building) -> Result<(), PlanFileError> {
    let elements = || building.levels.iter().flat_map(|level| &level.elements);
    let points = || elements().flat_map(|element| element.form.points());
    let low = points().fold([f64::INFINITY; 2], |l, p| [l[0].min(p.x), l[1].min(p.y)]);
    let high = points().fold([f64::NEG_INFINITY; 2], |h, p| [h[0].max(p.x), h[1].max(p.y)]);
    let [width_m, height_m] = [0, 1].map(|k| high[k] - low[k]);
    if width_m <= WIDEST_M && height_m <= WIDEST_M {
        return Ok(());
    }
    let Some((element, at)) = farthest(elements()) else { return Ok(()) };
    let source = element.source.as_deref().map(|source| format!(" ({})", text::short(source)));
    let what = format!("{}{}", element.kind.word(), source.unwrap_or_default());
    Err(PlanFileError::Astray { width_km: width_m / 1e3, height_km: height_m / 1e3, what, x: at.x, y: at.y })
}

/// The point that is farthest from the middle of all (the median, which a few cannot move), and whose it is.
pub(super) fn farthest<'a>(elements: impl Iterator<Item = &'a Element> + Clone) -> Option<(&'a Element, Pt2<Plan>)> {
    let median = |of: fn(Pt2<Plan>) -> f64| {
        let mut values: Vec<f64> = elements.clone().flat_map(|element| element.form.points()).map(of).collect();
        let middle = values.len() / 2;
        values.get(middle)?;
        Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
    };
    let middle = Pt2::new(median(|p| p.x)?, median(|p| p.y)?);
    let points = elements.flat_map(|element| element.form.points().map(move |at| (element, at)));
    points.max_by(|a, b| a.1.distance(middle).total_cmp(&b.1.distance(middle)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{ElementKind, Form};

    fn wall(x: f64, y: f64) -> Element {
        Element {
            source: Some(format!("line {x:.0}")),
            ..Element::new(ElementKind::Wall, Form::Line(vec![Pt2::new(x, y), Pt2::new(x + 1.0, y)]))
        }
    }

    #[test]
    fn what_lies_a_hundred_kilometres_off_is_named() {
        // In UTM's metres, the walls are farther from the origin than what is astray.
        let mut walls: Vec<Element> = (0..20).map(|i| wall(566_600.0 + f64::from(i), 5_932_800.0)).collect();
        assert!(check(&Building::of_one_level(walls.clone())).is_ok());
        walls.push(wall(12.0, 5_932_800.0));
        let error = check(&Building::of_one_level(walls)).unwrap_err().to_string();
        assert!(error.contains("567 km × 0 km") && error.contains("wall (line 12), at") && error.contains("12, 5932800"), "{error}");
    }

    #[test]
    fn nothing_is_in_one_place() {
        assert!(check(&Building::of_one_level(Vec::new())).is_ok());
        assert!(check(&Building::of_one_level(vec![wall(f64::INFINITY, 0.0)])).is_err());
    }
}
