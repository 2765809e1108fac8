//! What stands in the rooms that no plan knows of? Things along the walls, away from the doors, and clusters on open floors.

use planwalk_types::{Plan, Pt2, Seed, StreamRng, Wall};
use rand::RngExt;

use super::index::Index;
use super::{Solid, SolidKind};
use crate::building::{Building, Room, RoomKind};

/// Free way kept in front of every door, metres.
const DOOR_CLEAR_M: f64 = 1.15;
/// Free way kept in front of and beside furniture where nobody knows the doors, or where rooms are narrow, metres.
const WAY_M: f64 = 0.95;
/// Free way around a cluster on an open floor, metres.
const AISLE_M: f64 = 1.3;

/// A kind of thing: how often it is drawn, its width, half of its depth, its height.
struct Piece {
    share: f64,
    width: (f64, f64),
    half_m: (f64, f64),
    high: (f64, f64),
    kind: SolidKind,
}

const fn piece(share: f64, width: (f64, f64), half_m: (f64, f64), high: (f64, f64), kind: SolidKind) -> Piece {
    Piece { share, width, half_m, high, kind }
}

const PLANT: Piece = piece(0.12, (0.34, 0.46), (0.17, 0.23), (0.9, 1.6), SolidKind::Plant);
const BIN: Piece = piece(0.10, (0.28, 0.34), (0.14, 0.17), (0.4, 0.7), SolidKind::Bin);
const CRATE: Piece = piece(0.12, (0.4, 0.6), (0.17, 0.25), (0.3, 0.8), SolidKind::Crate);
const SHELF: Piece = piece(0.25, (0.8, 1.4), (0.16, 0.20), (1.2, 2.1), SolidKind::Shelf);
const CUPBOARD: Piece = piece(0.25, (0.8, 1.3), (0.21, 0.25), (1.1, 2.0), SolidKind::Cupboard);
const DESK: Piece = piece(0.40, (1.2, 1.6), (0.34, 0.40), (0.72, 0.76), SolidKind::Desk);
const BOARD: Piece = piece(0.12, (1.2, 1.8), (0.12, 0.15), (1.85, 1.95), SolidKind::Whiteboard);

/// What stands in a kind of room, and how much of it: pieces a square metre.
fn pieces_of(kind: RoomKind) -> (f64, &'static [Piece]) {
    const OFFICE: &[Piece] = &[DESK, CUPBOARD, SHELF, PLANT, BIN, BOARD];
    const STORE: &[Piece] = &[SHELF, CUPBOARD, CRATE, CRATE, BIN];
    const HALL: &[Piece] = &[PLANT, piece(0.3, (1.4, 2.0), (0.36, 0.42), (0.70, 0.80), SolidKind::Soft), CUPBOARD, BIN, BOARD];
    const OPEN: &[Piece] = &[CUPBOARD, SHELF, PLANT, BIN, BOARD, CRATE];
    const MEETING: &[Piece] = &[BOARD, PLANT, BIN, CUPBOARD];
    const LIVING: &[Piece] = &[piece(0.35, (1.6, 2.2), (0.40, 0.46), (0.70, 0.85), SolidKind::Soft), SHELF, CUPBOARD, PLANT, DESK];
    const BEDROOM: &[Piece] = &[piece(0.5, (1.9, 2.1), (0.45, 0.75), (0.45, 0.6), SolidKind::Soft), CUPBOARD, SHELF, CRATE];
    const KITCHEN: &[Piece] = &[piece(0.8, (1.2, 2.0), (0.29, 0.31), (0.88, 0.92), SolidKind::Counter), CUPBOARD, BIN];
    const BATH: &[Piece] = &[piece(0.5, (0.5, 0.9), (0.22, 0.26), (0.8, 0.9), SolidKind::Counter), BIN];
    match kind {
        RoomKind::Corridor => (0.0, &[]),
        RoomKind::Office => (0.16, OFFICE),
        RoomKind::Store => (0.20, STORE),
        RoomKind::Hall => (0.06, HALL),
        RoomKind::Open => (0.03, OPEN),
        RoomKind::Meeting => (0.10, MEETING),
        RoomKind::Living => (0.16, LIVING),
        RoomKind::Bedroom => (0.16, BEDROOM),
        RoomKind::Kitchen => (0.22, KITCHEN),
        RoomKind::Bath => (0.20, BATH),
    }
}

