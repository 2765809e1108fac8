//! Where does each object of a drawing come to lie? Blocks are put where they are inserted, and curves become chords.

use std::collections::BTreeMap;

use super::super::PlanFileError;
use super::super::sketch::{Sketch, SketchPath, SketchText};
use super::curves::{Affine, Curve, Point, Vertex};
use super::look::{Colour, Layer, Line};
use super::objects::{Insertion, Object, Shape};
use super::{DRAWN_LIMIT, Drawing};

/// What a path takes besides its points and its name, bytes.
const PATH_BYTES: usize = 160;

/// Blocks in blocks in blocks; real drawings have less than ten.
const DEPTH_LIMIT: usize = 32;

/// Points are one if they differ by less than this share of their coordinates: a circle's end is its beginning but for round-off.
const SAME: f64 = 1e-12;

/// Points that are looked at for the drawing's size, spread evenly over all.
const SIZE_POINTS: usize = 1_000_000;

/// Share of all points at either side that does not count for the size: a line left somewhere far off is no part of the floor.
const ASTRAY: f64 = 0.01;

/// What an object inherits from the insertion that it is part of.
pub(super) struct Frame {
    pub place: Affine,
    /// Layer of the insertion, for objects on layer 0.
    pub layer: Option<usize>,
    pub colour: [u8; 3],
    pub dashed: bool,
    /// "/BLOCK" of each block around.
    pub names: String,
}

/// Puts objects in their places.
pub(super) struct Placer<'a> {
    drawing: &'a Drawing,
    error: f64,
    pub sketch: Sketch,
    /// Bytes that may still be drawn.
    ink: usize,
    /// Blocks that we are in.
    inside: Vec<usize>,
    groups: usize,
    pub on_hidden_layers: BTreeMap<usize, usize>,
    pub not_finite: usize,
    pub missing: usize,
    pub endless: usize,
}

/// An object's looks, with what it inherits.
struct Looking {
    layer: usize,
    colour: [u8; 3],
    dashed: bool,
}

impl<'a> Placer<'a> {
    pub(super) fn new(drawing: &'a Drawing, error: f64, ink: usize) -> Self {
        Self {
            drawing,
            error,
            sketch: Sketch::default(),
            ink,
            inside: Vec::new(),
            groups: 0,
            on_hidden_layers: BTreeMap::new(),
            not_finite: 0,
            missing: 0,
            endless: 0,
        }
    }

    fn spend(&mut self, bytes: usize) -> Result<(), PlanFileError> {
        let left = self.ink.checked_sub(bytes);
        self.ink =
            left.ok_or(PlanFileError::DrawingTooLarge { what: "bytes of lines, once its blocks are inserted", limit: DRAWN_LIMIT })?;
        Ok(())
    }

