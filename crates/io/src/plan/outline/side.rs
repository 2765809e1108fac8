//! Which straight sides does a border of pixels have? Steps of a slanted wall are one side; a corner is where two sides meet.
//!
//! corners of a border ─▶ longest runs of corners along one line, one after the other ─▶ a line each ─▶ where neighbours cross
//!
//! A side is either one of the border's own straight pieces, with small bumps on it, or slanted: a digital straight line, in which
//! steps are one pixel high and evenly spaced (Rosenfeld 1974), or, in pictures that were scaled or turned, nearly so; through it a
//! line is laid by least squares, where Potrace (Selinger 2003) searches for the fewest sides of all. Corners are where
//! neighbouring lines cross (his section 2.3.1), or, where that is far from the pixels' corner, its feet on both.
//! Pixels, y down. The outcome depends on the border's shape alone, not on how the picture is turned.
//! Pitfall: two long pieces that are one pixel apart are a step in a wall, not a slanted wall.

use super::border::Corner;

/// Longest piece of a border, in pixels, that may lie off its side as a bump, or be part of a slope of a single step.
const BUMP_PX: i32 = 16;
/// A slanted line leaves a piece of the border that lies along one row by at most this, from one end to the other: 1 is exact.
const DRIFT_PX: f64 = 1.5;
/// The first and last piece of a slanted side are cut off somewhere, so they are no longer than this times those between.
const END_RATIO: f64 = 1.25;
/// A line drawn pixel by pixel has steps of this height …
const STEP_PX: i32 = 1;
/// … and is this near to the border's corners, pixels: √½, and room for a line that begins or ends within a step.
const SLANTED_PX: f64 = 0.75;
/// Pictures that were scaled or turned have steps of up to this height, and as far off as they may be …
const ROUGH_STEP_PX: i32 = 3;
/// … which are told from the corners of small things by their number.
const ROUGH_STEPS: usize = 4;
/// Where a line rises by less than this a pixel, noise may go down a step.
const FLAT: f64 = 0.4;
/// Numbers of pieces for a side that are tried one by one, before they grow by half: nine are needed for four rough steps.
const TRIED: usize = 9;
/// Lengths in a row that fail before a side ends.
const FAILURES: usize = 3;
/// Sides below this, pixels, between two that are longer may be what is left of a corner.
const CORNER_PX: i32 = 8;
/// Pieces to either side of such a corner among which the true one is looked for.
const CORNER_PIECES: usize = 4;
/// Times that sides which do not hold are given back to the pixels, before the whole ring is.
const ROUNDS: usize = 8;
/// Round-off, pixels.
const HAIR_PX: f64 = 1e-9;

/// Pixels from the picture's top left corner.
pub(super) type Point = [f64; 2];

/// A border as sides.
pub(super) struct Ring<'a> {
    border: Corners<'a>,
    slack_px: f64,
    sides: Vec<Side>,
}

/// A few pieces of a border that lie along a line.
#[derive(Debug, Clone, Copy)]
struct Side {
    /// Corner at which it begins.
    first: usize,
    /// Pieces that it is made of.
    pieces: usize,
    /// Where it is; none if it stays as the pixels have it.
    line: Option<Line>,
}

/// A corner of a ring, and which sides the way from it to the next belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vertex {
    pub at: Point,
    pub sides: [usize; 2],
    /// Whether the way is along the pixels' own border.
    pub exact: bool,
}

impl<'a> Ring<'a> {
    /// The fewest sides that are found, none farther from the border than `slack_px`.
    pub fn straightened(corners: &'a [Corner], slack_px: f64) -> Self {
        let border = Corners(corners);
        let mut ring = Self { border, slack_px, sides: border.sides(slack_px) };
        ring.sharpen();
        for _ in 0..ROUNDS {
            let failed = ring.failed();
            if failed.is_empty() {
                return ring;
            }
            ring.give_back(&failed);
        }
        ring.give_all_back();
        ring
    }

