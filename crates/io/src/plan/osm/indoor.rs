//! Which rooms does a map show? Simple Indoor Tagging: `indoor=room|area|corridor|wall|column|door`, `level`, doors on outlines.
//!
//! way, multipolygon ─▶ kind and extent by its tags ─▶ elements on each of its storeys ─┐
//! door, window on an outline ─▶ a piece of that outline ────────────────────────────────┴─▶ storeys
//!
//! Source: <https://wiki.openstreetmap.org/wiki/Simple_Indoor_Tagging>; `buildingpart` is of the older IndoorOSM. Rooms have walls
//! although none are drawn. Steps, lifts, footways and platforms belong to a building only if they name a level or are `indoor`.
//! Pitfall: a closed `indoor=corridor` is an area, a closed footway is a line unless it says `area=yes`.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use planwalk_types::{Element, ElementKind, Form};

use super::super::PlanFileError;
use super::ground::{self, Ends, Ground, Place};
use super::levels::{self, Level};
use super::map::{Map, Relation, Tags, Way};
use crate::text;

/// Width of a corridor, a footway or stairs drawn as a line that do not tell theirs, metres.
const LINE_WIDTH_M: f64 = 2.0;
/// Width of a column drawn as a node that does not tell its own, metres.
const COLUMN_WIDTH_M: f64 = 0.4;
/// Keys that tell where an element comes from, the first one that is there.
const TOLD: [&str; 13] = [
    "indoor",
    "room",
    "buildingpart",
    "stairs",
    "elevator",
    "door",
    "entrance",
    "window",
    "highway",
    "barrier",
    "railway",
    "public_transport",
    "building:part",
];

/// How a shape's nodes are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extent {
    Area,
    Line,
    Ribbon(Ends),
}

/// Whether the file shows rooms, walls or columns: what makes it the map of a building.
pub(super) fn is_indoors(map: &Map) -> bool {
    map.ways.iter().map(|way| &way.tags).chain(map.relations.iter().map(|relation| &relation.tags)).any(|tags| {
        tags.is("indoor", &["room", "area", "corridor", "wall", "column", "pillar"]) || tags.says("room") || tags.says("buildingpart")
    })
}

/// What the tags of a node, a line or a closed way stand for inside of a building.
fn kind(tags: &Tags, closed: bool) -> Option<ElementKind> {
    let indoor = tags.get("indoor").unwrap_or("");
    let placed = tags.get("level").or_else(|| tags.get("repeat_on")).is_some() || tags.says("indoor");
    // In car parks one walks where the cars drive.
    let is_route = tags.is("highway", &["footway", "path", "pedestrian", "corridor", "service"]);
    let is_platform = tags.is("railway", &["platform"]) || tags.is("public_transport", &["platform"]);
    match indoor {
        // The outline of a whole storey: it only gives it a name.
        "level" | "no" => None,
        "wall" if tags.is("material", &["glass"]) || tags.is("wall", &["glass"]) => Some(ElementKind::Window),
        "wall" | "column" | "pillar" => Some(ElementKind::Wall),
        "door" => Some(ElementKind::Door),
        "window" => Some(ElementKind::Window),
        _ if tags.is("room", &["stairs", "staircase"]) || tags.is("buildingpart", &["verticalpassage"]) => Some(ElementKind::Stairs),
        _ if tags.is("room", &["elevator", "lift"]) => Some(ElementKind::Lift),
        _ if placed && (tags.says("stairs") || tags.is("highway", &["steps"])) => Some(ElementKind::Stairs),
        _ if placed && (tags.says("elevator") || tags.is("highway", &["elevator"])) => Some(ElementKind::Lift),
        "room" | "corridor" => Some(ElementKind::Room),
        "area" => Some(ElementKind::Floor),
        _ if tags.says("room") || tags.says("buildingpart") => Some(ElementKind::Room),
        _ if !placed => None,
        // A closed way with a door is what the door leads into.
        _ if tags.get("door").is_some() && !closed => Some(ElementKind::Door),
        _ if tags.says("window") && !closed => Some(ElementKind::Window),
        _ if tags.is("barrier", &["wall"]) => Some(ElementKind::Wall),
        _ if is_route || is_platform || tags.says("building:part") => Some(ElementKind::Floor),
        // A shop, a counter: nobody says whether it has walls.
        "yes" if closed && tags.get("highway").or_else(|| tags.get("barrier")).is_none() => Some(ElementKind::Floor),
        _ => None,
    }
}

