//! What is on a CAD drawing? DXF of any release, ASCII or binary, as a [`Sketch`].
//!
//! pairs ─▶ tables: layers, line types ─┐
//!      ─▶ blocks and entities ─────────┴─▶ objects ─▶ blocks put where they are inserted, curves made chords ─▶ [`Sketch`]
//!
//! Only the model is read, not the sheets of paper around it, and only layers that are shown. A thing inside of a block is on the layer
//! "LAYER/BLOCK": what a block is called often says what it is. DWG, the programmes' own format, is recognised and refused.
//! Pitfall: `$INSUNITS` is often wrong, because nobody needs it while drawing; who has the scale from elsewhere should trust that.

mod curves;
mod look;
mod objects;
mod pairs;
mod words;

use std::collections::{BTreeMap, HashMap};

use curves::{Affine, Curve, Point, Vertex};
use look::{Colour, Layer, Line, Looks};
use objects::{Insertion, Lost, Object, Reader, Shape};
use pairs::{Record, Records};

use super::PlanFileError;
use super::sketch::{Sketch, SketchPath, SketchText};

/// Largest file, bytes: a million lines take about 150 MB as ASCII.
const FILE_LIMIT: usize = 256 << 20;
/// Most objects that a file may define, blocks' own ones included.
const OBJECTS_LIMIT: usize = 3_000_000;
/// Most memory that all blocks put in their places may take, bytes: about four million short lines.
const DRAWN_LIMIT: usize = 1 << 30;
/// What a path takes besides its points and its name, bytes.
const PATH_BYTES: usize = 160;
/// Blocks in blocks in blocks; real drawings have less than ten.
const DEPTH_LIMIT: usize = 32;
/// Allowed error of chords, metres.
const ERROR_M: f64 = 0.01;
/// And as a share of the drawing's size, which counts where it is smaller: the unit may be missing, or wrong.
const ERROR_SHARE: f64 = 1.0 / 2000.0;
/// Points are one if they differ by less than this share of their coordinates: a circle's end is its beginning but for round-off.
const SAME: f64 = 1e-12;
/// Points that are looked at for the drawing's size, spread evenly over all.
const SIZE_POINTS: usize = 1_000_000;
/// Share of all points at either side that does not count for the size: a line left somewhere far off is no part of the floor.
const ASTRAY: f64 = 0.01;

/// Whether a file that begins like this is a DXF drawing.
pub(super) fn is_one(head: &[u8]) -> bool {
    if head.starts_with(pairs::SENTINEL) {
        return true;
    }
    let head = String::from_utf8_lossy(head);
    let mut lines = head.trim_start_matches('\u{feff}').lines().map(str::trim).skip_while(|line| line.is_empty());
    loop {
        match (lines.next(), lines.next()) {
            (Some("999"), Some(_)) => {}
            (Some("0"), word) => return word == Some("SECTION"),
            _ => return false,
        }
    }
}

/// Whether a file that begins like this is a DWG drawing: release 1.0 to the newest.
pub(super) fn is_dwg(head: &[u8]) -> bool {
    dwg_version(head).is_some()
}

/// E.g. `AC1027`, and what follows is no text.
fn dwg_version(head: &[u8]) -> Option<String> {
    let (version, rest) = head.split_at_checked(6)?;
    let (letters, digits) = version.split_at_checked(2)?;
    let numbered = letters == b"AC" && digits.iter().all(|b| b.is_ascii_digit() || *b == b'.');
    (numbered && rest.first().is_none_or(|b| *b < b' ')).then(|| String::from_utf8_lossy(version).into_owned())
}

/// Reads a DXF drawing.
///
/// # Errors
/// [`PlanFileError::Dwg`], [`PlanFileError::Dxf`] if nothing can be read of it, [`PlanFileError::DrawingTooLarge`].
pub(super) fn read(bytes: &[u8]) -> Result<Sketch, PlanFileError> {
    if let Some(version) = dwg_version(bytes) {
        return Err(PlanFileError::Dwg { version });
    }
    if bytes.len() > FILE_LIMIT {
        return Err(PlanFileError::DrawingTooLarge { what: "bytes of file", limit: FILE_LIMIT });
    }
    let drawing = Drawing::read(bytes)?;
    drawing.sketch(DRAWN_LIMIT)
}

