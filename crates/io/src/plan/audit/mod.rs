//! What does a storey amount to, and what on it looks wrong? Rooms and the ways between them; findings, all at once.
//!
//! storey's elements ─▶ cells ─▶ `ground`: open, built, doors ─▶ rooms as drawn, or found by `regions` ─▶ `passages`
//!                                                                    └▶ names from the texts in them (`names`)
//! elements, rooms, passages ─▶ [`Finding`]s
//!
//! Rooms that the file draws as areas are kept. Where it draws none they are found between the walls, unless cells are too coarse to
//! see a doorway. Nothing of this is needed to localise anybody, and nothing of it changes the plan's cells.

mod facade;
mod finding;
mod ground;
mod isolated;
mod names;
mod passages;
mod reach;
mod regions;
mod scale;
mod sheets;
mod spaces;
mod strokes;

use planwalk_types::{Element, ElementKind, Form, Level, Plan, Pt2};

use super::{PlanFileError, vector};
pub use finding::{Finding, ScaleSign};
use ground::Ground;
pub(super) use names::labels;
pub use scale::Widths;
use spaces::Space;

/// [`Element::source`] of a room that no file draws: it was found between the walls, and changes no cell.
pub const FOUND: &str = "found between the walls";

/// A room.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// Its outline and holes, metres; its name; [`FOUND`] as its source where it was found.
    pub element: Element,
    /// Its floor, m².
    pub area_m2: f64,
    /// A place well inside of it.
    pub at: Pt2<Plan>,
}

/// What a passage leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum End {
    /// A room, an index into [`Audit::rooms`].
    Room(usize),
    /// Ground that is no room: a drawn floor, stairs, a lift; or what no room covers where rooms are drawn.
    Ground,
    /// Out of the building.
    Outdoors,
}

/// A way between two places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Its two ends.
    pub ends: [End; 2],
    /// Its middle.
    pub at: Pt2<Plan>,
    /// Clear width, metres.
    pub width_m: f64,
    /// Whether a door is drawn in it; else it is an opening.
    pub is_door: bool,
}

/// What can be said of a storey.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Audit {
    /// Rooms, from the bottom up.
    pub rooms: Vec<Room>,
    /// Ways between them.
    pub passages: Vec<Passage>,
    /// How wide the drawn doors are; without doors, the openings between rooms.
    pub widths: Option<Widths>,
    /// What looks wrong, by kind, the largest of each kind first.
    pub findings: Vec<Finding>,
}

impl Audit {
    /// Looks at a storey.
    ///
    /// # Errors
    /// [`PlanFileError`] where the storey cannot be drawn as cells.
    pub fn of(level: &Level) -> Result<Self, PlanFileError> {
        let plan = vector::draw(&level.elements, &mut Vec::new())?;
        let ground = Ground::of(&plan);
        let spaces = spaces::of(&ground, level)?;
        let ways = passages::between(&ground, &spaces.labels);
        let rooms: Vec<Room> = spaces.all.iter().filter_map(Space::room).collect();
        let passages: Vec<Passage> = ways.iter().map(|way| spaces.passage(way)).collect();
        let widths = Widths::of(level, &passages);
        let mut findings = scale::doors(level);
        if spaces::can_see_doorways(&ground) {
            findings.extend(reach::gaps(&passages));
            findings.extend(reach::unreachable(&ground, &spaces, &ways));
        }
        findings.extend(scale::signs(&plan, &ground, level, widths.as_ref()));
        findings.extend(strokes::short(level));
        findings.extend(strokes::doubled(level));
        findings.extend(isolated::specks(&ground));
        findings.extend(sheets::several(&ground));
        finding::sort(&mut findings);
        Ok(Self { rooms, passages, widths, findings })
    }

    /// The storey with its rooms: those found join it, drawn ones get their names, and what only named a room has done its part.
    pub fn complete(&self, level: &mut Level) {
        level.elements.retain(|element| !is_label(element));
        let is_room = |element: &&mut Element| element.kind == ElementKind::Room && matches!(element.form, Form::Area(_));
        let mut rooms = self.rooms.iter();
        for (drawn, room) in level.elements.iter_mut().filter(is_room).zip(rooms.by_ref()) {
            drawn.name.clone_from(&room.element.name);
        }
        level.elements.extend(rooms.map(|room| room.element.clone()));
    }
}

/// The storey without what was found on it, and without names that only stand in rooms: as other programs get it, which would take
/// both for ground that somebody drew.
pub fn as_drawn(level: &Level) -> Level {
    let elements = level.elements.iter().filter(|element| !is_remark(element)).cloned().collect();
    Level { ordinal: level.ordinal, name: level.name.clone(), elements }
}

/// Whether an element is only the name of the room that it stands in.
pub(super) fn is_label(element: &Element) -> bool {
    element.kind == ElementKind::Room && matches!(element.form, Form::Spot(_))
}

/// Whether an element says nothing of where the walls and the ground are.
pub(super) fn is_remark(element: &Element) -> bool {
    is_label(element) || (element.kind == ElementKind::Room && element.source.as_deref() == Some(FOUND))
}

#[cfg(test)]
mod tests;
