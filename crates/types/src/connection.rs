//! Which storeys can one go between? Stairs and lifts of a building, gathered over its storeys.
//!
//! stairs and lifts ─▶ those that overlap, on one storey, on neighbours, or on storeys that one says to join ─▶ [`Connection`]s
//!
//! What the source says ([`Element::joins`]) counts; where it says nothing, shapes of one kind that lie above each other on
//! neighbouring storeys are one. Pitfall: stairs that are drawn on one storey only lead somewhere, too; nobody knows where.

use std::collections::{BTreeMap, BTreeSet};

use crate::building::{Building, Element, ElementKind, Form};
use crate::groups::Groups;
use crate::space::{Plan, Pt2};

/// Shapes overlap if this much of both lies over each other, metres: lifts side by side share a wall.
const OVERLAP_M: f64 = 0.1;
/// Places on each side of the common box at which two shapes are compared.
const SAMPLES: usize = 12;
/// A place is as wide as this around it, metres: half a lift.
const SPOT_M: f64 = 0.75;
/// Most looks at corners of shapes: some tenths of a second. A venue of a hundred stairs needs a hundredth.
const MOST_LOOKS: usize = 50_000_000;

/// Stairs or a lift, on all of its storeys.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// [`ElementKind::Stairs`] or [`ElementKind::Lift`].
    pub kind: ElementKind,
    /// What people call it.
    pub name: Option<String>,
    /// Middle of what is drawn of it on its lowest storey.
    pub at: Pt2<Plan>,
    /// Ordinals of the storeys that it joins, lowest first; one alone if nothing tells where it leads.
    pub ordinals: Vec<i32>,
    /// Whether the source says so; else its shapes lie above each other.
    pub said: bool,
}

/// Stairs and lifts of a building, from the lowest storey up, in the order in which they are drawn.
pub fn connections(building: &Building) -> Vec<Connection> {
    let pieces: Vec<Piece> = (0..)
        .zip(&building.levels)
        .flat_map(|(storey, level)| level.elements.iter().filter_map(move |element| Piece::of(element, storey, level.ordinal)))
        .collect();
    let mut groups = Groups::new(pieces.len());
    let mut looks_left = MOST_LOOKS;
    for (i, a) in pieces.iter().enumerate() {
        for (j, b) in pieces.iter().enumerate().skip(i + 1) {
            // One look at least: a million stairs are none.
            let Some(left) = looks_left.checked_sub(1) else { return gathered(&pieces, &mut groups) };
            looks_left = left;
            if a.may_be_one_with(b) && a.overlaps(b, &mut looks_left) {
                groups.join(i, j);
            }
        }
    }
    gathered(&pieces, &mut groups)
}

fn gathered(pieces: &[Piece], groups: &mut Groups) -> Vec<Connection> {
    let mut found: BTreeMap<usize, Connection> = BTreeMap::new();
    for (i, piece) in pieces.iter().enumerate() {
        let connection = found.entry(groups.first(i)).or_insert_with(|| Connection {
            kind: piece.element.kind,
            name: None,
            at: Pt2::new(0.5 * (piece.low[0] + piece.high[0]), 0.5 * (piece.low[1] + piece.high[1])),
            ordinals: Vec::new(),
            said: false,
        });
        connection.name = connection.name.take().or_else(|| piece.element.name.clone());
        connection.said |= !piece.element.joins.is_empty();
        connection.ordinals.extend(piece.element.joins.iter().copied().chain([piece.ordinal]));
    }
    let sorted = |connection: Connection| {
        let ordinals: BTreeSet<i32> = connection.ordinals.iter().copied().collect();
        Connection { ordinals: ordinals.into_iter().collect(), ..connection }
    };
    found.into_values().map(sorted).collect()
}

/// What is drawn of stairs or a lift on one storey.
struct Piece<'b> {
    element: &'b Element,
    /// Place of the storey, from the lowest.
    storey: usize,
    ordinal: i32,
    low: [f64; 2],
    high: [f64; 2],
}

impl<'b> Piece<'b> {
    fn of(element: &'b Element, storey: usize, ordinal: i32) -> Option<Self> {
        if !matches!(element.kind, ElementKind::Stairs | ElementKind::Lift) {
            return None;
        }
        let margin = if matches!(element.form, Form::Spot(_)) { SPOT_M } else { 0.0 };
        let points = || element.form.points();
        let low = points().fold([f64::INFINITY; 2], |l, p| [l[0].min(p.x - margin), l[1].min(p.y - margin)]);
        let high = points().fold([f64::NEG_INFINITY; 2], |h, p| [h[0].max(p.x + margin), h[1].max(p.y + margin)]);
        let finite = low.iter().chain(&high).all(|v| v.is_finite());
        finite.then_some(Self { element, storey, ordinal, low, high })
    }

    /// Whether they are of one kind, and say nothing against being one.
    fn may_be_one_with(&self, other: &Self) -> bool {
        let (own, others) = (&self.element.joins, &other.element.joins);
        // One flight of a staircase ends where the next one begins.
        let agree = if own.is_empty() || others.is_empty() {
            self.storey.abs_diff(other.storey) <= 1 || own.contains(&other.ordinal) || others.contains(&self.ordinal)
        } else {
            own == others
        };
        self.element.kind == other.element.kind && agree
    }

