//! What is drawn of a building? Storeys of walls, doors, windows and rooms as shapes, before any of it becomes cells.
//!
//! Metres in the frame of the plan: x right, y **up**. A [`crate::FloorPlan`] is one storey of this on a grid.

use crate::space::{Plan, Pt2};

/// What a shape of a building is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ElementKind {
    /// Stops people and light.
    Wall,
    /// Glass: stops people only.
    Window,
    /// A way through a wall.
    Door,
    /// Ground to walk on that is no room of its own.
    Floor,
    /// A room or a corridor: an area with its own outline, and perhaps a name.
    Room,
    /// Stairs, an escalator or a ramp: ground that leads to another storey.
    Stairs,
    /// A lift, likewise.
    Lift,
}

impl ElementKind {
    /// Every kind.
    pub const ALL: [Self; 7] = [Self::Wall, Self::Window, Self::Door, Self::Floor, Self::Room, Self::Stairs, Self::Lift];

    /// Whether one walks on it: all but walls, windows and doors.
    pub fn is_ground(self) -> bool {
        !matches!(self, Self::Wall | Self::Window | Self::Door)
    }

    /// One word, as files have it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Wall => "wall",
            Self::Window => "window",
            Self::Door => "door",
            Self::Floor => "floor",
            Self::Room => "room",
            Self::Stairs => "stairs",
            Self::Lift => "lift",
        }
    }
}

/// Where a shape is.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// Rings, the first the outline, the others holes, whichever way they run; the last point need not repeat the first.
    Area(Vec<Vec<Pt2<Plan>>>),
    /// A chain of straight pieces.
    Line(Vec<Pt2<Plan>>),
    /// A place.
    Spot(Pt2<Plan>),
}

impl Form {
    /// Its rings, its line or its place, as chains of points.
    pub fn chains(&self) -> impl Iterator<Item = &[Pt2<Plan>]> {
        let (rings, chain) = match self {
            Self::Area(rings) => (rings.as_slice(), None),
            Self::Line(line) => (&[][..], Some(line.as_slice())),
            Self::Spot(spot) => (&[][..], Some(std::slice::from_ref(spot))),
        };
        rings.iter().map(Vec::as_slice).chain(chain)
    }

    /// All of its points.
    pub fn points(&self) -> impl Iterator<Item = Pt2<Plan>> {
        self.chains().flatten().copied()
    }

    /// The same, to be moved.
    pub fn points_mut(&mut self) -> impl Iterator<Item = &mut Pt2<Plan>> {
        let (rings, chain) = match self {
            Self::Area(rings) => (rings.as_mut_slice(), Default::default()),
            Self::Line(line) => (Default::default(), line.as_mut_slice()),
            Self::Spot(spot) => (Default::default(), std::slice::from_mut(spot)),
        };
        rings.iter_mut().flatten().chain(chain)
    }
}

/// One thing drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// What it is.
    pub kind: ElementKind,
    /// Where.
    pub form: Form,
    /// What people call it: a room's name or number.
    pub name: Option<String>,
    /// Where it comes from: a layer, a feature, a colour; for people who look for a mistake.
    pub source: Option<String>,
    /// Ordinals of the storeys that stairs or a lift join, as the source says; lowest first. Empty where it says nothing.
    pub joins: Vec<i32>,
}

impl Element {
    /// An element of which nothing else is known.
    pub fn new(kind: ElementKind, form: Form) -> Self {
        Self { kind, form, name: None, source: None, joins: Vec::new() }
    }
}

/// One storey.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Level {
    /// Order from below; 0 is the ground floor where the source says so, else the lowest.
    pub ordinal: i32,
    /// What the source calls it.
    pub name: String,
    /// What is drawn on it, in the source's order.
    pub elements: Vec<Element>,
}

/// Where on the globe a building is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Georeference {
    /// Longitude of the anchor, degrees, WGS 84.
    pub longitude_deg: f64,
    /// Latitude of it.
    pub latitude_deg: f64,
    /// Direction of the plan's y axis there: radians from north, clockwise as compasses count.
    pub bearing_rad: f64,
    /// The point of the plan that lies there: (0, 0) as a rule, but within the building where the plan's metres are a map's grid.
    pub anchor: Pt2<Plan>,
    /// Metres on the ground in a metre of the plan: 1 as a rule; a map's grid is off by up to 0.1 %, a plan's own scale by what it is
    /// wrong.
    pub scale: f64,
}

impl Georeference {
    /// A plan whose (0, 0) lies there, and whose metres are true.
    pub fn at_origin(longitude_deg: f64, latitude_deg: f64, bearing_rad: f64) -> Self {
        Self { longitude_deg, latitude_deg, bearing_rad, anchor: Pt2::new(0.0, 0.0), scale: 1.0 }
    }
}

/// A building.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Building {
    /// Its storeys, lowest first.
    pub levels: Vec<Level>,
    /// Where it is, if that is known.
    pub georeference: Option<Georeference>,
}

impl Building {
    /// A building of one storey.
    pub fn of_one_level(elements: Vec<Element>) -> Self {
        Self { levels: vec![Level { ordinal: 0, name: "0".to_owned(), elements }], georeference: None }
    }
}
