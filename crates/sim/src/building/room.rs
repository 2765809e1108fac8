//! Where does a room begin and end? A polygon of any shape, and what it is for.

use planwalk_types::{Plan, Pt2, Wall};

use super::distance_to_wall;

/// What a room is for; decides floor, light, furniture and what hangs on its walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoomKind {
    /// Desks and a carpet.
    Office,
    /// Where doors lead to: tiles, notice boards, signs.
    Corridor,
    /// A large room where people arrive: tiles.
    Hall,
    /// Shelves and bare walls.
    Store,
    /// A wide floor with clusters of desks and columns: a carpet.
    Open,
    /// A table behind glass.
    Meeting,
    /// Sofa, shelves, a wooden floor.
    Living,
    /// A bed and a wardrobe.
    Bedroom,
    /// Worktops along the walls, tiles.
    Kitchen,
    /// Small tiles.
    Bath,
}

/// A polygon of floor between centre lines of walls (or between their surfaces, in the world of a given plan).
///
/// A room around something else, such as a ring, is one polygon with a slit: its outline leads along the outer rim, through the slit,
/// around the inner rim, and back through the slit.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// What it is for.
    pub kind: RoomKind,
    /// Its corners, anticlockwise, metres.
    pub outline: Vec<Pt2<Plan>>,
}

impl Room {
    /// An axis-parallel rectangle between two opposite corners.
    pub fn rectangle(kind: RoomKind, low: Pt2<Plan>, high: Pt2<Plan>) -> Self {
        Self { kind, outline: vec![low, Pt2::new(high.x, low.y), high, Pt2::new(low.x, high.y)] }
    }

    /// A room around a hole: the outer rim anticlockwise, the inner one in the same sense.
    pub(super) fn around(kind: RoomKind, outer: &[Pt2<Plan>], hole: &[Pt2<Plan>]) -> Self {
        let mut outline = outer.to_vec();
        if let (Some(first), Some(inner)) = (outer.first(), hole.first()) {
            outline.push(*first);
            outline.push(*inner);
            outline.extend(hole.iter().rev());
        }
        Self { kind, outline }
    }

    /// Lower left and upper right corner of the rectangle around it.
    pub fn bounds(&self) -> (Pt2<Plan>, Pt2<Plan>) {
        bounds_of(&self.outline)
    }

    /// Whether it is an axis-parallel rectangle.
    pub(crate) fn is_rectangle(&self) -> bool {
        let level = |i: usize| self.outline[i].y == self.outline[(i + 1) % 4].y;
        let upright = |i: usize| self.outline[i].x == self.outline[(i + 1) % 4].x;
        self.outline.len() == 4
            && ((0..4).all(|i| if i % 2 == 0 { level(i) } else { upright(i) })
                || (0..4).all(|i| if i % 2 == 0 { upright(i) } else { level(i) }))
    }

    /// A place well inside the room: the middle of the rectangle around it if it holds it, else the place farthest from its walls.
    pub fn centre(&self) -> Pt2<Plan> {
        let (low, high) = self.bounds();
        let middle = Pt2::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y));
        if self.holds(middle) {
            return middle;
        }
        const SIDE: usize = 32;
        let share = |i: usize| (i as f64 + 0.5) / SIDE as f64;
        let at = |i: usize| Pt2::<Plan>::new(low.x + share(i % SIDE) * (high.x - low.x), low.y + share(i / SIDE) * (high.y - low.y));
        let sides: Vec<Wall> = self.sides().map(|(from, to)| Wall { from, to }).collect();
        let to_rim_m = |p: Pt2<Plan>| sides.iter().map(|side| distance_to_wall(p, side)).fold(f64::INFINITY, f64::min);
        let inside = (0..SIDE * SIDE).map(at).filter(|p| self.holds(*p));
        inside.map(|p| (to_rim_m(p), p)).max_by(|a, b| a.0.total_cmp(&b.0)).map_or(middle, |(_, p)| p)
    }

    /// Its sides, end to end, without slits.
    pub(crate) fn sides(&self) -> impl Iterator<Item = (Pt2<Plan>, Pt2<Plan>)> + '_ {
        let count = self.outline.len();
        let side = move |i: usize| (self.outline[i], self.outline[(i + 1) % count]);
        (0..count).map(side).filter(move |(a, b)| a != b && !(0..count).any(|j| side(j) == (*b, *a)))
    }

    /// Whether a point lies in it.
    pub fn holds(&self, point: Pt2<Plan>) -> bool {
        let mut inside = false;
        let mut last = match self.outline.last() {
            Some(p) => *p,
            None => return false,
        };
        for corner in &self.outline {
            if (corner.y > point.y) != (last.y > point.y) && point.x < crossing(last, *corner, point.y) {
                inside = !inside;
            }
            last = *corner;
        }
        inside
    }

    /// Floor area, m².
    pub fn area_m2(&self) -> f64 {
        let count = self.outline.len();
        let twice = |i: usize| {
            let (a, b) = (self.outline[i], self.outline[(i + 1) % count]);
            a.x * b.y - b.x * a.y
        };
        0.5 * (0..count).map(twice).sum::<f64>().abs()
    }

    /// Writes `value` into the cells of a grid whose centres it holds: cell (i, j) has its centre at `origin + (i + ½, j + ½) · cell_m`.
    pub(crate) fn paint(&self, value: u16, origin: [f64; 2], cell_m: f64, size: [usize; 2], cells: &mut [u16]) {
        let (low, high) = self.bounds();
        let row_of = |y: f64| ((y - origin[1]) / cell_m - 0.5).clamp(0.0, size[1] as f64) as usize;
        let mut crossings = Vec::new();
        for row in row_of(low.y)..(row_of(high.y) + 2).min(size[1]) {
            let y = origin[1] + (row as f64 + 0.5) * cell_m;
            crossings.clear();
            let mut last = match self.outline.last() {
                Some(p) => *p,
                None => return,
            };
            for corner in &self.outline {
                if (corner.y > y) != (last.y > y) {
                    crossings.push(crossing(last, *corner, y));
                }
                last = *corner;
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let column = |x: f64| ((x - origin[0]) / cell_m - 0.5).ceil().clamp(0.0, size[0] as f64) as usize;
                let (from, to) = (column(pair[0]), column(pair[1]));
                if from < to {
                    cells[row * size[0] + from..row * size[0] + to].fill(value);
                }
            }
        }
    }
}

