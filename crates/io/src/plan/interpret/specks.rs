//! Which lines are too small to be walls? Letters, hatches and symbols: little figures that touch no wall.

use std::collections::HashMap;

use planwalk_types::Groups;

use super::super::PlanFileError;
use super::nearby::Nearby;
use super::{Piece, SketchPoint, around};

/// Figures smaller than this, metres corner to corner, are no walls by themselves.
const SMALL_M: f64 = 0.5;
/// Ends this near to each other meet, metres.
const MEET_M: f64 = 0.03;

/// The lines without such figures.
pub(super) fn without(lines: Vec<Piece>) -> Result<Vec<Piece>, PlanFileError> {
    let figures = figures(&lines);
    let mut members: HashMap<usize, Vec<usize>> = HashMap::new();
    for (i, figure) in figures.iter().enumerate() {
        members.entry(*figure).or_default().push(i);
    }
    let large = |figure: usize| around(members[&figure].iter().map(|i| &lines[*i])).is_some_and(|bounds| bounds.diagonal() >= SMALL_M);
    let is_large: HashMap<usize, bool> = members.keys().map(|figure| (*figure, large(*figure))).collect();
    let walls = Nearby::of(lines.iter().enumerate().filter(|(i, _)| is_large[&figures[*i]]));
    let touches = |at: SketchPoint| walls.to_point(at).into_iter().any(|i| lines[i].distance_to(at) <= MEET_M);
    let keeps = |figure: &usize| is_large[figure] || members[figure].iter().any(|i| touches(lines[*i].from) || touches(lines[*i].to));
    let kept: HashMap<usize, bool> = members.keys().map(|figure| (*figure, keeps(figure))).collect();
    walls.check()?;
    Ok(lines.iter().zip(&figures).filter(|(_, figure)| kept[figure]).map(|(piece, _)| *piece).collect())
}

/// For each piece the number of its figure: pieces whose ends meet, directly or by others.
fn figures(lines: &[Piece]) -> Vec<usize> {
    let mut figures = Groups::new(lines.len());
    let mut first_at: HashMap<(i64, i64), usize> = HashMap::new();
    for (i, piece) in lines.iter().enumerate() {
        for end in [piece.from, piece.to] {
            let cell = end.map(|v| (v / MEET_M).round() as i64);
            figures.join(i, *first_at.entry(cell.into()).or_insert(i));
        }
    }
    (0..lines.len()).map(|i| figures.first(i)).collect()
}
