//! Where do the walls on a grid begin and end? Their outlines, as few straight lines as the cells allow.

/// Largest distance of a point of the outline from the line that replaces it, in cells. The middles of an oblique wall's steps lie
/// within half a cell of a straight line; much more would cut real corners off.
const TOLERANCE_CELLS: f64 = 0.75;
/// A step of at most so many cells between a left and a right turn counts as its middle: it is a stair of an oblique wall, or noise.
const STEP_CELLS: i32 = 1;

/// Which cells of a grid are set; beyond it none is.
pub(super) struct Mask<'a> {
    pub cells: &'a [bool],
    pub width: usize,
    pub height: usize,
}

/// Right, up, left, down.
const WAYS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

impl Mask<'_> {
    fn at(&self, x: i32, y: i32) -> bool {
        x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height && self.cells[y as usize * self.width + x as usize]
    }

    /// All outlines, in cells, closed, with the set cells to the left. Cells that touch at a corner belong together, so no line of
    /// sight leads between them.
    pub fn outlines(&self) -> Vec<Vec<[f64; 2]>> {
        // One bit for each side of a cell; only lower sides need be remembered as starts, since every outline has one.
        let mut done = vec![false; self.cells.len()];
        let mut outlines = Vec::new();
        for y in 0..self.height as i32 {
            for x in 0..self.width as i32 {
                if self.at(x, y) && !self.at(x, y - 1) && !done[y as usize * self.width + x as usize] {
                    outlines.push(simplified(&self.follow(x, y, &mut done)));
                }
            }
        }
        outlines
    }

    /// The corners of the outline that leads along the lower side of a cell.
    fn follow(&self, x: i32, y: i32, done: &mut [bool]) -> Vec<[i32; 2]> {
        let (mut at, mut way) = ([x, y], 0);
        let mut corners = Vec::new();
        loop {
            if way == 0 {
                let i = at[1] as usize * self.width + at[0] as usize;
                if done[i] {
                    return corners;
                }
                done[i] = true;
            }
            let (dx, dy) = WAYS[way];
            at = [at[0] + dx, at[1] + dy];
            // The cells ahead, to the left and to the right of the corner, by their lower left corners.
            let (left, right) = match way {
                0 => ([0, 0], [0, -1]),
                1 => ([-1, 0], [0, 0]),
                2 => ([-1, -1], [-1, 0]),
                _ => ([0, -1], [-1, -1]),
            };
            let set = |c: [i32; 2]| self.at(at[0] + c[0], at[1] + c[1]);
            if set(right) {
                way = (way + 3) % 4;
            } else if !set(left) {
                way = (way + 1) % 4;
            } else {
                continue;
            }
            corners.push(at);
        }
    }
}

/// The closed line with as few corners as [`TOLERANCE_CELLS`] allows (Douglas & Peucker 1973).
fn simplified(corners: &[[i32; 2]]) -> Vec<[f64; 2]> {
    let exact: Vec<[f64; 2]> = corners.iter().map(|c| [f64::from(c[0]), f64::from(c[1])]).collect();
    let points = with_middles_of_steps(corners);
    if points.len() < 3 {
        return exact;
    }
    // Two points that surely stay: the lowest of the leftmost ones, and the farthest from it.
    let leftmost = |a: &usize, b: &usize| points[*a][0].total_cmp(&points[*b][0]).then(points[*a][1].total_cmp(&points[*b][1]));
    let Some(first) = (0..points.len()).min_by(leftmost) else { return exact };
    let far2 = |i: usize| (points[i][0] - points[first][0]).powi(2) + (points[i][1] - points[first][1]).powi(2);
    let Some(second) = (0..points.len()).max_by(|a, b| far2(*a).total_cmp(&far2(*b))) else { return exact };
    let count = points.len();
    let ring: Vec<[f64; 2]> = (0..=count).map(|i| points[(first + i) % count]).collect();
    let middle = (second + count - first) % count;
    let mut kept = vec![false; ring.len()];
    (kept[0], kept[middle]) = (true, true);
    keep(&ring, 0, middle, &mut kept);
    keep(&ring, middle, count, &mut kept);
    let line: Vec<[f64; 2]> = (0..count).filter(|i| kept[*i]).map(|i| ring[i]).collect();
    // What a tolerance would flatten to nothing stays as it is.
    if line.len() < 3 { exact } else { line }
}