/// How a way of this kind is drawn; `None` for areas whose outline is not closed.
fn extent(kind: ElementKind, tags: &Tags, closed: bool) -> Option<Extent> {
    let ends = if kind == ElementKind::Stairs { Ends::Flat } else { Ends::Round };
    let is_room = tags.is("indoor", &["room", "area", "corridor"]) || tags.says("room");
    let is_route = tags.says("highway") && !is_room && !tags.is("highway", &["elevator"]);
    let is_area = match kind {
        ElementKind::Wall | ElementKind::Window => tags.says("area") || tags.is("indoor", &["column", "pillar"]),
        _ if is_route => tags.says("area"),
        _ => !tags.is("area", &["no"]),
    };
    match kind {
        _ if closed && is_area => Some(Extent::Area),
        ElementKind::Wall | ElementKind::Window | ElementKind::Door => Some(Extent::Line),
        ElementKind::Stairs | ElementKind::Lift => Some(Extent::Ribbon(ends)),
        _ if is_route || tags.is("indoor", &["corridor"]) => Some(Extent::Ribbon(ends)),
        _ => None,
    }
}

/// A door or a window at a node; an opening without a door in it (`door=no`) is a way through as well.
fn opening_kind(tags: &Tags) -> Option<ElementKind> {
    if tags.get("door").is_some() || tags.says("entrance") || tags.is("indoor", &["door"]) {
        Some(ElementKind::Door)
    } else if tags.says("window") || tags.is("indoor", &["window"]) {
        Some(ElementKind::Window)
    } else {
        None
    }
}

/// Where an element comes from.
fn source(what: &str, id: i64, tags: &Tags) -> String {
    let told = TOLD.iter().find_map(|key| tags.get(key).map(|value| format!(", {key}={value}")));
    format!("{what} {id}{}", told.unwrap_or_default())
}

/// A ring of a multipolygon: its nodes, the first one repeated, and their places.
type Ring = (Vec<i64>, Vec<Place>);

/// An outline or a wall that doors may lie on.
struct Outline<'m> {
    nodes: Cow<'m, [i64]>,
    levels: BTreeSet<Level>,
    /// Walls are asked before rooms, rooms before open ground.
    rank: u8,
}

/// What is on each storey, with the storeys that stairs and lifts are on.
pub(super) type Storeys = BTreeMap<Level, Vec<(Element, BTreeSet<Level>)>>;

/// What is drawn so far.
pub(super) struct Indoor<'g, 'm> {
    ground: &'g mut Ground<'m>,
    storeys: Storeys,
    outlines: Vec<Outline<'m>>,
    without_level: usize,
    unread_levels: BTreeMap<String, usize>,
    not_closed: usize,
    astray: usize,
}

/// Draws what is indoors, storey by storey.
pub(super) fn draw(ground: &mut Ground, notes: &mut Vec<String>) -> Result<Storeys, PlanFileError> {
    let map = ground.map;
    let mut indoor = Indoor {
        ground,
        storeys: BTreeMap::new(),
        outlines: Vec::new(),
        without_level: 0,
        unread_levels: BTreeMap::new(),
        not_closed: 0,
        astray: 0,
    };
    let drawn_as_relation = outer_ways(map);
    for way in &map.ways {
        let kind = kind(&way.tags, way.is_closed());
        if kind.is_some() && drawn_as_relation.get(&way.id) != kind.as_ref() {
            indoor.way(way)?;
        }
    }
    for relation in &map.relations {
        indoor.relation(relation)?;
    }
    indoor.nodes()?;
    indoor.openings()?;
    indoor.tell(notes);
    Ok(indoor.storeys)
}

