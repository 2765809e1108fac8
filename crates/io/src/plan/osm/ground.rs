//! Where is it, in metres? References to nodes become chains and rings on the plane that touches the earth at the first point drawn.
//!
//! refs ─▶ [`Ground::lines`], [`Ground::ring`]      ways of a relation ─▶ [`stitch`] ─▶ refs      line and width ─▶ [`Ground::ribbon`]
//!
//! Nodes that the file does not hold are counted; rings go on without them, lines are interrupted there.

use std::collections::{BTreeSet, HashMap};

use planwalk_types::{Form, Georeference, Plan, Pt2};

use super::super::PlanFileError;
use super::super::projection::Point;
use super::super::projection::Projection;
use super::map::{Map, Tags};

/// Most points, each counted whenever it is looked up, compared, or drawn on one more storey. An airport has 100,000.
const MOST_POINTS: usize = 2_000_000;
/// Points that a ribbon has for each of its line's: a rectangle and an octagon.
const RIBBON_POINTS: usize = 12;
/// A width that is none of a way or a door, metres.
const WIDEST_M: f64 = 100.0;
/// Nodes that an opening reaches past at most, to either side of its own.
const OPENING_NODES: usize = 8;
/// Cosine of the sharpest bend that an opening goes round: 45°.
const OPENING_BEND: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A place on the plan.
pub(super) type Place = Pt2<Plan>;

/// How a line of some width ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    /// Half of the width farther, so that no gap is left where it meets another one.
    Round,
    /// At its last point.
    Flat,
}

/// Looks up places, and keeps count of what that takes.
pub(super) struct Ground<'m> {
    pub map: &'m Map,
    /// Known from the first point on, with the longitude and latitude of it.
    plane: Option<(Projection, Point)>,
    points_left: usize,
    missing: BTreeSet<i64>,
    notes: Vec<String>,
}

impl<'m> Ground<'m> {
    pub(super) fn new(map: &'m Map) -> Self {
        Self { map, plane: None, points_left: MOST_POINTS, missing: BTreeSet::new(), notes: Vec::new() }
    }

    /// Takes points from what may be drawn.
    pub(super) fn spend(&mut self, points: usize) -> Result<(), PlanFileError> {
        let left = self.points_left.checked_sub(points);
        self.points_left = left.ok_or(PlanFileError::OsmTooLarge { what: "points to draw", limit: MOST_POINTS })?;
        Ok(())
    }

    /// Where a node is.
    pub(super) fn place(&mut self, node: i64) -> Option<Place> {
        let Some(point) = self.map.node(node) else {
            self.missing.insert(node);
            return None;
        };
        let (projection, origin) =
            self.plane.get_or_insert_with(|| (Projection::of(Some("EPSG:4326"), false, &[point], &mut self.notes), point));
        // Across the date line, too.
        let turns = ((point[0] - origin[0]) / 360.0).round();
        let [x, y] = projection.metres([point[0] - 360.0 * turns, point[1]]);
        Some(Place::new(x, y))
    }

    /// Chains of at least two different places: more than one where nodes between them are missing.
    pub(super) fn lines(&mut self, nodes: &[i64]) -> Result<Vec<Vec<Place>>, PlanFileError> {
        self.spend(nodes.len())?;
        let mut lines = vec![Vec::new()];
        for node in nodes {
            match (self.place(*node), lines.last_mut()) {
                (Some(place), Some(line)) if line.last() != Some(&place) => line.push(place),
                (Some(_), _) => {}
                (None, _) => lines.push(Vec::new()),
            }
        }
        lines.retain(|line| line.len() > 1);
        Ok(lines)
    }

    /// Areas that a chain of nodes of this width covers, and its length in metres.
    pub(super) fn ribbon(&mut self, nodes: &[i64], width_m: f64, ends: Ends) -> Result<(Vec<Vec<Place>>, f64), PlanFileError> {
        let (mut rings, mut length_m) = (Vec::new(), 0.0);
        for line in self.lines(nodes)? {
            self.spend(RIBBON_POINTS * line.len())?;
            rings.extend(ribbon(&line, width_m, ends));
            length_m += line.iter().zip(line.iter().skip(1)).map(|(a, b)| a.distance(*b)).sum::<f64>();
        }
        Ok((rings, length_m))
    }

    /// A ring that does not repeat its first place; `None` if it has no inside.
    pub(super) fn ring(&mut self, nodes: &[i64]) -> Result<Option<Vec<Place>>, PlanFileError> {
        self.spend(nodes.len())?;
        let mut ring: Vec<Place> = nodes.iter().filter_map(|node| self.place(*node)).collect();
        ring.dedup();
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        Ok((ring.len() > 2).then_some(ring))
    }