    /// Lets long sides meet where their lines cross: each was taken as far as it holds, which may be round the corner, and what was
    /// left of the corner became short sides.
    fn sharpen(&mut self) {
        let sides = self.sides.clone();
        let long: Vec<usize> = (0..sides.len()).filter(|k| self.border.length(sides[*k].first, sides[*k].pieces) > CORNER_PX).collect();
        if long.len() < 2 {
            return;
        }
        let mut is_left = vec![true; sides.len()];
        for (k, next) in long.iter().copied().zip(long.iter().copied().cycle().skip(1)) {
            let between: Vec<usize> = (1..).map(|i| (k + i) % sides.len()).take_while(|i| *i != next).collect();
            let gap = between.iter().map(|i| sides[*i].pieces).sum();
            if let Some(corner) = self.corner_between(sides[k], sides[next], gap) {
                let moved = corner - gap as isize;
                self.sides[k].pieces = self.sides[k].pieces.saturating_add_signed(corner);
                self.sides[next].pieces = self.sides[next].pieces.saturating_add_signed(-moved);
                self.sides[next].first = self.border.shifted(self.sides[next].first, moved);
                between.into_iter().for_each(|i| is_left[i] = false);
            }
        }
        let mut is_left = is_left.into_iter();
        self.sides.retain(|_| is_left.next().unwrap_or(true));
    }

    /// The border's corner nearest to where two sides cross that are so many pieces apart: counted in pieces from the end of the first.
    fn corner_between(&self, from: Side, to: Side, gap: usize) -> Option<isize> {
        let end = from.first + from.pieces;
        if self.border.length(end, gap) > CORNER_PX {
            return None;
        }
        let (line, next_line) = (from.line?, to.line?);
        let crossing = line.crossing(next_line)?;
        let at = |corner: isize| self.border.point(self.border.shifted(end, corner));
        let [back, on] = [from, to].map(|side| ((side.pieces - 1) / 2).min(CORNER_PIECES) as isize);
        let gap = gap as isize;
        let off = |corner: &isize| distance(at(*corner), crossing);
        let corner = (-back..=gap + on).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let is_near = |line: Line, corner: isize| line.distance(at(corner)) <= self.slack_px;
        let holds = (0..=corner).all(|i| is_near(line, i)) && (corner..=gap).all(|i| is_near(next_line, i));
        (holds && off(&corner) <= self.slack_px).then_some(corner)
    }

    /// Leaves these sides as the pixels have them.
    pub fn give_back(&mut self, sides: &[usize]) {
        for side in sides {
            if let Some(side) = self.sides.get_mut(*side) {
                side.line = None;
            }
        }
    }

    /// Leaves all as the pixels have it.
    pub fn give_all_back(&mut self) {
        self.sides.iter_mut().for_each(|side| side.line = None);
    }

    /// Its corners, and which sides lie between them.
    pub fn vertices(&self) -> Vec<Vertex> {
        let mut vertices: Vec<Vertex> = Vec::new();
        for (k, side) in self.sides.iter().enumerate() {
            let before = self.before(k);
            let (joint, count) = self.joint(k);
            if count == 2 {
                vertices.push(Vertex { at: joint[0], sides: [before, k], exact: false });
            }
            let exact = side.line.is_none();
            vertices.push(Vertex { at: joint[1], sides: [k, k], exact });
            if exact {
                let inner = (1..side.pieces).map(|i| self.border.point(side.first + i));
                vertices.extend(inner.map(|at| Vertex { at, sides: [k, k], exact }));
            }
        }
        vertices
    }

    /// Its corners, without those on a straight line.
    pub fn points(&self) -> Vec<Point> {
        let mut points: Vec<Point> = Vec::new();
        for vertex in self.vertices() {
            while let [.., a, b] = points[..]
                && is_straight(a, b, vertex.at)
            {
                points.pop();
            }
            points.push(vertex.at);
        }
        while let [first, .., a, b] = points[..]
            && is_straight(a, b, first)
        {
            points.pop();
        }
        while let [first, second, .., last] = points[..]
            && is_straight(last, first, second)
        {
            points.remove(0);
        }
        points
    }

    fn before(&self, k: usize) -> usize {
        k.checked_sub(1).unwrap_or(self.sides.len() - 1)
    }

    /// Where a side meets the one before it: one point, or where the one before ends and where it begins itself.
    fn joint(&self, k: usize) -> ([Point; 2], usize) {
        let corner = self.border.point(self.sides[k].first);
        let (from, to) = match (self.sides[self.before(k)].line, self.sides[k].line) {
            (None, None) => (corner, corner),
            (Some(from), None) => (from.foot(corner), corner),
            (None, Some(to)) => (corner, to.foot(corner)),
            (Some(from), Some(to)) => match from.crossing(to) {
                Some(at) if distance(at, corner) <= self.slack_px => (at, at),
                _ => (from.foot(corner), to.foot(corner)),
            },
        };
        if distance(from, to) <= HAIR_PX { ([to, to], 1) } else { ([from, to], 2) }
    }

