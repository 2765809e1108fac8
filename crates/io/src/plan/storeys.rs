//! Which storey is this on? Elements sorted by what their file calls the storey.

use std::collections::{BTreeMap, BTreeSet};

use planwalk_types::{Building, Element, ElementKind, Level};

use super::PlanFileError;

/// Names told in a note.
const NAMES_TOLD: usize = 8;

/// No building's storeys are numbered beyond this.
const FARTHEST_ORDINAL: f64 = 1e6;

/// What a file says of one of its storeys.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Storey {
    /// What people call it; the key that elements use, where nothing is said.
    pub name: Option<String>,
    /// Order from below, 0 is the ground floor.
    pub ordinal: Option<i32>,
}

/// An element, and the storeys that it belongs to, by their keys.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OnStoreys {
    /// Where it is drawn; none stands for all.
    pub on: Vec<String>,
    /// Which it joins.
    pub joins: BTreeSet<String>,
    /// What is drawn.
    pub element: Element,
}

/// Sorts elements by storey. Those that say none are on all of them: outlines of the building, as a rule. Stairs and lifts join the
/// storeys that they are on if those are several, and those that they are said to.
///
/// A storey that the file says nothing more of has the number that its key is, if it is one; else it follows the others in the
/// order of the keys.
pub(super) fn sort(elements: Vec<OnStoreys>, said: &BTreeMap<String, Storey>) -> Vec<Level> {
    let number = |key: &str| said.get(key).and_then(|s| s.ordinal.map(f64::from)).or_else(|| key.trim().parse().ok());
    let all: BTreeSet<&String> = elements.iter().flat_map(|e| &e.on).collect();
    if all.is_empty() {
        return Building::of_one_level(elements.into_iter().map(|e| e.element).collect()).levels;
    }
    let mut keys: Vec<(f64, String)> =
        all.into_iter().map(|key| (number(key).filter(|n| n.is_finite()).unwrap_or(f64::INFINITY), key.clone())).collect();
    keys.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    let numbers: Vec<f64> = keys.iter().map(|(number, _)| *number).collect();
    let order = ordinals(&numbers);
    let ordinal_of: BTreeMap<&str, i32> = keys.iter().map(|(_, key)| key.as_str()).zip(order.iter().copied()).collect();
    let mut on: BTreeMap<&str, Vec<Element>> = BTreeMap::new();
    let mut everywhere = Vec::new();
    for OnStoreys { on: own, joins, mut element } in elements {
        let leads = matches!(element.kind, ElementKind::Stairs | ElementKind::Lift);
        let several = own.iter().filter(|_| leads && own.len() > 1);
        let joined = several.chain(&joins).filter_map(|key| ordinal_of.get(key.as_str()).copied()).collect::<BTreeSet<i32>>();
        element.joins.extend(joined.into_iter().filter(|_| leads));
        match own.split_last() {
            None => everywhere.push(element),
            Some((last, others)) => {
                let own = others.iter().map(|key| (key, element.clone())).collect::<Vec<_>>();
                for (key, element) in own.into_iter().chain([(last, element)]) {
                    if let Some((key, _)) = ordinal_of.get_key_value(key.as_str()) {
                        on.entry(key).or_default().push(element);
                    }
                }
            }
        }
    }
    let level = |(key, ordinal): (&(f64, String), i32)| {
        let elements = on.remove(key.1.as_str()).unwrap_or_default().into_iter().chain(everywhere.iter().cloned()).collect();
        Level { ordinal, name: said.get(&key.1).and_then(|s| s.name.clone()).unwrap_or_else(|| key.1.clone()), elements }
    };
    keys.iter().zip(order.iter().copied()).map(level).collect()
}

/// Order of storeys from below by their numbers, which rise; the ground floor is 0. Whole numbers stay themselves; where there are
/// storeys between them, all are counted: -1, 0, 0.5, 1 become -1, 0, 1, 2. Infinite numbers are storeys of which none is known.
pub(super) fn ordinals(numbers: &[f64]) -> Vec<i32> {
    if numbers.iter().all(|number| *number == number.trunc() && number.abs() < FARTHEST_ORDINAL) {
        return numbers.iter().map(|number| *number as i32).collect();
    }
    let below = numbers.iter().filter(|number| **number < 0.0).count() as i32;
    // The ground floor counts even where nothing is drawn on it.
    let is_above = |number: f64| number > 0.0 && number.is_finite();
    let gap = i32::from(!numbers.contains(&0.0) && numbers.iter().any(|number| is_above(*number)));
    (-below..).zip(numbers).map(|(place, number)| if *number > 0.0 { place + gap } else { place }).collect()
}

