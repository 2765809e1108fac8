//! Are the metres metres? Doors, walls and floors have usual sizes all over the world.

use planwalk_types::{Element, ElementKind, FloorPlan, Form, Level, Plan, Pt2};

use super::finding::{Finding, ScaleSign};
use super::ground::{Ground, Place};
use super::spaces::area_m2;
use super::{End, Passage};

/// One walks through doors from and up to these widths, metres.
const DOOR_M: [f64; 2] = [0.6, 2.5];
/// So wide is the median door, metres: 1.34 m in a villa of double doors (Piet Hein's house).
const MEDIAN_DOOR_M: [f64; 2] = [0.6, 1.4];
/// So wide is the median opening where no doors are drawn, metres: some are passages, and some are what furniture leaves. It is 2.05 m in
/// an office whose glass and doors are not drawn (Hilti's floor 1).
const MEDIAN_OPENING_M: [f64; 2] = [0.5, 2.2];
/// Fewer doors say nothing of a scale.
const FEWEST: usize = 3;
/// So thick are walls, metres: from a sheet of glass to a castle.
const WALL_M: [f64; 2] = [0.02, 1.5];
/// What is thicker than this between two rooms is ground that nobody has seen, metres.
const SOLID_M: f64 = 3.0;
/// So large are storeys, m²: from a cabin to the largest hall there is.
const FLOOR_M2: [f64; 2] = [4.0, 500_000.0];

/// How wide doors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Widths {
    /// Whether these are drawn doors; else they are openings between rooms.
    pub are_doors: bool,
    /// How many were measured.
    pub count: usize,
    /// Half of them are wider, metres.
    pub median_m: f64,
    /// One of ten is narrower, metres.
    pub p10_m: f64,
    /// One of ten is wider, metres.
    pub p90_m: f64,
}

impl Widths {
    /// Of the drawn doors that have a width; without any, of the openings between rooms.
    pub(super) fn of(level: &Level, passages: &[Passage]) -> Option<Self> {
        let doors: Vec<f64> = level.elements.iter().filter_map(door).map(|(_, width_m)| width_m).collect();
        if !doors.is_empty() {
            return Self::among(true, doors);
        }
        let between_rooms = |p: &&Passage| !p.is_door && p.ends.iter().all(|end| matches!(end, End::Room(_)));
        Self::among(false, passages.iter().filter(between_rooms).map(|p| p.width_m).collect())
    }

    fn among(are_doors: bool, mut widths: Vec<f64>) -> Option<Self> {
        widths.sort_by(f64::total_cmp);
        let at = |share: f64| widths.get((share * widths.len().saturating_sub(1) as f64).round() as usize).copied();
        Some(Self { are_doors, count: widths.len(), median_m: at(0.5)?, p10_m: at(0.1)?, p90_m: at(0.9)? })
    }
}

/// A door's middle and width; a door given as a point has none.
fn door(element: &Element) -> Option<(Pt2<Plan>, f64)> {
    if element.kind != ElementKind::Door {
        return None;
    }
    let middle = |a: Pt2<Plan>, b: Pt2<Plan>| Pt2::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y));
    match &element.form {
        Form::Line(line) => {
            let (first, last) = (line.first()?, line.last()?);
            let length: f64 = line.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
            (length > 0.0).then_some((middle(*first, *last), length))
        }
        Form::Area(rings) => {
            // As long as its longest side, seen along it: doors are rectangles, turned anyhow.
            let ring = rings.first()?;
            let sides = || ring.iter().zip(ring.iter().cycle().skip(1));
            let (a, b) = sides().max_by(|x, y| x.0.distance(*x.1).total_cmp(&y.0.distance(*y.1)))?;
            let length = a.distance(*b);
            let (c, s) = ((b.x - a.x) / length, (b.y - a.y) / length);
            let along = || ring.iter().map(|p| c * (p.x - a.x) + s * (p.y - a.y));
            let across = || ring.iter().map(|p| c * (p.y - a.y) - s * (p.x - a.x));
            let span = |low: f64, high: f64| (0.5 * (low + high), high - low);
            let (u, width) = span(along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
            let (v, _) = span(across().fold(f64::INFINITY, f64::min), across().fold(f64::NEG_INFINITY, f64::max));
            (width.is_finite() && width > 0.0).then(|| (Pt2::new(a.x + c * u - s * v, a.y + s * u + c * v), width))
        }
        Form::Spot(_) => None,
    }
}

