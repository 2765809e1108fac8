//! How bright is it here, and in which room? Ceiling lamps, a baked map of their light, and rooms by cell.

use planwalk_types::{Plan, Pt2, Seed};
use rand::RngExt;

use crate::building::{Building, RoomKind};

/// Cell of the map of light, metres: lamps are 2.7 m up, so light changes slowly.
const LIGHT_CELL_M: f64 = 0.25;
/// Cell of the map of rooms, metres: the border between two floors is hidden under a door's leaf.
const ROOM_CELL_M: f64 = 0.06;

/// A bright panel in the ceiling.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lamp {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

/// Light and rooms by place.
#[derive(Debug, Clone)]
pub(crate) struct Light {
    origin: [f64; 2],
    size: [usize; 2],
    levels: Vec<f32>,
    room_size: [usize; 2],
    rooms: Vec<u8>,
    /// The kind of each room.
    pub kinds: Vec<RoomKind>,
    /// Lamps of each room.
    pub lamps: Vec<Vec<Lamp>>,
}

impl Light {
    pub fn new(building: &Building, seed: Seed) -> Self {
        let (low, high) = building.bounds();
        let origin = [low.x - 0.5, low.y - 0.5];
        let count = |cell: f64| [((high.x - low.x + 1.0) / cell).ceil() as usize + 1, ((high.y - low.y + 1.0) / cell).ceil() as usize + 1];
        let (size, room_size) = (count(LIGHT_CELL_M), count(ROOM_CELL_M));
        let centre = |i: usize, size: [usize; 2], cell: f64| {
            Pt2::<Plan>::new(origin[0] + ((i % size[0]) as f64 + 0.5) * cell, origin[1] + ((i / size[0]) as f64 + 0.5) * cell)
        };
        let room_of = |p: Pt2<Plan>| building.room_at(p).map_or(u8::MAX, |room| room.min(254) as u8);
        let rooms = (0..room_size[0] * room_size[1]).map(|i| room_of(centre(i, room_size, ROOM_CELL_M))).collect();
        let lamps: Vec<Vec<Lamp>> = building.rooms.iter().map(lamps_of).collect();
        let mut rng = seed.derive("light", 0);
        let base: Vec<f64> = building.rooms.iter().map(|_| rng.random_range(0.50..0.66)).collect();
        let level = |p: Pt2<Plan>| match building.room_at(p) {
            None => 0.6,
            Some(room) => base[room] + lamps[room].iter().map(|lamp| glow(lamp, p)).sum::<f64>().min(0.5),
        };
        let levels = (0..size[0] * size[1]).map(|i| level(centre(i, size, LIGHT_CELL_M)) as f32).collect();
        Self { origin, size, levels, room_size, rooms, kinds: building.rooms.iter().map(|r| r.kind).collect(), lamps }
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

    /// The room at a place.
    pub fn room(&self, x: f64, y: f64) -> Option<usize> {
        let (u, v) = ((x - self.origin[0]) / ROOM_CELL_M, (y - self.origin[1]) / ROOM_CELL_M);
        if !(u >= 0.0 && v >= 0.0 && u < self.room_size[0] as f64 && v < self.room_size[1] as f64) {
            return None;
        }
        let room = usize::from(self.rooms[v as usize * self.room_size[0] + u as usize]);
        (room < self.kinds.len()).then_some(room)
    }
}

/// A grid of panels, 0.6 m × 1.2 m, about 2.4 m apart, the long side along the room.
fn lamps_of(room: &crate::building::Room) -> Vec<Lamp> {
    let (w, h) = (room.high.x - room.low.x, room.high.y - room.low.y);
    let half = if w >= h { [0.6, 0.3] } else { [0.3, 0.6] };
    let (nx, ny) = ((w / 2.6).round().max(1.0) as usize, (h / 2.6).round().max(1.0) as usize);
    let mut lamps = Vec::with_capacity(nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            let x = room.low.x + w * (i as f64 + 0.5) / nx as f64;
            let y = room.low.y + h * (j as f64 + 0.5) / ny as f64;
            lamps.push(Lamp { low: [x - half[0], y - half[1]], high: [x + half[0], y + half[1]] });
        }
    }
    lamps
}

/// What a lamp adds to the brightness of what is below and around it.
fn glow(lamp: &Lamp, p: Pt2<Plan>) -> f64 {
    let (x, y) = (0.5 * (lamp.low[0] + lamp.high[0]), 0.5 * (lamp.low[1] + lamp.high[1]));
    let d2 = (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y);
    0.3 / (1.0 + d2 / 1.4)
}
