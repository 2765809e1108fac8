//! How are the cells of a plan tested sixty-four at a time? Grids of bits, shifted against each other.
//!
//! A [`Bitmap`] holds a grid with a margin of empty cells around it, so that shifts by a few cells lose nothing at the edges.
//! A [`Survivors`] is a grid while many cells are left, and then only those of its words in which one is: what is looked at again and
//! again gets shorter.

use std::ops::Range;

/// A grid of bits: 64 cells a word, rows padded to whole words.
#[derive(Debug, Clone)]
pub(super) struct Bitmap {
    words: Vec<u64>,
    per_row: usize,
    /// Columns with the margin.
    width: usize,
    /// Rows with the margin.
    height: usize,
    margin: usize,
    /// Rows outside of which nothing is set.
    rows: Range<usize>,
}

impl Bitmap {
    /// The cells of a `width` × `height` grid that `hold` names by (column, row), with a margin of empty cells.
    pub(super) fn of(width: usize, height: usize, margin: usize, mut hold: impl FnMut(usize, usize) -> bool) -> Self {
        let (padded_width, padded_height) = (width + 2 * margin, height + 2 * margin);
        let per_row = padded_width.div_ceil(64);
        let mut words = vec![0u64; per_row * padded_height];
        for row in 0..height {
            for column in 0..width {
                if hold(column, row) {
                    let (column, row) = (column + margin, row + margin);
                    words[row * per_row + column / 64] |= 1 << (column % 64);
                }
            }
        }
        Self { words, per_row, width: padded_width, height: padded_height, margin, rows: margin..margin + height }
    }

    /// A grid of the same size with nothing in it.
    pub(super) fn emptied(&self) -> Self {
        Self { words: vec![0; self.words.len()], rows: 0..0, ..*self }
    }

