//! What does `plan_info.json` say? What is on a plan: storeys, rooms, doors, what looks wrong; and how far one must walk on it to know
//! where one is.

use std::collections::BTreeMap;

use planwalk_locate::{Ambiguity, ConfusablePair};
use planwalk_types::{Cell, FloorPlan, Seed};
use serde::{Deserialize, Serialize};

use crate::result::{InputEntry, PoseEntry};

/// Name and version of the schema. A field may be added under the same number; what changes or goes raises it.
pub const SCHEMA: &str = "planwalk-plan-info/2";

/// The whole of `plan_info.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanInfo {
    /// [`SCHEMA`].
    pub schema: String,
    /// Version of the program.
    pub version: String,
    /// What chance grew from.
    pub seed: Seed,
    /// Bottom-left corner, metres.
    pub origin_m: [f64; 2],
    /// Width and height, metres.
    pub size_m: [f64; 2],
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Columns and rows.
    pub size_cells: [usize; 2],
    /// Floor that is likelier inside than outside, m².
    pub inside_m2: f64,
    /// How many cells are what.
    pub cells: CellCounts,
    /// Doorways: cells of doors that touch each other are one.
    pub doors: usize,
    /// The building: storeys, rooms, ways between them, and what looks wrong.
    pub building: BuildingEntry,
    /// How far one must walk to know where one is, where it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambiguity: Option<AmbiguityEntry>,
    /// What went in.
    pub inputs: Vec<InputEntry>,
    /// What was decided while the plan was read.
    pub notes: Vec<String>,
}

/// What is drawn of a building.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BuildingEntry {
    /// What the file was read as, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    /// Metres in one unit, or pixel, of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metres_per_unit: Option<f64>,
    /// Where the scale comes from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale_from: Option<String>,
    /// Where on the globe it is, if that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub georeference: Option<GeoreferenceEntry>,
    /// Name of the storey that the cells above are of.
    pub storey: String,
    /// All storeys, from below.
    pub storeys: Vec<StoreyEntry>,
    /// Stairs and lifts.
    pub connections: Vec<ConnectionEntry>,
    /// What its shapes come from, the commonest first: layers, kinds of features, colours.
    #[serde(default)]
    pub sources: Vec<SourceEntry>,
}

/// A layer, a kind of feature or a colour.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceEntry {
    /// What it is called.
    pub source: String,
    /// Shapes that come from it.
    pub shapes: usize,
}

/// Where on the globe a plan is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GeoreferenceEntry {
    /// Of the anchor; degrees, WGS 84.
    pub longitude_deg: f64,
    /// Degrees, WGS 84.
    pub latitude_deg: f64,
    /// Direction of the plan's y axis: radians from north, clockwise.
    pub bearing_rad: f64,
    /// The point of the plan that lies there, metres.
    pub anchor_m: [f64; 2],
    /// Metres on the ground in a metre of the plan.
    pub scale: f64,
}

/// A storey.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StoreyEntry {
    /// Order from below.
    pub ordinal: i32,
    /// What people call it.
    pub name: String,
    /// How many elements of each kind are drawn on it.
    pub elements: BTreeMap<String, usize>,
    /// Rooms, from the bottom up.
    pub rooms: Vec<RoomEntry>,
    /// Ways between rooms, and out.
    pub passages: Vec<PassageEntry>,
    /// How wide its doors are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub widths: Option<WidthsEntry>,
    /// What looks wrong, numbered from 1 in this order, as `plan render` marks it.
    pub findings: Vec<FindingEntry>,
}

/// A room.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RoomEntry {
    /// Its name or number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its floor, m².
    pub area_m2: f64,
    /// A place inside of it, metres.
    pub at_m: [f64; 2],
    /// Whether it was found between the walls; else the file draws it.
    pub found: bool,
    /// Places in [`StoreyEntry::rooms`], counted from 0, of the rooms that one gets to from it at once.
    pub leads_to: Vec<usize>,
}

/// A way between two places.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PassageEntry {
    /// Its two sides: a room's place in [`StoreyEntry::rooms`], counted from 0; or `ground` (no room of its own) or `outdoors`.
    pub between: [SideEntry; 2],
    /// Its middle, metres.
    pub at_m: [f64; 2],
    /// Clear width, metres.
    pub width_m: f64,
    /// Whether a door is drawn in it.
    pub door: bool,
}