    /// A piece of a chain of nodes, this long and with the node at `at` in its middle: a door in a wall. It is shorter where
    /// the wall turns away or ends.
    pub(super) fn opening(&mut self, nodes: &[i64], at: usize, width_m: f64) -> Option<Form> {
        let middle = self.place(*nodes.get(at)?)?;
        // A ring's first node is its last one, too.
        let closed = nodes.len() > 3 && nodes.first() == nodes.last();
        let corners = if closed { nodes.len() - 1 } else { nodes.len() };
        let step = |k: usize, back: bool| match (back, closed) {
            (false, true) => Some((at + k) % corners),
            (true, true) => Some((at + corners - k % corners) % corners),
            (false, false) => Some(at + k),
            (true, false) => at.checked_sub(k),
        };
        let mut arm = |back: bool| {
            let on = (1..=OPENING_NODES).map_while(|k| nodes.get(step(k, back)?)).filter_map(|node| self.place(*node));
            walk(middle, on, width_m / 2.0)
        };
        let (before, after) = (arm(true), arm(false));
        let line: Vec<Place> = before.into_iter().rev().chain([middle]).chain(after).collect();
        (line.len() > 1).then_some(Form::Line(line))
    }

    /// Where the plan's origin is, and what a person should know.
    pub(super) fn finish(self, notes: &mut Vec<String>) -> Option<Georeference> {
        notes.extend(self.notes);
        if !self.missing.is_empty() {
            let count = self.missing.len();
            notes.push(format!("{count} nodes that are referred to are not in the file: ways are drawn without them"));
        }
        self.plane.map(|(_, [longitude_deg, latitude_deg])| Georeference::at_origin(longitude_deg, latitude_deg, 0.0))
    }
}

/// Corners passed and the end reached when walking so far along a chain, without turning off.
fn walk(from: Place, on: impl Iterator<Item = Place>, length_m: f64) -> Vec<Place> {
    let (mut at, mut left_m, mut heading, mut passed) = (from, length_m, None, Vec::new());
    for next in on {
        let piece_m = at.distance(next);
        let [x, y] = [(next.x - at.x) / piece_m, (next.y - at.y) / piece_m];
        let [ahead_x, ahead_y] = *heading.get_or_insert([x, y]);
        // Two nodes at one place have no direction: this ends it, too.
        if !(ahead_x * x + ahead_y * y >= OPENING_BEND) {
            break;
        }
        let step_m = piece_m.min(left_m);
        at = Place::new(at.x + step_m * x, at.y + step_m * y);
        passed.push(at);
        left_m -= step_m;
        if left_m <= 0.0 {
            break;
        }
    }
    passed
}

/// Areas that a line of this width covers: a rectangle for every straight piece, and at joints an octagon around the circle that
/// is as wide as the line.
fn ribbon(line: &[Place], width_m: f64, ends: Ends) -> Vec<Vec<Place>> {
    let half_m = width_m / 2.0;
    let rectangle = |pair: &[Place]| {
        let [a, b] = [*pair.first()?, *pair.get(1)?];
        let scale = half_m / a.distance(b);
        let [x, y] = [(a.y - b.y) * scale, (b.x - a.x) * scale];
        let moved = |p: Place, side: f64| Place::new(p.x + side * x, p.y + side * y);
        scale.is_finite().then(|| vec![moved(a, -1.0), moved(b, -1.0), moved(b, 1.0), moved(a, 1.0)])
    };
    let joints = match ends {
        Ends::Round => line,
        Ends::Flat => line.get(1..line.len().saturating_sub(1)).unwrap_or_default(),
    };
    line.windows(2).filter_map(rectangle).chain(joints.iter().map(|joint| octagon(*joint, width_m))).collect()
}

/// An octagon around a circle.
pub(super) fn octagon(centre: Place, diameter_m: f64) -> Vec<Place> {
    let corner_m = diameter_m / 2.0 / std::f64::consts::FRAC_PI_8.cos();
    let corner = |k: u32| {
        let (s, c) = (std::f64::consts::FRAC_PI_8 * f64::from(2 * k + 1)).sin_cos();
        Place::new(centre.x + corner_m * c, centre.y + corner_m * s)
    };
    (0..8).map(corner).collect()
}

/// Rings made of ways that share their ends, and the number of ways that are left over. The first node is repeated at a ring's end.
pub(super) fn stitch(ways: &[&[i64]]) -> (Vec<Vec<i64>>, usize) {
    let mut ending_at: HashMap<i64, Vec<usize>> = HashMap::new();
    for (index, way) in ways.iter().enumerate() {
        for end in [way.first(), way.last()].into_iter().flatten() {
            ending_at.entry(*end).or_default().push(index);
        }
    }
    let mut used = vec![false; ways.len()];
    let mut take = |index: usize| used.get_mut(index).is_some_and(|used| !std::mem::replace(used, true));
    let (mut rings, mut left_over) = (Vec::new(), 0);
    for (index, way) in ways.iter().enumerate() {
        if way.len() < 2 || !take(index) {
            continue;
        }
        let (mut ring, mut count) = (way.to_vec(), 1);
        while ring.first() != ring.last() {
            let waiting = ring.last().and_then(|end| ending_at.get_mut(end));
            let next = waiting.and_then(|waiting| std::iter::from_fn(|| waiting.pop()).find(|next| take(*next)));
            let Some(next) = next.and_then(|next| ways.get(next)) else { break };
            count += 1;
            if next.first() == ring.last() {
                ring.extend(next.iter().skip(1));
            } else {
                ring.extend(next.iter().rev().skip(1));
            }
        }
        if ring.len() > 3 && ring.first() == ring.last() {
            rings.push(ring);
        } else {
            left_over += count;
        }
    }
    (rings, left_over)
}

