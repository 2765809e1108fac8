//! Which pixels hang together? Components of a picture's ink, as runs of its rows.
//!
//! Pixels that touch at a corner are one piece: pens leave no gap there. Cost goes with the runs, not with the pixels, so that a large
//! and mostly empty sheet costs little.

use std::ops::Range;

use planwalk_types::Groups;

/// Most runs that are looked at: dithered pictures have more than a drawing of any size, and no pieces worth knowing.
const RUN_LIMIT: usize = 8_000_000;

/// Pixels of one row that are ink, and the piece that they are of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    pub row: u32,
    pub start: u32,
    pub end: u32,
    pub blob: u32,
}

impl Run {
    /// Places in the picture's list of pixels.
    pub fn places(&self, width: usize) -> Range<usize> {
        let row = self.row as usize * width;
        row + self.start as usize..row + self.end as usize
    }
}

/// One piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blob {
    /// Column and row of its first pixels.
    pub low: [u32; 2],
    /// … and behind its last.
    pub high: [u32; 2],
    /// Pixels.
    pub area: u64,
    /// Runs of its rows.
    pub runs: u32,
}

impl Blob {
    /// Columns and rows that it spans.
    pub fn size(&self) -> [u32; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// Whether most rows cross it more than once, as they do what is drawn round, and most letters.
    pub fn is_closed(&self) -> bool {
        5 * self.runs >= 6 * self.size()[1]
    }

    /// The longer of the two.
    pub fn reach(&self) -> u32 {
        self.size()[0].max(self.size()[1])
    }
}

/// All pieces of a picture.
#[derive(Debug, Default)]
pub(super) struct Blobs {
    /// Row by row, left to right.
    pub runs: Vec<Run>,
    /// In the order of their first runs.
    pub blobs: Vec<Blob>,
}

impl Blobs {
    /// The pieces of the places that are `ink`; `None` where there are too many for a drawing.
    pub fn of(count: usize, width: usize, is_ink: impl Fn(usize) -> bool) -> Option<Self> {
        let mut runs: Vec<Run> = Vec::new();
        let mut groups = Groups::default();
        let (mut above, mut begin) = (0..0, 0);
        for row in 0..count.checked_div(width)? {
            for_runs(
                width,
                |u| is_ink(row * width + u),
                |run| {
                    // A picture has at most 500 million pixels.
                    let blob = groups.push() as u32;
                    runs.push(Run { row: row as u32, start: run.start as u32, end: run.end as u32, blob });
                },
            );
            if runs.len() > RUN_LIMIT {
                return None;
            }
            join_rows(&runs, above, begin..runs.len(), &mut groups);
            above = begin..runs.len();
            begin = runs.len();
        }
        Some(Self::gathered(runs, groups))
    }

    fn gathered(mut runs: Vec<Run>, mut groups: Groups) -> Self {
        let mut blobs: Vec<Blob> = Vec::new();
        let mut number = vec![u32::MAX; groups.len()];
        for run in &mut runs {
            let first = groups.first(run.blob as usize);
            if number[first] == u32::MAX {
                number[first] = blobs.len() as u32;
                blobs.push(Blob { low: [u32::MAX; 2], high: [0; 2], area: 0, runs: 0 });
            }
            run.blob = number[first];
            let blob = &mut blobs[run.blob as usize];
            blob.low = [blob.low[0].min(run.start), blob.low[1].min(run.row)];
            blob.high = [blob.high[0].max(run.end), blob.high[1].max(run.row + 1)];
            blob.area += u64::from(run.end - run.start);
            blob.runs += 1;
        }
        Self { runs, blobs }
    }

    /// The runs of those pieces that are chosen.
    pub fn runs_of(&self, is_chosen: impl Fn(usize) -> bool) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |run| is_chosen(run.blob as usize))
    }

    /// Runs of each piece, by its number: their places in [`Blobs::runs`].
    pub fn by_blob(&self) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.blobs.len()];
        for (i, run) in self.runs.iter().enumerate() {
            lists[run.blob as usize].push(i as u32);
        }
        lists
    }
}

/// Joins runs that touch, at corners too.
fn join_rows(runs: &[Run], above: Range<usize>, row: Range<usize>, groups: &mut Groups) {
    let mut first = above.start;
    for run in &runs[row] {
        while first < above.end && runs[first].end < run.start {
            first += 1;
        }
        for other in runs[first..above.end].iter().take_while(|other| other.start <= run.end) {
            groups.join(run.blob as usize, other.blob as usize);
        }
    }
}

/// Calls `found` with each run of places where `is` holds.
pub(in crate::plan) fn for_runs(count: usize, is: impl Fn(usize) -> bool, mut found: impl FnMut(Range<usize>)) {
    let mut start = None;
    for i in 0..=count {
        match (i < count && is(i), start) {
            (true, None) => start = Some(i),
            (false, Some(begin)) => {
                found(begin..i);
                start = None;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(drawn: &str) -> Blobs {
        let rows: Vec<&str> = drawn.split_whitespace().collect();
        let ink: Vec<bool> = rows.iter().flat_map(|row| row.chars().map(|c| c == '#')).collect();
        Blobs::of(ink.len(), rows[0].len(), |i| ink[i]).unwrap()
    }

    #[test]
    fn pieces_are_joined_at_sides_and_corners_however_late_they_meet() {
        let found = of("#..#.#
                        #..#..
                        .##..#");
        assert_eq!(found.blobs.len(), 3);
        assert_eq!(found.blobs[0], Blob { low: [0, 0], high: [4, 3], area: 6, runs: 5 });
        assert_eq!((found.blobs[1].area, found.blobs[2].reach()), (1, 1));
        assert_eq!(found.by_blob()[2], [6]);
    }

    #[test]
    fn no_picture_has_no_pieces() {
        assert!(Blobs::of(0, 5, |_| true).unwrap().blobs.is_empty());
        assert!(Blobs::of(0, 0, |_| true).is_none());
    }
}
