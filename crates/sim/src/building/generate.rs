//! How is a small office laid out? A hall, a corridor with a bend, rooms on both sides of it.
//!
//! ```text
//!  ┌──────┬──────┬────┬──┬─────┐ depth       a: end of the left column      c0, c1: the corridor's sides
//!  │store │ up 1 │up 2│  │ far │             v0, v1: the sides of its leg    b, r: where the columns are cut
//!  ├─ b ──┤      │    │  ├─ r ─┤             Left column, rows and right column are cut at different places, so
//!  │      ├──────┴────┘  │     │             nothing is symmetric; then the whole is mirrored by chance.
//!  │ hall    corridor    │ near│ c0..c1
//!  │      ├────┬──┬──────┤     │
//!  │      │low1│l2│ low3 │     │
//!  └──────┴────┴──┴──────┴─────┘ 0
//!  0      a              v0 v1 width
//! ```

use planwalk_types::{Plan, Pt2, Seed, StreamRng, Wall};
use rand::RngExt;

use super::{Building, BuildingOptions, Door, Room, RoomKind};

/// Clear width of a door: an accessible one, and room for a walker's sway on both sides.
const DOOR_M: f64 = 1.0;
/// From a door to the next corner: frame, light switch.
const DOOR_MARGIN_M: f64 = 0.3;

/// Where the layout's lines lie, metres.
struct Lines {
    width: f64,
    depth: f64,
    /// Right end of the left column.
    a: f64,
    /// Cut of the left column.
    b: f64,
    /// Corridor, lower and upper side.
    c: [f64; 2],
    /// Corridor's leg, left and right side.
    v: [f64; 2],
    /// Cut of the right column.
    r: f64,
    /// Cuts of the lower row.
    low: Vec<f64>,
    /// Cut of the upper row.
    up: f64,
}

impl Lines {
    fn draw(options: &BuildingOptions, rng: &mut StreamRng) -> Self {
        let width = options.width_m * rng.random_range(0.95..1.05);
        let depth = options.depth_m * rng.random_range(0.95..1.05);
        let a = width * rng.random_range(0.21..0.27);
        let c0 = depth * rng.random_range(0.30..0.40);
        let c1 = c0 + rng.random_range(1.7..2.1);
        let v1 = width * rng.random_range(0.72..0.79);
        let v0 = v1 - rng.random_range(1.6..2.0);
        let three = rng.random_range(0.0..1.0) < 0.6;
        let shares: &[f64] = if three { &[0.28, 0.56] } else { &[0.42] };
        let low = shares.iter().map(|s| a + (v1 - a) * (s + rng.random_range(-0.04..0.04))).collect();
        Self {
            width,
            depth,
            a,
            b: c1 + rng.random_range(0.8..2.4),
            c: [c0, c1],
            v: [v0, v1],
            r: c1 + rng.random_range(0.9..2.2),
            low,
            up: a + (v0 - a) * rng.random_range(0.36..0.64),
        }
    }
}

/// A wall before its doors are cut out, and the doors' places along it.
struct Line {
    from: Pt2<Plan>,
    to: Pt2<Plan>,
    doors: Vec<Pt2<Plan>>,
}

pub(super) fn office(options: &BuildingOptions, seed: Seed) -> Building {
    let mut rng = seed.derive("building", 0);
    let lines = Lines::draw(options, &mut rng);
    let rooms = rooms(&lines);
    let mut building = Building { walls: Vec::new(), doors: Vec::new(), rooms, thickness_m: 0.12, height_m: 2.7, door_height_m: 2.1 };
    for line in walls(&lines, &mut rng) {
        cut(&line, options, &mut building, &mut rng);
    }
    let flips = [rng.random_range(0.0..1.0) < 0.5, rng.random_range(0.0..1.0) < 0.5];
    mirror(&mut building, flips, lines.width, lines.depth);
    building
}

fn rooms(l: &Lines) -> Vec<Room> {
    let room = |kind, x0: f64, y0: f64, x1: f64, y1: f64| Room { kind, low: Pt2::new(x0, y0), high: Pt2::new(x1, y1) };
    let mut rooms = vec![
        room(RoomKind::Corridor, l.a, l.c[0], l.v[1], l.c[1]),
        room(RoomKind::Corridor, l.v[0], l.c[1], l.v[1], l.depth),
        room(RoomKind::Hall, 0.0, 0.0, l.a, l.b),
        room(RoomKind::Store, 0.0, l.b, l.a, l.depth),
        room(RoomKind::Office, l.a, l.c[1], l.up, l.depth),
        room(RoomKind::Office, l.up, l.c[1], l.v[0], l.depth),
        room(RoomKind::Office, l.v[1], 0.0, l.width, l.r),
        room(RoomKind::Office, l.v[1], l.r, l.width, l.depth),
    ];
    let cuts: Vec<f64> = std::iter::once(l.a).chain(l.low.iter().copied()).chain([l.v[1]]).collect();
    rooms.extend(cuts.windows(2).map(|x| room(RoomKind::Office, x[0], 0.0, x[1], l.c[0])));
    rooms
}

/// A place for a door between two coordinates, off the corners.
fn place(low: f64, high: f64, rng: &mut StreamRng) -> f64 {
    let margin = DOOR_MARGIN_M + 0.5 * DOOR_M;
    if high - low <= 2.0 * margin { 0.5 * (low + high) } else { rng.random_range(low + margin..high - margin) }
}

