//! What are the walls of a storey, piece by piece? CSV `x0,y0,x1,y1,kind`, as [`super::super::wall_list`] reads it.
//!
//! walls ─▶ every side; windows, doors ─▶ the sides along their wall; doors given as points ─▶ the pieces of wall that they open
//!
//! A list of walls knows no areas and no places. Ground is left out, but for a storey without walls and windows: there, outlines of
//! ground are its walls, as when it is drawn.
//! Pitfall: a door's line opens the wall to either side of it. The short sides of a door's area, across its wall, would open a
//! metre of wall beside it.

use std::fmt::Write;

use planwalk_types::{Element, ElementKind, Form, Level, Plan, Pt2};

use super::super::notation::{METRE_DECIMALS, push_decimal};

/// Most pairs of a side and a door given as a point that are looked at: some seconds. A campus has a hundredth.
const PAIR_LIMIT: usize = 1_000_000_000;

/// A straight piece.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    from: Pt2<Plan>,
    to: Pt2<Plan>,
    kind: ElementKind,
}

/// The list. A comment on top tells how many doors are left out, if any.
pub fn csv(level: &Level) -> String {
    let mut sides = sides(level);
    let lost = open_spots(level, &mut sides);
    let mut out = String::new();
    if lost > 0 {
        // Writing to a string does not fail.
        let _ = writeln!(out, "# {lost} doors given as points are left out: no wall is within {} m of them", super::SPOT_RADIUS_M);
    }
    out.push_str("x0,y0,x1,y1,kind\n");
    for side in sides {
        for value in [side.from.x, side.from.y, side.to.x, side.to.y] {
            push_decimal(&mut out, value, METRE_DECIMALS);
            out.push(',');
        }
        out.push_str(side.kind.word());
        out.push('\n');
    }
    out
}

/// All sides but those of doors given as points.
fn sides(level: &Level) -> Vec<Side> {
    let walled = super::elements(level).any(|e| matches!(e.kind, ElementKind::Wall | ElementKind::Window));
    let mut sides = Vec::new();
    for element in super::elements(level) {
        let of = |kind| element_sides(element, kind);
        match element.kind {
            ElementKind::Wall => sides.extend(of(ElementKind::Wall)),
            kind @ (ElementKind::Window | ElementKind::Door) if matches!(element.form, Form::Area(_)) => sides.extend(lengthwise(of(kind))),
            kind @ (ElementKind::Window | ElementKind::Door) => sides.extend(of(kind)),
            _ if !walled && matches!(element.form, Form::Area(_)) => sides.extend(of(ElementKind::Wall)),
            _ => {}
        }
    }
    sides
}

/// Each side of an element's rings, or each piece of its line.
fn element_sides(element: &Element, kind: ElementKind) -> Vec<Side> {
    let pieces = |chain: &[Pt2<Plan>]| chain.windows(2).filter_map(|ends| piece(ends, kind)).collect::<Vec<_>>();
    match &element.form {
        Form::Area(rings) => super::rings(rings)
            .into_iter()
            .flatten()
            .flat_map(|mut ring| {
                ring.extend(ring.first().copied());
                pieces(&ring)
            })
            .collect(),
        Form::Line(line) => pieces(line),
        Form::Spot(_) => Vec::new(),
    }
}

fn piece(ends: &[Pt2<Plan>], kind: ElementKind) -> Option<Side> {
    match ends {
        [from, to] => Some(Side { from: *from, to: *to, kind }),
        _ => None,
    }
}

/// The sides that run as the longest does, within 45°.
fn lengthwise(sides: Vec<Side>) -> Vec<Side> {
    let longest = sides.iter().copied().max_by(|a, b| a.length().total_cmp(&b.length()));
    sides.into_iter().filter(|side| longest.is_some_and(|longest| side.runs_as(&longest))).collect()
}

impl Side {
    fn way(&self) -> [f64; 2] {
        [self.to.x - self.from.x, self.to.y - self.from.y]
    }

    fn length(&self) -> f64 {
        self.from.distance(self.to)
    }

    /// Whether the directions differ by 45° at most, either way round.
    fn runs_as(&self, other: &Self) -> bool {
        let ([ax, ay], [bx, by]) = (self.way(), other.way());
        (ax * bx + ay * by).abs() >= (ax * by - ay * bx).abs()
    }

