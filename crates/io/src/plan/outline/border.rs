//! Where do pixels of one kind end? Loops along the cracks between pixels, gathered by the area that they bound.
//!
//! rows ─▶ runs, joined to those of the row above (areas) ─▶ a loop from every crack that no loop has passed yet
//!
//! Points are corners of pixels: column and row, row 0 at the **top** edge. The area lies to the left of who walks a loop, as the picture
//! is seen: outlines run counter-clockwise, holes clockwise.
//! Sources: crack following after Rosenfeld & Kak 1982, ch. 11; areas by union-find over runs (He, Chao & Suzuki 2008), which is
//! how a hole knows its outline.

use planwalk_types::{Cell, Groups};

use super::super::PlanFileError;
use super::super::cells::Pixels;

/// Most corners of all borders. A floor has some thousands, a hatched scan some hundred thousands; so many take up to 1 GB for a moment.
pub(super) const CORNER_LIMIT: usize = 4_000_000;

/// A corner of a pixel: column, row.
pub(super) type Corner = [i32; 2];

/// When are two pixels one piece?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Joined {
    /// When they have a side in common.
    AtSides,
    /// When they have a corner in common: thin diagonal walls are one piece.
    AtCorners,
}

/// A closed loop between pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Border {
    /// Where it turns; from each corner to the next it is straight. Even in number, at least four.
    pub corners: Vec<Corner>,
}

/// All areas of a picture.
#[derive(Debug, Default)]
pub(super) struct Borders {
    /// Their borders, the outline first.
    pub areas: Vec<Vec<Border>>,
    /// Loops left out because they are too small.
    pub specks: usize,
}

/// The borders of the areas of pixels that are `in`, without those below `smallest_px` in both directions.
pub(super) fn borders(pixels: &Pixels, is_in: impl Fn(Cell) -> bool, joined: Joined, smallest_px: i32) -> Result<Borders, PlanFileError> {
    let mut tracer = Tracer {
        pixels,
        is_in,
        joined,
        passed: vec![0; ((pixels.width + 1) * pixels.height).div_ceil(64)],
        corners_left: CORNER_LIMIT,
        smallest_px,
        specks: 0,
    };
    let mut pieces = Groups::default();
    let mut loops: Vec<(usize, bool, Border)> = Vec::new();
    let (mut above, mut row): (Vec<Run>, Vec<Run>) = (Vec::new(), Vec::new());
    for (v, cells) in pixels.cells.chunks_exact(pixels.width.max(1)).enumerate() {
        std::mem::swap(&mut above, &mut row);
        runs(cells, &tracer.is_in, &mut row);
        join_rows(&above, &mut row, joined, &mut pieces);
        for run in &row {
            // The first crack of a loop that a scan meets is on its top row: an outline's has the area to its right.
            for (u, heading, is_hole) in [(run.start, Heading::Down, false), (run.end, Heading::Up, true)] {
                if !tracer.has_passed(u, v)
                    && let Some(border) = tracer.follow(u, v, heading)?
                {
                    loops.push((run.piece, is_hole, border));
                }
            }
        }
    }
    Ok(Borders { areas: gather(loops, &mut pieces), specks: tracer.specks })
}

/// Holes go to the outline of their area.
fn gather(loops: Vec<(usize, bool, Border)>, pieces: &mut Groups) -> Vec<Vec<Border>> {
    let mut areas: Vec<Vec<Border>> = Vec::new();
    let mut area_of = vec![usize::MAX; pieces.len()];
    // An outline is met before its holes.
    for (piece, is_hole, border) in loops {
        let area = &mut area_of[pieces.first(piece)];
        match areas.get_mut(*area) {
            Some(area) if is_hole => area.push(border),
            Some(_) | None if is_hole => {}
            _ => {
                *area = areas.len();
                areas.push(vec![border]);
            }
        }
    }
    areas
}

/// Columns of one row that are in: `start..end`.
struct Run {
    start: usize,
    end: usize,
    piece: usize,
}

fn runs(cells: &[Cell], is_in: impl Fn(Cell) -> bool, found: &mut Vec<Run>) {
    found.clear();
    let mut at = 0;
    while let Some(skipped) = cells[at..].iter().position(|cell| is_in(*cell)) {
        let start = at + skipped;
        let length = cells[start..].iter().position(|cell| !is_in(*cell));
        at = length.map_or(cells.len(), |length| start + length);
        found.push(Run { start, end: at, piece: 0 });
    }
}

