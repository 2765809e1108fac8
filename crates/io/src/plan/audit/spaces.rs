//! Which piece of floor is which room? Areas as drawn, the rest divided at its narrow places; each with outline, area and name.

use planwalk_types::{Cell, Element, ElementKind, Form, Level, Plan, Pt2};

use super::super::cells::Pixels;
use super::super::{PlanFileError, outline};
use super::ground::{Ground, Place};
use super::passages::Way;
use super::regions::{self, NONE, OUTDOORS, Regions};
use super::{End, FOUND, Passage, Room, is_label, names};

/// Cells wider than this show no doorway, metres.
const COARSEST_M: f64 = 0.2;

/// Most cells that areas and outlines go through, together: some seconds. A real storey needs a hundredth of it.
const WORK_LIMIT: u64 = 1_000_000_000;

/// A piece of floor.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Space {
    /// What is drawn, or was found.
    pub element: Element,
    /// Whether it is a room; else it only leads somewhere.
    pub is_room: bool,
    pub area_m2: f64,
    /// Well inside.
    pub at: Pt2<Plan>,
}

/// All pieces of floor of a storey.
pub(super) struct Spaces {
    /// In the order of their labels, which begin at 1.
    pub all: Vec<Space>,
    /// Label of each cell.
    pub labels: Vec<u32>,
    /// Place of each among the rooms.
    rooms: Vec<Option<usize>>,
}

impl Space {
    pub fn room(&self) -> Option<Room> {
        self.is_room.then(|| Room { element: self.element.clone(), area_m2: self.area_m2, at: self.at })
    }
}

impl Spaces {
    /// The way, by rooms.
    pub fn passage(&self, way: &Way) -> Passage {
        let end = |side: u32| match side {
            OUTDOORS => End::Outdoors,
            label => self.rooms.get(label as usize - 1).copied().flatten().map_or(End::Ground, End::Room),
        };
        Passage { ends: way.sides.map(end), at: way.at, width_m: way.width_m, is_door: way.is_door }
    }
}

/// Whether cells are fine enough for a doorway to be told from a wall.
pub(super) fn can_see_doorways(ground: &Ground) -> bool {
    ground.cell_m <= COARSEST_M
}

/// The storey's pieces of floor.
pub(super) fn of(ground: &Ground, level: &Level) -> Result<Spaces, PlanFileError> {
    let drawn: Vec<&Element> = level.elements.iter().filter(|e| e.kind.is_ground() && matches!(e.form, Form::Area(_))).collect();
    let has_rooms = drawn.iter().any(|e| e.kind == ElementKind::Room);
    // Ground without rooms is the building's outline, or what a robot has seen: rooms are to be found in it.
    let drawn = if has_rooms { drawn } else { Vec::new() };
    let mut work_left = WORK_LIMIT;
    let labels = paint(ground, &drawn, &mut work_left)?;
    let count = drawn.len() as u32;
    let Regions { labels, count } =
        if can_see_doorways(ground) { regions::divide(ground, labels, count) } else { Regions { labels, count } };
    let cells = cells_by_label(&labels, count);
    let mut all = Vec::with_capacity(cells.len());
    for (n, cells) in cells.iter().enumerate() {
        let element = match drawn.get(n) {
            Some(element) => (*element).clone(),
            None => found(ground, cells, &mut work_left)?,
        };
        let is_room = element.kind == ElementKind::Room && (!has_rooms || n < drawn.len());
        all.push(Space { area_m2: area_m2(&element.form), at: heart(ground, cells, &element.form), element, is_room });
    }
    name(ground, &labels, level, &mut all);
    let mut next = 0..;
    let rooms = all.iter().map(|space| if space.is_room { next.next() } else { None }).collect();
    Ok(Spaces { all, labels, rooms })
}

/// Labels of drawn areas, large ones first, so that a room in a hall is not the hall.
fn paint(ground: &Ground, drawn: &[&Element], work_left: &mut u64) -> Result<Vec<u32>, PlanFileError> {
    let mut labels = vec![NONE; ground.places.len()];
    let mut order: Vec<usize> = (0..drawn.len()).collect();
    // Rooms lie on floors, whatever their sizes.
    order.sort_by(|a, b| {
        let of = |n: usize| (drawn[n].kind != ElementKind::Floor, -area_m2(&drawn[n].form));
        of(*a).0.cmp(&of(*b).0).then(of(*a).1.total_cmp(&of(*b).1))
    });
    for n in order {
        let Form::Area(rings) = &drawn[n].form else { continue };
        let cells = inside(ground, rings);
        spend(work_left, cells.len())?;
        for i in cells {
            if matches!(ground.places[i], Place::Open | Place::Unknown) {
                labels[i] = n as u32 + 1;
            }
        }
    }
    Ok(labels)
}

fn spend(work_left: &mut u64, work: usize) -> Result<(), PlanFileError> {
    *work_left = work_left.checked_sub(work as u64).ok_or(PlanFileError::TooIntricate { limit: WORK_LIMIT })?;
    Ok(())
}

