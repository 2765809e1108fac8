//! What is drawn in a GeoJSON file? Walls, doors, windows and rooms, by the properties of its features.
//!
//! features ─▶ kind by a property (`type`, `category`, `feature_type`, `indoor`, `class` …) ─▶ storeys of
//! elements in metres
//!
//! Lines of no known kind are walls, unless the collection calls itself one of routes; areas of none are left out, and a note tells their
//! number. IMDF's `feature_type` stands beside
//! the properties and is looked at first: an `opening` is a door.
//! Pitfall: `null` geometries are common.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use geojson::{Feature, GeoJson, Geometry, GeometryValue, JsonObject, JsonValue, Position};
use planwalk_types::{Building, Element, ElementKind, Form, Plan, Pt2};

use super::PlanFileError;
use super::kind::{self, Meaning};
use super::osm::levels;
use super::projection::{Point, Projection};
use super::storeys::{self, OnStoreys, Storey};
use crate::text;

/// Properties that say what a feature is, in the order in which they are asked; without regard to case.
const KEYS: [&str; 9] = ["feature_type", "type", "category", "indoor", "class", "kind", "layer", "object_type", "subclasses"];
/// Properties that make a point or a line a door when they are anything but "no".
const DOOR_KEYS: [&str; 2] = ["door", "entrance"];
/// Properties that hold what people call a room, in the order in which they are asked.
const NAMES: [&str; 4] = ["name", "label", "number", "ref"];
/// Most of each character in a file, strings included: they bound the memory before any of it is taken. A million walls have so many `{`;
/// their memory is 1.4 KB each, or a third of that for each point.
const LIMITS: [(u8, usize, &str); 4] =
    [(b'{', 3_000_000, "objects"), (b'[', 10_000_000, "points and lists"), (b',', 50_000_000, "numbers"), (b'"', 30_000_000, "texts")];
/// Kinds of words that are told when nothing is understood.
const WORDS_TOLD: usize = 8;

/// Reads a plan.
pub(super) fn read(text: &str, notes: &mut Vec<String>) -> Result<Building, PlanFileError> {
    let refuse = |why: String| PlanFileError::GeoJson { why };
    check_size(text)?;
    let document: GeoJson = text.parse().map_err(|why: geojson::Error| refuse(why.to_string()))?;
    let (features, members) = match document {
        GeoJson::FeatureCollection(collection) => (collection.features, collection.foreign_members),
        GeoJson::Feature(feature) => (vec![feature], None),
        GeoJson::Geometry(geometry) => (vec![Feature::from(geometry)], None),
    };
    let (crs, in_metres) = members.as_ref().map_or((None, false), |m| (crs(m), member(m, "units").is_some_and(|u| u == "m")));
    let routes = members.as_ref().and_then(|m| member(m, "name")).filter(|name| kind::is_routes(name)).map(text::short);
    building(&features, &Told { crs, in_metres, routes }, notes)
}

/// Whether a text is no larger than any plan.
///
/// # Errors
/// [`PlanFileError::DrawingTooLarge`].
pub(super) fn check_size(text: &str) -> Result<(), PlanFileError> {
    for (mark, limit, what) in LIMITS {
        if text.bytes().filter(|byte| *byte == mark).count() > limit {
            return Err(PlanFileError::DrawingTooLarge { what, limit });
        }
    }
    Ok(())
}

/// What a file says of all its features.
#[derive(Default)]
pub(super) struct Told {
    /// Name of the coordinate system.
    pub crs: Option<String>,
    /// Whether it calls its numbers metres.
    pub in_metres: bool,
    /// What the collection is called, if that means that its lines are ways to walk.
    pub routes: Option<String>,
}

/// The building that these features are.
pub(super) fn building(features: &[Feature], told: &Told, notes: &mut Vec<String>) -> Result<Building, PlanFileError> {
    let mut found = Found { routes: told.routes.clone(), ..Found::default() };
    for (number, feature) in (1..).zip(features) {
        found.take(number, feature);
    }
    found.join();
    found.take_unnamed(notes);
    found.tell(features.len(), notes);
    if found.elements.is_empty() {
        return Err(PlanFileError::NothingKnown { features: features.len(), found: found.words() });
    }
    let points: Vec<Point> = found.elements.iter().flat_map(|e| e.element.form.points()).map(|p| [p.x, p.y]).collect();
    let projection = Projection::of(told.crs.as_deref(), told.in_metres, &points, notes);
    for point in found.elements.iter_mut().flat_map(|e| e.element.form.points_mut()) {
        let [x, y] = projection.metres([point.x, point.y]);
        *point = Pt2::new(x, y);
    }
    Ok(Building { levels: storeys::sort(found.elements, &found.storeys), georeference: projection.georeference() })
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
    /// With what they say of their storey, and in the file's own coordinates.
    elements: Vec<OnStoreys>,
    without_geometry: usize,
    /// Areas of no known kind.
    unnamed: Vec<OnStoreys>,
    /// Their number, by what they say they are.
    unknown: BTreeMap<String, usize>,
    passed: usize,
    bare_lines: usize,
    /// What the collection is called if its bare lines are ways to walk, and no walls.
    routes: Option<String>,
    storeys: BTreeMap<String, Storey>,
    /// IMDF: storeys of each feature that is drawn, and the features that a relationship leads through.
    storeys_of: BTreeMap<String, Vec<String>>,
    ways: Vec<Vec<String>>,
    /// The feature that each of the elements is drawn from.
    ids: Vec<Option<String>>,
}