/// A side of a passage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SideEntry {
    /// A room, by its place in the list.
    Room(usize),
    /// `ground` or `outdoors`.
    Other(String),
}

/// How wide doors are, metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WidthsEntry {
    /// Whether these are drawn doors; else they are openings between rooms.
    pub are_doors: bool,
    /// How many were measured.
    pub count: usize,
    /// Half are wider.
    pub median_m: f64,
    /// One of ten is narrower.
    pub p10_m: f64,
    /// One of ten is wider.
    pub p90_m: f64,
}

/// Something that looks wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FindingEntry {
    /// What sort of thing: `outline-gap`, `unreachable`, `door-width`, `scale`, `short-wall`, `doubled-wall`, `letters`,
    /// `several-drawings`.
    pub kind: String,
    /// Where, metres; absent where it is the whole plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_m: Option<[f64; 2]>,
    /// Its numbers, by name and unit.
    pub figures: BTreeMap<String, f64>,
    /// It in words.
    pub says: String,
    /// What to do about it.
    pub remedy: String,
}

/// Stairs or a lift.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConnectionEntry {
    /// `stairs` or `lift`.
    pub kind: String,
    /// What people call it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Ordinals of the storeys that it joins, rising.
    pub ordinals: Vec<i32>,
    /// Its middle on the lowest of them, metres.
    pub at_m: [f64; 2],
}

/// Cells by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CellCounts {
    /// Nothing drawn.
    pub free: usize,
    /// Walls.
    pub wall: usize,
    /// What the plan does not know.
    pub unknown: usize,
    /// Doorways.
    pub door: usize,
    /// Glass.
    pub window: usize,
}

/// How ambiguous the plan is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AmbiguityEntry {
    /// Walks that were compared with all others.
    pub walks: usize,
    /// Metres after which half of the walks know their place; absent when fewer do within the longest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub median_m: Option<f64>,
    /// The same for nine of ten.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p90_m: Option<f64>,
    /// Share of the walks that do not know their place at their end, 0..=1.
    pub never: f64,
    /// Share of the walks that know their place, and median share of the plan's poses elsewhere that still fit, by metres walked.
    pub by_length: Vec<LengthEntry>,
    /// Places that are confused longest, worst first.
    pub pairs: Vec<PairEntry>,
    /// Share of the walks whose own place fitted to their end: how far the comparison can be trusted, 0..=1.
    pub kept_themselves: f64,
    /// Distance between the poses that were compared, metres.
    pub pitch_m: f64,
}

/// After so many metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LengthEntry {
    /// Metres walked.
    pub length_m: f64,
    /// Share of the walks that know their place.
    pub known: f64,
    /// Median share of all poses that are elsewhere and still fit.
    pub alike: f64,
}

/// Two poses from which a walk looks the same.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairEntry {
    /// One start.
    pub a: PoseEntry,
    /// The other.
    pub b: PoseEntry,
    /// Metres walked from both before they differ.
    pub alike_m: f64,
    /// Whether they still looked the same when the walk ended.
    pub to_the_end: bool,
}

impl PlanInfo {
    /// What is on this plan.
    pub fn new(plan: &FloorPlan, building: BuildingEntry, seed: Seed, inputs: Vec<InputEntry>, notes: Vec<String>) -> Self {
        let (width, height) = plan.size_m();
        Self {
            schema: SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed,
            origin_m: [plan.origin().x, plan.origin().y],
            size_m: [width, height],
            cell_m: plan.cell_m(),
            size_cells: [plan.width(), plan.height()],
            inside_m2: plan.inside_area_m2(),
            cells: counts(plan),
            doors: doors(plan),
            building,
            ambiguity: None,
            inputs,
            notes,
        }
    }

    /// Pretty JSON with a newline at the end.
    pub fn to_json(&self) -> String {
        // Every field is a number, a string or a list of them: nothing here can fail to be written.
        serde_json::to_string_pretty(self).map(|text| text + "\n").unwrap_or_default()
    }
}