    /// Sides that run backwards, or leave a part of the border too far away.
    fn failed(&self) -> Vec<usize> {
        let holds = |k: usize| {
            let Some(line) = self.sides[k].line else { return true };
            let ([_, begin], [end, _]) = (self.joint(k).0, self.joint((k + 1) % self.sides.len()).0);
            let length = dot(minus(end, begin), line.along);
            let near = |at: Point| {
                let along = dot(minus(at, begin), line.along).clamp(0.0, length);
                distance(at, [begin[0] + along * line.along[0], begin[1] + along * line.along[1]]) <= self.slack_px + HAIR_PX
            };
            length > HAIR_PX && (0..=self.sides[k].pieces).all(|i| near(self.border.point(self.sides[k].first + i)))
        };
        (0..self.sides.len()).filter(|k| !holds(*k)).collect()
    }
}

/// The corners of a border, the first again after the last.
#[derive(Clone, Copy)]
struct Corners<'a>(&'a [Corner]);

/// A straight piece of a border, from one corner to the next.
#[derive(Clone, Copy)]
struct Piece {
    /// Coordinate that changes: 0 along a row, 1 along a column.
    axis: usize,
    /// By how much, with its sign.
    length: i32,
    /// The coordinate that stays.
    level: i32,
    begin: Point,
}

