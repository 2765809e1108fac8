//! What is in an OpenStreetMap file? Nodes, ways and relations of OSM XML 0.6, with the tags that a plan needs.
//!
//! What is deleted (`action="delete"` of JOSM, `visible="false"` of the database) is not taken, and of relations only the ways
//! of multipolygons are. A node without coordinates is one that the file does not hold, as JOSM writes them.
//! Pitfalls: objects come in any order, so that references are looked up when everything is read. JOSM's new objects have
//! negative ids. Entities of the file's own are refused, never expanded: they may stand for gigabytes.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::super::PlanFileError;
use super::super::projection::Point;
use crate::text;

/// Most nodes: a city. They take 140 MB.
const MOST_NODES: usize = 3_000_000;
/// Most ways and relations together.
const MOST_WAYS: usize = 1_000_000;
/// Most references of ways to nodes and of relations to ways.
const MOST_REFERENCES: usize = 10_000_000;
/// Deepest nesting; real files have three levels.
const DEEPEST: usize = 32;
/// Longest value of a tag, characters; the database has the same limit. The rest is cut off.
const LONGEST_VALUE: usize = 255;
/// Most keys that are counted for the message that nothing was found.
const MOST_KEYS: usize = 500;
/// Keys told in it.
const KEYS_TOLD: usize = 6;

/// Keys of the tags that are kept.
const KEYS: [&str; 30] = [
    "access",
    "area",
    "barrier",
    "building:part",
    "buildingpart",
    "door",
    "elevator",
    "entrance",
    "est_width",
    "highway",
    "indoor",
    "lanes",
    "level",
    "level:ref",
    "material",
    "motor_vehicle",
    "motorcar",
    "name",
    "public_transport",
    "railway",
    "ref",
    "repeat_on",
    "room",
    "stairs",
    "type",
    "vehicle",
    "wall",
    "width",
    "window",
    "windows",
];