impl Found {
    /// Takes the feature of this number, counted from 1.
    fn take(&mut self, number: usize, feature: &Feature) {
        match property(feature, "feature_type").as_deref() {
            Some("level") => return self.take_level(feature),
            Some("relationship") => return self.take_relationship(feature),
            _ => {}
        }
        let Some(geometry) = &feature.geometry else {
            self.without_geometry += 1;
            return;
        };
        let on = keys(feature);
        let joins = joins(feature);
        let id = id(feature);
        if let Some(id) = &id {
            self.storeys_of.insert(id.clone(), on.clone());
        }
        let name = NAMES.iter().find_map(|key| property(feature, key)).map(|name| text::short(&name));
        let words = words(feature);
        let source = source(number, id.as_deref(), words.first());
        let mut forms = Vec::new();
        collect(geometry, &mut forms);
        for form in forms {
            let is_area = matches!(form, Form::Area(_));
            let Some(kind) = self.kind(feature, &words, &form) else { continue };
            let element = Element { name: name.clone(), source: Some(source.clone()), joins: joins.clone(), ..Element::new(kind.0, form) };
            let placed = OnStoreys { on: on.clone(), joins: BTreeSet::new(), element };
            if kind.1 {
                self.elements.push(placed);
                self.ids.push(id.clone());
            } else {
                self.unnamed.extend(is_area.then_some(placed));
            }
        }
    }

    /// What a form of a feature is, and whether that is known; `None` for what is left out.
    fn kind(&mut self, feature: &Feature, words: &[String], form: &Form) -> Option<(ElementKind, bool)> {
        let kind = words.iter().find_map(|word| kind::of(word));
        let door = || DOOR_KEYS.iter().any(|key| property(feature, key).is_some_and(|value| value != "no"));
        let leads = |kind: ElementKind| matches!(kind, ElementKind::Door | ElementKind::Stairs | ElementKind::Lift);
        match (form, kind) {
            (Form::Line(_) | Form::Spot(_), _) if door() => Some((ElementKind::Door, true)),
            (Form::Spot(_), Some(Meaning::Part(kind))) if leads(kind) => Some((kind, true)),
            (Form::Spot(_), Some(_)) | (_, Some(Meaning::Passed)) => {
                self.passed += 1;
                None
            }
            (_, Some(Meaning::Part(kind))) => Some((kind, true)),
            (Form::Line(_), None) => {
                self.bare_lines += 1;
                self.routes.is_none().then_some((ElementKind::Wall, true))
            }
            (_, None) => {
                let word = words.first().map_or_else(|| "nothing".to_owned(), |word| format!("\"{}\"", text::short(word)));
                *self.unknown.entry(word).or_default() += usize::from(matches!(form, Form::Area(_)));
                Some((ElementKind::Room, false))
            }
        }
    }

