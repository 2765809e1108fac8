//! How do curves, clips and looks become the chains of a [`Sketch`]? Readers of SVG and PDF draw with one pen.
//!
//! strokes of the file, in the sketch's frame ─▶ chains of chords ─▶ cut at the clip's box ─▶ [`SketchPath`]
//!
//! Curves are cut by Wang's bound (the second differences of the control points), so that no chord is farther from its curve than
//! is allowed. Clips count with their bounding box: nearly all of real ones are upright rectangles.

use super::PlanFileError;
use super::sketch::{Sketch, SketchPath, SketchPoint, SketchText};

/// Most points of all chains together: a hospital's floor with its furniture has a tenth of it. They take 80 MB.
const MOST_POINTS: usize = 5_000_000;
/// Most chords of one Bézier curve. Within a drawing 50 are enough for [`CHORD_ERROR`]; only curves that leave it ask for more.
pub(super) const MOST_CHORDS: usize = 64;
/// Farthest from a curve to its chord, as a share of the drawing's larger side.
pub(super) const CHORD_ERROR: f64 = 1.0 / 2000.0;
/// The same as a share of the curve's own size, whichever is less: a door's arc is still one when its plan is of a whole airport.
const OWN_CHORD_ERROR: f64 = 1.0 / 50.0;
/// Longest name of a layer, characters.
const LONGEST_LAYER: usize = 200;
/// Longest part of it, characters.
const LONGEST_NAME: usize = 60;
/// What is fainter than this counts as hidden.
pub(super) const FAINTEST: f64 = 0.02;
/// Height of capitals as a share of the size of their font (Arial 0.72, Calibri 0.64, Times 0.66).
const CAPITALS: f64 = 0.7;
/// Letters farther from those before are another text, font sizes: columns of a table are.
const JOINED: f64 = 0.6;
/// Letters farther than this have a blank between them.
const SPACE: f64 = 0.2;

/// One step of a path, in the sketch's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    Move(SketchPoint),
    Line(SketchPoint),
    Quadratic(SketchPoint, SketchPoint),
    Cubic(SketchPoint, SketchPoint, SketchPoint),
    Close,
}

/// What a path looks like, and what it belongs to.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Look {
    pub fill: Option<[u8; 3]>,
    pub stroke: Option<[u8; 3]>,
    pub width: f64,
    pub dashed: bool,
    pub layer: String,
}

/// An upright box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub low: SketchPoint,
    pub high: SketchPoint,
}

impl Bounds {
    /// Holds everything.
    pub(super) const ALL: Self = Self { low: [f64::NEG_INFINITY; 2], high: [f64::INFINITY; 2] };

    /// The smallest that holds the points; `None` without points, or where one is not finite.
    pub(super) fn of<'a>(points: impl IntoIterator<Item = &'a SketchPoint>) -> Option<Self> {
        let mut bounds = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        for point in points {
            if !point.iter().all(|v| v.is_finite()) {
                return None;
            }
            bounds.low = [0, 1].map(|k| bounds.low[k].min(point[k]));
            bounds.high = [0, 1].map(|k| bounds.high[k].max(point[k]));
        }
        (bounds.low[0] <= bounds.high[0]).then_some(bounds)
    }

    /// What both hold; may be empty.
    pub(super) fn both(self, other: Self) -> Self {
        Self { low: [0, 1].map(|k| self.low[k].max(other.low[k])), high: [0, 1].map(|k| self.high[k].min(other.high[k])) }
    }

    /// Width and height.
    pub(super) fn size(self) -> [f64; 2] {
        [0, 1].map(|k| self.high[k] - self.low[k])
    }

    fn is_empty(self) -> bool {
        !(self.low[0] <= self.high[0] && self.low[1] <= self.high[1])
    }

    fn contains(self, other: Self) -> bool {
        (0..2).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k])
    }

    /// Whether the point is inside.
    pub(super) fn holds(self, point: SketchPoint) -> bool {
        self.contains(Self { low: point, high: point })
    }
}

/// Letters in a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Piece {
    /// Left end of their base line.
    pub at: SketchPoint,
    /// One font size along it.
    pub em: SketchPoint,
    /// How far they go along it, font sizes.
    pub width_em: f64,
    pub text: String,
    pub layer: String,
}

/// The last letters that were written.
struct Written {
    end: SketchPoint,
    em: SketchPoint,
    /// Whether a blank comes before what follows.
    spaced: bool,
}