/// Where the line through two points meets a height.
fn crossing(a: Pt2<Plan>, b: Pt2<Plan>, y: f64) -> f64 {
    a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x)
}

/// Lower left and upper right corner of the rectangle around points; empty and inside out where there are none.
pub(crate) fn bounds_of(points: &[Pt2<Plan>]) -> (Pt2<Plan>, Pt2<Plan>) {
    let low = points.iter().fold((f64::INFINITY, f64::INFINITY), |l, p| (l.0.min(p.x), l.1.min(p.y)));
    let high = points.iter().fold((f64::NEG_INFINITY, f64::NEG_INFINITY), |h, p| (h.0.max(p.x), h.1.max(p.y)));
    (Pt2::new(low.0, low.1), Pt2::new(high.0, high.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pt(x: f64, y: f64) -> Pt2<Plan> {
        Pt2::new(x, y)
    }

    /// A ring of 10 m × 6 m around a core of 6 m × 2 m.
    fn ring() -> Room {
        let outer = [pt(0.0, 0.0), pt(10.0, 0.0), pt(10.0, 6.0), pt(0.0, 6.0)];
        Room::around(RoomKind::Corridor, &outer, &[pt(2.0, 2.0), pt(8.0, 2.0), pt(8.0, 4.0), pt(2.0, 4.0)])
    }

    #[test]
    fn a_ring_does_not_hold_its_core() {
        let ring = ring();
        assert!(ring.holds(pt(1.0, 3.0)) && ring.holds(pt(9.0, 5.0)) && !ring.holds(pt(5.0, 3.0)) && !ring.holds(pt(11.0, 3.0)));
        assert!((ring.area_m2() - (60.0 - 12.0)).abs() < 1e-12);
        assert!(ring.holds(ring.centre()), "{:?}", ring.centre());
        // Eight walls; the slit is none.
        assert_eq!(ring.sides().count(), 8);
    }

    #[test]
    fn paint_covers_the_cells_whose_centres_are_held() {
        let slanted = Room { kind: RoomKind::Hall, outline: vec![pt(0.3, 0.1), pt(4.2, 1.7), pt(3.1, 4.4), pt(1.9, 2.2), pt(-0.4, 3.9)] };
        for room in [ring(), slanted, Room::rectangle(RoomKind::Office, pt(0.33, 0.21), pt(3.77, 2.9))] {
            let (origin, cell_m, size) = ([-1.01, -0.52], 0.17, [70, 45]);
            let mut cells = vec![0u16; size[0] * size[1]];
            room.paint(7, origin, cell_m, size, &mut cells);
            for (i, cell) in cells.iter().enumerate() {
                let p = pt(origin[0] + ((i % size[0]) as f64 + 0.5) * cell_m, origin[1] + ((i / size[0]) as f64 + 0.5) * cell_m);
                assert_eq!(*cell == 7, room.holds(p), "{p:?}");
            }
        }
    }

    #[test]
    fn a_rectangle_knows_that_it_is_one() {
        let room = Room::rectangle(RoomKind::Office, pt(1.0, 2.0), pt(3.0, 5.0));
        assert!(room.is_rectangle() && !ring().is_rectangle());
        assert_eq!(room.centre(), pt(2.0, 3.5));
        assert_eq!(room.area_m2(), 6.0);
    }
}