/// Whether a place is inside of a ring, by the even-odd rule.
pub(super) fn is_inside(place: Place, ring: &[Place]) -> bool {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossings = edges.filter(|(a, b)| {
        let spans = (a.y > place.y) != (b.y > place.y);
        spans && place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

/// The width that is tagged, metres.
pub(super) fn width_m(tags: &Tags) -> Option<f64> {
    ["width", "est_width"].iter().find_map(|key| length_m(tags.get(key)?))
}

/// A length as OpenStreetMap writes them: `3.5`, `3.5 m`, `12'6"`, `350 cm`.
fn length_m(value: &str) -> Option<f64> {
    const INCH_M: f64 = 0.0254;
    let value = value.trim().replace(',', ".");
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let metres = if let Some((feet, inches)) = value.split_once('\'') {
        let inches = inches.trim().trim_end_matches('"');
        12.0 * INCH_M * number(feet)? + if inches.is_empty() { 0.0 } else { INCH_M * number(inches)? }
    } else {
        let units = [("cm", 0.01), ("mm", 0.001), ("ft", 12.0 * INCH_M), ("in", INCH_M), ("\"", INCH_M), ("m", 1.0), ("", 1.0)];
        units.iter().find_map(|(unit, scale)| Some(scale * number(value.strip_suffix(unit)?)?))?
    };
    (metres > 0.0 && metres <= WIDEST_M).then_some(metres)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn widths_have_units() {
        for (value, metres) in
            [("3.5", 3.5), ("3,5 m", 3.5), ("90 cm", 0.9), ("900mm", 0.9), ("3'", 0.9144), ("12'6\"", 3.81), ("3 ft", 0.9144)]
        {
            assert!((length_m(value).unwrap() - metres).abs() < 1e-9, "{value}");
        }
        for value in ["", "m", "wide", "-1", "0", "nan", "inf", "1e9", "'", "1 km"] {
            assert_eq!(length_m(value), None, "{value}");
        }
    }

    #[test]
    fn ways_are_stitched_whichever_way_they_run() {
        let (rings, left_over) = stitch(&[&[1, 2, 3], &[5, 4, 3], &[5, 1], &[7, 8, 9, 7], &[20, 21]]);
        assert_eq!(rings, [vec![1, 2, 3, 4, 5, 1], vec![7, 8, 9, 7]]);
        assert_eq!(left_over, 1);
        assert_eq!(stitch(&[&[], &[1], &[2, 2], &[3, 4], &[4, 3]]), (vec![], 3));
    }

    #[test]
    fn a_ribbon_covers_its_bends() {
        let line = [Place::new(0.0, 0.0), Place::new(10.0, 0.0), Place::new(10.0, 10.0)];
        let covers = |ends, x, y| ribbon(&line, 4.0, ends).iter().any(|ring| is_inside(Place::new(x, y), ring));
        for (x, y) in [(5.0, 1.9), (5.0, -1.9), (11.9, 5.0), (11.3, -1.3)] {
            assert!(covers(Ends::Flat, x, y) && covers(Ends::Round, x, y), "{x}, {y}");
        }
        assert!(!covers(Ends::Flat, -0.1, 0.0) && covers(Ends::Round, -1.9, 0.0));
        assert!(!covers(Ends::Round, 5.0, 2.1));
        assert!(ribbon(&[line[0], line[0]], 1.0, Ends::Flat).is_empty() && ribbon(&[], 1.0, Ends::Flat).is_empty());
    }

    proptest! {
        #[test]
        fn a_cut_ring_is_stitched_again(size in 4usize..40, cuts in prop::collection::btree_set(0usize..40, 1..8), flips in any::<u64>()) {
            let ring: Vec<i64> = (0..size as i64).collect();
            let cuts: Vec<usize> = cuts.into_iter().filter(|cut| *cut < size).collect();
            prop_assume!(!cuts.is_empty());
            let mut pieces: Vec<Vec<i64>> = Vec::new();
            for (k, from) in cuts.iter().enumerate() {
                let to = cuts.get(k + 1).copied().unwrap_or(cuts[0] + size);
                let mut piece: Vec<i64> = (*from..=to).map(|at| ring[at % size]).collect();
                if flips >> k & 1 == 1 {
                    piece.reverse();
                }
                pieces.push(piece);
            }
            let refs: Vec<&[i64]> = pieces.iter().map(Vec::as_slice).collect();
            let (rings, left_over) = stitch(&refs);
            prop_assert_eq!((rings.len(), left_over), (1, 0));
            let mut nodes = rings[0][1..].to_vec();
            nodes.sort_unstable();
            prop_assert_eq!(nodes, ring);
        }
    }
}
