//! Which rooms lead into which? Through doors that are drawn, and through openings where their floors touch.

use std::collections::BTreeMap;

use planwalk_types::{Plan, Pt2};

use super::ground::{Ground, Place};
use super::regions::NONE;

/// A door drawn in one face of a wall is so far from the room at its other side, metres.
const DOOR_REACH_M: f64 = 0.4;
/// Floors that touch for less than this touch by a slip of the pen, metres.
const SLIP_M: f64 = 0.15;

/// A way from one place to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Way {
    /// Labels of its two sides, the smaller first; outdoors is the greatest.
    pub sides: [u32; 2],
    /// Its middle.
    pub at: Pt2<Plan>,
    /// Its clear width, metres.
    pub width_m: f64,
    /// Whether a door is drawn in it.
    pub is_door: bool,
}

/// All ways between labelled cells and outdoors, doors first, each sort from the bottom up.
pub(super) fn between(ground: &Ground, labels: &[u32]) -> Vec<Way> {
    let side = |i: usize| labels[i];
    let mut ways = doors(ground, &side);
    ways.extend(openings(ground, &side));
    ways
}

fn doors(ground: &Ground, side: &impl Fn(usize) -> u32) -> Vec<Way> {
    let mut ways = Vec::new();
    for door in ground.groups(|i| ground.places[i] == Place::Door) {
        let (at, width_m) = ground.extent(&door);
        let mut sides = met(ground, &door, 1, side);
        if sides.len() < 2 {
            sides = met(ground, &door, (DOOR_REACH_M / ground.cell_m).ceil() as usize, side);
        }
        for (n, a) in sides.iter().enumerate() {
            ways.extend(sides[n + 1..].iter().map(|b| Way { sides: [*a, *b], at, width_m, is_door: true }));
        }
    }
    ways
}

/// Labels within some cells of a door, rising.
fn met(ground: &Ground, door: &[usize], reach: usize, side: &impl Fn(usize) -> u32) -> Vec<u32> {
    let mut sides: Vec<u32> = door.iter().flat_map(|i| ground.around(*i, reach)).map(side).filter(|s| *s != NONE).collect();
    sides.sort_unstable();
    sides.dedup();
    sides
}

fn openings(ground: &Ground, side: &impl Fn(usize) -> u32) -> Vec<Way> {
    let mut touching: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for i in 0..ground.places.len() {
        let own = side(i);
        if own == NONE {
            continue;
        }
        for k in ground.beside(i) {
            let other = side(k);
            if other != NONE && own < other {
                touching.entry([own, other]).or_default().push(i);
            }
        }
    }
    let mut ways = Vec::new();
    for (sides, cells) in touching {
        for neck in necks(ground, cells) {
            let (at, width_m) = span(ground, &neck);
            if width_m >= SLIP_M {
                ways.push(Way { sides, at, width_m, is_door: false });
            }
        }
    }
    ways
}

/// Cells along a border, gathered by neck.
pub(super) fn necks(ground: &Ground, mut cells: Vec<usize>) -> Vec<Vec<usize>> {
    cells.sort_unstable();
    cells.dedup();
    let mut waiting: BTreeMap<usize, ()> = cells.iter().map(|i| (*i, ())).collect();
    let mut necks = Vec::new();
    while let Some((start, ())) = waiting.pop_first() {
        let mut neck = vec![start];
        let mut next = 0;
        while let Some(i) = neck.get(next).copied() {
            next += 1;
            neck.extend(ground.around(i, 2).filter(|k| waiting.remove(k).is_some()));
        }
        necks.push(neck);
    }
    necks
}

/// Middle and length of a chain of cells, which may run slantwise.
fn span(ground: &Ground, cells: &[usize]) -> (Pt2<Plan>, f64) {
    let (a, b) = tips(ground, cells);
    (Pt2::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y)), a.distance(b) + ground.cell_m)
}

/// The two ends of a chain of cells.
pub(super) fn tips(ground: &Ground, cells: &[usize]) -> (Pt2<Plan>, Pt2<Plan>) {
    let points: Vec<Pt2<Plan>> = cells.iter().map(|i| ground.centre(*i)).collect();
    let Some(first) = points.first() else { return (ground.origin, ground.origin) };
    // The point farthest from any, and the one farthest from that, are the two ends of what is nearly straight.
    let farthest = |from: Pt2<Plan>| points.iter().copied().max_by(|a, b| a.distance(from).total_cmp(&b.distance(from))).unwrap_or(from);
    let end = farthest(*first);
    (farthest(end), end)
}