/// Tags of an object.
#[derive(Debug, Clone, Default)]
pub(super) struct Tags(Vec<(&'static str, Box<str>)>);

impl Tags {
    /// The value of a key, without blanks around it; `None` where it is empty.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(k, _)| *k == key).map(|(_, value)| value.as_ref())
    }

    /// Whether the key has one of these values.
    pub(super) fn is(&self, key: &str, values: &[&str]) -> bool {
        self.get(key).is_some_and(|value| values.contains(&value))
    }

    /// Whether the key is there, and is not "no".
    pub(super) fn says(&self, key: &str) -> bool {
        self.get(key).is_some_and(|value| value != "no")
    }

    /// What people call it: number and name.
    pub(super) fn label(&self) -> Option<String> {
        match (self.get("ref"), self.get("name")) {
            (Some(number), Some(name)) if number != name => Some(format!("{number} {name}")),
            (number, name) => name.or(number).map(str::to_owned),
        }
    }

    /// The first of two tags of one key counts.
    fn set(&mut self, key: &str, value: &str) {
        let value = value.trim();
        if let Some(key) = KEYS.iter().find(|k| **k == key)
            && self.get(key).is_none()
            && !value.is_empty()
        {
            self.0.push((key, value.chars().take(LONGEST_VALUE).collect()));
        }
    }
}

/// A chain of nodes.
#[derive(Debug)]
pub(super) struct Way {
    pub id: i64,
    pub nodes: Vec<i64>,
    pub tags: Tags,
}

impl Way {
    /// Whether it ends where it begins.
    pub(super) fn is_closed(&self) -> bool {
        self.nodes.len() > 3 && self.nodes.first() == self.nodes.last()
    }
}

/// A way of a multipolygon.
#[derive(Debug, Clone, Copy)]
pub(super) struct Member {
    pub way: i64,
    /// Part of a hole's edge; else of an outline.
    pub inner: bool,
}

/// A relation between ways.
#[derive(Debug)]
pub(super) struct Relation {
    pub id: i64,
    pub members: Vec<Member>,
    pub tags: Tags,
}

/// All of a file.
#[derive(Debug, Default)]
pub(super) struct Map {
    /// Longitude and latitude, degrees.
    nodes: HashMap<i64, Point>,
    /// Nodes with tags, in the file's order.
    pub places: Vec<(i64, Tags)>,
    /// In the file's order, likewise.
    pub ways: Vec<Way>,
    way_at: HashMap<i64, usize>,
    /// Multipolygons.
    pub relations: Vec<Relation>,
    relation_count: usize,
    key_counts: BTreeMap<String, usize>,
}

impl Map {
    /// Reads a file.
    pub(super) fn parse(text: &str) -> Result<Self, PlanFileError> {
        let mut reader = Reader::from_str(text);
        let mut parser = Parser::default();
        loop {
            let position = reader.buffer_position();
            let event = reader.read_event().map_err(|why| Fault::Broken(why.to_string()).at(text, reader.error_position()))?;
            match event {
                Event::Start(tag) => parser.start(&tag).map_err(|fault| fault.at(text, position))?,
                Event::Empty(tag) => {
                    parser.start(&tag).map_err(|fault| fault.at(text, position))?;
                    parser.end();
                }
                Event::End(_) => parser.end(),
                Event::Eof => return parser.finish().map_err(|fault| fault.at(text, position)),
                _ => {}
            }
        }
    }

    /// Longitude and latitude of a node, degrees.
    pub(super) fn node(&self, id: i64) -> Option<Point> {
        self.nodes.get(&id).copied()
    }

    /// The way of an id.
    pub(super) fn way(&self, id: i64) -> Option<&Way> {
        self.ways.get(*self.way_at.get(&id)?)
    }

    /// How much there is of what.
    pub(super) fn found(&self) -> String {
        let mut keys: Vec<_> = self.key_counts.iter().collect();
        keys.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let keys: Vec<String> = keys.iter().take(KEYS_TOLD).map(|(key, count)| format!("{key} ({count})")).collect();
        let tagged = if keys.is_empty() { "nothing is tagged".to_owned() } else { format!("the commonest tags are {}", keys.join(", ")) };
        format!("{} nodes, {} ways and {} relations; {tagged}", self.nodes.len(), self.ways.len(), self.relation_count)
    }
}

/// Why reading stops.
enum Fault {
    Broken(String),
    TooLarge(&'static str, usize),
}

impl Fault {
    fn at(self, text: &str, position: u64) -> PlanFileError {
        match self {
            Self::TooLarge(what, limit) => PlanFileError::OsmTooLarge { what, limit },
            Self::Broken(why) => {
                let before = text.as_bytes().get(..position as usize).unwrap_or_default();
                let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
                let line = 1 + before.iter().filter(|b| **b == b'\n').count();
                PlanFileError::Osm { line, column: 1 + before.len() - line_start, why }
            }
        }
    }
}

/// Whether a further one goes beyond the limit.
fn check(count: usize, what: &'static str, limit: usize) -> Result<(), Fault> {
    if count < limit { Ok(()) } else { Err(Fault::TooLarge(what, limit)) }
}

/// What is read so far.
#[derive(Default)]
struct Parser {
    map: Map,
    /// Elements that are not closed yet.
    depth: usize,
    open: Option<Open>,
    references: usize,
}

/// The object whose tags and members are being read.
struct Open {
    id: i64,
    tags: Tags,
    body: Body,
    depth: usize,
}

enum Body {
    Deleted,
    Node(Option<Point>),
    Way(Vec<i64>),
    Relation(Vec<Member>),
}

impl Parser {
    fn start(&mut self, tag: &BytesStart) -> Result<(), Fault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Fault::Broken(format!("elements lie in each other {} deep, more than {DEEPEST}", self.depth)));
        }
        let name = tag.name();
        let name: &str = name.as_ref();
        match (name, &mut self.open) {
            ("osm", None) if self.depth == 1 => Ok(()),
            _ if self.depth == 1 => Err(Fault::Broken(format!("it begins with <{}>, not <osm>", text::short(name)))),
            ("node" | "way" | "relation", None) => self.object(name, tag),
            ("node" | "way" | "relation", Some(open)) => Err(Fault::Broken(format!("a {name} begins inside of object {}", open.id))),
            ("tag", Some(_)) => self.tag(tag),
            ("nd", Some(Open { body: Body::Way(_), .. })) => self.way_node(tag),
            ("member", Some(Open { body: Body::Relation(_), .. })) => self.member(tag),
            _ => Ok(()),
        }
    }

    fn end(&mut self) {
        self.depth = self.depth.saturating_sub(1);
        if let Some(open) = self.open.take_if(|open| open.depth > self.depth) {
            self.map.add(open);
        }
    }

    fn finish(self) -> Result<Map, Fault> {
        if self.depth > 0 {
            return Err(Fault::Broken(format!("it ends too early, {} elements are still open", self.depth)));
        }
        Ok(self.map)
    }

    fn object(&mut self, name: &str, tag: &BytesStart) -> Result<(), Fault> {
        let [id, action, visible, latitude, longitude] = attributes(tag, ["id", "action", "visible", "lat", "lon"])?;
        let id = whole(id.as_deref()).ok_or_else(|| Fault::Broken(format!("a {name} has no id that is a whole number")))?;
        let deleted = action.as_deref() == Some("delete") || visible.as_deref() == Some("false");
        let body = match name {
            _ if deleted => Body::Deleted,
            "node" => {
                check(self.map.nodes.len(), "nodes", MOST_NODES)?;
                Body::Node(place(id, longitude.as_deref(), latitude.as_deref())?)
            }
            _ => {
                check(self.map.ways.len() + self.map.relation_count, "ways and relations", MOST_WAYS)?;
                if name == "way" { Body::Way(Vec::new()) } else { Body::Relation(Vec::new()) }
            }
        };
        self.open = Some(Open { id, tags: Tags::default(), body, depth: self.depth });
        Ok(())
    }

    fn tag(&mut self, tag: &BytesStart) -> Result<(), Fault> {
        let [key, value] = attributes(tag, ["k", "v"])?;
        let (Some(key), Some(value), Some(open)) = (key, value, &mut self.open) else { return Ok(()) };
        if matches!(open.body, Body::Deleted) {
            return Ok(());
        }
        open.tags.set(&key, &value);
        if let Some(count) = self.map.key_counts.get_mut(key.as_ref()) {
            *count += 1;
        } else if self.map.key_counts.len() < MOST_KEYS {
            self.map.key_counts.insert(text::short(&key), 1);
        }
        Ok(())
    }

    fn way_node(&mut self, tag: &BytesStart) -> Result<(), Fault> {
        check(self.references, "references", MOST_REFERENCES)?;
        self.references += 1;
        // Overpass's `out geom` has coordinates here, and no nodes.
        let [node, latitude, longitude] = attributes(tag, ["ref", "lat", "lon"])?;
        let node = whole(node.as_deref()).ok_or_else(|| Fault::Broken("a way's node has no number".to_owned()))?;
        if let Some(point) = place(node, longitude.as_deref(), latitude.as_deref())? {
            check(self.map.nodes.len(), "nodes", MOST_NODES)?;
            self.map.nodes.entry(node).or_insert(point);
        }
        if let Some(Open { body: Body::Way(nodes), .. }) = &mut self.open {
            nodes.push(node);
        }
        Ok(())
    }

    fn member(&mut self, tag: &BytesStart) -> Result<(), Fault> {
        check(self.references, "references", MOST_REFERENCES)?;
        self.references += 1;
        let [kind, way, role] = attributes(tag, ["type", "ref", "role"])?;
        if let (Some("way"), Some(way), Some(Open { body: Body::Relation(members), .. })) =
            (kind.as_deref(), whole(way.as_deref()), &mut self.open)
        {
            members.push(Member { way, inner: role.as_deref() == Some("inner") });
        }
        Ok(())
    }
}