/// The file, before blocks are put in their places.
#[derive(Default)]
struct Drawing {
    looks: Looks,
    /// Code of `$INSUNITS`.
    unit: i32,
    /// Whether `$MEASUREMENT` says metric; it says nothing of the unit.
    metric: Option<bool>,
    blocks: Vec<Block>,
    /// By name in lower case.
    block_of: HashMap<String, usize>,
    objects: Vec<Object>,
    lost: Lost,
    cut_off: bool,
}

struct Block {
    name: String,
    /// Which of its points comes where it is inserted.
    base: Point,
    objects: Vec<Object>,
}

/// Where in the file we are.
#[derive(Clone, Copy, PartialEq)]
enum Section {
    Tables,
    Blocks,
    Entities,
    Other,
}

impl Drawing {
    fn read(bytes: &[u8]) -> Result<Self, PlanFileError> {
        let mut drawing = Self::default();
        let mut records = Records::of(bytes);
        let mut section = Section::Other;
        let mut encoding = objects::encoding("", "");
        let mut sections = 0;
        let mut defined = 0;
        while let Some(record) = records.next() {
            let name = || record.first(2).map(|pair| objects::decode(&pair.value, encoding)).unwrap_or_default();
            match (record.kind.as_str(), section) {
                ("SECTION", _) => {
                    sections += 1;
                    section = match name().trim() {
                        "TABLES" => Section::Tables,
                        "BLOCKS" => Section::Blocks,
                        "ENTITIES" => Section::Entities,
                        "HEADER" => {
                            encoding = drawing.header(&record);
                            Section::Other
                        }
                        _ => Section::Other,
                    };
                    if section == Section::Entities {
                        let read = drawing.objects_until(&["ENDSEC"], &mut records, encoding, &mut defined)?;
                        drawing.objects.extend(read);
                    }
                }
                ("LAYER" | "LTYPE", Section::Tables) => drawing.table_entry(&record, encoding),
                ("BLOCK", Section::Blocks) => {
                    let base = [10, 20].map(|code| record.number(code).unwrap_or(0.0));
                    let name = look::short(&name()).to_owned();
                    let objects = drawing.objects_until(&["ENDBLK", "ENDSEC"], &mut records, encoding, &mut defined)?;
                    drawing.block_of.entry(name.to_lowercase()).or_insert(drawing.blocks.len());
                    drawing.blocks.push(Block { name, base, objects });
                }
                ("ENDSEC", _) => section = Section::Other,
                _ => {}
            }
        }
        if sections == 0 {
            return Err(PlanFileError::Dxf { why: "no section begins in it".to_owned() });
        }
        drawing.cut_off = !records.ended;
        Ok(drawing)
    }

