//! Which lines are steps? Many of one length, side by side, a step apart.

use planwalk_types::{Element, ElementKind, Form};

use super::{Piece, point};

/// Going of a step, metres: building codes allow from 0.21 to 0.36 m.
const GOING_M: std::ops::RangeInclusive<f64> = 0.2..=0.4;
/// Width of a flight, metres.
const WIDTH_M: std::ops::RangeInclusive<f64> = 0.6..=6.0;
/// Fewest lines that are a flight.
const FEWEST: usize = 5;
/// By how much lengths, places and directions of steps may differ, metres and radians.
const ALIKE: f64 = 0.05;

/// Flights of stairs, and the lines that are none.
pub(super) fn take(lines: Vec<Piece>) -> (Vec<Element>, Vec<Piece>) {
    let mut steps: Vec<usize> = (0..lines.len()).filter(|i| WIDTH_M.contains(&lines[*i].length())).collect();
    // Steps of one flight follow each other when sorted by direction, then by where they begin along it, then across.
    let key = |i: usize| {
        let piece = upward(&lines[i]);
        let [c, s] = piece.direction();
        let (along, across) = (c * piece.from[0] + s * piece.from[1], c * piece.from[1] - s * piece.from[0]);
        [(s.atan2(c) / ALIKE).round(), (along / ALIKE).round(), across]
    };
    steps.sort_by(|a, b| {
        let (p, q) = (key(*a), key(*b));
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2]))
    });
    let mut is_step = vec![false; lines.len()];
    let mut flights = Vec::new();
    for flight in steps.chunk_by(|a, b| follows(&upward(&lines[*a]), &upward(&lines[*b]))).filter(|flight| flight.len() >= FEWEST) {
        flight.iter().for_each(|i| is_step[*i] = true);
        let (first, last) = (upward(&lines[flight[0]]), upward(&lines[flight[flight.len() - 1]]));
        let ring = [first.from, first.to, last.to, last.from].map(point).to_vec();
        flights.push(Element::new(ElementKind::Stairs, Form::Area(vec![ring])));
    }
    let rest = lines.into_iter().zip(is_step).filter(|(_, step)| !step).map(|(piece, _)| piece).collect();
    (flights, rest)
}

/// The piece, turned so that it runs to the right, or straight up.
fn upward(piece: &Piece) -> Piece {
    let [x, y] = piece.direction();
    if x > 1e-6 || (x.abs() <= 1e-6 && y > 0.0) { *piece } else { Piece { from: piece.to, to: piece.from } }
}

/// Whether b is the step after a.
fn follows(a: &Piece, b: &Piece) -> bool {
    let [from, to] = [a.seen_from(b.from), a.seen_from(b.to)];
    let beside = from[0].abs() < ALIKE && (to[0] - a.length()).abs() < ALIKE;
    beside && (from[1] - to[1]).abs() < ALIKE && GOING_M.contains(&from[1].abs())
}
