//! Which two lines are the faces of one wall? Parallel ones, as far apart as a wall is thick, beside each other.

use planwalk_types::Form;

use super::super::PlanFileError;
use super::nearby::Nearby;
use super::{Piece, point};

/// Faces of a wall are so far apart, metres. What is thinner is a line drawn twice.
const THICK_M: std::ops::RangeInclusive<f64> = 0.03..=0.5;
/// Parallel is what is this near in direction, as a sine: 2°.
const PARALLEL: f64 = 0.035;
/// Lines that have others on both sides, each this far off, metres, are steps, shelves or hatches. Layers of one wall are closer.
const RUNG_M: f64 = 0.15;
/// Shortest stretch that faces lie beside each other, metres.
const BESIDE_M: f64 = 0.15;
/// Pieces longer than this share are of interest; shorter ones are corners and letters.
const SHORTEST_M: f64 = 0.15;
/// The ground between lines that are faces of one wall.
pub(super) fn between(pieces: &[Piece]) -> Result<Vec<Form>, PlanFileError> {
    let long = || pieces.iter().enumerate().filter(|(_, piece)| piece.length() >= SHORTEST_M);
    let nearby = Nearby::of(long());
    let pairs: Vec<(usize, usize, Pair)> = long()
        .flat_map(|(i, piece)| {
            nearby.to(piece).into_iter().filter(move |j| *j > i).filter_map(move |j| Some((i, j, Pair::of(piece, &pieces[j])?)))
        })
        .collect();
    let mut sides = vec![[false; 2]; pieces.len()];
    for (i, j, pair) in pairs.iter().filter(|(_, _, pair)| pair.apart_m.abs() >= RUNG_M) {
        sides[*i][usize::from(pair.apart_m > 0.0)] = true;
        sides[*j][usize::from(pair.left_of_second)] = true;
    }
    let in_ladder = |i: &usize| sides[*i] == [true; 2];
    nearby.check()?;
    Ok(pairs.iter().filter(|(i, j, _)| !in_ladder(i) && !in_ladder(j)).map(|(i, _, pair)| pair.ground(&pieces[*i])).collect())
}

/// Two pieces beside each other.
struct Pair {
    /// From where to where along the first.
    along_m: [f64; 2],
    /// How far the second is to the left of the first.
    apart_m: f64,
    /// Whether the first is to the left of the second.
    left_of_second: bool,
}

impl Pair {
    /// If they may be the faces of a wall.
    fn of(a: &Piece, b: &Piece) -> Option<Self> {
        let ([ax, ay], [bx, by]) = (a.direction(), b.direction());
        if (ax * by - ay * bx).abs() > PARALLEL {
            return None;
        }
        let ends = [a.seen_from(b.from), a.seen_from(b.to)];
        let along_m = [ends[0][0].min(ends[1][0]).max(0.0), ends[0][0].max(ends[1][0]).min(a.length())];
        let (apart_m, beside) = (0.5 * (ends[0][1] + ends[1][1]), along_m[1] - along_m[0]);
        let opposed = ax * bx + ay * by < 0.0;
        let is_wall = THICK_M.contains(&apart_m.abs()) && beside >= BESIDE_M.max(0.5 * apart_m.abs());
        is_wall.then_some(Self { along_m, apart_m, left_of_second: (apart_m < 0.0) != opposed })
    }

    /// What lies between them.
    fn ground(&self, first: &Piece) -> Form {
        let [from, to] = self.along_m;
        let corners = [(from, 0.0), (to, 0.0), (to, self.apart_m), (from, self.apart_m)];
        Form::Area(vec![corners.map(|(along, left)| point(first.point_at(along, left))).to_vec()])
    }
}
