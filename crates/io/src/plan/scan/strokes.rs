//! What of the ink is written or drawn by a thin pen over thick walls? Circles, arrows and scribbles on a plan whose walls are bars.
//!
//! Only where walls are much thicker than the rest, and only what is curly: a thin line that is straight for a good part of itself is
//! a partition, a window or a shelf, and stays. And what of it is a speck: dots that are much smaller than such walls are thick are what
//! a scan leaves of a coloured line.
//! Pitfall: a scanner breaks a pen's line into pieces, each of which is straight. Where specks tell of one, pieces are joined before they
//! are looked at.

use super::blobs::{Blobs, Run};

/// A plan has thick walls if strokes this many pixels thick, or thicker, hold most of its ink.
const THICK_PX: u8 = 6;
/// … and a thin pen is at most this share of their thickness.
const THIN_SHARE: f64 = 0.5;
/// Share of the ink that the walls hold at least.
const WALL_SHARE: f64 = 0.5;
/// Holes in ink that are no wider than this are a scanner's, pixels.
const PINHOLE_PX: usize = 2;
/// A thin piece that is straight for this share of its reach, or this many wall thicknesses, stays.
const STRAIGHT: (f64, f64) = (0.55, 8.0);
/// Gaps in a pen's line are no wider than this, pixels, or than the pen.
const GAP_PX: usize = 4;
/// A speck is no larger than this share of the walls' thickness …
const SPECK_SHARE: f64 = 0.4;
/// … and than this, metres: a larger one may be a post.
const SPECK_M: f64 = 0.1;
/// So many of that share tell a scan; drawings have a few dots that mean something.
const LEAST_SPECKS: usize = 1000;
/// Directions that straight runs are looked for in, over half a turn.
const DIRECTIONS: usize = 24;
/// Most thin pixels that are looked at: more is hatching.
const PIXEL_LIMIT: u64 = 4_000_000;
/// Pictures of more pixels are passed over: to find a scribble there takes longer than all the rest.
const PICTURE_LIMIT: usize = 40_000_000;

/// What a thin pen or a scanner left on a plan with thick walls.
#[derive(Debug, Default)]
pub(super) struct Strokes {
    /// Curly strokes of the pen, each with its runs.
    pub curls: Vec<Vec<Run>>,
    /// Specks, one after the other.
    pub specks: Vec<Run>,
    /// Number of specks.
    pub speck_count: usize,
}

/// Curly strokes that a thin pen drew, and specks.
pub(super) fn strokes(is_ink: &[bool], width: usize, metres_per_pixel: f64) -> Strokes {
    if is_ink.len() > PICTURE_LIMIT {
        return Strokes::default();
    }
    let thickness = thickness(&closed(is_ink, width), width);
    let Some(wall) = wall_thickness(&thickness) else { return Strokes::default() };
    // Specks are told beside a wall's thickness; walls as thick as can be told are dark areas, and theirs is not known.
    let found = if wall < u8::MAX { Blobs::of(is_ink.len(), width, |i| is_ink[i]).unwrap_or_default() } else { Blobs::default() };
    let is_small = |blob: usize| f64::from(found.blobs[blob].reach()) <= SPECK_SHARE * f64::from(wall);
    let small = (0..found.blobs.len()).filter(|blob| is_small(*blob)).count();
    if small < LEAST_SPECKS {
        return Strokes { curls: curls(is_ink, &thickness, width, wall, 0), ..Strokes::default() };
    }
    let is_speck = |blob: usize| is_small(blob) && f64::from(found.blobs[blob].reach()) * metres_per_pixel <= SPECK_M;
    Strokes {
        curls: curls(is_ink, &thickness, width, wall, GAP_PX),
        specks: found.runs_of(is_speck).copied().collect(),
        speck_count: (0..found.blobs.len()).filter(|blob| is_speck(*blob)).count(),
    }
}

/// Runs of curly strokes, by piece, beside walls of this thickness; pieces with no wider gaps than this are one.
fn curls(is_ink: &[bool], thickness: &[u8], width: usize, wall: u8, gap_px: usize) -> Vec<Vec<Run>> {
    let thin = (THIN_SHARE * f64::from(wall)) as u8;
    // The rim of a thick stroke is not thin: its pixels have the whole stroke's thickness.
    let is_thin: Vec<bool> = is_ink.iter().zip(thickness).map(|(ink, t)| *ink && (1..=thin).contains(t)).collect();
    if is_thin.iter().filter(|is| **is).count() as u64 > PIXEL_LIMIT {
        return Vec::new();
    }
    let found = match gap_px.min(thin.into()).div_ceil(2) {
        0 => Blobs::of(is_thin.len(), width, |i| is_thin[i]),
        reach => {
            let joined = grown(&is_thin, width, reach);
            Blobs::of(joined.len(), width, |i| joined[i])
        }
    };
    let Some(found) = found else { return Vec::new() };
    let mut curls = Vec::new();
    for (blob, runs) in found.by_blob().into_iter().enumerate() {
        let reach = f64::from(found.blobs[blob].reach());
        // Smaller pieces are rough edges of walls, and dots.
        if reach < 2.0 * f64::from(wall) {
            continue;
        }
        let runs: Vec<Run> = runs.iter().flat_map(|i| within(found.runs[*i as usize], &is_thin, width)).collect();
        let straight = longest_straight(&runs, f64::from(thin));
        if straight < STRAIGHT.0 * reach && straight < STRAIGHT.1 * f64::from(wall) {
            curls.push(runs);
        }
    }
    curls
}

