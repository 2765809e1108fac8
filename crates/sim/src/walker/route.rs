//! Which way through the rooms? Shortest ways over free space that keep to the middle, from room to room.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use planwalk_types::{Plan, Pt2, StreamRng};
use rand::RngExt;

use crate::building::{Building, NO_ROOM, RoomKind};
use crate::world::World;

/// Cell of the map, metres: a door of 1 m is ten cells.
const CELL_M: f64 = 0.1;
/// The same where doors are narrow: the middle of a doorway must not fall between two cells.
const FINE_CELL_M: f64 = 0.07;
/// A narrower door asks for the fine cells, metres.
const NARROW_DOOR_M: f64 = 0.95;
/// Cells closer to something than this are not walked; a little over the clearance, for the sway and for cut corners.
const KEEP_OFF_M: f64 = 0.42;
/// The same where doors are narrow or not known.
const KEEP_OFF_NARROW_M: f64 = 0.38;
/// Clearance is not measured beyond this, metres: nothing here asks for more.
const LOOK_M: f64 = 1.0;
/// A larger room has goals in each of its parts, m².
const LARGE_M2: f64 = 100.0;
/// Side of such a part, metres.
const PART_M: f64 = 8.0;
/// No place.
const NOWHERE: u32 = u32::MAX;
/// Where there is more room than this, one does not care.
const AT_EASE_M: f64 = 0.85;
/// Rooms' goals lie at least this far from everything, metres: room to turn round.
const GOAL_CLEAR_M: f64 = 0.8;
/// Half of the window that turns the corners of the grid into arcs, metres.
const SMOOTH_M: f64 = 0.45;
/// Distance of the points of a route, metres.
const POINT_M: f64 = 0.05;

/// Free space and how far it is from everything.
pub(super) struct FreeMap {
    origin: Pt2<Plan>,
    cell_m: f64,
    width: usize,
    height: usize,
    keep_off_m: f64,
    clearance: Vec<f32>,
    /// Cost of a step into each cell, straight and across: dearer near things.
    step_cost: Vec<[f32; 2]>,
    /// Which cells one can reach from each other; [`NOWHERE`] for those that are not walked.
    component: Vec<u32>,
    /// Places to go: rooms, or parts of large ones.
    places: Vec<Place>,
}

/// Somewhere to go.
struct Place {
    kind: RoomKind,
    /// Cells in which a goal may lie.
    goals: Vec<usize>,
}

/// A way, one point every 5 cm.
pub(super) struct Route {
    pub points: Vec<[f64; 2]>,
}

impl Route {
    pub fn length_m(&self) -> f64 {
        self.points.len().saturating_sub(1) as f64 * POINT_M
    }

    /// The point `along_m` from the start.
    pub fn at(&self, along_m: f64) -> [f64; 2] {
        let place = (along_m / POINT_M).clamp(0.0, self.points.len().saturating_sub(1) as f64);
        let i = (place as usize).min(self.points.len().saturating_sub(2));
        let (Some(a), Some(b)) = (self.points.get(i), self.points.get(i + 1).or(self.points.get(i))) else { return [0.0, 0.0] };
        let t = place - i as f64;
        [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
    }
}

impl FreeMap {
    pub fn new(building: &Building, world: &World) -> Self {
        let (low, high) = building.bounds();
        let narrow = building.doors.iter().any(|door| door.open && door.width_m() < NARROW_DOOR_M);
        let cell_m = if narrow { FINE_CELL_M } else { CELL_M };
        let keep_off_m = if narrow || building.doors.is_empty() { KEEP_OFF_NARROW_M } else { KEEP_OFF_M };
        let (width, height) = (((high.x - low.x) / cell_m).ceil() as usize + 1, ((high.y - low.y) / cell_m).ceil() as usize + 1);
        let count = width * height;
        let mut map = Self {
            origin: low,
            cell_m,
            width,
            height,
            keep_off_m,
            clearance: Vec::new(),
            step_cost: Vec::new(),
            component: vec![NOWHERE; count],
            places: Vec::new(),
        };
        let rooms = building.room_cells([low.x, low.y], cell_m, [width, height]);
        // Outdoors is not walked; in doorways there may be no room.
        let indoors = |i: usize| rooms[i] != NO_ROOM || !building.doors.is_empty();
        map.clearance = (0..count).map(|i| if indoors(i) { world.clearance_up_to(map.centre(i), LOOK_M) as f32 } else { 0.0 }).collect();
        let step_cost = |clear: &f32| {
            let crowded = ((AT_EASE_M - f64::from(*clear)) / AT_EASE_M).max(0.0);
            [1.0, std::f64::consts::SQRT_2].map(|way| (cell_m * way * (1.0 + 12.0 * crowded * crowded)) as f32)
        };
        map.step_cost = map.clearance.iter().map(step_cost).collect();
        map.find_components();
        map.find_places(building, &rooms);
        map
    }

