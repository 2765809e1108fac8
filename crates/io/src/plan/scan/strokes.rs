//! What of the ink is written or drawn by a thin pen over thick walls? Circles, arrows and scribbles on a plan whose walls are bars.
//!
//! Only where walls are much thicker than the rest, and only what is curly: a thin line that is straight for a good part of itself is
//! a partition, a window or a shelf, and stays.

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
/// Directions that straight runs are looked for in, over half a turn.
const DIRECTIONS: usize = 24;
/// Most thin pixels that are looked at: more is hatching.
const PIXEL_LIMIT: u64 = 4_000_000;
/// Pictures of more pixels are passed over: to find a scribble there takes longer than all the rest.
const PICTURE_LIMIT: usize = 40_000_000;

/// Runs of curly strokes that a thin pen drew, by piece.
pub(super) fn curls(is_ink: &[bool], width: usize) -> Vec<Vec<Run>> {
    if is_ink.len() > PICTURE_LIMIT {
        return Vec::new();
    }
    let thickness = thickness(&closed(is_ink, width), width);
    let Some(wall) = wall_thickness(&thickness) else { return Vec::new() };
    let thin = (THIN_SHARE * f64::from(wall)) as u8;
    // The rim of a thick stroke is not thin: its pixels have the whole stroke's thickness.
    let Some(found) = Blobs::of(is_ink.len(), width, |i| is_ink[i] && (1..=thin).contains(&thickness[i])) else { return Vec::new() };
    if found.blobs.iter().map(|blob| blob.area).sum::<u64>() > PIXEL_LIMIT {
        return Vec::new();
    }
    let mut curls = Vec::new();
    for (blob, runs) in found.by_blob().into_iter().enumerate() {
        let reach = f64::from(found.blobs[blob].reach());
        // Smaller pieces are rough edges of walls, and dots.
        if reach < 2.0 * f64::from(wall) {
            continue;
        }
        let runs: Vec<Run> = runs.iter().map(|i| found.runs[*i as usize]).collect();
        let straight = longest_straight(&runs, f64::from(thin));
        if straight < STRAIGHT.0 * reach && straight < STRAIGHT.1 * f64::from(wall) {
            curls.push(runs);
        }
    }
    curls
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
        let (s, c) = (std::f64::consts::PI * direction as f64 / DIRECTIONS as f64).sin_cos();
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
        let curls = curls(&drawn(|x, y| walls(x, y) || circle(x, y) || partition(x, y)), W);
        assert_eq!(curls.len(), 1);
        assert!(curls[0].iter().all(|run| run.end < 190 && run.row > 130 && run.row < 270));
    }

    #[test]
    fn where_all_lines_are_thin_a_round_wall_stays() {
        let thin = |v: f64, at: f64| (v - at).abs() <= 1.0;
        let frame = |x: f64, y: f64| thin(x, 20.0) || thin(y, 20.0);
        let round = |x: f64, y: f64| ((x - 200.0).hypot(y - 200.0) - 80.0).abs() <= 1.0;
        assert!(curls(&drawn(|x, y| frame(x, y) || round(x, y)), W).is_empty());
        assert!(curls(&[], 0).is_empty());
    }
}