fn counts(plan: &FloorPlan) -> CellCounts {
    plan.cells().iter().fold(CellCounts::default(), |mut counts, cell| {
        *match cell {
            Cell::Free => &mut counts.free,
            Cell::Wall => &mut counts.wall,
            Cell::Unknown => &mut counts.unknown,
            Cell::Door => &mut counts.door,
            Cell::Window => &mut counts.window,
        } += 1;
        counts
    })
}

/// Groups of touching door cells.
fn doors(plan: &FloorPlan) -> usize {
    let (width, height) = (plan.width(), plan.height());
    let mut waiting: Vec<bool> = plan.cells().iter().map(|cell| *cell == Cell::Door).collect();
    let mut groups = 0;
    for start in 0..waiting.len() {
        if !std::mem::take(&mut waiting[start]) {
            continue;
        }
        groups += 1;
        let mut open = vec![start];
        while let Some(i) = open.pop() {
            let (column, row) = (i % width, i / width);
            for r in row.saturating_sub(1)..(row + 2).min(height) {
                for c in column.saturating_sub(1)..(column + 2).min(width) {
                    if std::mem::take(&mut waiting[r * width + c]) {
                        open.push(r * width + c);
                    }
                }
            }
        }
    }
    groups
}

impl From<&Ambiguity> for AmbiguityEntry {
    fn from(found: &Ambiguity) -> Self {
        let n = found.walks.len().max(1) as f64;
        let share = |holds: &dyn Fn(&planwalk_locate::TriedWalk) -> bool| found.walks.iter().filter(|w| holds(w)).count() as f64 / n;
        let by_length = found.lengths_m.iter().enumerate().map(|(i, length_m)| {
            let mut alike: Vec<f64> = found.walks.iter().filter_map(|w| w.alike.get(i).copied()).collect();
            alike.sort_by(f64::total_cmp);
            let known = share(&|w| w.known_after_m.is_some_and(|m| m <= *length_m));
            LengthEntry { length_m: *length_m, known, alike: alike.get(alike.len() / 2).copied().unwrap_or(0.0) }
        });
        Self {
            walks: found.walks.len(),
            median_m: found.median_m,
            p90_m: found.p90_m,
            never: found.never,
            by_length: by_length.collect(),
            pairs: found.pairs.iter().map(PairEntry::from).collect(),
            kept_themselves: share(&|w| w.kept_itself),
            pitch_m: found.pitch_m,
        }
    }
}

impl From<&ConfusablePair> for PairEntry {
    fn from(pair: &ConfusablePair) -> Self {
        Self { a: PoseEntry::from(&pair.a), b: PoseEntry::from(&pair.b), alike_m: pair.alike_m, to_the_end: pair.to_the_end }
    }
}

/// The ambiguity in a sentence.
pub fn words(found: &Ambiguity) -> String {
    let whole = found.lengths_m.last().copied().unwrap_or(0.0);
    if found.walks.is_empty() {
        return "There is no floor inside of this plan to walk on.".to_owned();
    }
    let after = |metres: Option<f64>| metres.map_or_else(|| format!("not within {whole:.0} m"), |m| format!("after {m:.0} m"));
    format!(
        "Half of the walks know their place {}, nine of ten {}; {} do not within {whole:.0} m.",
        after(found.median_m),
        after(found.p90_m),
        crate::words::percent(found.never)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Pt2;

    #[test]
    fn doors_are_groups_of_cells() {
        let cells = "#####\n#D.D#\n#D.##\n#####".split('\n').flat_map(|line| {
            line.chars().map(|c| match c {
                '#' => Cell::Wall,
                'D' => Cell::Door,
                _ => Cell::Free,
            })
        });
        let plan = FloorPlan::new(Pt2::new(1.0, 2.0), 0.5, 5, 4, cells.collect()).unwrap();
        let info = PlanInfo::new(&plan, BuildingEntry::default(), Seed(0), vec![], vec![]);
        assert_eq!((info.doors, info.cells.door, info.cells.free), (2, 3, 2));
        assert_eq!(info.cells.wall, 15);
        assert_eq!(serde_json::from_str::<PlanInfo>(&info.to_json()).unwrap(), info);
    }
}