    fn layer(&self, number: usize) -> Option<&'a Layer> {
        self.drawing.looks.layers.get(number)
    }

    fn looking(&self, object: &Object, frame: &Frame) -> Looking {
        let inherits = self.layer(object.layer).is_some_and(Layer::is_inherited);
        let layer = frame.layer.filter(|_| inherits).unwrap_or(object.layer);
        let colour = match object.colour {
            Colour::Is(rgb) => rgb,
            Colour::ByBlock => frame.colour,
            Colour::ByLayer => self.layer(layer).map_or([0; 3], |l| l.colour),
        };
        let dashed = match object.line {
            Line::Is { dashed } => dashed,
            Line::ByBlock => frame.dashed,
            Line::ByLayer => self.layer(layer).is_some_and(|l| l.dashed),
        };
        Looking { layer, colour, dashed }
    }

    pub(super) fn object(&mut self, object: &'a Object, frame: &Frame) -> Result<(), PlanFileError> {
        self.spend(PATH_BYTES / 2)?;
        let looking = self.looking(object, frame);
        let is_insertion = matches!(object.shape, Shape::Insert(_));
        let shown = self.layer(looking.layer).is_none_or(|l| l.is_shown() || is_insertion && !l.frozen);
        if !shown {
            *self.on_hidden_layers.entry(looking.layer).or_default() += 1;
            return Ok(());
        }
        self.groups += 1;
        let place = frame.place.after(&object.plane);
        match &object.shape {
            Shape::Line { curve, closed } => self.line(curve, *closed, &place, &looking, frame),
            Shape::Area(rings) => rings.iter().try_for_each(|ring| self.ring(ring, &place, &looking, frame)),
            Shape::Text { at, height, text } => self.text(place.point(*at), height * place.mean(), text, &looking, frame),
            Shape::Insert(insertion) => self.insertion(insertion, &place, looking, frame),
        }
    }

    fn name(&self, looking: &Looking, frame: &Frame) -> String {
        let layer = self.layer(looking.layer).map_or("", |l| l.name.as_str());
        format!("{layer}{}", frame.names)
    }

    /// Chains are of one width from end to end: where it changes, the next begins.
    fn line(&mut self, curve: &Curve, closed: bool, place: &Affine, looking: &Looking, frame: &Frame) -> Result<(), PlanFileError> {
        let Curve::Chain(vertices) = curve else { return self.stroke(curve, closed, 0.0, place, looking, frame) };
        let widths = &vertices[..vertices.len().saturating_sub(usize::from(!closed))];
        let Some(first) = widths.first() else { return Ok(()) };
        if widths.iter().all(|v| v.width == first.width) {
            return self.stroke(curve, closed, first.width, place, looking, frame);
        }
        let mut vertices = vertices.clone();
        vertices.extend(vertices.first().copied().filter(|_| closed));
        let mut start = 0;
        while let Some(from) = vertices.get(start).filter(|_| start + 1 < vertices.len()) {
            let width = from.width;
            let same = vertices[start..vertices.len() - 1].iter().take_while(|v| v.width == width).count().max(1);
            let run: Vec<Vertex> = vertices[start..=start + same].to_vec();
            self.stroke(&Curve::Chain(run), false, width, place, looking, frame)?;
            start += same;
        }
        Ok(())
    }

    fn stroke(
        &mut self,
        curve: &Curve,
        closed: bool,
        width: f64,
        place: &Affine,
        looking: &Looking,
        frame: &Frame,
    ) -> Result<(), PlanFileError> {
        let points = self.points(std::slice::from_ref(curve), closed, place);
        let path = SketchPath {
            points,
            closed,
            fill: None,
            stroke: Some(looking.colour),
            width: width * place.mean(),
            dashed: looking.dashed,
            curved: curve.is_curved(),
            group: self.groups,
            layer: self.name(looking, frame),
        };
        self.path(path)
    }

    fn ring(&mut self, ring: &[Curve], place: &Affine, looking: &Looking, frame: &Frame) -> Result<(), PlanFileError> {
        let path = SketchPath {
            points: self.points(ring, false, place),
            closed: true,
            fill: Some(looking.colour),
            stroke: None,
            width: 0.0,
            dashed: false,
            curved: ring.iter().any(Curve::is_curved),
            group: self.groups,
            layer: self.name(looking, frame),
        };
        self.path(path)
    }

    /// Points of curves that follow each other; more than there is ink for end it.
    fn points(&self, curves: &[Curve], closed: bool, place: &Affine) -> Vec<Point> {
        let (error, enough) = (self.error / place.most(), self.ink / size_of::<Point>() + 1);
        let mut points = Vec::new();
        for curve in curves {
            let left = enough.saturating_sub(points.len());
            points.extend(curve.points(closed, error, left).into_iter().map(|p| place.point(p)));
        }
        points
    }

    /// Keeps a path that is one: finite, with two different points, none of them twice in a row.
    fn path(&mut self, mut path: SketchPath) -> Result<(), PlanFileError> {
        let numbers = path.points.iter().flatten().chain([&path.width]);
        let far = numbers.fold(0.0, |far: f64, v| if v.is_finite() { far.max(v.abs()) } else { f64::INFINITY });
        if !far.is_finite() {
            self.not_finite += 1;
            return Ok(());
        }
        let same = |a: &Point, b: &Point| (0..2).all(|k| (a[k] - b[k]).abs() <= SAME * far);
        path.points.dedup_by(|a, b| same(a, b));
        while path.closed && path.points.len() > 1 && path.points.first().zip(path.points.last()).is_some_and(|(a, b)| same(a, b)) {
            path.points.pop();
        }
        if path.points.len() < 2 {
            return Ok(());
        }
        self.spend(PATH_BYTES + path.layer.len() + path.points.len() * size_of::<Point>())?;
        self.sketch.paths.push(path);
        Ok(())
    }

    fn text(&mut self, at: Point, height: f64, text: &str, looking: &Looking, frame: &Frame) -> Result<(), PlanFileError> {
        if !(height.is_finite() && at.iter().all(|v| v.is_finite())) {
            self.not_finite += 1;
            return Ok(());
        }
        let layer = self.name(looking, frame);
        self.spend(PATH_BYTES + layer.len() + text.len())?;
        self.sketch.texts.push(SketchText { at, height, text: text.to_owned(), layer });
        Ok(())
    }

    fn insertion(&mut self, insertion: &'a Insertion, place: &Affine, looking: Looking, frame: &Frame) -> Result<(), PlanFileError> {
        let names = format!("{}/{}", frame.names, insertion.block);
        let labelled = Frame { place: frame.place, layer: Some(looking.layer), colour: looking.colour, dashed: looking.dashed, names };
        for label in &insertion.labels {
            self.object(label, &labelled)?;
        }
        let drawing = self.drawing;
        let number = drawing.block_of.get(&insertion.block.to_lowercase()).copied();
        let Some((number, block)) = number.and_then(|number| Some((number, drawing.blocks.get(number)?))) else {
            self.missing += 1;
            return Ok(());
        };
        if self.inside.contains(&number) || self.inside.len() >= DEPTH_LIMIT {
            self.endless += 1;
            return Ok(());
        }
        self.inside.push(number);
        let names = format!("{}/{}", frame.names, block.name);
        let mut inner = Frame { names, ..labelled };
        for row in 0..insertion.rows {
            for column in 0..insertion.columns {
                self.spend(PATH_BYTES / 2)?;
                inner.place = place.after(&insertion.place(column, row, block.base));
                for object in &block.objects {
                    self.object(object, &inner)?;
                }
            }
        }
        self.inside.pop();
        Ok(())
    }

    /// Extent of all but the outermost points, the longer side of it.
    pub(super) fn size(&self) -> f64 {
        let points = || self.sketch.paths.iter().flat_map(|path| &path.points).chain(self.sketch.texts.iter().map(|text| &text.at));
        let step = points().count() / SIZE_POINTS + 1;
        let extents = [0, 1].map(|k| {
            let mut values: Vec<f64> = points().step_by(step).map(|p| p[k]).collect();
            let last = values.len().saturating_sub(1);
            let astray = (last as f64 * ASTRAY) as usize;
            values.sort_unstable_by(f64::total_cmp);
            values.get(last - astray).zip(values.get(astray)).map_or(0.0, |(high, low)| high - low)
        });
        extents[0].max(extents[1])
    }

    /// Names of the hidden layers with most on them.
    pub(super) fn hidden_layers(&self) -> String {
        const NAMED: usize = 5;
        let mut layers: Vec<(usize, usize)> = self.on_hidden_layers.iter().map(|(layer, count)| (*count, *layer)).collect();
        layers.sort_unstable_by_key(|(count, layer)| (std::cmp::Reverse(*count), *layer));
        let names: Vec<&str> = layers.iter().take(NAMED).filter_map(|(_, layer)| Some(self.layer(*layer)?.name.as_str())).collect();
        names.join(", ") + if layers.len() > NAMED { " and others" } else { "" }
    }
}

impl Insertion {
    /// From the block's coordinates to those of what it is inserted into.
    fn place(&self, column: u16, row: u16, base: Point) -> Affine {
        let step = [f64::from(column) * self.spacing[0], f64::from(row) * self.spacing[1]];
        Affine::shift(self.at)
            .after(&Affine::turn(self.turn_rad))
            .after(&Affine::shift(step))
            .after(&Affine::scale(self.scale[0], self.scale[1]))
            .after(&Affine::shift(base.map(|v| -v)))
    }
}
