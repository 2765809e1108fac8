//! What stands in the rooms that no plan knows of? Cupboards and desks along the walls, away from the doors.

use planwalk_types::{Plan, Pt2, Seed, Wall};
use rand::RngExt;

use super::{Solid, SolidKind};
use crate::building::{Building, Room, RoomKind};

/// Free way kept in front of every door, metres.
const DOOR_CLEAR_M: f64 = 1.15;

/// Adds furniture; `amount` 1 is an ordinary office, 0 an empty one.
pub(super) fn place(building: &Building, amount: f64, seed: Seed, solids: &mut Vec<Solid>) {
    for (i, room) in building.rooms.iter().enumerate() {
        let mut rng = seed.derive("furniture", i as u64);
        let (per_m2, tries) = match room.kind {
            RoomKind::Corridor => continue,
            RoomKind::Office => (0.16, 40),
            RoomKind::Store => (0.20, 40),
            RoomKind::Hall => (0.06, 40),
        };
        let wanted = (amount * per_m2 * room.area_m2()).round() as usize;
        let mut placed = 0;
        for _ in 0..tries {
            if placed >= wanted {
                break;
            }
            let desk = room.kind == RoomKind::Office && rng.random_range(0.0..1.0) < 0.5;
            let (width, half_m, high, kind) = if desk {
                (rng.random_range(1.2..1.6), 0.36, 0.74, SolidKind::Desk)
            } else {
                (rng.random_range(0.8..1.3), 0.21, rng.random_range(1.1..2.0), SolidKind::Cupboard)
            };
            let (side, share) = (rng.random_range(0..4usize), rng.random_range(0.0..1.0));
            let Some(line) = along_wall(room, side, share, width, half_m, 0.5 * building.thickness_m) else { continue };
            let solid = Solid::new(line, half_m, [0.0, high], kind);
            if fits(&solid, building, solids) {
                solids.push(solid);
                placed += 1;
            }
        }
    }
}

/// The centre line of a box that stands with its back to one side of the room.
fn along_wall(room: &Room, side: usize, share: f64, width: f64, half_m: f64, wall_half_m: f64) -> Option<Wall> {
    let inset = wall_half_m + half_m + 0.015;
    let (low, high) = if side < 2 { (room.low.x, room.high.x) } else { (room.low.y, room.high.y) };
    let span = high - low - width - 2.0 * (wall_half_m + 0.1);
    if span < 0.0 {
        return None;
    }
    let from = low + wall_half_m + 0.1 + share * span;
    let (across_low, across_high) = if side < 2 { (room.low.y, room.high.y) } else { (room.low.x, room.high.x) };
    let across = if side.is_multiple_of(2) { across_low + inset } else { across_high - inset };
    let pt = |along: f64| if side < 2 { Pt2::<Plan>::new(along, across) } else { Pt2::new(across, along) };
    Some(Wall { from: pt(from), to: pt(from + width) })
}

/// Whether doors stay free and nothing stands in the same place.
fn fits(solid: &Solid, building: &Building, solids: &[Solid]) -> bool {
    if building.doors.iter().any(|door| solid.distance(door.centre()) < DOOR_CLEAR_M) {
        return false;
    }
    let (e, length) = (solid.e, solid.length);
    let n = [e[1], -e[0]];
    // Its outline, every 10 cm, keeps 8 cm from every other thing that is no wall; a leaf is thinner than that.
    let steps = (length / 0.1).ceil() as usize;
    (0..=steps).all(|i| {
        let s = length * i as f64 / steps as f64;
        [-1.0, 0.0, 1.0].iter().all(|t| {
            let x = solid.line.from.x + s * e[0] + t * solid.half_m * n[0];
            let y = solid.line.from.y + s * e[1] + t * solid.half_m * n[1];
            solids.iter().all(|other| other.kind == SolidKind::Wall || other.distance(Pt2::new(x, y)) > 0.08)
        })
    })
}
