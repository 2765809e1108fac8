//! What did usvg make of it? Its tree, walked, becomes a sketch.

use usvg::tiny_skia_path::{PathSegment, Point, Transform};

use super::super::PlanFileError;
use super::super::bounds::Bounds;
use super::super::drafter::{Drafter, FAINTEST, Look, Step};
use super::super::sketch::{Sketch, SketchPoint};
use super::NUMBERED;
use super::frame::Frame;
use super::redraft::Redraft;

impl Redraft<'_, '_> {
    /// What usvg made of it, as a sketch.
    pub(super) fn read(&self, tree: &usvg::Tree, frame: Frame, metres_per_unit: Option<f64>) -> Result<Sketch, PlanFileError> {
        let all = tree.root().abs_bounding_box();
        let side = match frame.view_box {
            Some([_, _, width, height]) => width.max(height),
            None => f64::from(all.width().max(all.height())),
        };
        let origin = match frame.view_box {
            Some([_, _, _, height]) => [0.0, height],
            None => [f64::from(all.left()), f64::from(all.bottom())],
        };
        let mut reader = Reader { draft: self, drafter: Drafter::new(side), origin, uncoloured: 0 };
        reader.group(tree.root(), None, Bounds::ALL, 1.0)?;
        let Reader { mut drafter, uncoloured, .. } = reader;
        if drafter.sketch.paths.is_empty() {
            let why = match (self.bitmaps, uncoloured) {
                (0, 0) => "is it empty, or is all of it hidden?".to_owned(),
                (0, _) => format!("its {uncoloured} shapes have neither a fill nor a stroke"),
                (bitmaps, _) => format!("it only holds {bitmaps} bitmaps: save them as PNG and read these"),
            };
            return Err(PlanFileError::NothingDrawn { format: "SVG", why });
        }
        let notes = &mut drafter.sketch.notes;
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} {what}"));
            }
        };
        note(self.bitmaps, "bitmaps in the SVG are not read");
        note(uncoloured, "shapes without fill and stroke are invisible: they count as outlines of rooms at most");
        note(self.loops, "copies (<use>) that hold themselves are left out");
        note(self.far, "shapes with coordinates over a thousand million are left out");
        note(drafter.broken, "shapes with coordinates that are no numbers are left out");
        if frame.view_box.is_none() {
            notes.push("the SVG has neither a valid viewBox nor a size: the origin is the bottom-left of what is drawn".to_owned());
        }
        drafter.sketch.metres_per_unit = metres_per_unit;
        Ok(drafter.sketch)
    }
}

/// The number that leads back, if this id is one.
fn numbered(id: &str) -> Option<usize> {
    id.strip_prefix(NUMBERED)?.parse().ok()
}

fn colour(paint: &usvg::Paint) -> [u8; 3] {
    let first = |stops: &[usvg::Stop]| stops.first().map_or([128; 3], |stop| rgb(stop.color()));
    match paint {
        usvg::Paint::Color(colour) => rgb(*colour),
        usvg::Paint::LinearGradient(gradient) => first(gradient.stops()),
        usvg::Paint::RadialGradient(gradient) => first(gradient.stops()),
        usvg::Paint::Pattern(_) => [128; 3],
    }
}

fn rgb(colour: usvg::Color) -> [u8; 3] {
    [colour.red, colour.green, colour.blue]
}

/// From a shape's own coordinates to the sketch's.
#[derive(Clone, Copy)]
pub(super) struct Placing {
    transform: Transform,
    /// The sketch's origin: x, and y (down) of the bottom.
    origin: SketchPoint,
}

impl Placing {
    pub(super) fn at(&self, x: f64, y: f64) -> SketchPoint {
        let [sx, kx, tx] = [self.transform.sx, self.transform.kx, self.transform.tx].map(f64::from);
        let [ky, sy, ty] = [self.transform.ky, self.transform.sy, self.transform.ty].map(f64::from);
        [sx * x + kx * y + tx - self.origin[0], self.origin[1] - (ky * x + sy * y + ty)]
    }