    /// The part of this side within `radius_m` of a place, as shares of the way; none if it does not come so near.
    fn within(&self, place: Pt2<Plan>, radius_m: f64) -> Option<[f64; 2]> {
        let ([x, y], length) = (self.way(), self.length());
        let from = [place.x - self.from.x, place.y - self.from.y];
        let (along, off) = ((from[0] * x + from[1] * y) / length, (from[0] * y - from[1] * x) / length);
        // Written so that a side of no length is refused too.
        if !(off.abs() < radius_m) {
            return None;
        }
        let half = (radius_m * radius_m - off * off).sqrt();
        let part = [(along - half).max(0.0) / length, (along + half).min(length) / length];
        (part[0] < part[1]).then_some(part)
    }

    /// The point at a share of the way.
    fn at(&self, share: f64) -> Pt2<Plan> {
        let [x, y] = self.way();
        Pt2::new(self.from.x + share * x, self.from.y + share * y)
    }

    /// Distance of a place from the nearest point of this side.
    fn distance(&self, place: Pt2<Plan>) -> f64 {
        let ([x, y], length) = (self.way(), self.length());
        let share = ((place.x - self.from.x) * x + (place.y - self.from.y) * y) / (length * length);
        self.at(if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }).distance(place)
    }
}

/// Doors given as points become the pieces of wall around them that run as the nearest does; how many find no wall.
fn open_spots(level: &Level, sides: &mut Vec<Side>) -> usize {
    let spots: Vec<Pt2<Plan>> = super::elements(level)
        .filter(|element| element.kind == ElementKind::Door)
        .filter_map(|element| if let Form::Spot(spot) = element.form { Some(spot) } else { None })
        .collect();
    if spots.len().saturating_mul(sides.len()) > PAIR_LIMIT {
        return spots.len();
    }
    let walls: Vec<Side> = sides.iter().copied().filter(|side| side.kind != ElementKind::Door).collect();
    let mut lost = 0;
    for spot in spots {
        let near = |side: &&Side| side.distance(spot) <= super::SPOT_RADIUS_M;
        let nearest = walls.iter().filter(near).min_by(|a, b| a.distance(spot).total_cmp(&b.distance(spot)));
        let before = sides.len();
        for wall in walls.iter().filter(|wall| nearest.is_some_and(|nearest| wall.runs_as(nearest))) {
            if let Some([from, to]) = wall.within(spot, super::SPOT_RADIUS_M) {
                sides.push(Side { from: wall.at(from), to: wall.at(to), kind: ElementKind::Door });
            }
        }
        lost += usize::from(sides.len() == before);
    }
    lost
}

#[cfg(test)]
mod tests {
    use super::super::tests::{flat, read, ring};
    use super::*;
    use crate::plan::wall_list;
    use planwalk_types::Cell;
    use proptest::prelude::*;

    fn one(elements: Vec<Element>) -> Level {
        Level { elements, ..Level::default() }
    }

