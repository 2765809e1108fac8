//! What is drawn in a GeoJSON file? Walls, doors, windows and rooms, by the properties of its features.
//!
//! features ─▶ kind by a property (`type`, `category`, `feature_type`, `indoor`, `class` …) ─▶ shapes in metres ─▶ [`vector::draw`]
//!
//! Lines of no known kind are walls; areas of none are left out, and a note tells their number. IMDF's `feature_type` stands beside
//! the properties and is looked at first: an `opening` is a door.
//! Pitfalls: `null` geometries are common. Files of several storeys lie on each other; a note says so.

use std::collections::BTreeMap;
use std::fmt::Write;

use geojson::{Feature, GeoJson, Geometry, GeometryValue, JsonObject, JsonValue, Position};

use super::kind::{self, Kind};
use super::projection::Projection;
use super::vector::{self, Form, Point, Shape};
use super::{PlanFile, PlanFileError};
use crate::text;

/// Properties that say what a feature is, in the order in which they are asked; without regard to case.
const KEYS: [&str; 9] = ["feature_type", "type", "category", "indoor", "class", "kind", "layer", "object_type", "subclasses"];
/// Properties that make a point or a line a door when they are anything but "no".
const DOOR_KEYS: [&str; 2] = ["door", "entrance"];
/// Kinds of words that are told when nothing is understood.
const WORDS_TOLD: usize = 8;

/// Reads a plan.
pub(super) fn read(text: &str) -> Result<PlanFile, PlanFileError> {
    let refuse = |why: String| PlanFileError::GeoJson { why };
    let document: GeoJson = text.parse().map_err(|why: geojson::Error| refuse(why.to_string()))?;
    let (features, members) = match document {
        GeoJson::FeatureCollection(collection) => (collection.features, collection.foreign_members),
        GeoJson::Feature(feature) => (vec![feature], None),
        GeoJson::Geometry(geometry) => (vec![Feature::from(geometry)], None),
    };
    let mut found = Found::default();
    for feature in &features {
        found.take(feature);
    }
    let mut notes = found.notes(features.len());
    if !found.shapes.iter().any(|shape| shape.kind != Kind::Passed) {
        return Err(PlanFileError::NothingKnown { features: features.len(), found: found.words() });
    }
    let points: Vec<Point> = found.shapes.iter().flat_map(|s| s.form.chains()).flatten().copied().collect();
    let (crs, in_metres) = members.as_ref().map_or((None, false), |m| (crs(m), member(m, "units").is_some_and(|u| u == "m")));
    let projection = Projection::of(crs.as_deref(), in_metres, &points, &mut notes);
    let mut shapes = found.shapes;
    for point in shapes.iter_mut().flat_map(|shape| shape.form.points_mut()) {
        *point = projection.metres(*point);
    }
    vector::draw(&shapes, notes)
}

/// A member that is text.
fn member<'a>(members: &'a JsonObject, name: &str) -> Option<&'a str> {
    members.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).and_then(|(_, value)| value.as_str())
}

/// Name of the coordinate system, as GeoJSON had it before RFC 7946.
fn crs(members: &JsonObject) -> Option<String> {
    let name = members.get("crs")?.get("properties")?.get("name")?.as_str()?;
    Some(text::short(name))
}

/// What the features are, and what was met on the way.
#[derive(Default)]
struct Found {
    shapes: Vec<Shape>,
    without_geometry: usize,
    /// Features of no known kind, by what they say they are.
    unknown: BTreeMap<String, usize>,
    passed: usize,
    bare_lines: usize,
    levels: BTreeMap<String, usize>,
}

impl Found {
    fn take(&mut self, feature: &Feature) {
        let Some(geometry) = &feature.geometry else {
            self.without_geometry += 1;
            return;
        };
        if let Some(level) = property(feature, "level").or_else(|| property(feature, "level_id")) {
            *self.levels.entry(text::short(&level)).or_default() += 1;
        }
        let words: Vec<String> = KEYS.iter().filter_map(|key| property(feature, key)).collect();
        let kind = words.iter().find_map(|word| kind::of(word));
        let door = DOOR_KEYS.iter().any(|key| property(feature, key).is_some_and(|value| value != "no"));
        let mut forms = Vec::new();
        collect(geometry, &mut forms);
        for form in forms {
            let is_area = matches!(form, Form::Area(_));
            let kind = match (&form, kind) {
                (Form::Line(_) | Form::Spot(_), _) if door => Kind::Door,
                (Form::Spot(_), Some(kind)) if kind != Kind::Door => Kind::Passed,
                (_, Some(kind)) => kind,
                (Form::Line(_), None) => {
                    self.bare_lines += 1;
                    Kind::Wall
                }
                (_, None) => {
                    let word = words.first().map_or_else(|| "nothing".to_owned(), |word| format!("\"{}\"", text::short(word)));
                    *self.unknown.entry(word).or_default() += usize::from(is_area);
                    continue;
                }
            };
            self.passed += usize::from(kind == Kind::Passed);
            if kind != Kind::Passed {
                self.shapes.push(Shape { kind, form });
            }
        }
    }