impl Map {
    /// Adds an object; a later version replaces an earlier one.
    fn add(&mut self, Open { id, tags, body, .. }: Open) {
        match body {
            Body::Deleted => {}
            Body::Node(None) => {}
            Body::Node(Some(point)) => {
                self.nodes.insert(id, point);
                if !tags.0.is_empty() {
                    self.places.push((id, tags));
                }
            }
            Body::Way(nodes) => {
                let way = Way { id, nodes, tags };
                match self.way_at.get(&id).and_then(|at| self.ways.get_mut(*at)) {
                    Some(earlier) => *earlier = way,
                    None => {
                        self.way_at.insert(id, self.ways.len());
                        self.ways.push(way);
                    }
                }
            }
            Body::Relation(members) => {
                self.relation_count += 1;
                if tags.is("type", &["multipolygon"]) {
                    self.relations.push(Relation { id, members, tags });
                }
            }
        }
    }
}

/// An attribute's value, if it is there.
type Value<'t> = Option<Cow<'t, str>>;

/// The attributes of these names.
fn attributes<'t, const N: usize>(tag: &'t BytesStart, names: [&str; N]) -> Result<[Value<'t>; N], Fault> {
    let broken = |why: String| Fault::Broken(why);
    let mut values = [const { None }; N];
    // Without checks: the first of two attributes of one name counts.
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.map_err(|why| broken(why.to_string()))?;
        let name: &str = attribute.key.as_ref();
        let slot = names.iter().position(|wanted| *wanted == name).and_then(|at| values.get_mut(at));
        if let Some(slot @ None) = slot {
            *slot = Some(attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|why| broken(why.to_string()))?);
        }
    }
    Ok(values)
}

fn whole(value: Option<&str>) -> Option<i64> {
    value?.trim().parse().ok()
}

/// Longitude and latitude, if they are given; they must be on the globe.
fn place(node: i64, longitude: Option<&str>, latitude: Option<&str>) -> Result<Option<Point>, Fault> {
    if longitude.is_none() && latitude.is_none() {
        return Ok(None);
    }
    let number = |value: Option<&str>, limit: f64| value?.trim().parse().ok().filter(|v: &f64| v.abs() <= limit);
    match (number(longitude, 180.0), number(latitude, 90.0)) {
        (Some(longitude), Some(latitude)) => Ok(Some([longitude, latitude])),
        _ => {
            let shown = |value: Option<&str>| text::short(value.unwrap_or("nothing"));
            let (longitude, latitude) = (shown(longitude), shown(latitude));
            Err(Fault::Broken(format!("node {node} has longitude {longitude} and latitude {latitude}, which is no place on the globe")))
        }
    }
}