    fn walked(&self, i: usize) -> bool {
        f64::from(self.clearance[i]) >= self.keep_off_m
    }

    /// Floods what can be walked.
    fn find_components(&mut self) {
        let mut next = 0;
        let mut open = Vec::new();
        for start in 0..self.clearance.len() {
            if !self.walked(start) || self.component[start] != NOWHERE {
                continue;
            }
            self.component[start] = next;
            open.push(start);
            while let Some(cell) = open.pop() {
                for near in self.neighbours(cell) {
                    if self.walked(near) && self.component[near] == NOWHERE {
                        self.component[near] = next;
                        open.push(near);
                    }
                }
            }
            next += 1;
        }
    }

    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, y, width, height) = (cell % self.width, cell / self.width, self.width, self.height);
        WAYS.into_iter().filter_map(move |(dx, dy)| {
            let (nx, ny) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            (nx < width && ny < height).then_some(ny * width + nx)
        })
    }

    /// Goals of each room; of each part of a large one.
    fn find_places(&mut self, building: &Building, rooms: &[u16]) {
        // The first place of each room, its lower left corner, and its parts along x.
        let mut parts: Vec<(usize, Pt2<Plan>, usize)> = Vec::new();
        for room in &building.rooms {
            let (low, high) = room.bounds();
            let large = room.area_m2() > LARGE_M2;
            let along = |from: f64, to: f64| if large { ((to - from) / PART_M).ceil().max(1.0) as usize } else { 1 };
            parts.push((self.places.len(), low, along(low.x, high.x)));
            let count = along(low.x, high.x) * along(low.y, high.y);
            self.places.extend((0..count).map(|_| Place { kind: room.kind, goals: Vec::new() }));
        }
        for (i, room) in rooms.iter().enumerate() {
            if f64::from(self.clearance[i]) < GOAL_CLEAR_M {
                continue;
            }
            let Some((first, low, columns)) = parts.get(usize::from(*room)) else { continue };
            let next = parts.get(usize::from(*room) + 1).map_or(self.places.len(), |p| p.0);
            let p = self.centre(i);
            let part = |v: f64| (v / PART_M).max(0.0) as usize;
            let place = if next - first == 1 { *first } else { first + part(p.y - low.y) * columns + part(p.x - low.x).min(columns - 1) };
            self.places[place.min(next - 1)].goals.push(i);
        }
    }

    fn centre(&self, i: usize) -> Pt2<Plan> {
        let (x, y) = ((i % self.width) as f64 + 0.5, (i / self.width) as f64 + 0.5);
        Pt2::new(self.origin.x + x * self.cell_m, self.origin.y + y * self.cell_m)
    }

    /// A way from room to room that is at least `wanted_m` long, or as long as it gets; `None` where one cannot walk at all.
    pub fn route(&self, wanted_m: f64, rng: &mut StreamRng) -> Option<Route> {
        let goals = |r: usize| &self.places[r].goals;
        let mut usable: Vec<usize> = (0..self.places.len()).filter(|r| !goals(*r).is_empty()).collect();
        let mut start_rooms: Vec<usize> = usable.iter().copied().filter(|r| self.places[*r].kind != RoomKind::Corridor).collect();
        if start_rooms.is_empty() {
            start_rooms.clone_from(&usable);
        }
        if start_rooms.is_empty() {
            return None;
        }
        let mut room = start_rooms[rng.random_range(0..start_rooms.len())];
        let mut cell = goals(room)[rng.random_range(0..goals(room).len())];
        let mut visits = vec![0usize; self.places.len()];
        visits[room] += 1;
        let mut cells = vec![cell];
        let (mut length_m, mut failures) = (0.0, 0);
        // A margin over what is wanted: smoothing and the grid's diagonals shorten the way.
        while length_m < 1.15 * wanted_m + 2.0 && failures < 12 {
            // A room less often visited, by chance.
            let next =
                (0..3).map(|_| usable[rng.random_range(0..usable.len())]).min_by_key(|r| visits[*r] + usize::from(*r == room) * 100)?;
            let goal = goals(next)[rng.random_range(0..goals(next).len())];
            if next == room {
                failures += 1;
                continue;
            }
            let Some(leg) = self.leg(cell, goal) else {
                // Behind a shut door: it stays so.
                usable.retain(|r| *r != next);
                continue;
            };
            length_m += leg.windows(2).map(|w| self.centre(w[0]).distance(self.centre(w[1]))).sum::<f64>();
            cells.extend_from_slice(&leg[1..]);
            (room, cell) = (next, goal);
            visits[next] += 1;
            failures = 0;
        }
        let corners: Vec<[f64; 2]> = cells.iter().map(|i| [self.centre(*i).x, self.centre(*i).y]).collect();
        let fine = resample(&corners);
        Some(Route { points: resample(&smooth(&fine)) })
    }

    /// Cheapest way between two cells (A*), each step dearer near things.
    fn leg(&self, from: usize, to: usize) -> Option<Vec<usize>> {
        if self.component[from] != self.component[to] || self.component[from] == NOWHERE {
            return None;
        }
        let count = self.width * self.height;
        let (mut cost, mut came) = (vec![f32::INFINITY; count], vec![u32::MAX; count]);
        let target = self.centre(to);
        // As the crow flies; never more than the way itself.
        let ahead = |cell: usize| {
            let p = self.centre(cell);
            ((p.x - target.x) * (p.x - target.x) + (p.y - target.y) * (p.y - target.y)).sqrt() as f32
        };
        let mut open = BinaryHeap::new();
        cost[from] = 0.0;
        open.push(Open { total: ahead(from), cell: from as u32 });
        while let Some(Open { total, cell }) = open.pop() {
            let cell = cell as usize;
            if cell == to {
                return Some(retrace(&came, from, to));
            }
            if total > cost[cell] + ahead(cell) + 1e-4 {
                continue;
            }
            let (x, y) = (cell % self.width, cell / self.width);
            for (dx, dy) in WAYS {
                let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { continue };
                if nx >= self.width || ny >= self.height {
                    continue;
                }
                let next = ny * self.width + nx;
                if self.component[next] == NOWHERE {
                    continue;
                }
                let through = cost[cell] + self.step_cost[next][usize::from(dx != 0 && dy != 0)];
                if through < cost[next] {
                    cost[next] = through;
                    came[next] = cell as u32;
                    open.push(Open { total: through + ahead(next), cell: next as u32 });
                }
            }
        }
        None
    }
}