/// The outline with each small step replaced by its middle; other corners stay.
fn with_middles_of_steps(corners: &[[i32; 2]]) -> Vec<[f64; 2]> {
    let count = corners.len();
    let at = |i: usize| corners[i % count];
    let run = |i: usize| [at(i + 1)[0] - at(i)[0], at(i + 1)[1] - at(i)[1]];
    let turns_left = |i: usize| {
        let (before, after) = (run(i + count - 1), run(i));
        before[0] * after[1] - before[1] * after[0] > 0
    };
    let is_step = |i: usize| run(i)[0].abs() + run(i)[1].abs() <= STEP_CELLS && turns_left(i) != turns_left(i + 1);
    let mut points = Vec::with_capacity(count);
    for i in 0..count {
        if is_step(i) {
            let (a, b) = (at(i), at(i + 1));
            points.push([0.5 * f64::from(a[0] + b[0]), 0.5 * f64::from(a[1] + b[1])]);
        } else if !is_step(i + count - 1) {
            points.push([f64::from(at(i)[0]), f64::from(at(i)[1])]);
        }
    }
    points
}

fn keep(line: &[[f64; 2]], from: usize, to: usize, kept: &mut [bool]) {
    let mut open = vec![(from, to)];
    while let Some((from, to)) = open.pop() {
        let (a, b) = (line[from], line[to]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = libm::hypot(dx, dy);
        let off = |p: [f64; 2]| {
            if length == 0.0 {
                return libm::hypot(p[0] - a[0], p[1] - a[1]);
            }
            // Beyond the ends the distance is to the end: outlines turn back on themselves.
            let t = (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (length * length)).clamp(0.0, 1.0);
            libm::hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)
        };
        let worst = (from + 1..to).map(|i| (off(line[i]), i)).max_by(|p, q| p.0.total_cmp(&q.0));
        if let Some((_, i)) = worst.filter(|(distance, _)| *distance > TOLERANCE_CELLS) {
            kept[i] = true;
            open.push((from, i));
            open.push((i, to));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outlines(rows: &[&str]) -> Vec<Vec<[f64; 2]>> {
        let (width, height) = (rows[0].len(), rows.len());
        // Row 0 is the lowest: the last one written.
        let cells: Vec<bool> = rows.iter().rev().flat_map(|row| row.bytes().map(|b| b == b'#')).collect();
        Mask { cells: &cells, width, height }.outlines()
    }

    #[test]
    fn a_frame_has_an_outer_and_an_inner_outline() {
        let mut found = outlines(&["#####", "#...#", "#...#", "#####"]);
        found.sort_by_key(|o| o[0][0] as i32);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0], [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [0.0, 4.0]]);
        // Clockwise: the walls are to its left.
        assert_eq!(found[1], [[1.0, 1.0], [1.0, 3.0], [4.0, 3.0], [4.0, 1.0]]);
    }

    #[test]
    fn cells_that_touch_at_a_corner_are_one_wall() {
        assert_eq!(outlines(&["#.", ".#"]).len(), 1);
        assert_eq!(outlines(&[".#", "#."]).len(), 1);
        assert_eq!(outlines(&["#.#"]).len(), 2);
    }

    #[test]
    fn the_steps_of_an_oblique_wall_become_straight_lines() {
        let rows: Vec<String> = (0..60).map(|r| (0..70).map(|c| if c >= r && c < r + 3 { '#' } else { '.' }).collect()).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let found = outlines(&rows);
        assert_eq!(found.len(), 1);
        assert!(found[0].len() <= 6, "{:?}", found[0]);
    }
}