    fn words(&self) -> String {
        let mut told = String::new();
        for (word, count) in self.unknown.iter().take(WORDS_TOLD) {
            // Writing to a string does not fail.
            let _ = write!(told, "{}{count} of {word}", if told.is_empty() { "" } else { ", " });
        }
        if told.is_empty() { "no areas or lines".to_owned() } else { told }
    }

    fn notes(&self, features: usize) -> Vec<String> {
        let mut notes = Vec::new();
        if self.without_geometry > 0 {
            notes.push(format!("{} of {features} features have no geometry and are left out", self.without_geometry));
        }
        if !self.unknown.is_empty() {
            notes.push(format!("areas of no known kind are left out: {}", self.words()));
        }
        if self.bare_lines > 0 {
            notes.push(format!("{} lines say nothing of what they are, and are taken as walls", self.bare_lines));
        }
        if self.passed > 0 {
            notes.push(format!("{} shapes of furniture, labels, routes and the like are left out", self.passed));
        }
        if self.levels.len() > 1 {
            let names: Vec<&str> = self.levels.keys().take(WORDS_TOLD).map(String::as_str).collect();
            notes.push(format!("features of {} storeys ({}) lie on each other: keep one", self.levels.len(), names.join(", ")));
        }
        notes
    }
}

/// A property, or a member beside them (IMDF), as text; without regard to case.
fn property(feature: &Feature, name: &str) -> Option<String> {
    let find = |members: &JsonObject| {
        let (_, value) = members.iter().find(|(key, _)| key.eq_ignore_ascii_case(name))?;
        match value {
            JsonValue::String(word) => Some(word.clone()),
            JsonValue::Number(number) => Some(number.to_string()),
            JsonValue::Bool(yes) => Some(if *yes { "yes" } else { "no" }.to_owned()),
            _ => None,
        }
    };
    feature.foreign_members.as_ref().and_then(find).or_else(|| feature.properties.as_ref().and_then(find))
}

/// The forms of a geometry; positions of fewer than two numbers are passed over.
fn collect(geometry: &Geometry, forms: &mut Vec<Form>) {
    let area = |rings: &Vec<Vec<Position>>| Form::Area(rings.iter().map(|ring| chain(ring)).collect());
    match &geometry.value {
        GeometryValue::Point { coordinates } => forms.extend(point(coordinates).map(Form::Spot)),
        GeometryValue::MultiPoint { coordinates } => forms.extend(coordinates.iter().filter_map(point).map(Form::Spot)),
        GeometryValue::LineString { coordinates } => forms.push(Form::Line(chain(coordinates))),
        GeometryValue::MultiLineString { coordinates } => forms.extend(coordinates.iter().map(|line| Form::Line(chain(line)))),
        GeometryValue::Polygon { coordinates } => forms.push(area(coordinates)),
        GeometryValue::MultiPolygon { coordinates } => forms.extend(coordinates.iter().map(area)),
        // JSON is refused by its reader when it is nested deeper than 128: this ends.
        GeometryValue::GeometryCollection { geometries } => geometries.iter().for_each(|inner| collect(inner, forms)),
    }
}

fn chain(positions: &[Position]) -> Vec<Point> {
    positions.iter().filter_map(point).collect()
}