    /// Units, and the code page that texts are in.
    fn header(&mut self, record: &Record) -> &'static encoding_rs::Encoding {
        let mut variable = String::new();
        let (mut version, mut code_page) = (String::new(), String::new());
        for pair in &record.pairs {
            let text = || String::from_utf8_lossy(&pair.value).trim().to_owned();
            match (variable.as_str(), pair.code) {
                (_, 9) => variable = text(),
                ("$INSUNITS", 70) => self.unit = pair.number().map_or(0, |v| v as i32),
                ("$MEASUREMENT", 70) => self.metric = pair.number().map(|v| v == 1.0),
                ("$ACADVER", 1) => version = text(),
                ("$DWGCODEPAGE", 3) => code_page = text(),
                _ => {}
            }
        }
        objects::encoding(&version, &code_page)
    }

    fn table_entry(&mut self, record: &Record, encoding: &'static encoding_rs::Encoding) {
        let text = |code| record.first(code).map(|pair| objects::decode(&pair.value, encoding)).unwrap_or_default();
        let name = text(2);
        if record.kind == "LTYPE" {
            let has_gaps = record.pairs.iter().any(|pair| pair.code == 49 && pair.number().is_some_and(|dash| dash <= 0.0));
            self.looks.define_line(&name, has_gaps);
        } else {
            let index = record.whole(62).unwrap_or(7);
            self.looks.define_layer(&name, record.whole(70).unwrap_or(0), index, record.whole(420), &text(6));
        }
    }

    fn objects_until(
        &mut self,
        ends: &[&str],
        records: &mut Records,
        encoding: &'static encoding_rs::Encoding,
        defined: &mut usize,
    ) -> Result<Vec<Object>, PlanFileError> {
        let mut reader = Reader::new(&mut self.looks, &mut self.lost, encoding);
        for record in records.take_while(|record| !ends.contains(&record.kind.as_str())) {
            *defined += 1;
            if *defined > OBJECTS_LIMIT {
                return Err(PlanFileError::DrawingTooLarge { what: "objects", limit: OBJECTS_LIMIT });
            }
            reader.add(&record);
        }
        Ok(reader.finish())
    }

    /// With so many bytes of ink, at most.
    fn sketch(&self, ink: usize) -> Result<Sketch, PlanFileError> {
        let unit = look::unit(self.unit);
        let on_paper = !self.objects.iter().any(|object| !object.on_paper);
        // Twice: how large the drawing is shows which chords it needs.
        let size = self.drawn(on_paper, f64::INFINITY, ink)?.size();
        let stated = unit.map_or(f64::INFINITY, |(_, metres)| ERROR_M / metres);
        let mut pen = self.drawn(on_paper, stated.min(size * ERROR_SHARE), ink)?;
        if pen.sketch.paths.is_empty() && pen.sketch.texts.is_empty() {
            return Err(PlanFileError::Dxf { why: self.emptiness(&pen) });
        }
        pen.sketch.metres_per_unit = unit.map(|(_, metres)| metres);
        pen.sketch.notes = self.notes(&pen, on_paper);
        Ok(pen.sketch)
    }

    fn drawn(&self, on_paper: bool, error: f64, ink: usize) -> Result<Pen<'_>, PlanFileError> {
        let mut pen = Pen::new(self, error, ink);
        let sheet = Frame { place: Affine::IDENTITY, layer: None, colour: [0; 3], dashed: false, names: String::new() };
        for object in self.objects.iter().filter(|object| object.on_paper == on_paper) {
            pen.object(object, &sheet)?;
        }
        Ok(pen)
    }

    /// Why nothing is drawn.
    fn emptiness(&self, pen: &Pen) -> String {
        let notes = self.notes(pen, false);
        let details = notes.get(1..).unwrap_or_default().join("; ");
        format!("none of its {} objects is a line, an area or a text that is shown ({details})", self.objects.len())
    }

    fn notes(&self, pen: &Pen, on_paper: bool) -> Vec<String> {
        let [paths, texts] = [pen.sketch.paths.len(), pen.sketch.texts.len()];
        let mut notes = vec![format!("a CAD drawing: {paths} lines and areas and {texts} texts of {} objects", self.objects.len())];
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} {what}"));
            }
        };
        let papers = self.objects.iter().filter(|object| object.on_paper).count();
        note(if on_paper { 0 } else { papers }, "objects on sheets of paper are left out");
        note(
            pen.on_hidden_layers.values().sum(),
            &format!("objects on layers that are off or frozen are left out: {}", pen.hidden_layers()),
        );
        note(self.lost.hidden, "objects are marked as not seen and left out");
        note(self.lost.broken, "objects are broken and left out");
        note(pen.not_finite, "lines or texts are infinitely far off and left out");
        note(pen.missing, "insertions are of blocks that are not in the file: bind external references, then save it again");
        note(pen.endless, "insertions of blocks into themselves, or too deep in others, are left out");
        let kinds: Vec<String> = self.lost.kinds.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
        if !kinds.is_empty() {
            notes.push(format!("not drawn: {}; what of these is a wall must be exploded into lines first", kinds.join(", ")));
        }
        if on_paper {
            notes.push("the model is empty: the sheet of paper is read instead, at whatever scale it has".to_owned());
        }
        if self.cut_off {
            notes.push("the file has no end: it may be cut off, and objects may be missing".to_owned());
        }
        notes.push(self.unit_note());
        notes
    }

    fn unit_note(&self) -> String {
        let metric = match self.metric {
            Some(true) => "; it is metric",
            Some(false) => "; it is imperial",
            None => "",
        };
        match (look::unit(self.unit), self.unit) {
            (Some((name, _)), code) => format!("its unit is {name} ($INSUNITS {code})"),
            (None, 0) => format!("it does not say how long its unit is ($INSUNITS is 0 or missing{metric})"),
            (None, code) => format!("its unit is not known ($INSUNITS {code}{metric})"),
        }
    }
}

