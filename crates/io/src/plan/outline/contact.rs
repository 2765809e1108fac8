//! Which sides of an area's rings meet where they should not?
//!
//! sides ─▶ the squares of a coarse grid that each passes ─▶ pairs within a square ─▶ those that cross, touch or fold back
//!
//! Neighbours in a ring share their corner, and what the pixels' own border touches it may touch; nothing else may.

use super::side::{Point, Vertex};

/// Side of a square, pixels: a few short sides each.
const SQUARE_PX: f64 = 8.0;
/// What is no farther apart touches, pixels: round-off.
const HAIR_PX: f64 = 1e-9;

/// A straight piece of a ring, from one vertex to the next.
struct Segment {
    from: Point,
    to: Point,
    ring: usize,
    place: usize,
}

/// For each ring that has some, the sides that meet others.
pub(super) fn meeting(rings: &[Vec<Vertex>]) -> Vec<(usize, Vec<usize>)> {
    let mut met: Vec<Vec<usize>> = vec![Vec::new(); rings.len()];
    let mut squares = squares(rings);
    squares.sort_unstable();
    for square in squares.chunk_by(|a, b| a.0 == b.0) {
        for (i, (_, a)) in square.iter().enumerate() {
            let (vertex, a) = (vertex(rings, *a), segment(rings, *a));
            for (_, b) in &square[i + 1..] {
                let (other, b) = (self::vertex(rings, *b), segment(rings, *b));
                if !(vertex.exact && other.exact) && meets(&a, &b, rings[a.ring].len()) {
                    met[a.ring].extend(vertex.sides);
                    met[b.ring].extend(other.sides);
                }
            }
        }
    }
    let mut found: Vec<(usize, Vec<usize>)> = met.into_iter().enumerate().filter(|(_, sides)| !sides.is_empty()).collect();
    for (_, sides) in &mut found {
        sides.sort_unstable();
        sides.dedup();
    }
    found
}

/// Ring and place in it: short, because there may be millions.
type Name = [u32; 2];

fn vertex(rings: &[Vec<Vertex>], [ring, place]: Name) -> Vertex {
    rings[ring as usize][place as usize]
}

fn segment(rings: &[Vec<Vertex>], [ring, place]: Name) -> Segment {
    let (ring, place) = (ring as usize, place as usize);
    let vertices = &rings[ring];
    Segment { from: vertices[place].at, to: vertices[(place + 1) % vertices.len()].at, ring, place }
}

/// Squares that the segments pass, row and column, each with the segment's name.
fn squares(rings: &[Vec<Vertex>]) -> Vec<([i32; 2], Name)> {
    let mut squares = Vec::new();
    let square = |v: f64| (v / SQUARE_PX).floor() as i32;
    let names = rings.iter().enumerate().flat_map(|(ring, vertices)| (0..vertices.len()).map(move |place| [ring as u32, place as u32]));
    for name in names {
        let Segment { from, to, .. } = segment(rings, name);
        let (top, bottom) = if from[1] <= to[1] { (from, to) } else { (to, from) };
        let rise = bottom[1] - top[1];
        for row in square(top[1] - HAIR_PX)..=square(bottom[1] + HAIR_PX) {
            // Where it enters and leaves the row of squares.
            let at = |y: f64| top[0] + (bottom[0] - top[0]) * (y.clamp(top[1], bottom[1]) - top[1]) / rise;
            let rows = [row, row + 1].map(|row| f64::from(row) * SQUARE_PX);
            let [a, b] = if rise > 0.0 { rows.map(at) } else { [top[0], bottom[0]] };
            let (low, high) = (a.min(b) - HAIR_PX, a.max(b) + HAIR_PX);
            squares.extend((square(low)..=square(high)).map(|column| ([row, column], name)));
        }
    }
    squares
}

/// Whether two segments have a point in common, other than the corner of neighbours.
fn meets(a: &Segment, b: &Segment, ring_length: usize) -> bool {
    if a.ring == b.ring {
        if (a.place + 1) % ring_length == b.place {
            return folds(a.from, a.to, b.to);
        }
        if (b.place + 1) % ring_length == a.place {
            return folds(b.from, b.to, a.to);
        }
    }
    let ends_before = |a: &Segment, b: &Segment, k: usize| a.from[k].max(a.to[k]) + HAIR_PX < b.from[k].min(b.to[k]);
    let apart = |k: usize| ends_before(a, b, k) || ends_before(b, a, k);
    let divides = |a: &Segment, b: &Segment| a.left_of(b.from) * a.left_of(b.to) <= 0.0;
    !apart(0) && !apart(1) && divides(a, b) && divides(b, a)
}

/// Whether the way turns back upon itself.
fn folds(a: Point, b: Point, c: Point) -> bool {
    let back = Segment { from: b, to: a, ring: 0, place: 0 };
    let onwards = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
    onwards < 0.0 && back.left_of(c) == 0.0
}

impl Segment {
    /// How far a point is to one side of the line (above zero) or the other; zero if it is on it.
    fn left_of(&self, at: Point) -> f64 {
        let way = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let off = (way[0] * (at[1] - self.from[1]) - way[1] * (at[0] - self.from[0])) / way[0].hypot(way[1]);
        if off.abs() > HAIR_PX { off } else { 0.0 }
    }
}