    /// Rows of numbers, with the words.
    fn rows(text: &str) -> Vec<([f64; 4], String)> {
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            ([0, 1, 2, 3].map(|k| cells[k].parse().unwrap()), cells[4].to_owned())
        };
        text.lines().filter(|line| !line.starts_with(['#', 'x'])).map(row).collect()
    }

    #[test]
    fn a_list_is_read_with_its_walls_doors_and_windows() {
        let text = csv(&flat());
        assert!(text.starts_with("x0,y0,x1,y1,kind\n-0.2,-0.2,8.2,-0.2,wall\n") && wall_list::is_one(&text), "{text}");
        let plan = read(&text);
        let at = |x, y| plan.at(Pt2::new(x, y));
        // Both faces of the wall, and the partition.
        assert_eq!([at(3.0, -0.19), at(3.0, 0.01), at(5.01, 1.0)], [Cell::Wall; 3]);
        assert_eq!([at(1.5, -0.19), at(1.5, 0.01), at(5.01, 2.0), at(0.01, 1.5)], [Cell::Door; 4]);
        assert_eq!([at(7.0, -0.19), at(7.0, 0.01), at(2.0, 2.0)], [Cell::Window, Cell::Window, Cell::Free]);
        // Half a metre beside each of them.
        assert_eq!([at(0.5, 0.01), at(2.4, -0.19), at(5.01, 2.95), at(5.7, 0.01)], [Cell::Wall; 4]);
    }

    #[test]
    fn a_door_area_gives_the_sides_along_its_wall() {
        let door = Element::new(ElementKind::Door, Form::Area(vec![ring(1.0, -0.2, 1.9, 0.0)]));
        let sides = [([1.0, -0.2, 1.9, -0.2], "door".to_owned()), ([1.9, 0.0, 1.0, 0.0], "door".to_owned())];
        assert_eq!(rows(&csv(&one(vec![door]))), sides);
    }

    #[test]
    fn a_door_as_a_point_opens_both_faces_of_its_wall_and_no_other_wall() {
        let spot = Element::new(ElementKind::Door, Form::Spot(Pt2::new(1.0, -0.1)));
        let far = Element::new(ElementKind::Door, Form::Spot(Pt2::new(2.0, 2.0)));
        let across = Element::new(ElementKind::Wall, Form::Line(vec![Pt2::new(1.3, 0.0), Pt2::new(1.3, 4.0)]));
        let text = csv(&one(vec![flat().elements[0].clone(), across, spot, far]));
        let doors: Vec<[f64; 4]> = rows(&text).into_iter().filter(|(_, word)| word == "door").map(|(ends, _)| ends).collect();
        // 0.45 m around a place 0.1 m from either face: 0.4387 m along it.
        assert_eq!(doors, [[0.5613, -0.2, 1.4387, -0.2], [0.5613, 0.0, 1.4387, 0.0]]);
        assert!(text.starts_with("# 1 doors given as points are left out"), "{text}");
        assert_eq!(read(&text).at(Pt2::new(1.0, 0.01)), Cell::Door);
    }

    #[test]
    fn rooms_are_walls_where_there_are_no_others() {
        let room = Element::new(ElementKind::Room, Form::Area(vec![ring(0.0, 0.0, 4.0, 3.0)]));
        let door = Element::new(ElementKind::Door, Form::Spot(Pt2::new(2.0, 0.0)));
        let plan = read(&csv(&one(vec![room.clone(), door])));
        assert_eq!([plan.at(Pt2::new(1.0, 0.01)), plan.at(Pt2::new(2.0, 0.01))], [Cell::Wall, Cell::Door]);
        let wall = Element::new(ElementKind::Wall, Form::Line(vec![Pt2::new(0.0, 0.0), Pt2::new(1.0, 0.0)]));
        assert_eq!(rows(&csv(&one(vec![room, wall]))).len(), 1);
    }

    #[test]
    fn doors_without_number_end_in_bounded_time() {
        let spot = |i: u32| Element::new(ElementKind::Door, Form::Spot(Pt2::new(f64::from(i), 0.0)));
        let line = (0..40_000).map(|i| Pt2::new(f64::from(i), f64::from(i % 2))).collect();
        let mut elements: Vec<Element> = (0..40_000).map(spot).collect();
        elements.push(Element::new(ElementKind::Wall, Form::Line(line)));
        assert!(csv(&one(elements)).starts_with("# 40000 doors"));
    }

    proptest! {
        #[test]
        fn every_side_of_a_wall_is_listed_to_a_millimetre(points in prop::collection::vec((-500.0..500.0, 5e6..5.0005e6), 3..12)) {
            let points: Vec<Pt2<Plan>> = points.into_iter().map(|(x, y)| Pt2::new(x, y)).collect();
            let line = Element::new(ElementKind::Wall, Form::Line(points.clone()));
            let area = Element::new(ElementKind::Wall, Form::Area(vec![points.clone()]));
            let n = points.len();
            let meant = (0..n - 1).chain(0..n).map(|i| (points[i], points[(i + 1) % n]));
            let rows = rows(&csv(&one(vec![line, area])));
            prop_assert_eq!(rows.len(), 2 * n - 1);
            for (([x0, y0, x1, y1], word), (from, to)) in rows.into_iter().zip(meant) {
                prop_assert!(word == "wall" && Pt2::new(x0, y0).distance(from) < 1e-3 && Pt2::new(x1, y1).distance(to) < 1e-3);
            }
        }
    }
}