/// Doors that are none by their width.
pub(super) fn doors(level: &Level) -> Vec<Finding> {
    let is_odd = |(_, width_m): &(Pt2<Plan>, f64)| *width_m < DOOR_M[0] - 1e-6 || *width_m > DOOR_M[1] + 1e-6;
    level.elements.iter().filter_map(door).filter(is_odd).map(|(at, width_m)| Finding::DoorWidth { at, width_m }).collect()
}

/// How thick walls are that are drawn as areas, metres: so thick that half of their length is thicker.
pub(super) fn wall_m(level: &Level) -> Option<f64> {
    let mut walls: Vec<(f64, f64)> = level.elements.iter().filter(|e| e.kind == ElementKind::Wall).filter_map(wall).collect();
    walls.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = walls.iter().map(|wall| wall.1).sum();
    let mut so_far = 0.0;
    walls
        .into_iter()
        .find(|wall| {
            so_far += wall.1;
            so_far >= 0.5 * whole
        })
        .map(|wall| wall.0)
}

/// Thickness and length around, metres.
fn wall(element: &Element) -> Option<(f64, f64)> {
    let Form::Area(rings) = &element.form else { return None };
    let around: f64 = rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1))).map(|(a, b)| a.distance(*b)).sum();
    (around > 0.0).then(|| (2.0 * area_m2(&element.form) / around, around))
}

/// How thick what stands between two open cells is, metres, along rows and columns: half of it is thicker. What is black to the rim of
/// the picture stands between nothing.
fn between_m(ground: &Ground) -> Option<f64> {
    let mut counts: Vec<usize> = vec![0; (SOLID_M / ground.cell_m) as usize + 1];
    let mut count_runs = |cells: &mut dyn Iterator<Item = usize>| {
        let (mut run, mut is_after_open) = (0, false);
        for i in cells {
            match ground.places[i] {
                Place::Built => run += 1,
                place => {
                    if is_after_open && place == Place::Open {
                        counts.get_mut(run).into_iter().for_each(|count| *count += 1);
                    }
                    (run, is_after_open) = (0, place == Place::Open);
                }
            }
        }
    };
    for row in 0..ground.height {
        count_runs(&mut (row * ground.width..(row + 1) * ground.width));
    }
    for column in 0..ground.width {
        count_runs(&mut (0..ground.height).map(|row| row * ground.width + column));
    }
    // Open cells side by side.
    counts[0] = 0;
    let whole: usize = counts.iter().sum();
    let mut so_far = 0;
    let median = counts.iter().position(|count| {
        so_far += count;
        2 * so_far >= whole
    })?;
    (whole > 0).then_some(median as f64 * ground.cell_m)
}

/// What says that the scale is wrong.
pub(super) fn signs(plan: &FloorPlan, ground: &Ground, level: &Level, widths: Option<&Widths>) -> Vec<Finding> {
    let doors = widths.filter(|widths| widths.count >= FEWEST);
    let median = doors.map(|w| (ScaleSign::Doors, w.median_m, if w.are_doors { MEDIAN_DOOR_M } else { MEDIAN_OPENING_M }));
    // Lines have no thickness.
    let has_areas = level.elements.iter().any(|e| e.kind == ElementKind::Wall && matches!(e.form, Form::Area(_)));
    let walls = between_m(ground).filter(|_| has_areas).map(|thick| (ScaleSign::Walls, thick, WALL_M));
    let floor = Some((ScaleSign::Floor, plan.inside_area_m2(), FLOOR_M2));
    let is_odd = |(_, measured, [least, most]): &(ScaleSign, f64, [f64; 2])| measured < least || measured > most;
    let signs = [median, walls, floor].into_iter().flatten().filter(is_odd);
    signs.map(|(sign, measured, usual)| Finding::Scale { sign, measured, usual }).collect()
}
