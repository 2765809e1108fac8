//! How bright is it here, and in which room? Ceiling lamps, a baked map of their light, and rooms by cell.
//!
//! Large rooms are cut into zones of a few lamps each, so that whoever looks at the ceiling asks only the lamps that hang there.

use planwalk_types::{Plan, Pt2, Seed};
use rand::RngExt;

use crate::building::{Building, NO_ROOM, Room, RoomKind};

/// Cell of the map of light, metres: lamps are 2.7 m up, so light changes slowly.
const LIGHT_CELL_M: f64 = 0.25;
/// Cell of the map of rooms, metres: the border between two floors is hidden under a door's leaf.
const ROOM_CELL_M: f64 = 0.06;
/// More lamps than these make a room fall into zones.
const MANY_LAMPS: usize = 24;
/// Side of a zone, metres; the lamps of its own and of the zones around it light it up.
const ZONE_M: f64 = 7.8;
/// Least distance of lamps in rooms that are no rectangles, metres.
const APART_M: f64 = 2.4;

/// A bright panel in the ceiling.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lamp {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl Lamp {
    fn middle(&self) -> [f64; 2] {
        [0.5 * (self.low[0] + self.high[0]), 0.5 * (self.low[1] + self.high[1])]
    }
}

/// Light and rooms by place.
#[derive(Debug, Clone)]
pub(crate) struct Light {
    origin: [f64; 2],
    size: [usize; 2],
    levels: Vec<f32>,
    room_size: [usize; 2],
    /// Zone of each cell.
    rooms: Vec<u16>,
    /// The kind of room of each zone.
    pub kinds: Vec<RoomKind>,
    /// Lamps of each zone.
    pub lamps: Vec<Vec<Lamp>>,
}

/// How a room falls into zones: the first one's number, and how many there are along x and y from its lower left corner.
struct Zones {
    first: usize,
    low: [f64; 2],
    count: [usize; 2],
}

impl Zones {
    fn of(&self, x: f64, y: f64) -> [usize; 2] {
        let along = |v: f64, axis: usize| (((v - self.low[axis]) / ZONE_M).max(0.0) as usize).min(self.count[axis] - 1);
        [along(x, 0), along(y, 1)]
    }

    fn number(&self, [i, j]: [usize; 2]) -> usize {
        self.first + j * self.count[0] + i
    }
}

impl Light {
    pub fn new(building: &Building, seed: Seed) -> Self {
        let (low, high) = building.bounds();
        let origin = [low.x - 0.5, low.y - 0.5];
        let count = |cell: f64| [((high.x - low.x + 1.0) / cell).ceil() as usize + 1, ((high.y - low.y + 1.0) / cell).ceil() as usize + 1];
        let (size, room_size) = (count(LIGHT_CELL_M), count(ROOM_CELL_M));
        let mut rng = seed.derive("light", 0);
        let base: Vec<f64> = building.rooms.iter().map(|_| rng.random_range(0.50..0.66)).collect();
        let (mut kinds, mut lamps, mut zones) = (Vec::new(), Vec::new(), Vec::new());
        for (i, room) in building.rooms.iter().enumerate() {
            let of_room = lamps_of(building, i);
            let (low, high) = room.bounds();
            let along = |from: f64, to: f64| if of_room.len() > MANY_LAMPS { ((to - from) / ZONE_M).ceil().max(1.0) as usize } else { 1 };
            let zone = Zones { first: kinds.len(), low: [low.x, low.y], count: [along(low.x, high.x), along(low.y, high.y)] };
            let total = zone.count[0] * zone.count[1];
            // Numbers fit into a cell: beyond that, which takes a floor of square kilometres, ceilings stay dark.
            if zone.first + total >= usize::from(NO_ROOM) {
                break;
            }
            kinds.resize(zone.first + total, room.kind);
            lamps.resize(zone.first + total, Vec::new());
            for lamp in of_room {
                let [x, y] = lamp.middle();
                lamps[zone.number(zone.of(x, y))].push(lamp);
            }
            zones.push(zone);
        }
        let levels = levels(building, &base, &zones, &lamps, origin, size);
        let mut rooms = building.room_cells(origin, ROOM_CELL_M, room_size);
        for (i, cell) in rooms.iter_mut().enumerate() {
            if let Some(zone) = zones.get(usize::from(*cell)) {
                let at = |k: usize, axis: usize| origin[axis] + (k as f64 + 0.5) * ROOM_CELL_M;
                *cell = if zone.count == [1, 1] {
                    zone.first as u16
                } else {
                    zone.number(zone.of(at(i % room_size[0], 0), at(i / room_size[0], 1))) as u16
                };
            } else {
                *cell = NO_ROOM;
            }
        }
        Self { origin, size, levels, room_size, rooms, kinds, lamps }
    }

    /// Brightness at a place, about 0.5..=1.1, interpolated.
    pub fn at(&self, x: f64, y: f64) -> f32 {
        let u = ((x - self.origin[0]) / LIGHT_CELL_M - 0.5).clamp(0.0, (self.size[0] - 1) as f64 - 1e-6);
        let v = ((y - self.origin[1]) / LIGHT_CELL_M - 0.5).clamp(0.0, (self.size[1] - 1) as f64 - 1e-6);
        let (i, j) = (u as usize, v as usize);
        let (a, b) = ((u - i as f64) as f32, (v - j as f64) as f32);
        let row = &self.levels[j * self.size[0] + i..];
        let next = &self.levels[(j + 1) * self.size[0] + i..];
        (row[0] * (1.0 - a) + row[1] * a) * (1.0 - b) + (next[0] * (1.0 - a) + next[1] * a) * b
    }

