//! Where do the shapes of a building come from? Counts of what their sources say, without the numbers of single lines and features.

use std::collections::BTreeMap;

use planwalk_types::Building;

/// Words before the number or id of one of many.
const NUMBERED: [&str; 6] = ["line", "feature", "way", "node", "relation", "pixel"];
/// What is said where a source is missing.
const UNKNOWN: &str = "not said";

/// How many shapes come from where: layers, kinds of features, colours; the commonest first.
///
/// `way 17, indoor=room` counts as `way, indoor=room`, and `line 3` as `line`.
pub fn provenance(building: &Building) -> Vec<(String, usize)> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for element in building.levels.iter().flat_map(|level| &level.elements) {
        *counts.entry(element.source.as_deref().map_or_else(|| UNKNOWN.to_owned(), kind_of)).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> = counts.into_iter().collect();
    // Stable: sources of one count stay in the order of their names.
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts
}

/// A source without the number of the one among many.
fn kind_of(source: &str) -> String {
    let numbered = NUMBERED.iter().find(|word| source.strip_prefix(**word).is_some_and(|rest| rest.starts_with(' ')));
    match (numbered, source.split_once(", ")) {
        (None, _) => source.to_owned(),
        (Some(word), None) => (*word).to_owned(),
        (Some(word), Some((_, what))) => format!("{word}, {what}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Element, ElementKind, Form, Pt2};

    #[test]
    fn sources_are_counted_without_their_numbers() {
        let from = |source: Option<&str>| Element {
            source: source.map(str::to_owned),
            ..Element::new(ElementKind::Wall, Form::Spot(Pt2::new(0.0, 0.0)))
        };
        let sources = ["line 3", "line 4", "way -1, indoor=room", "way 7, indoor=room", "way 8, indoor=wall", "A-WALL", "lineament 2"];
        let building = Building::of_one_level(sources.iter().map(|source| from(Some(source))).chain([from(None)]).collect());
        let counts = provenance(&building);
        let counts: Vec<(&str, usize)> = counts.iter().map(|(source, count)| (source.as_str(), *count)).collect();
        let one = ["A-WALL", "lineament 2", "not said", "way, indoor=wall"].map(|source| (source, 1));
        assert_eq!(counts[..2], [("line", 2), ("way, indoor=room", 2)]);
        assert_eq!(counts[2..], one);
    }
}
