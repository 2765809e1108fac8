//! Which ends of walls look at each other across a way through? Those in line, a door's width apart, with nothing between.

use planwalk_types::{Element, ElementKind, Form};

use super::super::super::PlanFileError;
use super::super::nearby::Nearby;
use super::super::{Piece, SketchPoint};
use super::{ASLANT, END_M, Faces, TOUCH_M, Taken, WIDEST_DOOR_M, distance, opening, sides};

/// Gaps are no narrower than this, metres.
const NARROWEST_M: f64 = 0.5;
/// Walls in line are off by this much at most, metres, where they are lines, and as a share of the thinner where they are thick.
const OFF_LINE_M: f64 = 0.1;
const OFF_LINE_SHARE: f64 = 0.4;
/// A wall is longer than it is thick by this factor; else it is a column.
const LONGER: f64 = 1.5;

/// The end of a wall.
struct Jamb {
    middle: SketchPoint,
    /// Away from the wall.
    outward: SketchPoint,
    width_m: f64,
    /// Whether the wall behind is long, and no column.
    long: bool,
}

/// Ways through between walls, except where an opening is taken to be already.
pub(super) fn between(found: &[Element], faces: &Faces, taken: &mut Taken) -> Result<Vec<Element>, PlanFileError> {
    let walls = || found.iter().filter(|element| element.kind == ElementKind::Wall);
    let mut jambs: Vec<Jamb> = walls().flat_map(|wall| of_areas(&wall.form)).collect();
    jambs.extend(walls().flat_map(|wall| of_lines(&wall.form, faces)));
    let middles: Vec<Piece> = jambs.iter().map(|jamb| Piece { from: jamb.middle, to: jamb.middle }).collect();
    let nearby = Nearby::of(middles.iter().enumerate());
    let facing: Vec<Option<usize>> = jambs
        .iter()
        .map(|jamb| {
            let reach = [0, 1].map(|k| jamb.middle[k] + WIDEST_DOOR_M * jamb.outward[k]);
            let seen = nearby.to(&Piece { from: jamb.middle, to: reach }).into_iter().filter(|j| jamb.looks_at(&jambs[*j]));
            seen.min_by(|a, b| distance(jamb.middle, jambs[*a].middle).total_cmp(&distance(jamb.middle, jambs[*b].middle)))
        })
        .collect();
    nearby.check()?;
    let mut ways: Vec<Element> = Vec::new();
    for (i, j) in facing.iter().enumerate().filter_map(|(i, j)| Some((i, (*j)?))) {
        let (a, b) = (&jambs[i], &jambs[j]);
        // Each pair once, and only where either is the nearest to the other.
        if j < i || facing[j] != Some(i) || !(a.long || b.long) {
            continue;
        }
        let way = Piece { from: a.middle, to: b.middle };
        let centre = way.point_at(0.5 * way.length(), 0.0);
        if is_free(&way, faces) && !taken.holds(centre) {
            let half = 0.5 * a.width_m.min(b.width_m);
            ways.push(opening(ElementKind::Door, &way, -half, half));
            taken.add(centre);
        }
    }
    Ok(ways)
}

impl Jamb {
    fn looks_at(&self, other: &Self) -> bool {
        let way = [other.middle[0] - self.middle[0], other.middle[1] - self.middle[1]];
        let ahead = way[0] * self.outward[0] + way[1] * self.outward[1];
        let aside = (way[1] * self.outward[0] - way[0] * self.outward[1]).abs();
        let opposed = self.outward[0] * other.outward[0] + self.outward[1] * other.outward[1] < -1.0 + ASLANT * ASLANT;
        let off = OFF_LINE_M.max(OFF_LINE_SHARE * self.width_m.min(other.width_m));
        opposed && aside <= off && (NARROWEST_M..=WIDEST_DOOR_M).contains(&ahead)
    }
}

/// Whether no wall comes near between its ends.
fn is_free(way: &Piece, faces: &Faces) -> bool {
    let steps = (way.length() / 0.2).ceil().max(2.0);
    (1..steps as usize).all(|i| {
        let along = way.length() * i as f64 / steps;
        faces.distance(way.point_at(along, 0.0)) > 0.8 * along.min(way.length() - along).min(0.3)
    })
}

/// Short sides of areas with two corners that stick out.
fn of_areas(form: &Form) -> Vec<Jamb> {
    let Form::Area(rings) = form else { return Vec::new() };
    let ring_of = |ring: &Vec<planwalk_types::Pt2<planwalk_types::Plan>>| -> Vec<Jamb> {
        let pieces: Vec<Piece> = sides(&Form::Area(vec![ring.clone()])).into_iter().filter(|piece| piece.length() > 1e-3).collect();
        let count = pieces.len();
        if count < 4 {
            return Vec::new();
        }
        let area: f64 = pieces.iter().map(|piece| piece.from[0] * piece.to[1] - piece.to[0] * piece.from[1]).sum();
        let turn = |a: &Piece, b: &Piece| {
            let ([ax, ay], [bx, by]) = (a.direction(), b.direction());
            (ax * by - ay * bx) * area.signum()
        };
        let jamb = |i: usize| {
            let (before, piece, after) = (&pieces[(i + count - 1) % count], &pieces[i], &pieces[(i + 1) % count]);
            let convex = turn(before, piece) > 1.0 - ASLANT && turn(piece, after) > 1.0 - ASLANT;
            let (width_m, depth_m) = (piece.length(), before.length().min(after.length()));
            let is_end = convex && END_M.contains(&width_m) && depth_m >= 0.5 * width_m;
            let [c, s] = piece.direction();
            // The area lies to the left of a ring that runs anticlockwise.
            let outward = [s * area.signum(), -c * area.signum()];
            let middle = piece.point_at(0.5 * width_m, 0.0);
            is_end.then_some(Jamb { middle, outward, width_m, long: depth_m >= LONGER * width_m })
        };
        (0..count).filter_map(jamb).collect()
    };
    // Only of outlines: a hole is what walls are around.
    rings.iter().take(1).flat_map(ring_of).collect()
}

/// Ends of lines that touch no other wall.
fn of_lines(form: &Form, faces: &Faces) -> Vec<Jamb> {
    let Form::Line(_) = form else { return Vec::new() };
    let ends = |piece: Piece| [piece, Piece { from: piece.to, to: piece.from }];
    let loose = |piece: &Piece| {
        let others = faces.around(piece.to).filter(|other| other.distance_to(piece.to) <= TOUCH_M);
        // Itself, perhaps drawn twice.
        others.into_iter().all(|other| piece.distance_to(other.from) <= TOUCH_M && piece.distance_to(other.to) <= TOUCH_M)
    };
    sides(form)
        .into_iter()
        .filter(|piece| piece.length() >= NARROWEST_M)
        .flat_map(ends)
        .filter(loose)
        .map(|piece| Jamb { middle: piece.to, outward: piece.direction(), width_m: 0.0, long: true })
        .collect()
}