/// The parts of a run that are in it.
fn within(run: Run, is_in: &[bool], width: usize) -> Vec<Run> {
    let begin = run.places(width).start;
    let mut parts = Vec::new();
    let mut add = |part: std::ops::Range<usize>| {
        parts.push(Run { start: run.start + part.start as u32, end: run.start + part.end as u32, ..run });
    };
    super::for_runs((run.end - run.start) as usize, |u| is_in[begin + u], &mut add);
    parts
}

/// Everything within some pixels along rows and columns.
fn grown(is_in: &[bool], width: usize, by: usize) -> Vec<bool> {
    let mut grown = is_in.to_vec();
    let mut fill = |place: usize, step: usize, first: usize, last: usize| {
        (first..=last).for_each(|k| grown[place + k * step - by * step] = true);
    };
    let height = is_in.len() / width.max(1);
    for (place, _) in is_in.iter().enumerate().filter(|(_, is)| **is) {
        let (u, v) = (place % width, place / width);
        // From `by` before to `by` behind, as far as the picture goes.
        let span = |at: usize, end: usize| (by.saturating_sub(at), (by + end - 1 - at).min(2 * by));
        let (left, right) = span(u, width);
        let (top, bottom) = span(v, height);
        fill(place, 1, left, right);
        fill(place, width, top, bottom);
    }
    grown
}

/// The ink without the pinholes that a scanner leaves in it: gaps of rows, and then of columns, of no more than [`PINHOLE_PX`].
fn closed(is_ink: &[bool], width: usize) -> Vec<bool> {
    let mut closed = is_ink.to_vec();
    for row in closed.chunks_mut(width.max(1)) {
        let mut last: Option<usize> = None;
        for u in 0..row.len() {
            if row[u] {
                if let Some(from) = last.filter(|from| u - from <= PINHOLE_PX + 1) {
                    row[from..u].fill(true);
                }
                last = Some(u);
            }
        }
    }
    for i in 0..closed.len() {
        for gap in 1..=PINHOLE_PX {
            let above = (gap + 1) * width;
            if closed[i] && i >= above && closed[i - above] {
                (1..=gap).for_each(|k| closed[i - k * width] = true);
            }
        }
    }
    closed
}

/// Thickness of the stroke at each place, pixels, 255 for more: the shorter of the runs of ink along its row and column.
fn thickness(is_ink: &[bool], width: usize) -> Vec<u8> {
    let mut down = vec![0u8; is_ink.len()];
    for i in 0..is_ink.len() {
        let above = if i >= width { down[i - width] } else { 0 };
        down[i] = if is_ink[i] { above.saturating_add(1) } else { 0 };
    }
    // The count at a run's lower end is its length.
    for i in (0..is_ink.len().saturating_sub(width)).rev() {
        if down[i] > 0 && down[i + width] > 0 {
            down[i] = down[i + width];
        }
    }
    for (row, ink) in down.chunks_mut(width.max(1)).zip(is_ink.chunks(width.max(1))) {
        super::for_runs(
            ink.len(),
            |u| ink[u],
            |run| {
                let length = run.len().min(255) as u8;
                row[run].iter_mut().for_each(|t| *t = (*t).min(length));
            },
        );
    }
    down
}

/// The walls' thickness, where walls are thick and most of the ink: the median over the ink of thick strokes.
fn wall_thickness(thickness: &[u8]) -> Option<u8> {
    let mut counts = [0u64; 256];
    thickness.iter().for_each(|t| counts[usize::from(*t)] += 1);
    let (ink, thick) = (counts[1..].iter().sum::<u64>(), counts[usize::from(THICK_PX)..].iter().sum::<u64>());
    if (thick as f64) < WALL_SHARE * ink as f64 || ink == 0 {
        return None;
    }
    let mut left = thick / 2;
    (THICK_PX..=255).find(|t| {
        let count = counts[usize::from(*t)];
        let found = count > left;
        left = left.saturating_sub(count);
        found
    })
}