impl Corners<'_> {
    fn corner(self, i: usize) -> Corner {
        self.0[i % self.0.len()]
    }

    fn point(self, i: usize) -> Point {
        self.corner(i).map(f64::from)
    }

    fn piece(self, i: usize) -> Piece {
        let (from, to) = (self.corner(i), self.corner(i + 1));
        let axis = usize::from(from[0] == to[0]);
        Piece { axis, length: to[axis] - from[axis], level: from[1 - axis], begin: from.map(f64::from) }
    }

    fn pieces(self, first: usize, count: usize) -> impl Iterator<Item = Piece> + Clone {
        (first..first + count).map(move |i| self.piece(i))
    }

    /// A corner so many after this one, or before it.
    fn shifted(self, i: usize, by: isize) -> usize {
        let count = self.0.len() as isize;
        (i as isize + by).rem_euclid(count) as usize
    }

    /// Length of so many pieces, pixels.
    fn length(self, first: usize, count: usize) -> i32 {
        self.pieces(first, count).map(|piece| piece.length.abs()).sum()
    }

    /// One side after the other, each as long as can be.
    fn sides(self, slack_px: f64) -> Vec<Side> {
        let count = self.0.len();
        // A rectangle is as straight as can be; and no small one is lost.
        if count <= 4 {
            return (0..count).map(|first| self.side(first, 1, slack_px)).collect();
        }
        let (longest, period) = self.least_rotation();
        // The longest piece is no slope's; where its side ends, none is cut in two.
        let begin = longest + self.longest_side(longest, period, slack_px).pieces;
        let mut sides = Vec::new();
        let mut done = 0;
        while done < period {
            let side = self.longest_side((begin + done) % count, period - done, slack_px);
            done += side.pieces;
            sides.push(side);
        }
        // What looks the same when turned has the same sides again.
        let again = |turn: usize, side: &Side| self.side((side.first + turn * period) % count, side.pieces, slack_px);
        (0..count / period).flat_map(|turn| sides.iter().map(move |side| again(turn, side))).collect()
    }

    /// Where to begin so that the list of (length, turn) comes first in order, the longest length first (Shiloach 1981), and after how many
    /// pieces that list repeats itself. So one begins at the longest piece, and of several at the same one however the picture is turned.
    fn least_rotation(self) -> (usize, usize) {
        let count = self.0.len();
        let key = |i: usize| {
            let (piece, next) = (self.piece(i), self.piece(i + 1));
            let turns_right = (piece.axis == 0) == ((piece.length > 0) == (next.length > 0));
            (-piece.length.abs(), turns_right)
        };
        let (mut best, mut other, mut same) = (0, 1, 0);
        while best < count && other < count && same < count {
            let (a, b) = (key(best + same), key(other + same));
            if a == b {
                same += 1;
                continue;
            }
            if a > b {
                best += same + 1;
            } else {
                other += same + 1;
            }
            if best == other {
                other += 1;
            }
            same = 0;
        }
        (best.min(other), if same == count { best.abs_diff(other) } else { count })
    }

    /// The longest side found that begins at this corner and has at most so many pieces.
    fn longest_side(self, first: usize, most: usize, slack_px: f64) -> Side {
        let mut best = self.side(first, 1, slack_px);
        let is_long = |i: usize| f64::from(self.piece(i).length.abs()) > 2.0 * slack_px;
        if most < 2 || is_long(first) && is_long(first + 1) {
            return best;
        }
        let attempt = |pieces: usize| Some(self.side(first, pieces, slack_px)).filter(|side| side.line.is_some());
        // A side cannot always end between two pieces that it can go beyond: hence the second attempt.
        let longest_to = |pieces: usize| attempt(pieces).or_else(|| attempt(pieces - 1));
        for pieces in 2..=most.min(TRIED) {
            best = attempt(pieces).unwrap_or(best);
        }
        if best.pieces + 4 < TRIED {
            return best;
        }
        // Grow by half, past lengths that fail by chance; then halve what lies between.
        let (mut tried, mut bad, mut failures) = (best.pieces, most + 1, 0);
        while tried < most && failures < FAILURES {
            tried = (tried + tried / 2).min(most);
            if let Some(side) = longest_to(tried) {
                (best, bad, failures) = (side, most + 1, 0);
            } else {
                bad = bad.min(tried);
                failures += 1;
            }
        }
        while best.pieces + 1 < bad {
            let middle = best.pieces + (bad - best.pieces) / 2;
            match longest_to(middle) {
                Some(side) if side.pieces > best.pieces => best = side,
                _ => bad = middle,
            }
        }
        best
    }

    /// These pieces as a side, which has a line if they lie along one.
    fn side(self, first: usize, pieces: usize, slack_px: f64) -> Side {
        Side { first, pieces, line: self.line(first, pieces, slack_px) }
    }

    fn line(self, first: usize, count: usize, slack_px: f64) -> Option<Line> {
        if count == 1 {
            return Some(self.piece(first).line());
        }
        if count + 2 > self.0.len() {
            return None;
        }
        let pieces = self.pieces(first, count);
        let slanted = least_squares(pieces.clone());
        let axis = usize::from(slanted.along[1].abs() > slanted.along[0].abs() + HAIR_PX);
        let ends = self.line_along(first, count, axis, slanted, slack_px);
        // Exactly between the axes, either will do.
        let is_between = (slanted.along[0].abs() - slanted.along[1].abs()).abs() <= HAIR_PX;
        if is_between { ends.or_else(|| self.line_along(first, count, 1 - axis, slanted, slack_px)) } else { ends }
    }

    fn line_along(self, first: usize, count: usize, axis: usize, slanted: Line, slack_px: f64) -> Option<Line> {
        let pieces = self.pieces(first, count);
        let along = pieces.clone().filter(|piece| piece.axis == axis);
        let longest = along.clone().reduce(|a, b| if b.length.abs() > a.length.abs() { b } else { a })?;
        let onwards = |piece: Piece| piece.axis != axis || (piece.length > 0) == (longest.length > 0);
        // A step at either end belongs to it if the border goes on in the same sense: it is no end of a wall.
        let around = [(first + self.0.len() - 1, first), (first + count, first + count - 1)];
        let ends_well = around.into_iter().all(|(beyond, end)| self.piece(end).axis == axis || onwards(self.piece(beyond)));
        if !ends_well || !pieces.clone().all(onwards) {
            return None;
        }
        let is_near = |line: Line, slack_px: f64| (0..=count).all(|i| line.distance(self.point(first + i)) <= slack_px);
        let total: i32 = along.clone().map(|piece| piece.length.abs()).sum();
        let is_bump = |piece: Piece| piece.level == longest.level || piece.length.abs() <= BUMP_PX;
        if 2 * longest.length.abs() >= total && along.clone().all(is_bump) && is_near(longest.line(), slack_px) {
            return Some(longest.line());
        }
        let steps = pieces.filter(|piece| piece.axis != axis);
        let sense = slanted.along[1 - axis];
        let goes_up = |piece: Piece| (piece.length > 0) == (sense > 0.0);
        let is_flat = sense.abs() < FLAT * slanted.along[axis].abs();
        if !is_even(along, slanted.along, axis) || !(is_flat || steps.clone().all(goes_up)) {
            return None;
        }
        let highest = steps.clone().map(|step| step.length.abs()).max().unwrap_or(0);
        let is_drawn = highest <= STEP_PX && is_near(slanted, SLANTED_PX);
        let is_rough = || highest <= ROUGH_STEP_PX && steps.count() >= ROUGH_STEPS && is_near(slanted, slack_px);
        (is_drawn || is_rough()).then_some(slanted)
    }
}