/// Tags of a multipolygon; those of its first outer way where it has none itself, as was usual once.
fn tags_of<'m>(map: &'m Map, relation: &'m Relation) -> &'m Tags {
    let first = || relation.members.iter().filter(|m| !m.inner).find_map(|m| map.way(m.way));
    if kind(&relation.tags, true).is_some() { &relation.tags } else { first().map_or(&relation.tags, |way| &way.tags) }
}

/// Ways that are outlines of multipolygons, and what those are.
fn outer_ways(map: &Map) -> HashMap<i64, ElementKind> {
    let mut outer = HashMap::new();
    for relation in &map.relations {
        if let Some(kind) = kind(tags_of(map, relation), true) {
            outer.extend(relation.members.iter().filter(|m| !m.inner).map(|m| (m.way, kind)));
        }
    }
    outer
}

impl<'m> Indoor<'_, 'm> {
    /// The storeys that tags name: the ground floor if they name none, nothing if they are not to be understood.
    fn levels(&mut self, tags: &Tags) -> Result<BTreeSet<Level>, PlanFileError> {
        let mut all = BTreeSet::new();
        let values: Vec<&str> = ["level", "repeat_on"].iter().filter_map(|key| tags.get(key)).collect();
        for value in &values {
            match levels::parse(value) {
                Some(levels) => all.extend(levels),
                None => *self.unread_levels.entry(text::short(value)).or_default() += 1,
            }
        }
        if values.is_empty() {
            self.without_level += 1;
            all.insert(Level::default());
        }
        self.ground.spend(all.len())?;
        Ok(all)
    }

    fn push(&mut self, levels: &BTreeSet<Level>, element: Element) -> Result<(), PlanFileError> {
        let points = element.form.points().count();
        let leads = matches!(element.kind, ElementKind::Stairs | ElementKind::Lift) && levels.len() > 1;
        let joins = if leads { levels.clone() } else { BTreeSet::new() };
        for level in levels {
            self.ground.spend(points + joins.len())?;
            self.storeys.entry(*level).or_default().push((element.clone(), joins.clone()));
        }
        Ok(())
    }

    fn way(&mut self, way: &'m Way) -> Result<(), PlanFileError> {
        let tags = &way.tags;
        let Some(kind) = kind(tags, way.is_closed()) else { return Ok(()) };
        let Some(extent) = extent(kind, tags, way.is_closed()) else {
            self.not_closed += 1;
            return Ok(());
        };
        // A line of a guessed width has no walls: it would block the corridors that it meets.
        let kind = if kind == ElementKind::Room && extent != Extent::Area { ElementKind::Floor } else { kind };
        let levels = self.levels(tags)?;
        let forms: Vec<Form> = match extent {
            Extent::Area => self.ground.ring(&way.nodes)?.map(|ring| Form::Area(vec![ring])).into_iter().collect(),
            Extent::Line => self.ground.lines(&way.nodes)?.into_iter().map(Form::Line).collect(),
            Extent::Ribbon(ends) => {
                let width_m = ground::width_m(tags).unwrap_or(LINE_WIDTH_M);
                let (rings, _) = self.ground.ribbon(&way.nodes, width_m, ends)?;
                rings.into_iter().map(|ring| Form::Area(vec![ring])).collect()
            }
        };
        for form in forms {
            let element = Element { name: tags.label(), source: Some(source("way", way.id, tags)), ..Element::new(kind, form) };
            self.push(&levels, element)?;
        }
        if !matches!(extent, Extent::Ribbon(_)) {
            self.outline(kind, Cow::Borrowed(&way.nodes), levels);
        }
        Ok(())
    }

    fn relation(&mut self, relation: &'m Relation) -> Result<(), PlanFileError> {
        let map = self.ground.map;
        let tags = tags_of(map, relation);
        let Some(kind) = kind(tags, true) else { return Ok(()) };
        let levels = self.levels(tags)?;
        let (outlines, mut holes) = (self.rings(relation, false)?, self.rings(relation, true)?);
        let is_one = outlines.len() == 1;
        for (nodes, outline) in outlines {
            self.ground.spend(outline.len().saturating_mul(holes.len()))?;
            let is_in = |hole: &[Place]| is_one || hole.first().is_some_and(|place| ground::is_inside(*place, &outline));
            let inside: Vec<_> = holes.extract_if(.., |(_, hole)| is_in(hole)).collect();
            let rings = std::iter::once(outline).chain(inside.iter().map(|(_, hole)| hole.clone())).collect();
            let source = Some(source("relation", relation.id, tags));
            let element = Element { name: tags.label(), source, ..Element::new(kind, Form::Area(rings)) };
            self.push(&levels, element)?;
            for nodes in std::iter::once(nodes).chain(inside.into_iter().map(|(nodes, _)| nodes)) {
                self.outline(kind, Cow::Owned(nodes), levels.clone());
            }
        }
        Ok(())
    }

    /// Outlines or holes of a multipolygon, as nodes and in metres.
    fn rings(&mut self, relation: &Relation, inner: bool) -> Result<Vec<Ring>, PlanFileError> {
        let map = self.ground.map;
        let mut seen = HashSet::new();
        let members = relation.members.iter().filter(|member| member.inner == inner && seen.insert(member.way));
        let (mut ways, mut unknown) = (Vec::new(), 0);
        for member in members {
            match map.way(member.way) {
                Some(way) => {
                    self.ground.spend(way.nodes.len())?;
                    ways.push(way.nodes.as_slice());
                }
                None => unknown += 1,
            }
        }
        let (rings, left_over) = ground::stitch(&ways);
        self.not_closed += usize::from(left_over + unknown > 0);
        let mut placed = Vec::new();
        for nodes in rings {
            if let Some(ring) = self.ground.ring(&nodes)? {
                placed.push((nodes, ring));
            }
        }
        Ok(placed)
    }

    fn outline(&mut self, kind: ElementKind, nodes: Cow<'m, [i64]>, levels: BTreeSet<Level>) {
        let rank = match kind {
            ElementKind::Wall | ElementKind::Window => 0,
            ElementKind::Room => 1,
            ElementKind::Stairs | ElementKind::Lift => 2,
            ElementKind::Floor => 3,
            ElementKind::Door => return,
        };
        self.outlines.push(Outline { nodes, levels, rank });
    }

    /// Lifts and columns drawn as nodes.
    fn nodes(&mut self) -> Result<(), PlanFileError> {
        let map = self.ground.map;
        for (node, tags) in &map.places {
            let kind = kind(tags, false).filter(|kind| matches!(kind, ElementKind::Lift | ElementKind::Wall));
            let (Some(kind), Some(place)) = (kind, self.ground.place(*node)) else { continue };
            let column = || ground::octagon(place, ground::width_m(tags).unwrap_or(COLUMN_WIDTH_M));
            let form = match kind {
                ElementKind::Lift => Form::Spot(place),
                _ if tags.is("indoor", &["column", "pillar"]) => Form::Area(vec![column()]),
                _ => continue,
            };
            let levels = self.levels(tags)?;
            self.push(&levels, Element { name: tags.label(), source: Some(source("node", *node, tags)), ..Element::new(kind, form) })?;
        }
        Ok(())
    }

    /// Doors and windows at nodes: on the outlines that they are part of, on the storeys that both are on.
    fn openings(&mut self) -> Result<(), PlanFileError> {
        let map = self.ground.map;
        let found = map.places.iter().filter_map(|(node, tags)| Some((*node, (opening_kind(tags)?, tags))));
        let openings: HashMap<i64, (ElementKind, &Tags)> = found.collect();
        // Where it says nothing, a door is wherever its wall is.
        let stated = |tags: &Tags| {
            let values = ["level", "repeat_on"].iter().filter_map(|key| levels::parse(tags.get(key)?));
            values.reduce(|mut all, more| {
                all.extend(more);
                all
            })
        };
        let mut outlines = std::mem::take(&mut self.outlines);
        outlines.sort_by_key(|outline| outline.rank);
        let mut drawn: HashSet<(i64, Level)> = HashSet::new();
        for outline in &outlines {
            for (at, node) in outline.nodes.iter().enumerate() {
                let Some((kind, tags)) = openings.get(node) else { continue };
                let own = stated(tags);
                self.ground.spend(own.as_ref().map_or(0, BTreeSet::len) + outline.levels.len())?;
                let shared = outline.levels.iter().filter(|level| own.as_ref().is_none_or(|own| own.contains(level)));
                let new: BTreeSet<Level> = shared.copied().filter(|level| drawn.insert((*node, *level))).collect();
                if !new.is_empty() {
                    self.opening(*kind, *node, tags, Some((&outline.nodes, at)), &new)?;
                }
            }
        }
        let on_outlines: HashSet<i64> = drawn.iter().map(|(node, _)| *node).collect();
        for (node, tags) in &map.places {
            let Some(kind) = opening_kind(tags) else { continue };
            let own = stated(tags).unwrap_or_default();
            let left: BTreeSet<Level> = own.into_iter().filter(|level| drawn.insert((*node, *level))).collect();
            self.astray += usize::from(left.is_empty() && !on_outlines.contains(node));
            if !left.is_empty() {
                self.opening(kind, *node, tags, None, &left)?;
            }
        }
        Ok(())
    }

    /// One door or window: as wide as it says, if it lies on an outline and says so.
    fn opening(
        &mut self,
        kind: ElementKind,
        node: i64,
        tags: &Tags,
        on: Option<(&[i64], usize)>,
        levels: &BTreeSet<Level>,
    ) -> Result<(), PlanFileError> {
        let Some(place) = self.ground.place(node) else { return Ok(()) };
        let wide = on.zip(ground::width_m(tags)).and_then(|((nodes, at), width_m)| self.ground.opening(nodes, at, width_m));
        let form = wide.unwrap_or(Form::Spot(place));
        self.push(levels, Element { name: tags.label(), source: Some(source("node", node, tags)), ..Element::new(kind, form) })
    }

    fn tell(&self, notes: &mut Vec<String>) {
        if self.without_level > 0 {
            notes.push(format!("{} objects name no level: they are taken for the ground floor's", self.without_level));
        }
        let unread: usize = self.unread_levels.values().sum();
        if let Some(value) = self.unread_levels.keys().next() {
            notes.push(format!(
                "{unread} objects name a level that is no number, list or range (e.g. \"{value}\"): they are left out there"
            ));
        }
        if self.not_closed > 0 {
            notes.push(format!("{} outlines of rooms or areas are not closed, and are left out", self.not_closed));
        }
        if self.astray > 0 {
            notes.push(format!("{} doors, entrances and windows lie on no outline that is drawn and name no level: left out", self.astray));
        }
    }
}