impl Written {
    /// Font sizes from its end to letters that go on with it, on its base line or as an exponent.
    fn gap_to(&self, piece: &Piece) -> Option<f64> {
        let square = self.em[0] * self.em[0] + self.em[1] * self.em[1];
        let step = [0, 1].map(|k| piece.at[k] - self.end[k]);
        let along = (step[0] * self.em[0] + step[1] * self.em[1]) / square;
        let raised = (step[1] * self.em[0] - step[0] * self.em[1]) / square;
        let alike = (piece.em[0] * self.em[0] + piece.em[1] * self.em[1]) / square;
        let turned = (piece.em[1] * self.em[0] - piece.em[0] * self.em[1]).abs() / square;
        let same_line = raised.abs() < 0.1 && (0.9..1.1).contains(&alike);
        let exponent = (0.1..0.6).contains(&raised) && (0.4..0.9).contains(&alike);
        (turned < 0.02 && (same_line || exponent) && (-JOINED..JOINED).contains(&along)).then_some(along)
    }
}

/// Draws into a sketch.
pub(super) struct Pen {
    pub sketch: Sketch,
    written: Option<Written>,
    /// Chains left out because a coordinate is no number.
    pub broken: usize,
    tolerance: f64,
    groups: usize,
    points: usize,
}

struct Chain {
    points: Vec<SketchPoint>,
    closed: bool,
    curved: bool,
}

impl Pen {
    /// For a drawing whose larger side is this long.
    pub(super) fn new(side: f64) -> Self {
        Self { sketch: Sketch::default(), written: None, broken: 0, tolerance: side * CHORD_ERROR, groups: 0, points: 0 }
    }

    /// Draws what one command of the file draws.
    ///
    /// # Errors
    /// [`PlanFileError::DrawingTooIntricate`] at the first point over the limit.
    pub(super) fn draw(&mut self, steps: impl IntoIterator<Item = Step>, clip: Bounds, look: &Look) -> Result<(), PlanFileError> {
        let chains = self.chains(steps)?;
        let before = self.sketch.paths.len();
        for chain in chains {
            let Some(bounds) = Bounds::of(&chain.points) else {
                self.broken += 1;
                continue;
            };
            if clip.contains(bounds) {
                self.push(chain, look)?;
            } else if !clip.is_empty() && !clip.both(bounds).is_empty() {
                self.cut(&chain, clip, look)?;
            }
        }
        if !self.merged_stroke(before) && self.sketch.paths.len() > before {
            self.groups += 1;
        }
        Ok(())
    }

    /// Writes a text, or the next letters of the one before: files have words in pieces, down to single letters.
    pub(super) fn write(&mut self, piece: Piece) -> Result<(), PlanFileError> {
        let size = piece.em[0].hypot(piece.em[1]);
        if !(size > 0.0 && size.is_finite() && piece.at.iter().all(|v| v.is_finite())) {
            return Ok(());
        }
        self.spend(1 + piece.text.len())?;
        let words = one_line(&piece.text);
        let end = [0, 1].map(|k| piece.at[k] + piece.em[k] * piece.width_em);
        let follows = self.written.as_ref().and_then(|last| last.gap_to(&piece));
        if let (Some(gap), Some(last), Some(text)) = (follows, &mut self.written, self.sketch.texts.last_mut()) {
            last.spaced |= gap > SPACE || piece.text.starts_with(char::is_whitespace);
            if !words.is_empty() {
                if last.spaced {
                    text.text.push(' ');
                }
                text.text.push_str(&words);
                last.spaced = false;
            }
            last.spaced |= piece.text.ends_with(char::is_whitespace);
            last.end = end;
        } else if !words.is_empty() {
            self.written = Some(Written { end, em: piece.em, spaced: piece.text.ends_with(char::is_whitespace) });
            self.sketch.texts.push(SketchText { at: piece.at, height: size * CAPITALS, text: words, layer: piece.layer });
        }
        Ok(())
    }

    fn spend(&mut self, points: usize) -> Result<(), PlanFileError> {
        self.points += points;
        if self.points > MOST_POINTS { Err(PlanFileError::DrawingTooIntricate { limit: MOST_POINTS }) } else { Ok(()) }
    }