/// The storey that is asked for by name or ordinal; without a wish the ground floor, or the lowest above it, or the highest.
///
/// # Errors
/// [`PlanFileError::NoSuchLevel`] with those that there are; [`PlanFileError::NothingDrawn`] where there are none.
pub(super) fn choose<'a>(building: &'a Building, wish: Option<&str>, notes: &mut Vec<String>) -> Result<&'a Level, PlanFileError> {
    let levels = &building.levels;
    if levels.is_empty() {
        let why = "it has no storeys: write at least one into its \"levels\", or import the plan again";
        return Err(PlanFileError::NothingDrawn { format: "plan", why: why.to_owned() });
    }
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
    use proptest::prelude::*;

    fn at(x: f64) -> Element {
        Element::new(ElementKind::Wall, Form::Spot(Pt2::new(x, 0.0)))
    }

    fn of(keys: &[Option<&str>], said: &[(&str, &str, i32)]) -> Vec<(i32, String, usize)> {
        let on = |key: &Option<&str>| key.iter().map(|key| (*key).to_owned()).collect();
        let elements = keys.iter().map(|key| OnStoreys { on: on(key), joins: BTreeSet::new(), element: at(0.0) }).collect();
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
    fn stairs_join_the_storeys_that_they_are_on_or_are_said_to() {
        let kind = |kind| Element::new(kind, Form::Spot(Pt2::new(0.0, 0.0)));
        let element = |on: &[&str], joins: &[&str], element| OnStoreys {
            on: on.iter().map(|key| (*key).to_owned()).collect(),
            joins: joins.iter().map(|key| (*key).to_owned()).collect(),
            element,
        };
        let levels = sort(
            vec![
                element(&["1", "0"], &[], kind(ElementKind::Stairs)),
                element(&["0"], &["0", "2", "9"], kind(ElementKind::Lift)),
                element(&["0", "1", "2"], &[], kind(ElementKind::Wall)),
            ],
            &BTreeMap::new(),
        );
        let joins: Vec<Vec<&[i32]>> = levels.iter().map(|l| l.elements.iter().map(|e| e.joins.as_slice()).collect()).collect();
        // What is not in the file is joined to nothing.
        assert_eq!(joins, [vec![&[0, 1][..], &[0, 2], &[]], vec![&[0, 1], &[]], vec![&[]]]);
    }

    #[test]
    fn the_ground_floor_is_zero_and_mezzanines_are_counted() {
        let none = f64::INFINITY;
        assert_eq!(ordinals(&[-1.0, 0.0, 0.5, 1.0]), [-1, 0, 1, 2]);
        assert_eq!(ordinals(&[-2.0, 0.0, 3.0]), [-2, 0, 3]);
        assert_eq!(ordinals(&[-2.0, -0.5, 0.0, 1.0]), [-2, -1, 0, 1]);
        assert_eq!(ordinals(&[-1.0, 0.5, 2.0]), [-1, 1, 2], "without a ground floor");
        assert_eq!(ordinals(&[none, none]), [0, 1], "nothing is known");
        assert_eq!(ordinals(&[-1.0, none]), [-1, 0]);
        assert_eq!(ordinals(&[]), [0i32; 0]);
    }

    proptest! {
        #[test]
        fn ordinals_rise_with_their_storeys(halves in prop::collection::btree_set(-20i32..20, 1..12)) {
            let numbers: Vec<f64> = halves.iter().map(|half| 0.5 * f64::from(*half)).collect();
            let ordinals = ordinals(&numbers);
            prop_assert!(ordinals.windows(2).all(|pair| pair[0] < pair[1]), "{ordinals:?}");
        }
    }

    #[test]
    fn a_plan_without_storeys_says_so() {
        for wish in [None, Some("1")] {
            let error = choose(&Building::default(), wish, &mut Vec::new()).unwrap_err().to_string();
            assert!(error.contains("no storeys"), "{error}");
        }
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