/// Gives each run of a row its piece: that of the runs above that it touches, or a new one.
fn join_rows(above: &[Run], row: &mut [Run], joined: Joined, pieces: &mut Groups) {
    let reach = usize::from(joined == Joined::AtCorners);
    let mut first = 0;
    for run in row {
        while above.get(first).is_some_and(|other| other.end + reach <= run.start) {
            first += 1;
        }
        let touching = above[first..].iter().take_while(|other| other.start < run.end + reach);
        let piece = touching.fold(None, |piece, other| Some(piece.map_or(other.piece, |piece| pieces.join(piece, other.piece))));
        run.piece = piece.unwrap_or_else(|| pieces.push());
    }
}

/// Which way a loop goes; its order is that of right turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Heading {
    Right,
    Down,
    Left,
    Up,
}

impl Heading {
    fn turned_right(self) -> Self {
        match self {
            Self::Right => Self::Down,
            Self::Down => Self::Left,
            Self::Left => Self::Up,
            Self::Up => Self::Right,
        }
    }

    fn turned_left(self) -> Self {
        self.turned_right().turned_right().turned_right()
    }

    fn step(self) -> Corner {
        match self {
            Self::Right => [1, 0],
            Self::Down => [0, 1],
            Self::Left => [-1, 0],
            Self::Up => [0, -1],
        }
    }

    /// From a corner to the pixels ahead, left and right, each by its own top left corner.
    fn ahead(self) -> [Corner; 2] {
        match self {
            Self::Right => [[0, -1], [0, 0]],
            Self::Down => [[0, 0], [-1, 0]],
            Self::Left => [[-1, 0], [-1, -1]],
            Self::Up => [[-1, -1], [0, -1]],
        }
    }
}

struct Tracer<'a, F> {
    pixels: &'a Pixels,
    is_in: F,
    joined: Joined,
    /// One bit for each upright crack: every loop has one, and each belongs to one loop.
    passed: Vec<u64>,
    corners_left: usize,
    smallest_px: i32,
    specks: usize,
}

impl<F: Fn(Cell) -> bool> Tracer<'_, F> {
    /// The crack left of the pixel in this column and row.
    fn has_passed(&self, u: usize, v: usize) -> bool {
        let crack = v * (self.pixels.width + 1) + u;
        self.passed[crack / 64] >> (crack % 64) & 1 == 1
    }

    fn pass(&mut self, u: i32, v: i32) {
        let crack = v as usize * (self.pixels.width + 1) + u as usize;
        self.passed[crack / 64] |= 1 << (crack % 64);
    }

    fn is_in(&self, [u, v]: Corner) -> bool {
        let inside = u >= 0 && v >= 0 && (u as usize) < self.pixels.width && (v as usize) < self.pixels.height;
        inside && (self.is_in)(self.pixels.cells[v as usize * self.pixels.width + u as usize])
    }

    /// The loop through the crack left of this pixel; none if it is a speck.
    fn follow(&mut self, u: usize, v: usize, mut heading: Heading) -> Result<Option<Border>, PlanFileError> {
        // Sides of pictures are at most 32,000 px.
        let (u, v) = (u as i32, v as i32);
        let begin = ([u, if heading == Heading::Up { v + 1 } else { v }], heading);
        let mut at = begin.0;
        let mut corners = Vec::new();
        loop {
            let [du, dv] = heading.step();
            if dv != 0 {
                self.pass(at[0], at[1].min(at[1] + dv));
            }
            at = [at[0] + du, at[1] + dv];
            let turned = self.turn(at, heading);
            if turned != heading {
                corners.push(at);
                if corners.len() > self.corners_left {
                    return Err(PlanFileError::TooRagged { limit: CORNER_LIMIT });
                }
            }
            heading = turned;
            if (at, heading) == begin {
                break;
            }
        }
        if is_below(&corners, self.smallest_px) {
            self.specks += 1;
            return Ok(None);
        }
        self.corners_left -= corners.len();
        corners.shrink_to_fit();
        Ok(Some(Border { corners }))
    }

    /// Where a loop goes on from a corner, its area to the left.
    fn turn(&self, at: Corner, heading: Heading) -> Heading {
        let [left, right] = heading.ahead().map(|pixel| self.is_in([at[0] + pixel[0], at[1] + pixel[1]]));
        match (left, right, self.joined) {
            (true, false, _) => heading,
            (true, true, _) | (false, true, Joined::AtCorners) => heading.turned_right(),
            (false, false, _) | (false, true, Joined::AtSides) => heading.turned_left(),
        }
    }
}

/// Whether a loop is smaller than this many pixels in both directions.
fn is_below(corners: &[Corner], px: i32) -> bool {
    [0, 1].into_iter().all(|k| {
        let (low, high) = corners.iter().fold((i32::MAX, i32::MIN), |(low, high), at| (low.min(at[k]), high.max(at[k])));
        i64::from(high) - i64::from(low) < i64::from(px)
    })
}
