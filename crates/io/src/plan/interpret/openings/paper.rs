//! Where does paper lie over a wall? What is filled with white hides what was drawn before it: that is how many draw a window.

use planwalk_types::{Element, ElementKind};

use super::super::super::PlanFileError;
use super::super::nearby::Nearby;
use super::super::{Drawn, PAPER, Piece, SketchPoint};
use super::{END_M, SPAN_M, opening};

/// Just beside the paper, metres.
const BESIDE_M: f64 = 0.04;
/// Most corners of walls that are compared with strips, all together: a second or two. Offices need a thousandth of it.
const CORNERS_MOST: usize = 500_000_000;
/// A line on it is glass if it is this long, as a share of it.
const GLASS: f64 = 0.7;

/// Openings where a strip of paper cuts through a wall that was drawn before.
pub(super) fn laid_over(
    drawn: &[&Drawn<'_>],
    is_wall: &impl Fn(&Drawn<'_>) -> bool,
    lines: &[Piece],
) -> Result<Vec<Element>, PlanFileError> {
    let solid: Vec<&Drawn<'_>> = drawn.iter().copied().filter(|path| path.path.closed && path.is_filled() && is_wall(path)).collect();
    let sides: Vec<(Piece, usize)> = solid.iter().enumerate().flat_map(|(i, path)| path.pieces().map(move |piece| (piece, i))).collect();
    let nearby = Nearby::of(sides.iter().map(|(piece, _)| piece).enumerate());
    let glass = Nearby::of(lines.iter().enumerate());
    let mut openings = Vec::new();
    let mut corners = 0;
    for path in drawn.iter().filter(|path| path.path.closed && is_paper(path)) {
        let Some((along, half)) = strip(path) else { continue };
        let middle = along.point_at(0.5 * along.length(), 0.0);
        // Walls with a side near to its middle, which a strip as wide as the wall has.
        let mut walls: Vec<usize> = nearby.to_point(middle).into_iter().filter_map(|i| Some(sides.get(i)?.1)).collect();
        walls.sort_unstable();
        walls.dedup();
        // Five points are asked of each.
        corners += walls.iter().map(|i| 5 * solid[*i].points.len()).sum::<usize>();
        if corners > CORNERS_MOST {
            return Err(PlanFileError::DrawingTooLarge { what: "corners of walls under white areas", limit: CORNERS_MOST });
        }
        let below = |at: SketchPoint| walls.iter().any(|i| solid[*i].path.group < path.path.group && holds(solid[*i], at));
        let length = along.length();
        let on_wall = [0.25, 0.5, 0.75].iter().all(|share| below(along.point_at(share * length, 0.0)));
        let cuts = [half + BESIDE_M, -half - BESIDE_M].iter().all(|left| !below(along.point_at(0.5 * length, *left)));
        if !(on_wall && cuts) {
            continue;
        }
        let is_glass = |piece: &Piece| {
            let ends = [piece.from, piece.to].map(|at| along.seen_from(at));
            let within = ends.iter().all(|end| end[1].abs() < half * 0.9);
            within && (ends[1][0] - ends[0][0]).abs() >= GLASS * length && (ends[0][0].min(ends[1][0])).abs() < 0.5 * length
        };
        let has_glass = glass.to_point(middle).into_iter().filter_map(|i| lines.get(i)).any(is_glass);
        openings.push(opening(if has_glass { ElementKind::Window } else { ElementKind::Door }, &along, -half, half));
    }
    nearby.check()?;
    glass.check()?;
    Ok(openings)
}

/// Filled with what is white.
fn is_paper(path: &Drawn<'_>) -> bool {
    path.path.fill.is_some_and(|fill| fill.iter().all(|v| *v >= PAPER))
}

/// The middle line of a rectangle as thick as a wall, and half of its width.
fn strip(path: &Drawn<'_>) -> Option<(Piece, f64)> {
    let [a, b, c, d] = path.points[..] else { return None };
    let between = |p: SketchPoint, q: SketchPoint| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let ways = [Piece { from: between(a, b), to: between(c, d) }, Piece { from: between(b, c), to: between(d, a) }];
    let [long, wide] = if ways[0].length() >= ways[1].length() { ways } else { [ways[1], ways[0]] };
    let square = long.way()[0] * wide.way()[0] + long.way()[1] * wide.way()[1];
    let is_strip = SPAN_M.contains(&long.length()) && END_M.contains(&wide.length()) && square.abs() < 0.05 * long.length() * wide.length();
    is_strip.then_some((long, 0.5 * wide.length()))
}

/// Even-odd rule.
fn holds(path: &Drawn<'_>, at: SketchPoint) -> bool {
    let ends = path.points.iter().zip(path.points.iter().skip(1).chain(path.points.first()));
    let crossings = ends.filter(|(a, b)| (a[1] > at[1]) != (b[1] > at[1]) && at[0] < a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
    crossings.count() % 2 == 1
}
