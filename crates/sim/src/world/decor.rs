//! What hangs on this wall? Posters, notices, door plates, switches, windows — and on some walls nothing.

use planwalk_types::{Seed, StreamRng};
use rand::{Rng, RngExt};

use super::{Face, SolidKind, in_front};
use crate::building::{Building, RoomKind};
use crate::look::Look;

/// What a rectangle on a face shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DecorKind {
    /// A picture in a dark frame.
    Poster,
    /// A sheet of text.
    Notice,
    /// A dark plate with bright marks.
    Plate,
    /// A switch or a socket.
    Switch,
    /// Daylight, with bars.
    Window,
    /// The frame around a door.
    Trim,
    /// A glazed wall: dark bars and what shines through.
    Glass,
}

/// A rectangle on a face.
#[derive(Debug, Clone)]
pub(crate) struct Decor {
    /// From and to, metres along the face.
    pub s: [f64; 2],
    /// From and to, metres above the floor.
    pub z: [f64; 2],
    pub kind: DecorKind,
    pub seed: u32,
}

/// Width of the frame around doors, metres.
const TRIM_M: f64 = 0.07;
/// How rough a blank wall's plaster looks beside that of others: near the noise of a phone's camera.
const BLANK: f32 = 0.45;

/// Decides what a face looks like.
pub(super) fn hang(face: &mut Face, building: &Building, look: &Look, seed: Seed) {
    let mut rng = seed.derive("face", 0);
    face.seed = rng.next_u32();
    let chance = rng.random_range(0.0..1.0);
    match face.kind {
        SolidKind::Lintel => {
            face.roughness = BLANK * look.texture_density as f32;
            let z = [face.z[0], face.z[0] + TRIM_M];
            face.decor.push(Decor { s: [0.0, face.length], z, kind: DecorKind::Trim, seed: 0 });
        }
        SolidKind::Wall => {
            trim(face, building.door_height_m);
            // More than a quarter of the walls stays blank and smooth at ordinary density.
            let blank = chance > 0.72 * look.texture_density.min(1.4);
            face.roughness = (if blank { BLANK } else { 1.0 }) * look.texture_density as f32;
            let outer = face.room.is_some() && building.outdoors_behind(in_front(face, 0.5 * face.length, 0.0), face.n);
            if outer {
                windows(face, building.plain, &mut rng);
            } else if is_glazed(face, building) {
                let z = [0.06, building.door_height_m];
                face.decor.push(Decor { s: [0.05, face.length - 0.05], z, kind: DecorKind::Glass, seed: rng.next_u32() });
                return;
            } else if !blank {
                pictures(face, building, look, &mut rng);
            }
            if look.texture_density > 0.0 {
                beside_doors(face, &mut rng);
            }
        }
        SolidKind::Leaf
        | SolidKind::Cupboard
        | SolidKind::Desk
        | SolidKind::Shelf
        | SolidKind::Plant
        | SolidKind::Bin
        | SolidKind::Crate
        | SolidKind::Whiteboard
        | SolidKind::Soft
        | SolidKind::Counter => {}
    }
}

/// The wall between a meeting room and an open floor.
fn is_glazed(face: &Face, building: &Building) -> bool {
    let behind = building.room_at(in_front(face, 0.5 * face.length, -2.0 * building.thickness_m - 0.1));
    let kinds = [face.room, behind].map(|room| room.map(|r| building.rooms[r].kind));
    face.length > 0.3 && kinds.contains(&Some(RoomKind::Meeting)) && kinds.contains(&Some(RoomKind::Open))
}

fn trim(face: &mut Face, door_height_m: f64) {
    let z = [0.0, door_height_m + TRIM_M];
    for (end, jamb) in face.doorway.into_iter().enumerate() {
        if jamb {
            let s = if end == 0 { [0.0, TRIM_M.min(face.length)] } else { [(face.length - TRIM_M).max(0.0), face.length] };
            face.decor.push(Decor { s, z, kind: DecorKind::Trim, seed: 0 });
        }
    }
}

/// Windows every two metres or so along an outer wall; between piers a narrower place will do, but not in a plain building.
fn windows(face: &mut Face, plain: bool, rng: &mut StreamRng) {
    let width = 1.25;
    let between_piers = usize::from(!plain && face.length > width + 0.2);
    let count = ((face.length / rng.random_range(1.9..2.6)).floor() as usize).max(between_piers);
    for i in 0..count {
        let middle = face.length * (i as f64 + 0.5) / count as f64;
        let s = [middle - 0.5 * width, middle + 0.5 * width];
        face.decor.push(Decor { s, z: [0.92, 2.15], kind: DecorKind::Window, seed: rng.next_u32() });
    }
}

/// Posters and notices from left to right, with gaps that shrink with density.
fn pictures(face: &mut Face, building: &Building, look: &Look, rng: &mut StreamRng) {
    let corridor = face.room.is_some_and(|r| building.rooms[r].kind == RoomKind::Corridor);
    let gap = 1.0 / look.texture_density.max(0.05);
    let mut cursor = rng.random_range(0.25..0.9) * gap;
    loop {
        let notice = rng.random_range(0.0..1.0) < if corridor { 0.55 } else { 0.35 };
        let (width, height, middle) = if notice {
            (rng.random_range(0.2..0.34), rng.random_range(0.28..0.42), rng.random_range(1.35..1.7))
        } else {
            (rng.random_range(0.4..0.95), rng.random_range(0.45..0.9), rng.random_range(1.4..1.65))
        };
        if cursor + width > face.length - 0.2 {
            break;
        }
        let kind = if notice { DecorKind::Notice } else { DecorKind::Poster };
        let z = [middle - 0.5 * height, middle + 0.5 * height];
        face.decor.push(Decor { s: [cursor, cursor + width], z, kind, seed: rng.next_u32() });
        // Notices hang in groups, pictures apart.
        cursor += width + if notice { rng.random_range(0.04..0.5) } else { rng.random_range(0.4..1.5) } * gap;
    }
}

/// A plate with the room's number, a switch, a socket: where people put them.
fn beside_doors(face: &mut Face, rng: &mut StreamRng) {
    for (end, jamb) in face.doorway.into_iter().enumerate() {
        if !jamb || face.length < 0.7 {
            continue;
        }
        let mut add = |from: f64, width: f64, low: f64, height: f64, kind: DecorKind, seed: u32| {
            let s = if end == 0 { [from, from + width] } else { [face.length - from - width, face.length - from] };
            let z = [low, low + height];
            // What would overlap a picture is left out.
            let clash = face.decor.iter().any(|d| d.s[0] < s[1] && s[0] < d.s[1] && d.z[0] < z[1] && z[0] < d.z[1]);
            if !clash {
                face.decor.push(Decor { s, z, kind, seed });
            }
        };
        if rng.random_range(0.0..1.0) < 0.6 {
            add(0.14, 0.22, 1.52, 0.14, DecorKind::Plate, rng.next_u32());
        }
        if rng.random_range(0.0..1.0) < 0.7 {
            add(0.16, 0.085, 1.02, 0.085, DecorKind::Switch, 1);
        }
        if rng.random_range(0.0..1.0) < 0.5 {
            add(rng.random_range(0.3..0.5), 0.16, 0.26, 0.085, DecorKind::Switch, 2);
        }
    }
}