/// Cells whose middles are inside some rings, by the even-odd rule.
fn inside(ground: &Ground, rings: &[Vec<Pt2<Plan>>]) -> Vec<usize> {
    let to_row = |y: f64| (y - ground.origin.y) / ground.cell_m - 0.5;
    let ys = || rings.iter().flatten().map(|p| to_row(p.y));
    let (low, high) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
    let rows = low.ceil().max(0.0) as usize..((high.floor() + 1.0).max(0.0) as usize).min(ground.height);
    // The rows that each side crosses, so that many sides and many rows are not multiplied.
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); rows.len()];
    for (a, b) in rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1))) {
        let (lower, upper) = if a.y <= b.y { (a, b) } else { (b, a) };
        let first = (to_row(lower.y).ceil().max(rows.start as f64) as usize).max(rows.start);
        let end = (to_row(upper.y).ceil().max(0.0) as usize).min(rows.end);
        for row in first..end {
            let share = (row as f64 - to_row(lower.y)) / (to_row(upper.y) - to_row(lower.y));
            crossings[row - rows.start].push((lower.x + share * (upper.x - lower.x) - ground.origin.x) / ground.cell_m - 0.5);
        }
    }
    let mut cells = Vec::new();
    for (row, mut crossings) in rows.zip(crossings) {
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            let columns = pair[0].ceil().max(0.0) as usize..(pair[1].ceil().max(0.0) as usize).min(ground.width);
            cells.extend(columns.map(|column| row * ground.width + column));
        }
    }
    cells
}

fn cells_by_label(labels: &[u32], count: u32) -> Vec<Vec<usize>> {
    let mut cells = vec![Vec::new(); count as usize];
    for (i, label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        if let Some(cells) = cells.get_mut(*label as usize - 1) {
            cells.push(i);
        }
    }
    cells
}

/// The outline of found cells: that of the largest piece, if a corner is all that holds others to it.
fn found(ground: &Ground, cells: &[usize], work_left: &mut u64) -> Result<Element, PlanFileError> {
    let columns = || cells.iter().map(|i| i % ground.width);
    let rows = || cells.iter().map(|i| i / ground.width);
    let (left, right) = (columns().min().unwrap_or(0), columns().max().unwrap_or(0));
    let (lower, upper) = (rows().min().unwrap_or(0), rows().max().unwrap_or(0));
    let (width, height) = (right - left + 1, upper - lower + 1);
    spend(work_left, width * height)?;
    let mut pixels = Pixels { width, height, cells: vec![Cell::Free; width * height] };
    for i in cells {
        pixels.cells[(upper - i / ground.width) * width + i % ground.width - left] = Cell::Wall;
    }
    let corner = [ground.origin.x + left as f64 * ground.cell_m, ground.origin.y + lower as f64 * ground.cell_m];
    let pieces = outline::trace(&pixels, ground.cell_m)?.elements;
    let mut form = pieces.into_iter().map(|e| e.form).max_by(|a, b| area_m2(a).total_cmp(&area_m2(b))).unwrap_or(Form::Area(Vec::new()));
    for point in form.points_mut() {
        *point = Pt2::new(point.x + corner[0], point.y + corner[1]);
    }
    Ok(Element { source: Some(FOUND.to_owned()), ..Element::new(ElementKind::Room, form) })
}

/// Area of the outline without its holes, m².
pub(super) fn area_m2(form: &Form) -> f64 {
    let ring = |ring: &[Pt2<Plan>]| {
        let Some(first) = ring.first() else { return 0.0 };
        // About its first corner: eastings of millions would leave no digits.
        let at = |p: &Pt2<Plan>| (p.x - first.x, p.y - first.y);
        let pairs = ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| (at(a), at(b)));
        0.5 * pairs.map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>().abs()
    };
    match form {
        Form::Area(rings) => {
            rings.split_first().map_or(0.0, |(outline, holes)| (ring(outline) - holes.iter().map(|hole| ring(hole)).sum::<f64>()).max(0.0))
        }
        Form::Line(_) | Form::Spot(_) => 0.0,
    }
}

/// The cell of a room that is nearest to its middle; the middle of its corners where it has no cells.
fn heart(ground: &Ground, cells: &[usize], form: &Form) -> Pt2<Plan> {
    let mean = |points: &mut dyn Iterator<Item = Pt2<Plan>>| {
        let (x, y, n) = points.fold((0.0, 0.0, 0.0), |(x, y, n), p| (x + p.x, y + p.y, n + 1.0));
        (n > 0.0).then(|| Pt2::new(x / n, y / n))
    };
    let Some(middle) = mean(&mut cells.iter().map(|i| ground.centre(*i))) else {
        return mean(&mut form.points()).unwrap_or(ground.origin);
    };
    let centres = cells.iter().map(|i| ground.centre(*i));
    centres.min_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle))).unwrap_or(middle)
}

/// Rooms without a name are called by what is written in them.
fn name(ground: &Ground, labels: &[u32], level: &Level, all: &mut [Space]) {
    let mut written: Vec<Vec<names::Written>> = vec![Vec::new(); all.len()];
    for element in level.elements.iter().filter(|e| is_label(e)) {
        let (Form::Spot(at), Some(text)) = (&element.form, &element.name) else { continue };
        let label = ground.index(*at).map_or(NONE, |i| labels[i]);
        if let Some(written) = (label != NONE).then(|| written.get_mut(label as usize - 1)).flatten() {
            written.push(names::Written { at: *at, text: text.clone() });
        }
    }
    for (space, name) in all.iter_mut().zip(names::choose(written)) {
        if space.is_room && space.element.name.is_none() {
            space.element.name = name;
        }
    }
}
