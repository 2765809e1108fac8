//! Which pieces are near? A grid of metres in which they are looked up.

use std::cell::Cell;
use std::collections::HashMap;

use super::super::PlanFileError;
use super::{Piece, SketchPoint};

/// Side of a cell, metres: what is asked for is nearer than this.
const CELL_M: f64 = 1.0;
/// Most cells that one piece is entered into: a street's length.
const CELLS_MOST: f64 = 4096.0;

/// Most pieces that are entered and met in all lookups together: some seconds. A storey of an office has a hundredth of it.
const WORK_LIMIT: usize = 30_000_000;
/// Most entries, which take memory.
const ENTRIES_MOST: usize = 20_000_000;

/// Pieces by the cells that they run through.
pub(in crate::plan) struct Nearby {
    cells: HashMap<(i64, i64), Vec<usize>>,
    work: Cell<usize>,
}

impl Nearby {
    /// Of the pieces with these numbers.
    pub(in crate::plan) fn of<'a>(pieces: impl Iterator<Item = (usize, &'a Piece)>) -> Self {
        let (mut cells, mut entries): (HashMap<(i64, i64), Vec<usize>>, usize) = (HashMap::new(), 0);
        for (i, piece) in pieces {
            for cell in cells_of(piece) {
                let entered = cells.entry(cell).or_default();
                if entered.last() != Some(&i) {
                    entered.push(i);
                    entries += 1;
                }
            }
            if entries > ENTRIES_MOST {
                return Self { cells: HashMap::new(), work: Cell::new(WORK_LIMIT + 1) };
            }
        }
        Self { cells, work: Cell::new(0) }
    }

    /// Whether all lookups were answered: a drawing with too much in one place is not gone through.
    ///
    /// # Errors
    /// [`PlanFileError::DrawingTooLarge`].
    pub(in crate::plan) fn check(&self) -> Result<(), PlanFileError> {
        if self.work.get() > WORK_LIMIT {
            Err(PlanFileError::DrawingTooLarge { what: "pairs of lines near to each other", limit: WORK_LIMIT })
        } else {
            Ok(())
        }
    }

    /// Numbers of the pieces within [`CELL_M`] of this one, in rising order; some that are farther are among them. None, once there was
    /// too much to do: see [`Nearby::check`].
    pub(in crate::plan) fn to(&self, piece: &Piece) -> Vec<usize> {
        if self.work.get() > WORK_LIMIT {
            return Vec::new();
        }
        let around = |(x, y): (i64, i64)| (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| (x.saturating_add(dx), y.saturating_add(dy))));
        let mut found: Vec<usize> = cells_of(piece).flat_map(around).filter_map(|cell| self.cells.get(&cell)).flatten().copied().collect();
        self.work.set(self.work.get() + 10 + found.len());
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The same of a point.
    pub(in crate::plan) fn to_point(&self, at: SketchPoint) -> Vec<usize> {
        self.to(&Piece { from: at, to: at })
    }
}

fn cells_of(piece: &Piece) -> impl Iterator<Item = (i64, i64)> + use<> {
    let (from, way) = (piece.from, piece.way());
    // Two steps a cell: no cell that matters is stepped over.
    let count = (2.0 * piece.length() / CELL_M).ceil().clamp(1.0, CELLS_MOST) as usize;
    let at = move |i: usize| [0, 1].map(|k| ((from[k] + way[k] * i as f64 / count as f64) / CELL_M).floor() as i64);
    (0..=count).map(move |i| at(i).into())
}