    /// Whether nothing is set.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.start >= self.rows.end
    }

    /// Whether a cell of the grid, without the margin, is set.
    #[cfg(test)]
    pub(super) fn holds(&self, column: usize, row: usize) -> bool {
        let (column, row) = (column + self.margin, row + self.margin);
        self.words[row * self.per_row + column / 64] >> (column % 64) & 1 == 1
    }

    fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.per_row..(row + 1) * self.per_row]
    }

    /// Bits of the word `i` of a row, after the row is moved so that column c holds what column `c + dx` held.
    #[inline]
    fn moved_word(&self, row: i64, i: i64, shift_bits: u32) -> u64 {
        if row < 0 || row >= self.height as i64 {
            return 0;
        }
        let line = self.row(row as usize);
        let at = |i: i64| usize::try_from(i).ok().and_then(|i| line.get(i)).copied().unwrap_or(0);
        let high = if shift_bits == 0 { 0 } else { at(i + 1) << (64 - shift_bits) };
        at(i) >> shift_bits | high
    }

    /// Keeps the cells c for which `other`, of the same size, holds c + (dx, dy).
    ///
    /// All rows are taken as one long row, which is moved as a whole; what came in from the neighbouring row is cleared after.
    pub(super) fn and_moved(&mut self, other: &Bitmap, dx: i64, dy: i64) {
        let old = self.rows.clone();
        let within = |row: i64| row.clamp(old.start as i64, old.end as i64) as usize;
        let mut rows = within(-dy)..within(self.height as i64 - dy);
        if dx.unsigned_abs() as usize >= self.width || rows.start >= rows.end {
            rows = old.start..old.start;
        }
        self.words[old.start * self.per_row..rows.start * self.per_row].fill(0);
        self.words[rows.end * self.per_row..old.end * self.per_row].fill(0);
        let (shift_words, shift_bits) = (dx.div_euclid(64), dx.rem_euclid(64) as u32);
        let target = rows.start * self.per_row..rows.end * self.per_row;
        and_long(&mut self.words, target, &other.words, dy * self.per_row as i64 + shift_words, shift_bits);
        self.clear_moved_in(&rows, dx);
        let none = |row: usize| self.row(row).iter().all(|word| *word == 0);
        while rows.start < rows.end && none(rows.start) {
            rows.start += 1;
        }
        while rows.start < rows.end && none(rows.end - 1) {
            rows.end -= 1;
        }
        self.rows = rows;
    }

    /// Clears the columns c of these rows for which c + dx is on no column.
    fn clear_moved_in(&mut self, rows: &Range<usize>, dx: i64) {
        let by = (dx.unsigned_abs() as usize).min(self.width);
        let columns = if dx > 0 { self.width - by..self.width } else { 0..by };
        if columns.is_empty() {
            return;
        }
        let (first, last) = (columns.start / 64, (columns.end - 1) / 64);
        let (from, to) = (u64::MAX << (columns.start % 64), u64::MAX >> (63 - (columns.end - 1) % 64));
        for row in rows.clone() {
            let line = &mut self.words[row * self.per_row..(row + 1) * self.per_row];
            if first == last {
                line[first] &= !(from & to);
            } else {
                line[first] &= !from;
                line[first + 1..last].fill(0);
                line[last] &= !to;
            }
        }
    }

    /// Adds the cells c for which `other` holds c + (dx, dy).
    pub(super) fn or_moved(&mut self, other: &Bitmap, dx: i64, dy: i64) {
        let (shift_words, shift_bits) = (dx.div_euclid(64), dx.rem_euclid(64) as u32);
        let within = |row: i64| row.clamp(0, self.height as i64) as usize;
        let target = within(other.rows.start as i64 - dy)..within(other.rows.end as i64 - dy);
        for row in target.clone() {
            for i in 0..self.per_row {
                let more = other.moved_word(row as i64 + dy, i as i64 + shift_words, shift_bits);
                self.words[row * self.per_row + i] |= more;
            }
            self.trim(row);
        }
        self.cover(target);
    }

    /// Bits past the last column are no cells.
    fn trim(&mut self, row: usize) {
        let used = self.width % 64;
        if used > 0 {
            self.words[(row + 1) * self.per_row - 1] &= (1 << used) - 1;
        }
    }

    fn cover(&mut self, rows: Range<usize>) {
        if rows.start >= rows.end {
            return;
        }
        self.rows = if self.is_empty() { rows } else { self.rows.start.min(rows.start)..self.rows.end.max(rows.end) };
    }

    /// Adds each cell's neighbours in its row, or in its column.
    pub(super) fn grow(&mut self, along_row: bool) {
        if self.is_empty() {
            return;
        }
        if along_row {
            for row in self.rows.clone() {
                let line = &mut self.words[row * self.per_row..(row + 1) * self.per_row];
                let mut before = 0u64;
                for i in 0..line.len() {
                    let (here, after) = (line[i], line.get(i + 1).copied().unwrap_or(0));
                    line[i] = here | here << 1 | before >> 63 | here >> 1 | after << 63;
                    before = here;
                }
                self.trim(row);
            }
            return;
        }
        let rows = self.rows.start.saturating_sub(1)..(self.rows.end + 1).min(self.height);
        let mut below = vec![0u64; self.per_row];
        for row in rows.clone() {
            let (head, tail) = self.words.split_at_mut((row + 1) * self.per_row);
            let line = &mut head[row * self.per_row..];
            for i in 0..line.len() {
                let here = line[i];
                line[i] |= below[i] | tail.get(i).copied().unwrap_or(0);
                below[i] = here;
            }
        }
        self.rows = rows;
    }

    /// The cells c for which this grid holds one of the `side` × `side` cells from c on, rightwards and upwards.
    pub(super) fn windows(&self, side: usize) -> Self {
        let mut windows = self.clone();
        for _ in 1..side {
            let before = windows.clone();
            for (dx, dy) in [(1, 0), (0, 1), (1, 1)] {
                windows.or_moved(&before, dx, dy);
            }
        }
        windows
    }

    /// The set cells (column, row) without the margin; those in the margin are left out.
    pub(super) fn cells(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let whole = self.rows.clone().flat_map(|row| (0..self.per_row).map(move |i| (row, i)));
        let chunks = whole.map(|(row, i)| (row, i, self.words[row * self.per_row + i])).filter(|(_, _, bits)| *bits != 0);
        chunks.flat_map(|(row, i, bits)| bits_of(bits).map(move |bit| (64 * i + bit, row))).filter_map(|cell| self.inner(cell))
    }

    fn inner(&self, (column, row): (usize, usize)) -> Option<(usize, usize)> {
        let (column, row) = (column.checked_sub(self.margin)?, row.checked_sub(self.margin)?);
        (column + 2 * self.margin < self.width && row + 2 * self.margin < self.height).then_some((column, row))
    }

    /// All cells, to be looked at again and again.
    pub(super) fn survivors(&self) -> Survivors {
        Survivors::Many { grid: self.clone(), looks: 0 }
    }

    fn chunks(&self) -> Vec<Chunk> {
        let mut chunks = Vec::new();
        for row in self.rows.clone() {
            for (i, bits) in self.row(row).iter().enumerate().filter(|(_, bits)| **bits != 0) {
                chunks.push(Chunk { row: row as u32, word: i as u32, bits: *bits });
            }
        }
        chunks
    }

    /// Adds the survivors, moved by (dx, dy); what leaves the grid is lost.
    pub(super) fn add(&mut self, survivors: &Survivors, dx: i64, dy: i64) {
        let chunks = match survivors {
            Survivors::Many { grid, .. } => &grid.chunks(),
            Survivors::Few(chunks) => chunks,
        };
        for chunk in chunks {
            let row = i64::from(chunk.row) + dy;
            if row < 0 || row >= self.height as i64 {
                continue;
            }
            let first = 64 * i64::from(chunk.word) + dx;
            let (word, bit) = (first.div_euclid(64), first.rem_euclid(64) as u32);
            let line = row as usize * self.per_row;
            let mut set = |word: i64, bits: u64| {
                if word >= 0 && word < self.per_row as i64 {
                    self.words[line + word as usize] |= bits;
                }
            };
            set(word, chunk.bits << bit);
            if bit > 0 {
                set(word + 1, chunk.bits >> (64 - bit));
            }
            self.cover(row as usize..row as usize + 1);
        }
    }

    /// Adds all cells of another grid of the same size.
    pub(super) fn or(&mut self, other: &Bitmap) {
        self.or_moved(other, 0, 0);
    }
}