    fn push(&mut self, chain: Chain, look: &Look) -> Result<(), PlanFileError> {
        // A line has no inside; that of an open chain is closed by its filling.
        let fill = look.fill.filter(|_| chain.points.len() > 2);
        if fill.is_none() && look.stroke.is_none() {
            return Ok(());
        }
        self.spend(chain.points.len())?;
        let closed = chain.closed || (fill.is_some() && look.stroke.is_none());
        self.sketch.paths.push(SketchPath {
            points: chain.points,
            closed,
            fill,
            stroke: look.stroke,
            width: look.width,
            dashed: look.dashed,
            curved: chain.curved,
            group: self.groups,
            layer: look.layer.clone(),
        });
        Ok(())
    }

    /// Fills and lines cut at a box are no longer the same chains: the box's edge bounds the filling, but is no line.
    fn cut(&mut self, chain: &Chain, clip: Bounds, look: &Look) -> Result<(), PlanFileError> {
        if look.fill.is_some() && chain.points.len() > 2 {
            let points = cut_area(&chain.points, clip);
            if points.len() > 2 {
                let filled = Look { stroke: None, width: 0.0, dashed: false, ..look.clone() };
                self.push(Chain { points, closed: true, curved: chain.curved }, &filled)?;
            }
        }
        if look.stroke.is_some() {
            let lined = Look { fill: None, ..look.clone() };
            for points in cut_line(chain, clip) {
                self.push(Chain { points, closed: false, curved: chain.curved }, &lined)?;
            }
        }
        Ok(())
    }

    /// PDF fills and strokes one path by two commands: the second becomes the first's line.
    fn merged_stroke(&mut self, before: usize) -> bool {
        let paths = &mut self.sketch.paths;
        let count = paths.len() - before;
        let Some(first) = before.checked_sub(count).filter(|_| count > 0) else { return false };
        let (old, new) = paths.split_at_mut(before);
        let old = &mut old[first..];
        let group = old[0].group;
        let same = old.iter().zip(new.iter()).all(|(filled, lined)| {
            let looks = filled.group == group && filled.stroke.is_none() && lined.fill.is_none() && lined.stroke.is_some();
            looks && filled.closed == lined.closed && filled.points == lined.points && filled.layer == lined.layer
        });
        let whole = first == 0 || self.sketch.paths[first - 1].group != group;
        if !same || !whole {
            return false;
        }
        let new = self.sketch.paths.split_off(before);
        for (filled, lined) in self.sketch.paths[first..].iter_mut().zip(new) {
            filled.stroke = lined.stroke;
            filled.width = lined.width;
            filled.dashed = lined.dashed;
        }
        true
    }

    fn chains(&self, steps: impl IntoIterator<Item = Step>) -> Result<Vec<Chain>, PlanFileError> {
        let mut chains = Vec::new();
        let mut chain = Chain { points: Vec::new(), closed: false, curved: false };
        let mut total = self.points;
        for step in steps {
            let start = chain.points.first().copied().unwrap_or_default();
            let from = chain.points.last().copied().unwrap_or_default();
            total += 1;
            match step {
                Step::Move(to) => finish(&mut chain, &mut chains, to),
                Step::Line(to) => chain.points.push(to),
                Step::Quadratic(a, to) => {
                    total += self.curve(&mut chain, &[from, a, to]);
                }
                Step::Cubic(a, b, to) => {
                    total += self.curve(&mut chain, &[from, a, b, to]);
                }
                Step::Close => {
                    chain.closed = true;
                    finish(&mut chain, &mut chains, start);
                }
            }
            if total > MOST_POINTS {
                return Err(PlanFileError::DrawingTooIntricate { limit: MOST_POINTS });
            }
        }
        finish(&mut chain, &mut chains, [0.0; 2]);
        Ok(chains)
    }

    /// Adds a Bézier curve; tells how many points that were.
    fn curve(&self, chain: &mut Chain, control: &[SketchPoint]) -> usize {
        if Bounds::of(control).is_none() {
            chain.points.push([f64::NAN; 2]);
            return 1;
        }
        let count = chords(control, self.tolerance);
        chain.curved |= count > 1;
        chain.points.extend((1..=count).map(|i| bezier(control, i as f64 / count as f64)));
        count
    }
}

/// Ends a chain and begins the next.
fn finish(chain: &mut Chain, chains: &mut Vec<Chain>, next: SketchPoint) {
    let mut done = std::mem::replace(chain, Chain { points: vec![next], closed: false, curved: false });
    done.points.dedup();
    if done.points.len() > 2 && done.points.first() == done.points.last() {
        done.points.pop();
        done.closed = true;
    }
    done.closed &= done.points.len() > 2;
    if done.points.len() > 1 {
        chains.push(done);
    }
}