/// To the eight cells around a cell.
const WAYS: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)];

/// A cell on A*'s list, cheapest first, then by number so that ties fall the same way everywhere.
struct Open {
    total: f32,
    cell: u32,
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.total.total_cmp(&self.total).then(other.cell.cmp(&self.cell))
    }
}
impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Open {}

fn retrace(came: &[u32], from: usize, to: usize) -> Vec<usize> {
    let mut cells = vec![to];
    let mut cell = to;
    while cell != from {
        cell = came[cell] as usize;
        cells.push(cell);
    }
    cells.reverse();
    cells
}

/// Points every 5 cm along a line.
fn resample(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = line.first().copied().into_iter().collect();
    let mut left = POINT_M;
    for pair in line.windows(2) {
        let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        let length = libm::hypot(dx, dy);
        let mut at = left;
        while at <= length {
            points.push([pair[0][0] + at / length * dx, pair[0][1] + at / length * dy]);
            at += POINT_M;
        }
        left = at - length;
    }
    points
}

/// Mean over a window along the line: two passes make corners into arcs of continuous curvature.
fn smooth(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let reach = (SMOOTH_M / POINT_M / 2.0) as usize;
    let pass = |line: &[[f64; 2]]| -> Vec<[f64; 2]> {
        (0..line.len())
            .map(|i| {
                let r = reach.min(i).min(line.len() - 1 - i);
                let window = &line[i - r..=i + r];
                let n = window.len() as f64;
                [window.iter().map(|p| p[0]).sum::<f64>() / n, window.iter().map(|p| p[1]).sum::<f64>() / n]
            })
            .collect()
    };
    pass(&pass(line))
}