/// Adds furniture; `amount` 1 is an ordinary building, 0 an empty one.
pub(super) fn place(building: &Building, amount: f64, seed: Seed, solids: &mut Vec<Solid>) {
    let fixed = super::index_of(solids);
    for (i, room) in building.rooms.iter().enumerate() {
        let mut rng = seed.derive("furniture", i as u64);
        let (per_m2, pieces) = pieces_of(room.kind);
        let wanted = (amount * per_m2 * room.area_m2()).round() as usize;
        if wanted == 0 || pieces.is_empty() {
            continue;
        }
        let mut site = Site::new(building, i, &fixed, solids);
        if room.kind == RoomKind::Open {
            site.place_clusters(amount, &mut rng);
        }
        if building.plain {
            site.place_plainly(wanted, &mut rng)
        } else {
            site.place_pieces(wanted, pieces, &mut rng)
        }
        let Site { placed, .. } = site;
        solids.extend(placed);
    }
}

/// One room while it is being furnished.
struct Site<'a> {
    building: &'a Building,
    room: &'a Room,
    number: usize,
    /// Walls along which things may stand: ends with the room to the left, and how far off them it begins.
    sides: Vec<(Pt2<Plan>, Pt2<Plan>)>,
    /// What stands in and near the room, walls excepted.
    near: Vec<Solid>,
    /// Walls in and near the room.
    walls: Vec<Solid>,
    /// Middles of the doors near it.
    doors: Vec<Pt2<Plan>>,
    placed: Vec<Solid>,
}

impl<'a> Site<'a> {
    fn new(building: &'a Building, number: usize, fixed: &Index, solids: &[Solid]) -> Self {
        let room = &building.rooms[number];
        let (low, high) = room.bounds();
        let (low, high) = ([low.x - 2.0, low.y - 2.0], [high.x + 2.0, high.y + 2.0]);
        let (walls, mut near): (Vec<Solid>, Vec<Solid>) =
            fixed.around(low, high).into_iter().map(|k| solids[k as usize].clone()).partition(|s| s.kind == SolidKind::Wall);
        let reaches = |s: &&Solid| {
            let (from, to) = s.span();
            (0..2).all(|axis| from[axis] <= high[axis] && to[axis] >= low[axis])
        };
        // Furniture of the rooms before this one was added after the index was made.
        near.extend(solids[fixed.count()..].iter().filter(reaches).cloned());
        let doors = building.doors.iter().map(crate::building::Door::centre);
        let doors = doors.filter(|p| p.x >= low[0] && p.y >= low[1] && p.x <= high[0] && p.y <= high[1]).collect();
        let sides = if building.thickness_m == 0.0 {
            // The room lies to the right of a traced wall.
            let beside = |w: &Wall| {
                let length = w.from.distance(w.to).max(1e-9);
                let (ex, ey) = ((w.to.x - w.from.x) / length, (w.to.y - w.from.y) / length);
                Pt2::new(0.5 * (w.from.x + w.to.x) + 0.15 * ey, 0.5 * (w.from.y + w.to.y) - 0.15 * ex)
            };
            walls.iter().map(|s| s.line).filter(|w| building.room_at(beside(w)) == Some(number)).map(|w| (w.to, w.from)).collect()
        } else {
            sorted_sides(room)
        };
        Self { building, room, number, sides, near, walls, doors, placed: Vec::new() }
    }

    /// Desks and cupboards.
    fn place_plainly(&mut self, wanted: usize, rng: &mut StreamRng) {
        for _ in 0..40 {
            if self.placed.len() >= wanted {
                break;
            }
            let desk = self.room.kind == RoomKind::Office && rng.random_range(0.0..1.0) < 0.5;
            let (width, half_m, high, kind) = if desk {
                (rng.random_range(1.2..1.6), 0.36, 0.74, SolidKind::Desk)
            } else {
                (rng.random_range(0.8..1.3), 0.21, rng.random_range(1.1..2.0), SolidKind::Cupboard)
            };
            let (side, share) = (rng.random_range(0..self.sides.len()), rng.random_range(0.0..1.0));
            let Some(line) = self.along_side(side, share, width, half_m) else { continue };
            let solid = Solid::new(line, half_m, [0.0, high], kind);
            if self.fits(&solid) {
                self.placed.push(solid);
            }
        }
    }