/// `words[i] &=` the source's word i + `by`, moved on by `bits`, for each i in `target`; beyond the source is nothing.
fn and_long(words: &mut [u64], target: Range<usize>, source: &[u64], by: i64, bits: u32) {
    let whole = |i: i64| i.clamp(target.start as i64, target.end as i64) as usize;
    // Where both words of the source are there.
    let fast = whole(-by)..whole(source.len() as i64 - 1 - by).max(whole(-by));
    if !fast.is_empty() {
        let from = (fast.start as i64 + by) as usize;
        let (first, second) = (&source[from..from + fast.len()], &source[from + 1..from + 1 + fast.len()]);
        for ((word, a), b) in words[fast.clone()].iter_mut().zip(first).zip(second) {
            // Two shifts, since one by 64 is none.
            *word &= a >> bits | b << 1 << (63 - bits);
        }
    }
    let at = |i: i64| usize::try_from(i).ok().and_then(|i| source.get(i)).copied().unwrap_or(0);
    for i in (target.start..fast.start).chain(fast.end..target.end) {
        let j = i as i64 + by;
        words[i] &= at(j) >> bits | at(j + 1) << 1 << (63 - bits);
    }
}

fn bits_of(bits: u64) -> impl Iterator<Item = usize> {
    let mut rest = bits;
    std::iter::from_fn(move || {
        let bit = rest.trailing_zeros() as usize;
        rest &= rest.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

/// One word of a grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk {
    row: u32,
    word: u32,
    bits: u64,
}

/// The cells of a grid that are left.
#[derive(Debug, Clone)]
pub(super) enum Survivors {
    /// So many that the whole grid is looked at fastest.
    Many {
        /// All of them.
        grid: Bitmap,
        /// Looks since they were counted.
        looks: usize,
    },
    /// The words in which a cell is left, row by row.
    Few(Vec<Chunk>),
}

/// A word of a list takes as long as this many of a grid.
const FEW: usize = 6;
/// Looks after which the cells of a grid are counted.
const COUNT_EVERY: usize = 6;

impl Survivors {
    /// Words in which a cell is left.
    pub(super) fn words(&self) -> usize {
        match self {
            Self::Many { grid, .. } => grid.rows.clone().map(|row| grid.row(row).iter().filter(|word| **word != 0).count()).sum(),
            Self::Few(chunks) => chunks.len(),
        }
    }

    /// Keeps the cells c for which `map` holds c + (dx, dy); says whether one is left.
    pub(super) fn keep(&mut self, map: &Bitmap, dx: i64, dy: i64) -> bool {
        match self {
            Self::Many { grid, looks } => {
                grid.and_moved(map, dx, dy);
                let (all, any) = (grid.rows.len() * grid.per_row, !grid.is_empty());
                *looks += 1;
                if *looks >= COUNT_EVERY {
                    *looks = 0;
                    if FEW * self.words() < all {
                        *self = self.few();
                    }
                }
                any
            }
            Self::Few(chunks) => {
                let (shift_words, shift_bits) = (dx.div_euclid(64), dx.rem_euclid(64) as u32);
                chunks.retain_mut(|chunk| {
                    chunk.bits &= map.moved_word(i64::from(chunk.row) + dy, i64::from(chunk.word) + shift_words, shift_bits);
                    chunk.bits != 0
                });
                !chunks.is_empty()
            }
        }
    }

    fn few(&self) -> Self {
        match self {
            Self::Many { grid, .. } => Self::Few(grid.chunks()),
            Self::Few(chunks) => Self::Few(chunks.clone()),
        }
    }

    /// The cells (column, row) without the margin of the grid that they come from.
    pub(super) fn cells(&self, of: &Bitmap) -> Vec<(usize, usize)> {
        match self {
            Self::Many { grid, .. } => grid.cells().collect(),
            Self::Few(chunks) => {
                let all =
                    chunks.iter().flat_map(|chunk| bits_of(chunk.bits).map(|bit| (64 * chunk.word as usize + bit, chunk.row as usize)));
                all.filter_map(|cell| of.inner(cell)).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WIDTH: i64 = 150;
    const HEIGHT: i64 = 9;
    const MARGIN: i64 = 3;

    /// Some two thirds of all cells, at random.
    fn grid(seed: u64) -> Bitmap {
        let mixed = |c: usize, r: usize| (c as u64 * 31 + r as u64 * 17 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33;
        Bitmap::of(WIDTH as usize, HEIGHT as usize, MARGIN as usize, |c, r| mixed(c, r) % 3 > 0)
    }

    fn at(map: &Bitmap, column: i64, row: i64) -> bool {
        (0..WIDTH).contains(&column) && (0..HEIGHT).contains(&row) && map.holds(column as usize, row as usize)
    }

    proptest! {
        #[test]
        fn shifts_agree_with_single_bits(seed in 0..50u64, dx in -160..160i64, dy in -10..10i64) {
            let (a, b) = (grid(seed), grid(seed + 1000));
            let (mut dense, mut sparse) = (a.clone(), a.survivors());
            dense.and_moved(&b, dx, dy);
            sparse.keep(&b, dx, dy);
            let expected: Vec<_> = a.cells().filter(|(c, r)| at(&b, *c as i64 + dx, *r as i64 + dy)).collect();
            prop_assert_eq!(dense.cells().collect::<Vec<_>>(), expected.clone());
            prop_assert_eq!(sparse.cells(&a), expected.clone());
            let mut few = a.survivors().few();
            prop_assert_eq!(few.keep(&b, dx, dy), few.words() > 0);
            prop_assert_eq!(few.cells(&a), expected);
            let (mut both, mut added) = (a.clone(), a.emptied());
            both.or_moved(&b, dx, dy);
            added.add(&b.survivors(), -dx, -dy);
            for row in 0..HEIGHT {
                for column in 0..WIDTH {
                    let moved = at(&b, column + dx, row + dy);
                    prop_assert_eq!(at(&both, column, row), at(&a, column, row) || moved);
                    prop_assert_eq!(at(&added, column, row), moved);
                }
            }
        }
    }

    #[test]
    fn windows_reach_over_the_edge_into_the_margin() {
        let map = Bitmap::of(5, 5, 3, |c, r| (c, r) == (0, 0));
        let windows = map.windows(3);
        let mut start = map.emptied();
        start.or_moved(&windows, -2, -2);
        // Shifted back by two cells: the window's corner at (−2, −2) came to (0, 0), and (0, 0) itself to (2, 2).
        assert!(start.holds(0, 0) && start.holds(2, 2) && !start.holds(3, 3));
        assert_eq!(windows.cells().collect::<Vec<_>>(), [(0, 0)]);
    }

    #[test]
    fn growing_adds_the_neighbours() {
        let mut map = Bitmap::of(70, 3, 1, |c, r| (c, r) == (63, 1));
        map.grow(true);
        assert_eq!(map.cells().collect::<Vec<_>>(), [(62, 1), (63, 1), (64, 1)]);
        map.grow(false);
        assert_eq!(map.cells().count(), 9);
    }
}