/// How many chords keep to the tolerance (Wang 1984): n² ≥ d (d − 1) / 8 · greatest second difference / tolerance.
fn chords(control: &[SketchPoint], tolerance: f64) -> usize {
    let bend = control.windows(3).map(|w| (w[0][0] - 2.0 * w[1][0] + w[2][0]).hypot(w[0][1] - 2.0 * w[1][1] + w[2][1])).fold(0.0, f64::max);
    let extent = Bounds::of(control).map_or(0.0, |b| b.size()[0].hypot(b.size()[1]));
    let tolerance = tolerance.min(extent * OWN_CHORD_ERROR);
    let degree = control.len() as f64 - 1.0;
    let wanted = (degree * (degree - 1.0) / 8.0 * bend / tolerance).sqrt().ceil();
    // Also where nothing bends (0 / 0) and where a point is no number.
    if wanted >= 1.0 { (wanted as usize).min(MOST_CHORDS) } else { 1 }
}

/// De Casteljau's construction.
fn bezier(control: &[SketchPoint], t: f64) -> SketchPoint {
    let mut points = [[0.0; 2]; 4];
    let count = control.len().min(points.len());
    points[..count].copy_from_slice(&control[..count]);
    for last in (1..count).rev() {
        for i in 0..last {
            points[i] = [0, 1].map(|k| points[i][k] + t * (points[i + 1][k] - points[i][k]));
        }
    }
    // Exactly, so that chains close.
    if t == 1.0 { control.last().copied().unwrap_or_default() } else { points[0] }
}