    fn point(&self, point: Point) -> SketchPoint {
        self.at(f64::from(point.x), f64::from(point.y))
    }

    /// Length of what was 1 long, on average over directions.
    fn scale(&self) -> f64 {
        let [a, b, c, d] = [self.transform.sx, self.transform.kx, self.transform.ky, self.transform.sy].map(f64::from);
        (a * d - b * c).abs().sqrt()
    }
}

/// Walks what usvg made.
struct Reader<'a, 'b, 'input> {
    draft: &'a Redraft<'b, 'input>,
    drafter: Drafter,
    origin: SketchPoint,
    uncoloured: usize,
}

impl Reader<'_, '_, '_> {
    fn group(&mut self, group: &usvg::Group, number: Option<usize>, clip: Bounds, opacity: f64) -> Result<(), PlanFileError> {
        let opacity = opacity * f64::from(group.opacity().get());
        if opacity < FAINTEST {
            return Ok(());
        }
        let number = numbered(group.id()).or(number);
        let clip = match group.clip_path() {
            Some(path) => {
                let placing = self.placing(group.abs_transform().pre_concat(path.transform()));
                let rect = path.root().bounding_box();
                let corners =
                    [(rect.left(), rect.top()), (rect.right(), rect.top()), (rect.right(), rect.bottom()), (rect.left(), rect.bottom())];
                let corners = corners.map(|(x, y)| placing.at(f64::from(x), f64::from(y)));
                clip.both(Bounds::of(&corners).unwrap_or(Bounds::ALL))
            }
            None => clip,
        };
        for node in group.children() {
            match node {
                usvg::Node::Group(inner) => self.group(inner, number, clip, opacity)?,
                usvg::Node::Path(path) => self.path(path, number, clip, opacity)?,
                usvg::Node::Image(_) | usvg::Node::Text(_) => {}
            }
        }
        Ok(())
    }

    fn placing(&self, transform: Transform) -> Placing {
        Placing { transform, origin: self.origin }
    }

    fn path(&mut self, path: &usvg::Path, number: Option<usize>, clip: Bounds, opacity: f64) -> Result<(), PlanFileError> {
        let number = numbered(path.id()).or(number);
        let run = number.and_then(|n| self.draft.runs.get(&n));
        let shown = |own: usvg::Opacity| opacity * f64::from(own.get()) >= FAINTEST;
        let fill = path.fill().filter(|fill| shown(fill.opacity()));
        let stroke = path.stroke().filter(|stroke| shown(stroke.opacity()));
        if !path.is_visible() || (fill.is_none() && stroke.is_none()) {
            // An outline without any look is kept, as one that is not shown (usvg calls it invisible); what is faint is not.
            let without_look = run.is_none() && path.fill().is_none() && path.stroke().is_none();
            if !without_look {
                return Ok(());
            }
            self.uncoloured += 1;
        }
        let placing = self.placing(path.abs_transform());
        let layer = number.and_then(|n| self.draft.layers.get(n)).cloned().unwrap_or_default();
        if let Some(run) = run {
            return self.drafter.write(run.piece(path.data().bounds(), placing, layer));
        }
        let look = Look {
            fill: fill.map(|fill| colour(fill.paint())),
            stroke: stroke.map(|stroke| colour(stroke.paint())),
            width: stroke.map_or(0.0, |stroke| f64::from(stroke.width().get()) * placing.scale()),
            dashed: stroke.is_some_and(|stroke| stroke.dasharray().is_some()),
            layer,
        };
        let steps = path.data().segments().map(|segment| match segment {
            PathSegment::MoveTo(p) => Step::Move(placing.point(p)),
            PathSegment::LineTo(p) => Step::Line(placing.point(p)),
            PathSegment::QuadTo(a, p) => Step::Quadratic(placing.point(a), placing.point(p)),
            PathSegment::CubicTo(a, b, p) => Step::Cubic(placing.point(a), placing.point(b), placing.point(p)),
            PathSegment::Close => Step::Close,
        });
        self.drafter.draw(steps, clip, &look)
    }
}