    /// Things of many kinds, each with a free way in front of it.
    fn place_pieces(&mut self, wanted: usize, pieces: &[Piece], rng: &mut StreamRng) {
        let total: f64 = pieces.iter().map(|p| p.share).sum();
        let before = self.placed.len();
        for _ in 0..4 * wanted + 12 {
            if self.placed.len() >= before + wanted || self.sides.is_empty() {
                break;
            }
            let mut draw = rng.random_range(0.0..total);
            let piece = pieces.iter().find(|p| {
                draw -= p.share;
                draw < 0.0
            });
            let Some(piece) = piece.or(pieces.last()) else { break };
            let mut between = |(low, high): (f64, f64)| rng.random_range(low..high);
            let (width, half_m, high) = (between(piece.width), between(piece.half_m), between(piece.high));
            // A whiteboard's foot is left out: one looks under it.
            let low = if piece.kind == SolidKind::Whiteboard { 0.6 } else { 0.0 };
            let (side, share) = (rng.random_range(0..self.sides.len()), rng.random_range(0.0..1.0));
            let Some(line) = self.along_side(side, share, width, half_m) else { continue };
            let solid = Solid::new(line, half_m, [low, high], piece.kind);
            if self.fits(&solid) && self.leaves_way(&solid, WAY_M) {
                self.placed.push(solid);
            }
        }
    }

    /// Clusters of four desks with a screen or a row of cupboards between them, on a grid with gaps.
    fn place_clusters(&mut self, amount: f64, rng: &mut StreamRng) {
        let (low, high) = self.room.bounds();
        let (dx, dy) = (rng.random_range(5.0..6.5), rng.random_range(4.4..5.6));
        let share = (0.62 * amount).min(0.95);
        let turned = rng.random_range(0.0..1.0) < 0.5;
        let (dx, dy) = if turned { (dy, dx) } else { (dx, dy) };
        let (nx, ny) = (((high.x - low.x) / dx) as usize, ((high.y - low.y) / dy) as usize);
        for j in 0..ny {
            for i in 0..nx {
                let x = low.x + (i as f64 + 0.5 + rng.random_range(-0.06..0.06)) * dx;
                let y = low.y + (j as f64 + 0.5 + rng.random_range(-0.06..0.06)) * dy;
                if rng.random_range(0.0..1.0) > share {
                    continue;
                }
                let cluster = cluster(x, y, turned, rng);
                if cluster.iter().all(|solid| self.fits(solid) && self.leaves_way(solid, AISLE_M)) {
                    self.placed.extend(cluster);
                }
            }
        }
    }

    /// The centre line of a box that stands with its back to one side of the room.
    fn along_side(&self, side: usize, share: f64, width: f64, half_m: f64) -> Option<Wall> {
        let (a, b) = self.sides[side];
        let wall_half_m = 0.5 * self.building.thickness_m;
        let inset = wall_half_m + half_m + 0.015;
        let length = libm::hypot(b.x - a.x, b.y - a.y);
        let span = length - width - 2.0 * (wall_half_m + 0.1);
        if !(span >= 0.0) {
            return None;
        }
        // Rows are set from the left or from below, whichever way the outline runs; the room is to the left of it.
        let e = [(b.x - a.x) / length, (b.y - a.y) / length];
        let n = [-e[1], e[0]];
        let (a, e) = if e[0] + e[1] < 0.0 { (b, [-e[0], -e[1]]) } else { (a, e) };
        let start = |p: f64, axis: usize| p + wall_half_m * e[axis] + 0.1 * e[axis] + share * span * e[axis];
        let (x, y) = (start(a.x, 0), start(a.y, 1));
        let pt = |along: f64| Pt2::<Plan>::new(x + along * e[0] + inset * n[0], y + along * e[1] + inset * n[1]);
        Some(Wall { from: pt(0.0), to: pt(width) })
    }

    /// Whether doors stay free and nothing stands in the same place.
    fn fits(&self, solid: &Solid) -> bool {
        if self.doors.iter().any(|door| solid.distance(*door) < DOOR_CLEAR_M) {
            return false;
        }
        // Its outline, every 10 cm, keeps 8 cm from every other thing that is no wall; a leaf is thinner than that.
        outline_of(solid, 0.0).all(|p| self.near.iter().chain(&self.placed).all(|other| other.distance(p) > 0.08))
    }

    /// Whether one can walk past: around it the room is free, save for the wall behind it and things in one row with it.
    fn leaves_way(&self, solid: &Solid, way_m: f64) -> bool {
        let all_in_room = outline_of(solid, 0.0).all(|p| self.holds(p));
        let obstacles = || self.walls.iter().chain(&self.near).chain(&self.placed);
        // In front or behind: the middle of a way as wide as wanted must be free for half of it.
        let side_free = |sign: f64| {
            along(solid, sign * (solid.half_m + 0.5 * way_m))
                .all(|p| self.holds(p) && obstacles().all(|o| o.distance(p) > 0.5 * way_m - 0.02))
        };
        all_in_room && (side_free(1.0) || side_free(-1.0)) && (self.near_wall(solid) || (side_free(1.0) && side_free(-1.0)))
    }