    fn overlaps(&self, other: &Self, looks_left: &mut usize) -> bool {
        let low = [0, 1].map(|k| self.low[k].max(other.low[k]));
        let high = [0, 1].map(|k| self.high[k].min(other.high[k]));
        // What is drawn as a line has a box that may be flat.
        let is_line = |piece: &Self| matches!(piece.element.form, Form::Line(_));
        let least = if is_line(self) || is_line(other) { 0.0 } else { OVERLAP_M };
        if (0..2).any(|k| high[k] - low[k] < least) {
            return false;
        }
        let step = [0, 1].map(|k| (high[k] - low[k]) / SAMPLES as f64);
        let looks = SAMPLES * SAMPLES * (self.element.form.points().count() + other.element.form.points().count());
        let Some(left) = looks_left.checked_sub(looks) else { return false };
        *looks_left = left;
        (0..SAMPLES * SAMPLES).any(|i| {
            let at = |k: usize, n: usize| low[k] + step[k] * (n as f64 + 0.5);
            let place = [at(0, i % SAMPLES), at(1, i / SAMPLES)];
            self.covers(place) && other.covers(place)
        })
    }

    /// Whether the shape is there; lines and places cover their box.
    fn covers(&self, [x, y]: [f64; 2]) -> bool {
        let Form::Area(rings) = &self.element.form else { return true };
        let edges = rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        // The even-odd rule: holes stay holes.
        edges.filter(|(a, b)| (a.y > y) != (b.y > y) && x < a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x)).count() % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::building::Level;

    fn square(x: f64, y: f64, side: f64) -> Form {
        Form::Area(vec![vec![Pt2::new(x, y), Pt2::new(x + side, y), Pt2::new(x + side, y + side), Pt2::new(x, y + side)]])
    }

    fn stairs(form: Form, joins: &[i32]) -> Element {
        Element { joins: joins.to_vec(), ..Element::new(ElementKind::Stairs, form) }
    }

    fn building(storeys: Vec<(i32, Vec<Element>)>) -> Building {
        let level = |(ordinal, elements): (i32, Vec<Element>)| Level { ordinal, name: ordinal.to_string(), elements };
        Building { levels: storeys.into_iter().map(level).collect(), georeference: None }
    }

    fn ordinals(building: &Building) -> Vec<(Vec<i32>, bool)> {
        connections(building).into_iter().map(|connection| (connection.ordinals, connection.said)).collect()
    }

    #[test]
    fn stairs_above_each_other_are_one_and_those_beside_are_not() {
        let at = |x: f64| stairs(square(x, 0.0, 3.0), &[]);
        let house = building(vec![(-1, vec![at(0.0)]), (0, vec![at(0.2), at(3.125)]), (1, vec![at(3.2)]), (2, vec![at(0.0)])]);
        // The cellar's stairs end on the ground floor; those of the top are drawn there alone.
        assert_eq!(ordinals(&house), [(vec![-1, 0], false), (vec![0, 1], false), (vec![2], false)]);
        let found = connections(&house);
        assert_eq!((found[1].kind, found[1].at), (ElementKind::Stairs, Pt2::new(4.625, 1.5)));
    }

    #[test]
    fn what_the_source_says_counts() {
        // A lift that does not stop on the first floor, drawn as a place; and one that is drawn on one storey alone.
        let lift = |x: f64, joins: &[i32]| Element {
            name: Some("L".to_owned()),
            joins: joins.to_vec(),
            ..Element::new(ElementKind::Lift, Form::Spot(Pt2::new(x, 1.0)))
        };
        let house = building(vec![(0, vec![lift(0.0, &[0, 2]), lift(9.0, &[0, 5])]), (1, vec![]), (2, vec![lift(0.2, &[0, 2])])]);
        assert_eq!(ordinals(&house), [(vec![0, 2], true), (vec![0, 5], true)]);
        assert_eq!(connections(&house)[0].name.as_deref(), Some("L"));
        // Two flights that each say their two storeys are two connections.
        let flight = |joins: &[i32]| stairs(square(0.0, 0.0, 3.0), joins);
        let house = building(vec![(0, vec![flight(&[0, 1])]), (1, vec![flight(&[0, 1]), flight(&[1, 2])]), (2, vec![flight(&[1, 2])])]);
        assert_eq!(ordinals(&house), [(vec![0, 1], true), (vec![1, 2], true)]);
    }

    #[test]
    fn stairs_and_lifts_are_not_one_and_pieces_of_a_flight_are() {
        let lift = Element::new(ElementKind::Lift, square(0.0, 0.0, 2.0));
        let flight = |x: f64| stairs(square(x, 0.0, 2.0), &[]);
        let house = building(vec![(0, vec![flight(0.0), flight(1.5), lift.clone()]), (1, vec![flight(3.0), lift])]);
        assert_eq!(ordinals(&house), [(vec![0, 1], false), (vec![0, 1], false)]);
        // An L around a lift: their boxes overlap, they do not.
        let corner = [(0.0, 0.0), (6.0, 0.0), (6.0, 2.0), (2.0, 2.0), (2.0, 6.0), (0.0, 6.0)];
        let l_shape = Form::Area(vec![corner.map(|(x, y)| Pt2::new(x, y)).to_vec()]);
        let house = building(vec![(0, vec![stairs(l_shape, &[])]), (1, vec![stairs(square(2.5, 2.5, 3.0), &[])])]);
        assert_eq!(ordinals(&house), [(vec![0], false), (vec![1], false)]);
    }

    #[test]
    fn a_hostile_crowd_of_stairs_is_gathered_in_bounded_time() {
        let crowd = (0..30_000).map(|i| stairs(square(f64::from(i), 0.0, 0.5), &[])).collect();
        let count = connections(&building(vec![(0, crowd), (1, vec![stairs(square(f64::NAN, 0.0, 1.0), &[])])])).len();
        assert_eq!(count, 30_000, "what is no place is left out");
    }
}