/// Names of storeys: `level:ref` or the name of an `indoor=level`, else the `level:ref` of something that is there.
pub(super) fn level_names(ground: &mut Ground) -> Result<BTreeMap<Level, String>, PlanFileError> {
    let map = ground.map;
    let ways = map.ways.iter().map(|way| &way.tags);
    let all: Vec<&Tags> = ways.chain(map.relations.iter().map(|r| &r.tags)).chain(map.places.iter().map(|(_, tags)| tags)).collect();
    let mut names = BTreeMap::new();
    for is_level in [true, false] {
        for tags in all.iter().filter(|tags| tags.is("indoor", &["level"]) == is_level) {
            let own_name = || tags.get("name").filter(|_| is_level);
            let (Some(level), Some(name)) = (tags.get("level"), tags.get("level:ref").or_else(own_name)) else { continue };
            let levels = levels::parse(level).unwrap_or_default();
            ground.spend(levels.len())?;
            // Several storeys have several names, or the name is of none of them.
            let parts: Vec<&str> = if levels.len() == 1 { vec![name] } else { name.split(';').map(str::trim).collect() };
            if parts.len() == levels.len() {
                for (level, part) in levels.into_iter().zip(parts) {
                    names.entry(level).or_insert_with(|| part.to_owned());
                }
            }
        }
    }
    Ok(names)
}