fn walls(l: &Lines, rng: &mut StreamRng) -> Vec<Line> {
    let pt = Pt2::<Plan>::new;
    let line = |x0, y0, x1, y1, doors: Vec<Pt2<Plan>>| Line { from: pt(x0, y0), to: pt(x1, y1), doors };
    let [c0, c1] = l.c;
    let [v0, v1] = l.v;
    let mut lines = vec![
        line(0.0, 0.0, l.width, 0.0, vec![]),
        line(0.0, l.depth, l.width, l.depth, vec![]),
        line(0.0, 0.0, 0.0, l.depth, vec![]),
        line(l.width, 0.0, l.width, l.depth, vec![]),
    ];
    // Left column: the hall opens to the corridor; the store opens to the hall, and sometimes to the first upper room.
    let mut left = vec![pt(l.a, place(c0, c1, rng))];
    if rng.random_range(0.0..1.0) < 0.5 {
        left.push(pt(l.a, place(l.b, l.depth, rng)));
    }
    lines.push(line(l.a, 0.0, l.a, l.depth, left));
    lines.push(line(0.0, l.b, l.a, l.b, vec![pt(place(0.0, l.a, rng), l.b)]));
    // Lower row: a door to the corridor each, and one between neighbours.
    let cuts: Vec<f64> = std::iter::once(l.a).chain(l.low.iter().copied()).chain([v1]).collect();
    let doors = cuts.windows(2).map(|x| pt(place(x[0], x[1], rng), c0)).collect();
    lines.push(line(l.a, c0, v1, c0, doors));
    for (i, x) in l.low.iter().enumerate() {
        let doors = if i == 0 { vec![pt(*x, place(0.0, c0, rng))] } else { vec![] };
        lines.push(line(*x, 0.0, *x, c0, doors));
    }
    // Upper row: the same, and sometimes a door to the corridor's leg.
    lines.push(line(l.a, c1, v0, c1, vec![pt(place(l.a, l.up, rng), c1), pt(place(l.up, v0, rng), c1)]));
    lines.push(line(l.up, c1, l.up, l.depth, vec![pt(l.up, place(c1, l.depth, rng))]));
    let leg = if rng.random_range(0.0..1.0) < 0.6 { vec![pt(v0, place(c1, l.depth, rng))] } else { vec![] };
    lines.push(line(v0, c1, v0, l.depth, leg));
    // Right column: the corridor ends at the near room's door, the far room opens to the leg.
    lines.push(line(v1, 0.0, v1, l.depth, vec![pt(v1, place(c0, c1, rng)), pt(v1, place(l.r, l.depth, rng))]));
    let between = if rng.random_range(0.0..1.0) < 0.5 { vec![pt(place(v1, l.width, rng), l.r)] } else { vec![] };
    lines.push(line(v1, l.r, l.width, l.r, between));
    lines
}

/// Cuts a line's doors out of it, hangs their leaves, and adds what is left to the walls.
fn cut(line: &Line, options: &BuildingOptions, building: &mut Building, rng: &mut StreamRng) {
    let length = line.from.distance(line.to);
    let (ex, ey) = ((line.to.x - line.from.x) / length, (line.to.y - line.from.y) / length);
    let at = |s: f64| Pt2::<Plan>::new(line.from.x + s * ex, line.from.y + s * ey);
    let mut places: Vec<f64> = line.doors.iter().map(|p| (p.x - line.from.x) * ex + (p.y - line.from.y) * ey).collect();
    places.sort_by(f64::total_cmp);
    let mut done = 0.0;
    for s in places {
        let opening = Wall { from: at(s - 0.5 * DOOR_M), to: at(s + 0.5 * DOOR_M) };
        building.walls.push(Wall { from: at(done), to: opening.from });
        done = s + 0.5 * DOOR_M;
        let side = |n: f64| building.room_at(Pt2::new(at(s).x - n * ey, at(s).y + n * ex));
        let (left, right) = (side(0.3).unwrap_or(0), side(-0.3).unwrap_or(0));
        let private = |room: usize| building.rooms[room].kind != RoomKind::Corridor;
        // Leaves swing into rooms, not into the corridor, and hang at the end nearer to the room's corner.
        let swings_into = if private(left) { left } else { right };
        let room = &building.rooms[swings_into];
        let low = (room.low.x - line.from.x) * ex + (room.low.y - line.from.y) * ey;
        let high = (room.high.x - line.from.x) * ex + (room.high.y - line.from.y) * ey;
        let hinge_at_from = s - low < high - s;
        // The hall's door to the corridor always stands open: a walk needs one.
        let always = building.rooms[left].kind == RoomKind::Hall || building.rooms[right].kind == RoomKind::Hall;
        let open = rng.random_range(0.0..1.0) < options.open_doors || (always && (!private(left) || !private(right)));
        building.doors.push(Door { opening, open, swings_into, hinge_at_from });
    }
    building.walls.push(Wall { from: at(done), to: line.to });
}

fn mirror(building: &mut Building, [flip_x, flip_y]: [bool; 2], width: f64, depth: f64) {
    let map = |p: Pt2<Plan>| Pt2::<Plan>::new(if flip_x { width - p.x } else { p.x }, if flip_y { depth - p.y } else { p.y });
    for wall in building.walls.iter_mut().chain(building.doors.iter_mut().map(|d| &mut d.opening)) {
        *wall = Wall { from: map(wall.from), to: map(wall.to) };
    }
    for room in &mut building.rooms {
        let (p, q) = (map(room.low), map(room.high));
        room.low = Pt2::new(p.x.min(q.x), p.y.min(q.y));
        room.high = Pt2::new(p.x.max(q.x), p.y.max(q.y));
    }
}