    /// IMDF: which features one passes on the way by stairs or lift.
    fn take_relationship(&mut self, way: &Feature) {
        let leads = property(way, "category").and_then(|word| kind::of(&word));
        if !matches!(leads, Some(Meaning::Part(ElementKind::Stairs | ElementKind::Lift))) {
            return;
        }
        let members = |key: &str| {
            let value = way.properties.as_ref().and_then(|properties| properties.get(key));
            let list = value.map_or(&[][..], |value| value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice));
            list.iter().filter_map(|member| member.get("id")?.as_str().map(text::short)).collect::<Vec<_>>()
        };
        self.ways.push(["origin", "intermediary", "destination"].into_iter().flat_map(members).collect());
    }

    /// Stairs and lifts join the storeys of all that a relationship leads through.
    fn join(&mut self) {
        let mut joined: BTreeMap<&str, BTreeSet<&String>> = BTreeMap::new();
        for way in &self.ways {
            let storeys: BTreeSet<&String> = way.iter().filter_map(|id| self.storeys_of.get(id)).flatten().collect();
            for id in way.iter().filter(|_| storeys.len() > 1) {
                joined.entry(id).or_default().extend(&storeys);
            }
        }
        for (element, id) in self.elements.iter_mut().zip(&self.ids) {
            let joins = id.as_deref().and_then(|id| joined.get(id)).into_iter().flatten();
            element.joins.extend(joins.map(|key| (*key).clone()));
        }
    }

    /// Where a floor is known and nothing that divides it, as on maps of malls, areas of no known kind are its rooms.
    fn take_unnamed(&mut self, notes: &mut Vec<String>) {
        let is_bare = |placed: &OnStoreys| placed.element.kind == ElementKind::Floor;
        if !self.unnamed.is_empty() && !self.elements.is_empty() && self.elements.iter().all(is_bare) {
            notes.push(format!("{} areas of no known kind are taken as rooms: nothing else divides the floor", self.unnamed.len()));
            self.elements.append(&mut self.unnamed);
            self.unknown.clear();
        }
    }

    /// IMDF: what others call by its id.
    fn take_level(&mut self, level: &Feature) {
        let Some(id) = id(level) else { return };
        let ordinal = property(level, "ordinal").and_then(|n| n.parse::<f64>().ok()).filter(|n| n.abs() < 1e6).map(|n| n.round() as i32);
        let name = ["short_name", "name"].iter().find_map(|key| property(level, key)).map(|name| text::short(&name));
        self.storeys.insert(id, Storey { name, ordinal });
    }

    fn words(&self) -> String {
        let mut told = String::new();
        for (word, count) in self.unknown.iter().take(WORDS_TOLD) {
            // Writing to a string does not fail.
            let _ = write!(told, "{}{count} of {word}", if told.is_empty() { "" } else { ", " });
        }
        match &self.routes {
            Some(name) if self.bare_lines > 0 => {
                let _ = write!(told, "{}{} lines that \"{name}\" calls routes", if told.is_empty() { "" } else { ", " }, self.bare_lines);
                told
            }
            _ if told.is_empty() => "no areas or lines".to_owned(),
            _ => told,
        }
    }

    fn tell(&self, features: usize, notes: &mut Vec<String>) {
        if self.without_geometry > 0 {
            notes.push(format!("{} of {features} features have no geometry and are left out", self.without_geometry));
        }
        if !self.unknown.is_empty() {
            notes.push(format!("areas of no known kind are left out: {}", self.words()));
        }
        if self.bare_lines > 0 {
            notes.push(match &self.routes {
                None => format!("{} lines say nothing of what they are, and are taken as walls", self.bare_lines),
                Some(name) => format!("{} lines say nothing of what they are, and are left out: \"{name}\" means routes", self.bare_lines),
            });
        }
        if self.passed > 0 {
            notes.push(format!("{} shapes of furniture, labels, routes and the like are left out", self.passed));
        }
    }
}

/// Keys of the storeys that a feature is on: `level` or `level_id`, several as OpenStreetMap lists them (`0;1`, `0-2`).
fn keys(feature: &Feature) -> Vec<String> {
    let Some(value) = property(feature, "level").or_else(|| property(feature, "level_id")) else { return Vec::new() };
    match levels::parse(&value) {
        Some(several) if several.len() > 1 => several.into_iter().map(levels::Level::name).collect(),
        _ => vec![text::short(&value)],
    }
}

/// Ordinals of the storeys that stairs or a lift are said to join, as this program's own export lists them.
fn joins(feature: &Feature) -> Vec<i32> {
    let several = property(feature, "joins").and_then(|value| levels::parse(&value));
    several.into_iter().flatten().map(|level| level.number().round() as i32).collect()
}

/// Words that may say what a feature is, the first one first.
fn words(feature: &Feature) -> Vec<String> {
    let mut words: Vec<String> = KEYS.iter().filter_map(|key| property(feature, key)).collect();
    if words.first().is_some_and(|word| word == "unit") {
        // IMDF: which sort of unit says more.
        words.rotate_left(1);
    }
    words
}

fn id(feature: &Feature) -> Option<String> {
    feature.id.as_ref().map(id_text).or_else(|| property(feature, "id")).map(|id| text::short(&id))
}

/// Where an element comes from: its feature's id, or else its number, and what it says it is.
fn source(number: usize, id: Option<&str>, word: Option<&String>) -> String {
    let feature = id.map_or_else(|| format!("feature {number}"), |id| format!("feature {id}"));
    word.map_or(feature.clone(), |word| format!("{feature}, {}", text::short(word)))
}

/// A property, or a member beside them (IMDF), as text; without regard to case.
fn property(feature: &Feature, name: &str) -> Option<String> {
    let find = |members: &JsonObject| {
        let (_, value) = members.iter().find(|(key, _)| key.eq_ignore_ascii_case(name))?;
        match value {
            JsonValue::String(word) => Some(word.clone()),
            JsonValue::Number(number) => Some(number.to_string()),
            JsonValue::Bool(yes) => Some(if *yes { "yes" } else { "no" }.to_owned()),
            // IMDF names things in several languages.
            JsonValue::Object(languages) => languages.values().find_map(|name| name.as_str()).map(str::to_owned),
            _ => None,
        }
    };
    feature.foreign_members.as_ref().and_then(find).or_else(|| feature.properties.as_ref().and_then(find))
}

fn id_text(id: &geojson::feature::Id) -> String {
    match id {
        geojson::feature::Id::String(text) => text.clone(),
        geojson::feature::Id::Number(number) => number.to_string(),
    }
}

/// The forms of a geometry, in the file's own coordinates; positions of fewer than two numbers are passed over.
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

fn chain(positions: &[Position]) -> Vec<Pt2<Plan>> {
    positions.iter().filter_map(point).collect()
}

fn point(position: &Position) -> Option<Pt2<Plan>> {
    match position.as_slice() {
        [x, y, ..] => Some(Pt2::new(*x, *y)),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