/// Whether pieces along one axis are those of a slanted line, and not of two walls that are a step apart.
fn is_even(along: impl Iterator<Item = Piece> + Clone, direction: Point, axis: usize) -> bool {
    let lengths = along.map(|piece| piece.length.abs());
    let longest = lengths.clone().max().unwrap_or(0);
    if longest <= BUMP_PX {
        return true;
    }
    let count = lengths.clone().count();
    let inner = lengths.skip(1).take(count.saturating_sub(2)).max().unwrap_or(0);
    let drift = f64::from(longest) * (direction[1 - axis] / direction[axis]).abs();
    f64::from(longest) <= END_RATIO * f64::from(inner) + 1.0 && drift <= DRIFT_PX
}

/// A straight line.
#[derive(Debug, Clone, Copy)]
struct Line {
    through: Point,
    /// Of length one.
    along: Point,
}

impl Piece {
    fn line(self) -> Line {
        let mut along = [0.0; 2];
        along[self.axis] = f64::from(self.length.signum());
        Line { through: self.begin, along }
    }

    fn end(self) -> Point {
        let mut end = self.begin;
        end[self.axis] += f64::from(self.length);
        end
    }
}

impl Line {
    fn foot(self, at: Point) -> Point {
        let along = dot(minus(at, self.through), self.along);
        [self.through[0] + along * self.along[0], self.through[1] + along * self.along[1]]
    }

    fn distance(self, at: Point) -> f64 {
        cross(self.along, minus(at, self.through)).abs()
    }

    fn crossing(self, other: Self) -> Option<Point> {
        let sine = cross(self.along, other.along);
        let along = cross(minus(other.through, self.through), other.along) / sine;
        let at = [self.through[0] + along * self.along[0], self.through[1] + along * self.along[1]];
        (sine.abs() > HAIR_PX && at.iter().all(|v| v.is_finite())).then_some(at)
    }
}

/// The line nearest to all points of the pieces, by squared distances across it (Pearson 1901).
fn least_squares(pieces: impl Iterator<Item = Piece>) -> Line {
    let (mut begin, mut end) = (None, [0.0; 2]);
    let (mut weight, mut sum, mut squares) = (0.0, [0.0; 2], [0.0; 3]);
    for piece in pieces {
        // Sums are taken from the first corner, so that they stay small.
        let origin = *begin.get_or_insert(piece.begin);
        end = minus(piece.end(), origin);
        let from = minus(piece.begin, origin);
        let middle = [0.5 * (from[0] + end[0]), 0.5 * (from[1] + end[1])];
        let length = f64::from(piece.length.abs());
        weight += length;
        for k in 0..2 {
            sum[k] += length * middle[k];
            squares[k] += length * middle[k] * middle[k];
        }
        squares[piece.axis] += length.powi(3) / 12.0;
        squares[2] += length * middle[0] * middle[1];
    }
    let origin = begin.unwrap_or_default();
    let mean = sum.map(|s| s / weight);
    let half = 0.5 * (squares[0] - squares[1] - weight * (mean[0] * mean[0] - mean[1] * mean[1]));
    let mixed = squares[2] - weight * mean[0] * mean[1];
    let root = half.hypot(mixed);
    let along = if half >= 0.0 { [half + root, mixed] } else { [mixed, root - half] };
    let sense = if dot(along, end) < 0.0 { -1.0 } else { 1.0 };
    let length = sense * along[0].hypot(along[1]);
    Line { through: [origin[0] + mean[0], origin[1] + mean[1]], along: along.map(|v| v / length) }
}

/// Whether the second point lies on the way from the first to the third, or on one of them.
fn is_straight(a: Point, b: Point, c: Point) -> bool {
    let (before, after) = (minus(b, a), minus(c, b));
    let (long, short) = (before[0].hypot(before[1]), after[0].hypot(after[1]));
    long <= HAIR_PX || short <= HAIR_PX || (cross(before, after).abs() <= HAIR_PX * long.max(short) && dot(before, after) > 0.0)
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
