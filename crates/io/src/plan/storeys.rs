//! Which storey is this on? Elements sorted by what their file calls the storey.

use std::collections::BTreeMap;

use planwalk_types::{Building, Element, Level};

use super::PlanFileError;

/// Names told in a note.
const NAMES_TOLD: usize = 8;

/// What a file says of one of its storeys.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Storey {
    /// What people call it; the key that elements use, where nothing is said.
    pub name: Option<String>,
    /// Order from below, 0 is the ground floor.
    pub ordinal: Option<i32>,
}

/// Sorts elements by storey. Those that say none are on all of them: outlines of the building, as a rule.
///
/// A storey that the file says nothing more of has the number that its key is, if it is one; else it follows the others in the
/// order of the keys.
pub(super) fn sort(elements: Vec<(Option<String>, Element)>, said: &BTreeMap<String, Storey>) -> Vec<Level> {
    let mut by_key: BTreeMap<String, Vec<Element>> = BTreeMap::new();
    let mut everywhere = Vec::new();
    for (key, element) in elements {
        match key {
            Some(key) => by_key.entry(key).or_default().push(element),
            None => everywhere.push(element),
        }
    }
    if by_key.is_empty() {
        return Building::of_one_level(everywhere).levels;
    }
    let number = |key: &str| said.get(key).and_then(|s| s.ordinal.map(f64::from)).or_else(|| key.trim().parse().ok());
    let mut keys: Vec<(f64, String)> =
        by_key.keys().map(|key| (number(key).filter(|n| n.is_finite()).unwrap_or(f64::MAX), key.clone())).collect();
    keys.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    let ground = keys.iter().position(|(number, _)| *number >= 0.0).unwrap_or(0) as i32;
    let whole = keys.iter().all(|(number, _)| *number == number.trunc() && number.abs() < 1e6);
    let level = |(at, (number, key)): (usize, (f64, String))| {
        let ordinal = if whole { number as i32 } else { at as i32 - ground };
        let elements = by_key.remove(&key).unwrap_or_default().into_iter().chain(everywhere.iter().cloned()).collect();
        Level { ordinal, name: said.get(&key).and_then(|s| s.name.clone()).unwrap_or(key), elements }
    };
    keys.into_iter().enumerate().map(level).collect()
}

/// The storey that is asked for by name or ordinal; without a wish the ground floor, or the lowest above it, or the highest.
///
/// # Errors
/// [`PlanFileError::NoSuchLevel`] with those that there are.
pub(super) fn choose<'a>(building: &'a Building, wish: Option<&str>, notes: &mut Vec<String>) -> Result<&'a Level, PlanFileError> {
    let levels = &building.levels;
    let names = || {
        let names: Vec<&str> = levels.iter().take(NAMES_TOLD).map(|level| level.name.as_str()).collect();
        let more = if levels.len() > NAMES_TOLD { format!(" and {} more", levels.len() - NAMES_TOLD) } else { String::new() };
        format!("{}{more}", names.join(", "))
    };
    let found = match wish {
        Some(wish) => levels
            .iter()
            .find(|level| level.name.eq_ignore_ascii_case(wish.trim()))
            .or_else(|| levels.iter().find(|level| wish.trim().parse() == Ok(level.ordinal))),
        None => levels.iter().find(|level| level.ordinal >= 0).or(levels.last()),
    };
    let level = found.ok_or_else(|| PlanFileError::NoSuchLevel { wish: wish.unwrap_or("").to_owned(), levels: names() })?;
    if wish.is_none() && levels.len() > 1 {
        notes.push(format!("{} storeys ({}): {} is taken; --level NAME takes another", levels.len(), names(), level.name));
    }
    Ok(level)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{ElementKind, Form, Pt2};

    fn at(x: f64) -> Element {
        Element::new(ElementKind::Wall, Form::Spot(Pt2::new(x, 0.0)))
    }

    fn of(keys: &[Option<&str>], said: &[(&str, &str, i32)]) -> Vec<(i32, String, usize)> {
        let elements = keys.iter().map(|key| (key.map(str::to_owned), at(0.0))).collect();
        let storey = |name: &str, ordinal| Storey { name: Some(name.to_owned()), ordinal: Some(ordinal) };
        let said = said.iter().map(|(key, name, ordinal)| ((*key).to_owned(), storey(name, *ordinal))).collect();
        sort(elements, &said).into_iter().map(|level| (level.ordinal, level.name, level.elements.len())).collect()
    }

    fn levels(expected: &[(i32, &str, usize)]) -> Vec<(i32, String, usize)> {
        expected.iter().map(|(ordinal, name, count)| (*ordinal, (*name).to_owned(), *count)).collect()
    }

    #[test]
    fn storeys_are_ordered_by_number_and_what_says_none_is_on_all() {
        assert_eq!(of(&[None, None], &[]), levels(&[(0, "0", 2)]));
        assert_eq!(of(&[Some("10"), Some("2"), None, Some("-1")], &[]), levels(&[(-1, "-1", 2), (2, "2", 2), (10, "10", 2)]));
        // A mezzanine has no whole number: the order is kept.
        assert_eq!(
            of(&[Some("0.5"), Some("1"), Some("0"), Some("-1")], &[]),
            levels(&[(-1, "-1", 1), (0, "0", 1), (1, "0.5", 1), (2, "1", 1)])
        );
        assert_eq!(of(&[Some("b"), Some("a")], &[]), levels(&[(0, "a", 1), (1, "b", 1)]));
        assert_eq!(of(&[Some("k1"), Some("k0")], &[("k1", "Upper", 1), ("k0", "Ground", 0)]), levels(&[(0, "Ground", 1), (1, "Upper", 1)]));
    }

    #[test]
    fn one_asks_by_name_or_number_and_gets_the_ground_floor_else() {
        let level = |ordinal: i32, name: &str| Level { ordinal, name: name.to_owned(), elements: Vec::new() };
        let building = Building { levels: vec![level(-1, "Cellar"), level(0, "EG"), level(1, "OG")], georeference: None };
        let mut notes = Vec::new();
        assert_eq!(choose(&building, None, &mut notes).unwrap().name, "EG");
        assert!(notes[0].contains("3 storeys (Cellar, EG, OG): EG is taken"), "{notes:?}");
        assert_eq!(choose(&building, Some("og"), &mut notes).unwrap().ordinal, 1);
        assert_eq!(choose(&building, Some("-1"), &mut notes).unwrap().name, "Cellar");
        let error = choose(&building, Some("7"), &mut notes).unwrap_err().to_string();
        assert!(error.contains("\"7\"") && error.contains("Cellar, EG, OG"), "{error}");
    }
}
