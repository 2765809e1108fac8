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

use planwalk_types::{Plan, Pt2, StreamRng};
use rand::RngExt;

use super::sketch::{self, Line, Sketch};
use super::{Room, RoomKind};

/// Clear width of a door: an accessible one, and room for a walker's sway on both sides.
pub(super) const DOOR_M: f64 = 1.0;

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
    fn draw((width_m, depth_m): (f64, f64), rng: &mut StreamRng) -> Self {
        let width = width_m * rng.random_range(0.95..1.05);
        let depth = depth_m * rng.random_range(0.95..1.05);
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

/// The hall's door to the corridor always stands open: a walk needs one.
pub(super) fn hall_is_open(left: RoomKind, right: RoomKind) -> bool {
    (left == RoomKind::Hall || right == RoomKind::Hall) && (left == RoomKind::Corridor || right == RoomKind::Corridor)
}

/// The layout of a small office, and its true size.
pub(super) fn small(size_m: (f64, f64), rng: &mut StreamRng) -> (Sketch, (f64, f64)) {
    let lines = Lines::draw(size_m, rng);
    let rooms = rooms(&lines);
    let size_m = (lines.width, lines.depth);
    let lines = walls(&lines, rng);
    (Sketch { rooms, lines, door_m: DOOR_M, always_open: hall_is_open, plain: true }, size_m)
}

fn rooms(l: &Lines) -> Vec<Room> {
    let room = |kind, x0: f64, y0: f64, x1: f64, y1: f64| Room::rectangle(kind, Pt2::new(x0, y0), Pt2::new(x1, y1));
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

/// A place for a door between two coordinates.
pub(super) fn place(low: f64, high: f64, rng: &mut StreamRng) -> f64 {
    sketch::place(low, high, DOOR_M, rng)
}

fn walls(l: &Lines, rng: &mut StreamRng) -> Vec<Line> {
    let pt = Pt2::<Plan>::new;
    let line = Line::new;
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
    lines.push(Line::partition(0.0, l.b, l.a, l.b, vec![pt(place(0.0, l.a, rng), l.b)]));
    // Lower row: a door to the corridor each, and one between neighbours.
    let cuts: Vec<f64> = std::iter::once(l.a).chain(l.low.iter().copied()).chain([v1]).collect();
    let doors = cuts.windows(2).map(|x| pt(place(x[0], x[1], rng), c0)).collect();
    lines.push(line(l.a, c0, v1, c0, doors));
    for (i, x) in l.low.iter().enumerate() {
        let doors = if i == 0 { vec![pt(*x, place(0.0, c0, rng))] } else { vec![] };
        lines.push(Line::partition(*x, 0.0, *x, c0, doors));
    }
    // Upper row: the same, and sometimes a door to the corridor's leg.
    lines.push(line(l.a, c1, v0, c1, vec![pt(place(l.a, l.up, rng), c1), pt(place(l.up, v0, rng), c1)]));
    lines.push(Line::partition(l.up, c1, l.up, l.depth, vec![pt(l.up, place(c1, l.depth, rng))]));
    let leg = if rng.random_range(0.0..1.0) < 0.6 { vec![pt(v0, place(c1, l.depth, rng))] } else { vec![] };
    lines.push(line(v0, c1, v0, l.depth, leg));
    // Right column: the corridor ends at the near room's door, the far room opens to the leg.
    lines.push(line(v1, 0.0, v1, l.depth, vec![pt(v1, place(c0, c1, rng)), pt(v1, place(l.r, l.depth, rng))]));
    let between = if rng.random_range(0.0..1.0) < 0.5 { vec![pt(place(v1, l.width, rng), l.r)] } else { vec![] };
    lines.push(Line::partition(v1, l.r, l.width, l.r, between));
    lines
}
