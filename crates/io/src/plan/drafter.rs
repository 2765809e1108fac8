//! How do curves, clips and looks become the chains of a [`Sketch`]? Readers of SVG and PDF draw with one [`Drafter`].
//!
//! strokes of the file, in the sketch's frame ─▶ chains of chords ─▶ cut at the clip's box ─▶ [`SketchPath`]
//!
//! Curves are cut by Wang's bound (the second differences of the control points), so that no chord is farther from its curve than
//! is allowed. Clips count with their bounding box: nearly all of real ones are upright rectangles.

mod clip;
mod letters;

use super::PlanFileError;
use super::bounds::Bounds;
use super::sketch::{Sketch, SketchPath, SketchPoint, SketchText};
use clip::{cut_area, cut_line};
pub(super) use letters::Letters;
use letters::Written;

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

/// Draws into a sketch.
pub(super) struct Drafter {
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

impl Drafter {
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
    pub(super) fn write(&mut self, piece: Letters) -> Result<(), PlanFileError> {
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
        let is_hidden = fill.is_none() && look.stroke.is_none();
        if is_hidden && !chain.closed {
            return Ok(());
        }
        self.spend(chain.points.len())?;
        let closed = chain.closed || (fill.is_some() && look.stroke.is_none());
        let paths = if is_hidden { &mut self.sketch.hidden } else { &mut self.sketch.paths };
        paths.push(SketchPath {
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
mod tests;