    /// The zone at a place: a room, or a part of a large one. An index into `kinds` and `lamps`.
    pub fn room(&self, x: f64, y: f64) -> Option<usize> {
        let (u, v) = ((x - self.origin[0]) / ROOM_CELL_M, (y - self.origin[1]) / ROOM_CELL_M);
        if !(u >= 0.0 && v >= 0.0 && u < self.room_size[0] as f64 && v < self.room_size[1] as f64) {
            return None;
        }
        let zone = usize::from(self.rooms[v as usize * self.room_size[0] + u as usize]);
        (zone < self.kinds.len()).then_some(zone)
    }
}

/// Brightness of each cell of the map of light.
fn levels(building: &Building, base: &[f64], zones: &[Zones], lamps: &[Vec<Lamp>], origin: [f64; 2], size: [usize; 2]) -> Vec<f32> {
    let rooms = building.room_cells(origin, LIGHT_CELL_M, size);
    let centre = |k: usize, axis: usize| origin[axis] + (k as f64 + 0.5) * LIGHT_CELL_M;
    let level = |i: usize| {
        let room = usize::from(rooms[i]);
        let (Some(zone), Some(base)) = (zones.get(room), base.get(room)) else { return 0.6 };
        let p = Pt2::<Plan>::new(centre(i % size[0], 0), centre(i / size[0], 1));
        let [zi, zj] = zone.of(p.x, p.y);
        let near_i = zi.saturating_sub(1)..(zi + 2).min(zone.count[0]);
        let near = (zj.saturating_sub(1)..(zj + 2).min(zone.count[1])).flat_map(|j| near_i.clone().map(move |i| [i, j]));
        let sum: f64 = near.flat_map(|z| &lamps[zone.number(z)]).map(|lamp| glow(lamp, p)).sum();
        base + sum.min(0.5)
    };
    (0..size[0] * size[1]).map(|i| level(i) as f32).collect()
}

/// Panels of 0.6 m × 1.2 m, about 2.4 m apart.
fn lamps_of(building: &Building, index: usize) -> Vec<Lamp> {
    let room = &building.rooms[index];
    if room.is_rectangle() { lamps_in_rows(room) } else { lamps_apart(building, index) }
}

/// A grid of panels, the long side along the room.
fn lamps_in_rows(room: &Room) -> Vec<Lamp> {
    let (low, high) = room.bounds();
    let (w, h) = (high.x - low.x, high.y - low.y);
    let half = if w >= h { [0.6, 0.3] } else { [0.3, 0.6] };
    let (nx, ny) = ((w / 2.6).round().max(1.0) as usize, (h / 2.6).round().max(1.0) as usize);
    let mut lamps = Vec::with_capacity(nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            let x = low.x + w * (i as f64 + 0.5) / nx as f64;
            let y = low.y + h * (j as f64 + 0.5) / ny as f64;
            lamps.push(Lamp { low: [x - half[0], y - half[1]], high: [x + half[0], y + half[1]] });
        }
    }
    lamps
}

/// Panels wherever there is room for one, row by row, each [`APART_M`] from all others; at least one in the room's middle.
fn lamps_apart(building: &Building, index: usize) -> Vec<Lamp> {
    let room = &building.rooms[index];
    let (low, high) = room.bounds();
    let (w, h) = (high.x - low.x, high.y - low.y);
    let step = APART_M / 4.0;
    let (nx, ny) = ((w / step).floor().max(0.0) as usize, (h / step).floor().max(0.0) as usize);
    // The room on the same grid: whether a panel fits is asked for each place.
    let size = [2 * nx + 2, 2 * ny + 2];
    let cells = building.room_cells([low.x, low.y], 0.5 * step, size);
    let held = |x: f64, y: f64| {
        let (i, j) = ((x - low.x) / (0.5 * step), (y - low.y) / (0.5 * step));
        i >= 0.0
            && j >= 0.0
            && (i as usize) < size[0]
            && (j as usize) < size[1]
            && usize::from(cells[j as usize * size[0] + i as usize]) == index
    };
    let mut lamps: Vec<Lamp> = Vec::new();
    let half = if w >= h { [0.6, 0.3] } else { [0.3, 0.6] };
    // Rows from bottom to top: whatever is too near lies in the last few.
    let mut recent = 0;
    for j in 0..ny {
        let y = low.y + (j as f64 + 0.5) * step;
        while lamps.get(recent).is_some_and(|lamp| lamp.middle()[1] < y - APART_M) {
            recent += 1;
        }
        for i in 0..nx {
            let x = low.x + (i as f64 + 0.5) * step;
            let fits = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
                .iter()
                .all(|(a, b)| held(x + a * half[0] * 1.1, y + b * half[1] * 1.1));
            let free = || lamps[recent..].iter().all(|lamp| libm::hypot(lamp.middle()[0] - x, lamp.middle()[1] - y) >= APART_M - 1e-9);
            if fits && free() {
                lamps.push(Lamp { low: [x - half[0], y - half[1]], high: [x + half[0], y + half[1]] });
            }
        }
    }
    if lamps.is_empty() {
        let p = room.centre();
        lamps.push(Lamp { low: [p.x - 0.3, p.y - 0.3], high: [p.x + 0.3, p.y + 0.3] });
    }
    lamps
}

/// What a lamp adds to the brightness of what is below and around it.
fn glow(lamp: &Lamp, p: Pt2<Plan>) -> f64 {
    let (x, y) = (0.5 * (lamp.low[0] + lamp.high[0]), 0.5 * (lamp.low[1] + lamp.high[1]));
    let d2 = (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y);
    0.3 / (1.0 + d2 / 1.4)
}
