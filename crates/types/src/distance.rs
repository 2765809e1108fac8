//! How far is every cell of a grid from the nearest one of a kind? Exact Euclidean distances between centres, in cells.
//!
//! cells ─▶ [`in_columns`] (how far up or down) ─▶ an [`Envelope`] a row (how far in the plane)
//!
//! Source: Felzenszwalb & Huttenlocher 2012, "Distance Transforms of Sampled Functions"; linear in the cells.
//! Numbers are of any type that holds small integers: who keeps a byte a cell moves a quarter of the memory of who keeps an `f32`.
//! Rows are independent of each other, so that they can be swept in parallel.

use std::ops::Add;

/// What distances are kept in: `u8`, `f32`, `f64` and the like.
pub trait Distance: Copy + PartialOrd + Add<Output = Self> + From<u8> + Into<f64> {}

impl<D: Copy + PartialOrd + Add<Output = D> + From<u8> + Into<f64>> Distance for D {}

/// Distance from each cell to the nearest one that is of the kind; `far` or more where there is none.
///
/// `is_there` tells it of all cells, row by row, `width` in a row; `far` is more than any
/// distance that matters, and the type holds one more than it.
pub fn to_nearest<D: Distance>(is_there: impl IntoIterator<Item = bool>, width: usize, far: D, kept: impl Fn(f64) -> D) -> Vec<D> {
    let mut distances = in_columns(is_there, width, far);
    let mut envelope = Envelope::default();
    for row in distances.chunks_exact_mut(width.max(1)) {
        envelope.sweep(row, |square| kept(square.sqrt()));
    }
    distances
}

/// Distance from each cell to the nearest one of its own column that is of the kind, at most `far`; like [`to_nearest`].
pub fn in_columns<D: Distance>(is_there: impl IntoIterator<Item = bool>, width: usize, far: D) -> Vec<D> {
    let mut distances: Vec<D> = is_there.into_iter().map(|is_there| if is_there { D::from(0) } else { far }).collect();
    if width == 0 {
        return distances;
    }
    for start in (width..distances.len()).step_by(width) {
        let (done, rest) = distances.split_at_mut(start);
        lower(rest, &done[start - width..]);
    }
    // A last row that is cut short has nothing below some of its columns; nobody passes one.
    for end in (width..distances.len()).step_by(width).rev() {
        let (rest, done) = distances.split_at_mut(end);
        lower(&mut rest[end - width..], done);
    }
    distances
}

/// A row is at most one farther than the one beside it.
fn lower<D: Distance>(row: &mut [D], beside: &[D]) {
    for (here, beside) in row.iter_mut().zip(beside) {
        let next = *beside + D::from(1);
        if next < *here {
            *here = next;
        }
    }
}

/// Lower envelope of the parabolas that stand on the cells of a row; its memory serves all rows.
#[derive(Debug, Clone, Default)]
pub struct Envelope {
    /// Those that are the lowest somewhere: their vertex and height, and where each begins to be the lowest.
    parabolas: Vec<(f64, f64, f64)>,
}

impl Envelope {
    /// Turns distances within the columns, of one row, into distances in the plane; `kept` makes one of a squared distance.
    pub fn sweep<D: Distance>(&mut self, row: &mut [D], kept: impl Fn(f64) -> D) {
        self.parabolas.clear();
        for (at, down) in row.iter().enumerate() {
            let down: f64 = (*down).into();
            self.add(at as f64, down * down);
        }
        let mut parabolas = self.parabolas.iter().copied().peekable();
        let Some((mut vertex, mut height, _)) = parabolas.next() else { return };
        for (at, out) in row.iter_mut().enumerate() {
            let at = at as f64;
            while let Some((v, h, _)) = parabolas.next_if(|next| next.2 <= at) {
                (vertex, height) = (v, h);
            }
            *out = kept(height + (at - vertex) * (at - vertex));
        }
    }

    /// A parabola to the right of all others.
    fn add(&mut self, at: f64, height: f64) {
        while let Some((vertex, lower, begins)) = self.parabolas.last().copied() {
            let meet = ((height + at * at) - (lower + vertex * vertex)) / (2.0 * (at - vertex));
            if meet > begins {
                self.parabolas.push((at, height, meet));
                return;
            }
            self.parabolas.pop();
        }
        self.parabolas.push((at, height, f64::NEG_INFINITY));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The nearest by trying all.
    fn by_trying(cells: &[bool], width: usize) -> Vec<f64> {
        let at = |i: usize| ((i % width) as f64, (i / width) as f64);
        let distance = |i: usize, j: usize| (at(i).0 - at(j).0).hypot(at(i).1 - at(j).1);
        let nearest = |i: usize| (0..cells.len()).filter(|j| cells[*j]).map(|j| distance(i, j)).fold(f64::INFINITY, f64::min);
        (0..cells.len()).map(nearest).collect()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_trying_all_cells(width in 1usize..12, cells in prop::collection::vec(prop::bool::weighted(0.1), 1..150)) {
            let cells = &cells[..cells.len() / width * width];
            prop_assume!(cells.contains(&true));
            let wide = to_nearest(cells.iter().copied(), width, 1e6, |d| d);
            let single = to_nearest(cells.iter().copied(), width, 1e3_f32, |d| d as f32);
            // A byte that ends at 4 is right up to there.
            let capped = to_nearest(cells.iter().copied(), width, 4_u8, |d| d.floor().min(4.0) as u8);
            for (i, nearest) in by_trying(cells, width).into_iter().enumerate() {
                // Round-off of a square root of some hundreds.
                prop_assert!((wide[i] - nearest).abs() < 1e-12 * nearest.max(1.0), "cell {i}: {} for {nearest}", wide[i]);
                prop_assert_eq!(single[i], wide[i] as f32);
                prop_assert_eq!(f64::from(capped[i]), nearest.min(4.0).floor());
            }
        }
    }

    #[test]
    fn a_wide_grid_is_as_exact_as_a_narrow_one() {
        // Squares of columns beyond 4096 are no numbers of single precision: kept in it, but reckoned in double.
        let (width, height) = (9000, 40);
        let cells: Vec<bool> = (0..width * height).map(|i| i % 211 == 0 && i / width % 7 == 3).collect();
        let found = to_nearest(cells.iter().copied(), width, 1e5_f32, |d| d as f32);
        let there: Vec<[i64; 2]> = (0..cells.len()).filter(|i| cells[*i]).map(|i| [(i % width) as i64, (i / width) as i64]).collect();
        for i in (0..cells.len()).step_by(1009) {
            let (u, v) = ((i % width) as i64, (i / width) as i64);
            let nearest = there.iter().map(|at| (at[0] - u).pow(2) + (at[1] - v).pow(2)).min();
            assert_eq!(Some(found[i]), nearest.map(|square| (square as f64).sqrt() as f32), "column {u}, row {v}");
        }
    }

    #[test]
    fn where_there_is_none_everything_is_far() {
        assert!(to_nearest([false; 6], 3, 6.0, |d| d).iter().all(|d| *d >= 6.0));
        assert!(to_nearest([], 3, 6.0_f32, |d| d as f32).is_empty());
        assert_eq!(to_nearest([true], 0, 6.0, |d| d), [0.0], "no width, no neighbours");
    }
}