/// Sutherland & Hodgman 1974: the ring, cut by one side of the box after the other.
fn cut_area(ring: &[SketchPoint], clip: Bounds) -> Vec<SketchPoint> {
    let mut points = ring.to_vec();
    for (axis, limit, sign) in [(0, clip.low[0], 1.0), (0, clip.high[0], -1.0), (1, clip.low[1], 1.0), (1, clip.high[1], -1.0)] {
        let depth = |p: &SketchPoint| sign * (p[axis] - limit);
        let mut kept = Vec::with_capacity(points.len());
        let mut from = points.last().copied();
        for to in points {
            if let Some(from) = from.filter(|from| (depth(from) < 0.0) != (depth(&to) < 0.0)) {
                let t = depth(&from) / (depth(&from) - depth(&to));
                let mut crossing = [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
                crossing[axis] = limit;
                kept.push(crossing);
            }
            if depth(&to) >= 0.0 {
                kept.push(to);
            }
            from = Some(to);
        }
        points = kept;
    }
    points.dedup();
    points
}

/// Liang & Barsky 1984: what of each piece is inside; pieces that meet stay one chain.
fn cut_line(chain: &Chain, clip: Bounds) -> Vec<Vec<SketchPoint>> {
    let mut chains: Vec<Vec<SketchPoint>> = Vec::new();
    let ends = chain.points.iter().skip(1).chain(chain.points.first().filter(|_| chain.closed));
    for (from, to) in chain.points.iter().zip(ends) {
        let (mut begin, mut end) = (0.0_f64, 1.0_f64);
        for k in 0..2 {
            let run = to[k] - from[k];
            for (ahead, room) in [(-run, from[k] - clip.low[k]), (run, clip.high[k] - from[k])] {
                if ahead < 0.0 {
                    begin = begin.max(room / ahead);
                } else if ahead > 0.0 {
                    end = end.min(room / ahead);
                } else if room < 0.0 {
                    end = -1.0;
                }
            }
        }
        if begin < end {
            let at = |t: f64| [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
            let (a, b) = (if begin == 0.0 { *from } else { at(begin) }, if end == 1.0 { *to } else { at(end) });
            match chains.last_mut().filter(|last| last.last() == Some(&a)) {
                Some(last) => last.push(b),
                None => chains.push(vec![a, b]),
            }
        }
    }
    chains
}

/// The layer of something with these names inside of another; neither grows without bound.
pub(super) fn layer_within<'a>(outer: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let mut layer = outer.to_owned();
    for name in names {
        let name = name.trim();
        if name.is_empty() || layer.chars().count() >= LONGEST_LAYER {
            continue;
        }
        if !layer.is_empty() {
            layer.push('/');
        }
        layer.extend(name.chars().take(LONGEST_NAME));
    }
    layer
}

/// Text with every run of blanks as one.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BOX: Bounds = Bounds { low: [0.0, 0.0], high: [10.0, 10.0] };

    fn black() -> Look {
        Look { stroke: Some([0; 3]), ..Look::default() }
    }

    fn drawn(steps: &[Step], clip: Bounds, look: &Look) -> Vec<SketchPath> {
        let mut pen = Pen::new(100.0);
        pen.draw(steps.iter().copied(), clip, look).unwrap();
        pen.sketch.paths
    }

    #[test]
    fn a_quarter_circle_becomes_chords_that_keep_to_it() {
        // The usual approximation of a quarter of radius 50.
        let k = 50.0 * 0.552_284_75;
        let paths = drawn(&[Step::Move([50.0, 0.0]), Step::Cubic([50.0, k], [k, 50.0], [0.0, 50.0])], Bounds::ALL, &black());
        let points = &paths[0].points;
        assert!(paths[0].curved && !paths[0].closed);
        for pair in points.windows(2) {
            let middle = [0, 1].map(|i| (pair[0][i] + pair[1][i]) / 2.0);
            let sag = 50.0 - middle[0].hypot(middle[1]);
            assert!(sag < 100.0 * CHORD_ERROR + 0.02, "{sag} in {} chords", points.len() - 1);
        }
        assert!((4..MOST_CHORDS).contains(&points.len()), "{}", points.len());
    }

    #[test]
    fn chains_close_where_they_end_at_their_start() {
        let square = [Step::Move([0.0, 0.0]), Step::Line([4.0, 0.0]), Step::Line([4.0, 3.0]), Step::Line([0.0, 0.0])];
        let paths = drawn(&square, Bounds::ALL, &black());
        assert_eq!((paths[0].closed, paths[0].points.len()), (true, 3));
        // There and back is no ring, and a dot is no line.
        let line = [Step::Move([0.0, 0.0]), Step::Line([4.0, 0.0]), Step::Close, Step::Line([0.0, 0.0])];
        let paths = drawn(&line, Bounds::ALL, &black());
        assert_eq!((paths.len(), paths[0].closed), (1, false));
        // After a close the pen is at the start again.
        let after = [Step::Move([1.0, 1.0]), Step::Line([4.0, 1.0]), Step::Line([4.0, 3.0]), Step::Close, Step::Line([0.0, 0.0])];
        assert_eq!(drawn(&after, Bounds::ALL, &black())[1].points, [[1.0, 1.0], [0.0, 0.0]]);
    }

    #[test]
    fn a_line_leaves_its_clip_and_comes_back_as_two() {
        let line = [Step::Move([5.0, 5.0]), Step::Line([15.0, 5.0]), Step::Line([15.0, 8.0]), Step::Line([5.0, 8.0])];
        let points: Vec<_> = drawn(&line, BOX, &black()).into_iter().map(|p| p.points).collect();
        assert_eq!(points, [[[5.0, 5.0], [10.0, 5.0]], [[10.0, 8.0], [5.0, 8.0]]]);
    }

    #[test]
    fn an_area_is_cut_but_the_cut_is_no_line() {
        let square = [[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]];
        let steps: Vec<Step> =
            std::iter::once(Step::Move(square[0])).chain(square[1..].iter().map(|p| Step::Line(*p))).chain([Step::Close]).collect();
        let paths = drawn(&steps, BOX, &Look { fill: Some([9; 3]), ..black() });
        let (area, lines): (Vec<_>, Vec<_>) = paths.iter().partition(|p| p.fill.is_some());
        assert_eq!(Bounds::of(&area[0].points), Some(Bounds { low: [5.0, 5.0], high: [10.0, 10.0] }));
        assert_eq!((area.len(), area[0].stroke, lines.len()), (1, None, 2));
        assert!(paths.iter().all(|p| p.group == 0));
        assert!(drawn(&steps, Bounds { low: [20.0, 0.0], high: [30.0, 4.0] }, &black()).is_empty());
    }

    #[test]
    fn a_stroke_after_its_filling_is_the_same_path() {
        let steps = [Step::Move([0.0, 0.0]), Step::Line([4.0, 0.0]), Step::Line([4.0, 3.0]), Step::Close];
        let mut pen = Pen::new(10.0);
        pen.draw(steps, Bounds::ALL, &Look { fill: Some([200; 3]), ..Look::default() }).unwrap();
        pen.draw(steps, Bounds::ALL, &Look { width: 0.5, ..black() }).unwrap();
        pen.draw(steps, Bounds::ALL, &black()).unwrap();
        let paths = pen.sketch.paths;
        assert_eq!((paths.len(), paths[0].fill, paths[0].stroke, paths[0].width), (2, Some([200; 3]), Some([0; 3]), 0.5));
        assert_eq!((paths[0].group, paths[1].group), (0, 1));
    }

    #[test]
    fn what_is_no_number_is_left_out_and_too_much_is_refused() {
        let mut pen = Pen::new(10.0);
        for bad in [f64::NAN, f64::INFINITY] {
            pen.draw([Step::Move([0.0, 0.0]), Step::Cubic([1.0, bad], [2.0, 0.0], [3.0, 0.0])], Bounds::ALL, &black()).unwrap();
        }
        assert_eq!((pen.sketch.paths.len(), pen.broken), (0, 2));
        let endless = (0..).map(|i| Step::Line([f64::from(i % 7), 0.0]));
        assert!(matches!(pen.draw(endless, Bounds::ALL, &black()), Err(PlanFileError::DrawingTooIntricate { .. })));
    }

    #[test]
    fn letters_become_words_and_words_become_lines() {
        let mut pen = Pen::new(100.0);
        let mut write = |x: f64, y: f64, size: f64, width_em: f64, text: &str| {
            pen.write(Piece { at: [x, y], em: [size, 0.0], width_em, text: text.to_owned(), layer: String::new() }).unwrap();
        };
        write(0.0, 0.0, 10.0, 0.6, "A");
        write(6.1, 0.0, 10.0, 0.3, ":");
        write(12.0, 0.0, 10.0, 1.1, "65");
        write(23.0, 0.0, 10.0, 0.3, " ");
        write(25.0, 0.0, 10.0, 0.8, "m");
        write(33.0, 3.0, 6.0, 0.5, "2");
        // A column of a table, the next line, and a text that stands upright.
        write(60.0, 0.0, 10.0, 1.0, "17");
        write(0.0, -12.0, 10.0, 1.0, " Flur \n EG ");
        pen.write(Piece { at: [10.0, -12.0], em: [0.0, 10.0], width_em: 1.0, text: "Lift".into(), layer: String::new() }).unwrap();
        let texts: Vec<&str> = pen.sketch.texts.iter().map(|t| t.text.as_str()).collect();
        assert_eq!(texts, ["A: 65 m2", "17", "Flur EG", "Lift"]);
        assert_eq!(pen.sketch.texts[0].height, 10.0 * CAPITALS);
    }

    #[test]
    fn layers_have_a_longest_name() {
        assert_eq!(layer_within("plan", ["", " Walls ", "st1"]), "plan/Walls/st1");
        let long = "x".repeat(1_000_000);
        let layer = (0..100).fold(String::new(), |layer, _| layer_within(&layer, [long.as_str()]));
        assert!(layer.chars().count() <= LONGEST_LAYER + LONGEST_NAME + 1);
    }

    proptest! {
        #[test]
        fn chords_begin_and_end_where_their_curve_does(c in prop::collection::vec(prop::array::uniform2(-1e3..1e3f64), 4)) {
            let paths = drawn(&[Step::Move(c[0]), Step::Cubic(c[1], c[2], c[3])], Bounds::ALL, &black());
            prop_assert_eq!(paths[0].points[0], c[0]);
            prop_assert!(paths[0].closed || paths[0].points.last() == Some(&c[3]));
            prop_assert!(paths[0].points.len() <= MOST_CHORDS + 1);
        }

        #[test]
        fn nothing_is_left_outside_of_the_clip(points in prop::collection::vec(prop::array::uniform2(-20.0..30.0f64), 3..12), fill: bool) {
            let steps = std::iter::once(Step::Move(points[0])).chain(points[1..].iter().map(|p| Step::Line(*p)));
            let look = Look { fill: fill.then_some([1; 3]), ..black() };
            for path in drawn(&steps.collect::<Vec<_>>(), BOX, &look) {
                let bounds = Bounds::of(&path.points).unwrap();
                // Round-off of a crossing 50 units away.
                prop_assert!(bounds.low.iter().all(|v| *v > -1e-12) && bounds.high.iter().all(|v| *v < 10.0 + 1e-12), "{:?}", bounds);
            }
        }
    }
}