fn point(position: &Position) -> Option<Point> {
    match position.as_slice() {
        [x, y, ..] => Some([*x, *y]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Cell, Pt2};

    fn collection(head: &str, features: &[String]) -> String {
        format!("{{\"type\":\"FeatureCollection\",{head}\"features\":[{}]}}", features.join(","))
    }

    fn feature(properties: &str, geometry: &str, coordinates: &str) -> String {
        format!(
            "{{\"type\":\"Feature\",\"properties\":{properties},\"geometry\":{{\"type\":\"{geometry}\",\"coordinates\":{coordinates}}}}}"
        )
    }

    fn flat() -> Vec<String> {
        vec![
            feature(
                "{\"Type\":\"Wa\"}",
                "Polygon",
                "[[[0,0],[5,0],[5,4],[0,4],[0,0]],[[0.2,0.2],[0.2,3.8],[4.8,3.8],[4.8,0.2],[0.2,0.2]]]",
            ),
            feature("{\"Type\":\"B_Door\"}", "Polygon", "[[[2,0],[3,0],[3,0.2],[2,0.2],[2,0]]]"),
            feature("{\"category\":\"window\"}", "LineString", "[[0.1,1,0],[0.1,2,0]]"),
            "{\"type\":\"Feature\",\"properties\":{\"Type\":\"Wall\"},\"geometry\":null}".to_owned(),
            feature("{\"Type\":\"furniture\"}", "Polygon", "[[[2,2],[3,2],[3,3],[2,2]]]"),
            feature("{\"Type\":\"NaNs\"}", "Polygon", "[[[2,2],[3,2],[3,3],[2,2]]]"),
            feature("null", "LineString", "[[4,0],[4,4]]"),
        ]
    }

    #[test]
    fn features_are_known_by_their_words_and_what_is_left_out_is_told() {
        let file = read(&collection("", &flat())).unwrap();
        let at = |x, y| file.plan.at(Pt2::new(x, y));
        assert_eq!([at(1.0, 0.1), at(2.5, 0.1), at(0.1, 1.5), at(2.5, 2.4)], [Cell::Wall, Cell::Door, Cell::Window, Cell::Free]);
        assert_eq!(at(4.01, 2.0), Cell::Wall, "a bare line");
        for told in ["1 of 7 features have no geometry", "1 of \"NaNs\"", "1 lines say nothing", "1 shapes of furniture", "metres"] {
            assert!(file.notes.iter().any(|note| note.contains(told)), "{told}: {:?}", file.notes);
        }
    }

    #[test]
    fn units_and_openings_make_rooms_with_doors() {
        let unit = |x: f64| {
            let ring = format!("[[[{x},0],[{},0],[{},3],[{x},3],[{x},0]]]", x + 4.0, x + 4.0);
            feature("{\"category\":\"room\",\"level_id\":\"a\"}", "Polygon", &ring).replacen('{', "{\"feature_type\":\"unit\",", 1)
        };
        let opening = feature("{\"level_id\":\"b\"}", "LineString", "[[4,1],[4,2]]").replacen('{', "{\"feature_type\":\"opening\",", 1);
        let file = read(&collection("\"units\":\"m\",", &[unit(0.0), unit(4.0), opening])).unwrap();
        assert_eq!(file.plan.at(Pt2::new(4.01, 1.5)), Cell::Door);
        assert_eq!(file.plan.at(Pt2::new(4.01, 0.5)), Cell::Wall);
        assert!(file.notes.iter().any(|n| n.contains("2 storeys (a, b)")), "{:?}", file.notes);
    }

    #[test]
    fn a_plan_on_the_globe_becomes_metres() {
        // 0.0001° are 11 m northwards and 6.6 m eastwards at Hamburg.
        let walls = feature("{\"type\":\"wall\"}", "LineString", "[[10,53.54],[10.0001,53.54],[10.0001,53.5401],[10,53.5401],[10,53.54]]");
        let file = read(&collection("", &[walls])).unwrap();
        let (width, height) = file.plan.size_m();
        assert!((width - 2.0 - 6.63).abs() < 0.2 && (height - 2.0 - 11.13).abs() < 0.2, "{width} × {height}");
        assert!(file.notes.iter().any(|n| n.contains("10.0000000, 53.5400000")), "{:?}", file.notes);
    }

    #[test]
    fn doors_as_points_open_their_wall() {
        let mut features = flat();
        features.push(feature("{\"door\":\"hinged\"}", "Point", "[4,1]"));
        assert_eq!(read(&collection("", &features)).unwrap().plan.at(Pt2::new(4.01, 1.0)), Cell::Door);
    }

    #[test]
    fn what_is_no_plan_is_refused_with_a_remedy() {
        let error = |text: &str| read(text).unwrap_err().to_string();
        let nested = format!(
            "{{\"type\":\"GeometryCollection\",\"geometries\":{}",
            "[{\"type\":\"GeometryCollection\",\"geometries\":".repeat(50_000)
        );
        for text in ["{", "{}", "{\"type\":\"Topology\"}", "{\"walls\":[]}", &nested, &"[".repeat(100_000)] {
            assert!(error(text).contains("no GeoJSON"), "{}", error(text));
        }
        let huge = collection("", &[feature("{\"type\":\"wall\"}", "LineString", "[[0,0],[1e999,0]]")]);
        assert!(error(&huge).contains("no GeoJSON"), "{}", error(&huge));
        let unknown = collection("", &[feature("{\"type\":\"tree\"}", "Polygon", "[[[0,0],[1,0],[1,1],[0,0]]]")]);
        assert!(error(&unknown).contains("1 of \"tree\""), "{}", error(&unknown));
        assert!(error(&collection("", &[])).contains("none of the 0 features"));
        let wide = collection("", &[feature("{\"type\":\"wall\"}", "LineString", "[[0,0],[566600,5932800]]")]);
        assert!(error(&wide).contains("566600"), "{}", error(&wide));
        for coordinates in ["[]", "[[]]", "[[[]]]", "[[[1]]]"] {
            let odd = collection("", &[feature("{\"type\":\"wall\"}", "Polygon", coordinates)]);
            assert!(read(&odd).is_err(), "{coordinates}");
        }
    }
}