/// What an object inherits from the insertion that it is part of.
struct Frame {
    place: Affine,
    /// Layer of the insertion, for objects on layer 0.
    layer: Option<usize>,
    colour: [u8; 3],
    dashed: bool,
    /// "/BLOCK" of each block around.
    names: String,
}

/// Puts objects in their places.
struct Pen<'a> {
    drawing: &'a Drawing,
    error: f64,
    sketch: Sketch,
    /// Bytes that may still be drawn.
    ink: usize,
    /// Blocks that we are in.
    inside: Vec<usize>,
    groups: usize,
    on_hidden_layers: BTreeMap<usize, usize>,
    not_finite: usize,
    missing: usize,
    endless: usize,
}

/// An object's looks, with what it inherits.
struct Looking {
    layer: usize,
    colour: [u8; 3],
    dashed: bool,
}

impl<'a> Pen<'a> {
    fn new(drawing: &'a Drawing, error: f64, ink: usize) -> Self {
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

    fn object(&mut self, object: &'a Object, frame: &Frame) -> Result<(), PlanFileError> {
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
    fn size(&self) -> f64 {
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
    fn hidden_layers(&self) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Pairs as a file has them: a code and a value each, separated by spaces; `~` stands for a space in values.
    fn pairs(text: &str) -> String {
        let words: Vec<&str> = text.split_whitespace().collect();
        words.chunks(2).map(|pair| format!("{}\n{}\n", pair[0], pair.get(1).unwrap_or(&"").replace('~', " "))).collect()
    }

    fn file(header: &str, tables: &str, blocks: &str, entities: &str) -> String {
        pairs(&format!(
            "0 SECTION 2 HEADER {header} 0 ENDSEC 0 SECTION 2 TABLES {tables} 0 ENDSEC 0 SECTION 2 BLOCKS {blocks} 0 ENDSEC \
             0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF"
        ))
    }

    fn entities(entities: &str) -> Sketch {
        read(file("", "", "", entities).as_bytes()).unwrap()
    }

    /// The points of all paths, to the centimetre, without minus zeros.
    fn points(sketch: &Sketch) -> Vec<Vec<Point>> {
        let round = |p: &Point| p.map(|v| (v * 100.0).round() / 100.0 + 0.0);
        sketch.paths.iter().map(|path| path.points.iter().map(round).collect()).collect()
    }

    fn noted(sketch: &Sketch, words: &str) -> bool {
        sketch.notes.iter().any(|note| note.contains(words))
    }

    const LINE: &str = "0 LINE 8 A-WALL 10 1 20 2 11 4 21 2";

    #[test]
    fn a_line_has_its_layer_its_colour_and_its_unit() {
        let header = "9 $ACADVER 1 AC1015 9 $TDCREATE 40 1.#INF 9 $INSUNITS 70 4";
        let tables = "0 TABLE 2 LTYPE 0 LTYPE 2 Zaun 49 0.5 49 -0.25 0 ENDTAB \
                      0 TABLE 2 LAYER 0 LAYER 2 A-WALL 70 0 62 3 6 CONTINUOUS 0 LAYER 2 HID 62 1 6 zaun 0 ENDTAB";
        let lines = format!("{LINE} {LINE} 8 HID {LINE} 62 5 6 HIDDEN2 {LINE} 62 5 420 {}", 0xFF_8000);
        let sketch =
            read(file(header, tables, "", &lines.replace("8 A-WALL 10 1 20 2 11 4 21 2 8 HID", "8 HID 10 1 20 2 11 4 21 2")).as_bytes())
                .unwrap();
        let looks: Vec<_> = sketch.paths.iter().map(|p| (p.layer.as_str(), p.stroke.unwrap(), p.dashed)).collect();
        let green = [0, 255, 0];
        assert_eq!(
            looks,
            [("A-WALL", green, false), ("HID", [255, 0, 0], true), ("A-WALL", [0, 0, 255], true), ("A-WALL", [255, 128, 0], false)]
        );
        assert_eq!((sketch.metres_per_unit, points(&sketch)[0].as_slice()), (Some(0.001), [[1.0, 2.0], [4.0, 2.0]].as_slice()));
        assert!(noted(&sketch, "millimetres"), "{:?}", sketch.notes);
    }

    #[test]
    fn a_unit_that_is_not_stated_is_not_guessed() {
        let sketch = read(file("9 $MEASUREMENT 70 1", "", "", LINE).as_bytes()).unwrap();
        assert_eq!(sketch.metres_per_unit, None);
        assert!(noted(&sketch, "does not say how long its unit is") && noted(&sketch, "metric"), "{:?}", sketch.notes);
    }

    #[test]
    fn polylines_old_and_new_have_bulges_widths_and_ends() {
        let new = "0 LWPOLYLINE 90 3 70 1 43 0.2 10 0 20 0 10 4 20 0 42 1 10 4 20 2";
        let old = "0 POLYLINE 66 1 70 1 40 0.2 41 0.2 0 VERTEX 10 0 20 0 0 VERTEX 10 4 20 0 42 1 0 VERTEX 10 4 20 2 0 SEQEND";
        let (new, old) = (entities(new), entities(old));
        assert_eq!(points(&new), points(&old));
        let path = &new.paths[0];
        assert_eq!((path.closed, path.curved, path.width), (true, true, 0.2));
        assert!(path.points.len() > 10 && path.points.iter().any(|p| (p[0] - 5.0).abs() < 0.01), "the half circle reaches x = 5");
        let open = entities("0 LWPOLYLINE 10 0 20 0 10 1 20 0 40 0.4 41 0.4 10 2 20 0 40 0.4 41 0.4 10 3 20 0");
        assert_eq!(points(&open), [vec![[0.0, 0.0], [1.0, 0.0]], vec![[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]]);
        assert_eq!((open.paths[1].width, open.paths[0].group == open.paths[1].group), (0.4, true));
    }

    #[test]
    fn arcs_turn_counter_clockwise_and_mirrored_ones_the_other_way() {
        let arc = "0 ARC 10 5 20 0 40 1 50 0 51 90";
        let ends = |sketch: &Sketch| (points(sketch)[0][0], *points(sketch)[0].last().unwrap());
        assert_eq!(ends(&entities(arc)), ([6.0, 0.0], [5.0, 1.0]));
        assert_eq!(ends(&entities(&format!("{arc} 210 0 220 0 230 -1"))), ([-6.0, 0.0], [-5.0, 1.0]));
        assert_eq!(ends(&entities("0 ARC 10 0 20 0 40 1 50 270 51 90")), ([0.0, -1.0], [0.0, 1.0]));
        let circle = &entities("0 CIRCLE 10 0 20 0 40 3").paths[0];
        assert!(circle.closed && circle.curved && circle.points.len() > 50);
        let [first, last] = [circle.points[0], *circle.points.last().unwrap()];
        assert!((first[0] - last[0]).hypot(first[1] - last[1]) > 0.1, "{first:?} is not there twice");
        let ellipse = entities("0 ELLIPSE 10 0 20 0 11 2 21 0 40 0.5 41 0 42 1.570796326794");
        assert_eq!(ends(&ellipse), ([2.0, 0.0], [0.0, 1.0]));
        let spline = entities("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 30 0 10 1 20 2 30 0 10 2 20 0 30 0");
        assert!(ends(&spline) == ([0.0, 0.0], [2.0, 0.0]) && spline.paths[0].points.iter().any(|p| (p[1] - 1.0).abs() < 1e-9));
    }

    #[test]
    fn areas_are_filled() {
        let solid = entities("0 SOLID 62 1 10 0 20 0 11 2 21 0 12 0 22 1 13 2 23 1");
        assert_eq!(points(&solid), [vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]]);
        assert_eq!((solid.paths[0].fill, solid.paths[0].stroke), (Some([255, 0, 0]), None));
        let outline = "92 2 72 0 73 1 93 3 10 0 20 0 10 4 20 0 10 4 20 4 97 0";
        let hole = "92 1 93 2 72 1 10 3 20 1 11 2 21 1 72 2 10 2.5 20 1 40 0.5 50 180 51 360 73 1 97 1 330 AF";
        let hatch = entities(&format!("0 HATCH 10 0 20 0 30 0 2 SOLID 70 1 71 0 91 2 {outline} {hole} 75 1 98 1 10 9 20 9"));
        let [ring, island] = &hatch.paths[..] else { panic!("{hatch:?}") };
        assert_eq!((ring.points.len(), ring.group == island.group, island.curved), (3, true, true));
        assert!(island.points.iter().all(|p| p[1] <= 1.0 + 1e-9) && island.points.iter().any(|p| p[1] < 0.51), "{:?}", island.points);
        let lines = entities(&format!("{LINE} 0 HATCH 2 ANSI31 70 0 91 1 {outline}"));
        assert!(lines.paths.len() == 1 && noted(&lines, "1 HATCH of lines"), "{:?}", lines.notes);
    }

    #[test]
    fn texts_are_where_their_base_line_begins() {
        let at = |text: &str| {
            let sketch = entities(text);
            let text = &sketch.texts[0];
            (text.text.clone(), text.at.map(|v| (v * 100.0).round() / 100.0 + 0.0), text.height)
        };
        let is = |text: &str, at: Point| (text.to_owned(), at, 2.0);
        assert_eq!(at("0 TEXT 10 1 20 2 40 2 1 %%u101%%u"), is("101", [1.0, 2.0]));
        assert_eq!(at("0 TEXT 10 7 20 2 40 2 1 101 72 1 11 9 21 2"), is("101", [7.0, 2.0]));
        assert_eq!(at("0 TEXT 10 0 20 0 40 2 1 1234 72 4 11 9 21 2"), is("1234", [6.0, 1.0]));
        assert_eq!(at(r"0 MTEXT 10 1 20 9 40 2 71 1 1 {\fArial|b1;OFFICE}\P101"), is("OFFICE\n101", [1.0, 7.0]));
        assert_eq!(at("0 MTEXT 10 1 20 9 40 2 71 5 11 0 21 1 1 1234"), is("1234", [2.0, 6.0]));
        let long = entities(r"0 MTEXT 10 1 20 9 40 2 3 a\P 3 b~ 1 c");
        assert_eq!(long.texts[0].text, "a\nb c");
    }

    #[test]
    fn old_files_say_their_code_page() {
        let text = |header: &str, bytes: &[u8]| {
            let mut file = pairs(&format!("0 SECTION 2 HEADER {header} 0 ENDSEC 0 SECTION 2 ENTITIES 0 TEXT 10 0 20 0 40 1")).into_bytes();
            file.extend(b"1\n");
            file.extend(bytes);
            file.extend(b"\n0\nENDSEC\n0\nEOF\n");
            read(&file).unwrap().texts[0].text.clone()
        };
        assert_eq!(text("9 $ACADVER 1 AC1009 9 $DWGCODEPAGE 3 ANSI_1251", &[0xca, 0xeb]), "Кл");
        assert_eq!(text("9 $ACADVER 1 AC1021 9 $DWGCODEPAGE 3 ANSI_1251", "Büro".as_bytes()), "Büro");
        assert_eq!(text("", &[b'B', 0xfc, b'r', b'o']), "Büro");
    }

    const DOOR: &str = "0 BLOCK 2 Door 70 0 10 1 20 0 0 LINE 8 0 62 0 10 1 20 0 11 2 21 0 0 LINE 8 LEAF 10 1 20 0 11 1 21 1 0 ENDBLK";

    #[test]
    fn blocks_are_moved_turned_stretched_and_mirrored() {
        let inserted = |insert: &str| read(file("", "", DOOR, &format!("0 INSERT 8 A-DOOR 62 1 2 DOOR {insert}")).as_bytes()).unwrap();
        let sketch = inserted("10 10 20 20 50 90 41 3 42 -2");
        assert_eq!(points(&sketch), [vec![[10.0, 20.0], [10.0, 23.0]], vec![[10.0, 20.0], [12.0, 20.0]]]);
        let looks: Vec<_> = sketch.paths.iter().map(|p| (p.layer.as_str(), p.stroke.unwrap())).collect();
        assert_eq!(looks, [("A-DOOR/Door", [255, 0, 0]), ("LEAF/Door", [0, 0, 0])]);
        let rows = inserted("10 0 20 0 70 2 71 3 44 5 45 7");
        let first: Vec<Point> = points(&rows).iter().step_by(2).map(|p| p[0]).collect();
        assert_eq!(first, [[0.0, 0.0], [5.0, 0.0], [0.0, 7.0], [5.0, 7.0], [0.0, 14.0], [5.0, 14.0]]);
        assert_eq!(points(&inserted("10 10 20 0 230 -1"))[0], [[-10.0, 0.0], [-11.0, 0.0]]);
        let labelled = inserted(
            "66 1 10 10 20 20 41 9 0 ATTRIB 8 0 10 3 20 4 40 2 1 D1 2 NUMBER 70 0 0 ATTRIB 8 0 10 3 20 4 40 2 1 X 2 Y 70 1 0 SEQEND",
        );
        assert_eq!((labelled.texts.len(), labelled.texts[0].text.as_str(), labelled.texts[0].at), (1, "D1", [3.0, 4.0]));
        assert_eq!(labelled.texts[0].layer, "A-DOOR/DOOR");
    }

    #[test]
    fn blocks_in_blocks_are_named_from_outside_in() {
        let outer = "0 BLOCK 2 Wing 10 0 20 0 0 INSERT 8 0 2 Door 10 5 20 5 0 ENDBLK";
        let sketch = read(file("", "", &format!("{outer} {DOOR}"), "0 INSERT 8 EAST 2 Wing 10 100 20 0").as_bytes()).unwrap();
        assert_eq!((sketch.paths[0].layer.as_str(), points(&sketch)[0][0]), ("EAST/Wing/Door", [105.0, 5.0]));
    }

    #[test]
    fn blocks_that_explode_or_contain_themselves_are_stopped() {
        let endless = "0 BLOCK 2 A 0 LINE 10 0 20 0 11 1 21 0 0 INSERT 2 B 0 ENDBLK 0 BLOCK 2 B 0 INSERT 2 A 0 ENDBLK";
        let sketch = read(file("", "", endless, "0 INSERT 2 A 0 INSERT 2 nowhere").as_bytes()).unwrap();
        assert_eq!(sketch.paths.len(), 1);
        assert!(noted(&sketch, "into themselves") && noted(&sketch, "not in the file"), "{:?}", sketch.notes);
        // Thirty times two of the one before: a thousand million.
        let bomb: String = (0..30).map(|k| format!("0 BLOCK 2 B{} 0 INSERT 2 B{k} 0 INSERT 2 B{k} 0 ENDBLK ", k + 1)).collect();
        let drawn = |blocks, entities| Drawing::read(file("", "", blocks, entities).as_bytes()).unwrap().sketch(1 << 20);
        let too_large = drawn(&bomb, "0 INSERT 2 B30");
        assert!(matches!(too_large, Err(PlanFileError::DrawingTooLarge { .. })), "{too_large:?}");
        let array = drawn(DOOR, "0 INSERT 2 Door 70 32767 71 32767");
        assert!(matches!(array, Err(PlanFileError::DrawingTooLarge { .. })), "{array:?}");
    }

    #[test]
    fn more_entities_than_any_floor_has_are_refused() {
        let crowd = file("", "", "", &"0 POINT ".repeat(OBJECTS_LIMIT + 1));
        let refused = read(crowd.as_bytes());
        assert!(matches!(refused, Err(PlanFileError::DrawingTooLarge { .. })), "{:?}", refused.map(|sketch| sketch.notes));
    }

    #[test]
    fn what_is_not_shown_is_left_out() {
        let tables = "0 TABLE 2 LAYER 0 LAYER 2 OFF 62 -3 70 0 0 LAYER 2 ICE 62 3 70 1 0 ENDTAB";
        let hidden = format!("{LINE} 0 LINE 8 off 10 1 11 2 0 LINE 8 ICE 10 1 11 2 0 LINE 60 1 10 1 11 2 0 LINE 67 1 10 1 11 2");
        let inserts = "0 INSERT 8 OFF 2 Door 0 INSERT 8 ICE 2 Door";
        let sketch = read(file("", tables, DOOR, &format!("{hidden} {inserts}")).as_bytes()).unwrap();
        let layers: Vec<&str> = sketch.paths.iter().map(|p| p.layer.as_str()).collect();
        // Of what is inserted on a layer that is off, only what lies on that layer too is hidden.
        assert_eq!(layers, ["A-WALL", "LEAF/Door"]);
        for words in ["4 objects on layers that are off or frozen are left out: OFF, ICE", "1 objects are marked", "1 objects on sheets"] {
            assert!(noted(&sketch, words), "{:?}", sketch.notes);
        }
        let paper = entities("0 LINE 67 1 10 1 20 1 11 2 21 1");
        assert!(paper.paths.len() == 1 && noted(&paper, "the model is empty"), "{:?}", paper.notes);
    }

    #[test]
    fn broken_objects_are_counted_and_the_others_read() {
        let broken =
            "0 LINE 10 nan 20 0 11 1 21 1 0 LINE 10 1e999 20 0 11 1 21 1 0 LWPOLYLINE 20 3 10 1 0 CIRCLE 10 1e308 20 1e308 40 1e308";
        let sketch = entities(&format!("{LINE} {broken} 0 DIMENSION 2 *D1 0 3DSOLID 0 POLYLINE 70 64 {LINE}"));
        assert_eq!(sketch.paths.len(), 2);
        for words in ["3 objects are broken", "1 lines or texts are infinitely far", "1 3DSOLID, 1 DIMENSION, 1 POLYLINE mesh"] {
            assert!(noted(&sketch, words), "{:?}", sketch.notes);
        }
        let all = file("", "", "", &format!("{LINE} {LINE}"));
        let cut = read(&all.as_bytes()[..all.len() - 25]).unwrap();
        assert!(cut.paths.len() == 1 && noted(&cut, "cut off"), "{:?}", cut.notes);
    }

    #[test]
    fn other_files_are_refused_with_what_to_do() {
        let why = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert!(why(b"AC1027\0\0\0\0").contains("ODA File Converter"));
        assert!(why(b"").contains("no section"));
        assert!(why(b"%PDF-1.7\nhello\n").contains("no section"));
        assert!(why(file("", "", "", "").as_bytes()).contains("none of its 0 objects"));
        assert!(is_one(LINE_FILE.as_bytes()) && is_one(pairs::SENTINEL) && is_one(b"\xef\xbb\xbf  0\nSECTION\n"));
        for other in ["", "0", "0\nLINE\n", "0,0,4,0\n4,0,4,3\n", "AC1027\0", "{}"] {
            assert!(!is_one(other.as_bytes()), "{other}");
        }
        assert!(is_dwg(b"AC1015\0\0") && is_dwg(b"AC2.10\0") && !is_dwg(b"AC1015 is a release") && !is_dwg(b"AC"));
    }

    const LINE_FILE: &str = "999\r\nmade by hand\r\n  0\r\nSECTION\r\n  2\r\nENTITIES\r\n  0\r\nEOF\r\n";

    #[test]
    fn binary_files_say_the_same() {
        let mut binary = pairs::SENTINEL.to_vec();
        let mut add = |code: u8, value: &[u8]| binary.extend([code, 0].iter().chain(value));
        add(0, b"SECTION\0");
        add(2, b"ENTITIES\0");
        add(0, b"LINE\0");
        add(8, b"A-WALL\0");
        for (code, value) in [(10, 1.0f64), (20, 2.0), (11, 4.0), (21, 2.0)] {
            add(code, &value.to_le_bytes());
        }
        add(0, b"ENDSEC\0");
        add(0, b"EOF\0");
        assert_eq!(read(&binary).unwrap(), entities(LINE));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]

        #[test]
        fn nothing_that_a_file_says_is_a_panic(
            words in prop::collection::vec(
                prop_oneof![
                    prop::sample::select(vec![
                        "LINE", "ARC", "INSERT", "POLYLINE", "VERTEX", "ATTRIB", "SPLINE", "HATCH", "MTEXT", "TEXT", "ELLIPSE", "SOLID",
                        "LWPOLYLINE", "BLOCK", "ENDBLK", "ENDSEC", "SECTION", "SEQEND", "EOF",
                    ]).prop_map(|kind| format!("0 {kind}")),
                    (prop::sample::select(vec![1, 2, 8, 10, 11, 20, 40, 41, 42, 50, 62, 66, 70, 71, 72, 73, 91, 92, 93, 210, 230]), -3i32..9)
                        .prop_map(|(code, value)| format!("{code} {value}")),
                ],
                0..200,
            ),
        ) {
            let text = words.join(" ");
            if let Ok(sketch) = read(file("", "", &text, &text).as_bytes()) {
                prop_assert!(sketch.paths.iter().all(|path| path.points.len() >= 2));
                prop_assert!(sketch.paths.iter().flat_map(|path| &path.points).flatten().all(|v| v.is_finite()));
            }
        }
    }
}