    fn near_wall(&self, solid: &Solid) -> bool {
        self.walls.iter().any(|w| w.distance(mid(solid)) < solid.half_m + 0.1)
    }

    fn holds(&self, p: Pt2<Plan>) -> bool {
        if self.building.thickness_m == 0.0 { self.building.room_at(p) == Some(self.number) } else { self.room.holds(p) }
    }
}

fn mid(solid: &Solid) -> Pt2<Plan> {
    Pt2::new(0.5 * (solid.line.from.x + solid.line.to.x), 0.5 * (solid.line.from.y + solid.line.to.y))
}

/// Sides of a room: level ones from below, then upright ones from the left, then oblique ones.
fn sorted_sides(room: &Room) -> Vec<(Pt2<Plan>, Pt2<Plan>)> {
    let mut sides: Vec<_> = room.sides().collect();
    let order = |(a, b): &(Pt2<Plan>, Pt2<Plan>)| match (a.y == b.y, a.x == b.x) {
        (true, _) => (0, a.y),
        (_, true) => (1, a.x),
        _ => (2, 0.0),
    };
    sides.sort_by(|p, q| order(p).0.cmp(&order(q).0).then(order(p).1.total_cmp(&order(q).1)));
    sides
}

/// Places every 10 cm along a line beside the solid's centre line, `off_m` to the right of it.
fn along(solid: &Solid, off_m: f64) -> impl Iterator<Item = Pt2<Plan>> + '_ {
    let (e, n) = (solid.e, [solid.e[1], -solid.e[0]]);
    let steps = (solid.length / 0.1).ceil() as usize;
    (0..=steps).map(move |i| {
        let s = solid.length * i as f64 / steps as f64;
        Pt2::new(solid.line.from.x + s * e[0] + off_m * n[0], solid.line.from.y + s * e[1] + off_m * n[1])
    })
}

/// Both long sides and the middle.
fn outline_of(solid: &Solid, more_m: f64) -> impl Iterator<Item = Pt2<Plan>> + '_ {
    [-1.0, 0.0, 1.0].into_iter().flat_map(move |t| along(solid, t * (solid.half_m + more_m)))
}

/// Two double desks back to back, with a low screen between them or plants at their end.
fn cluster(x: f64, y: f64, turned: bool, rng: &mut StreamRng) -> Vec<Solid> {
    let (half_length, high) = (rng.random_range(1.3..1.65), rng.random_range(0.72..0.76));
    let at = |s: f64, t: f64| if turned { Pt2::<Plan>::new(x + t, y + s) } else { Pt2::new(x + s, y + t) };
    let row = |t: f64, half_m: f64, z: [f64; 2], kind: SolidKind| {
        Solid::new(Wall { from: at(-half_length, t), to: at(half_length, t) }, half_m, z, kind)
    };
    let mut cluster = vec![row(-0.42, 0.38, [0.0, high], SolidKind::Desk), row(0.42, 0.38, [0.0, high], SolidKind::Desk)];
    if rng.random_range(0.0..1.0) < 0.6 {
        cluster.push(row(0.0, 0.02, [0.45, 1.25], SolidKind::Whiteboard));
    }
    if rng.random_range(0.0..1.0) < 0.5 {
        let line = Wall { from: at(half_length + 0.12, -0.4), to: at(half_length + 0.12, 0.4) };
        let shelf = Solid::new(Wall { from: line.from, to: line.to }, 0.0, [0.0, 1.2], SolidKind::Shelf);
        let e = shelf.e;
        // Moved out by half of its depth.
        let out = if turned { [0.0, 0.2] } else { [0.2, 0.0] };
        let moved = |p: Pt2<Plan>| Pt2::<Plan>::new(p.x + out[0], p.y + out[1]);
        let long = |p: Pt2<Plan>, k: f64| Pt2::<Plan>::new(p.x + k * e[0], p.y + k * e[1]);
        let ends = (long(moved(line.from), -0.35), long(moved(line.to), 0.35));
        cluster.push(Solid::new(Wall { from: ends.0, to: ends.1 }, 0.18, [0.0, rng.random_range(0.8..1.4)], SolidKind::Shelf));
    }
    cluster
}