/// Length of the longest straight line within a piece, pixels: within a strip as wide as the pen, and without gaps.
fn longest_straight(runs: &[Run], pen: f64) -> f64 {
    let strip = pen.max(2.0);
    let mut longest: f64 = 0.0;
    for direction in 0..DIRECTIONS {
        let (s, c) = libm::sincos(std::f64::consts::PI * direction as f64 / DIRECTIONS as f64);
        let places = runs.iter().flat_map(|run| (run.start..run.end).map(move |u| (f64::from(u), f64::from(run.row))));
        let mut at: Vec<(i64, f64)> = places.map(|(u, v)| (((c * v - s * u) / strip).floor() as i64, c * u + s * v)).collect();
        at.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for line in at.chunk_by(|a, b| a.0 == b.0 && b.1 - a.1 <= 2.0) {
            if let (Some(first), Some(last)) = (line.first(), line.last()) {
                longest = longest.max(last.1 - first.1);
            }
        }
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: usize = 400;

    fn drawn(is: impl Fn(f64, f64) -> bool) -> Vec<bool> {
        (0..W * W).map(|i| is((i % W) as f64, (i / W) as f64)).collect()
    }

    fn walls(x: f64, y: f64) -> bool {
        let near = |v: f64, at: f64| (v - at).abs() <= 5.0;
        (near(x, 20.0) || near(x, 380.0) || near(y, 20.0) || near(y, 380.0)) && (15.0..=385.0).contains(&x) && (15.0..=385.0).contains(&y)
    }

    #[test]
    fn a_circle_over_thick_walls_goes_and_a_thin_partition_stays() {
        let circle = |x: f64, y: f64| ((x - 120.0).hypot(y - 200.0) - 60.0).abs() <= 1.5;
        let partition = |x: f64, y: f64| (x - 0.2 * y - 230.0).abs() <= 1.5 && (20.0..380.0).contains(&y);
        let curls = strokes(&drawn(|x, y| walls(x, y) || circle(x, y) || partition(x, y)), W, 0.05).curls;
        assert_eq!(curls.len(), 1);
        assert!(curls[0].iter().all(|run| run.end < 190 && run.row > 130 && run.row < 270));
    }

    #[test]
    fn where_all_lines_are_thin_a_round_wall_stays() {
        let thin = |v: f64, at: f64| (v - at).abs() <= 1.0;
        let frame = |x: f64, y: f64| thin(x, 20.0) || thin(y, 20.0);
        let round = |x: f64, y: f64| ((x - 200.0).hypot(y - 200.0) - 80.0).abs() <= 1.0;
        assert!(strokes(&drawn(|x, y| frame(x, y) || round(x, y)), W, 0.05).curls.is_empty());
        assert!(strokes(&[], 0, 0.05).curls.is_empty());
    }

    /// Dots of 2 px, as many as fit within the walls' lower half.
    fn dots(x: f64, y: f64) -> bool {
        (200.0..360.0).contains(&y) && (40.0..360.0).contains(&x) && x.rem_euclid(7.0) < 2.0 && y.rem_euclid(7.0) < 2.0
    }

    fn pieces(x: f64, y: f64) -> bool {
        let (dx, dy) = (x - 120.0, y - 120.0);
        (dx.hypot(dy) - 60.0).abs() <= 1.5 && (dy.atan2(dx) * 60.0).rem_euclid(15.0) > 3.0
    }

    #[test]
    fn on_a_speckled_scan_specks_go_and_the_pieces_of_a_circle_but_a_post_stays() {
        let post = |x: f64, y: f64| (x - 300.0).abs() < 4.0 && (y - 100.0).abs() < 4.0;
        let found = strokes(&drawn(|x, y| walls(x, y) || pieces(x, y) || dots(x, y) || post(x, y)), W, 0.05);
        assert_eq!((found.curls.len(), found.speck_count), (1, 46 * 23));
        assert!(found.specks.iter().all(|run| run.row >= 200));
        // Four fifths of a line of 3 px, 377 px long.
        let pixels: u32 = found.curls[0].iter().map(|run| run.end - run.start).sum();
        assert!((f64::from(pixels) - 905.0).abs() < 100.0, "{pixels} px");
    }

    #[test]
    fn dots_and_pieces_stay_where_they_are_few_and_dots_where_they_are_as_large_as_posts() {
        let few = strokes(&drawn(|x, y| walls(x, y) || pieces(x, y) || (dots(x, y) && y < 300.0)), W, 0.05);
        assert_eq!((few.curls.len(), few.speck_count), (0, 0));
        assert_eq!(strokes(&drawn(|x, y| walls(x, y) || dots(x, y)), W, 0.06).speck_count, 0);
    }
}
