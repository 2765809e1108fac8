//! What is drawn in a section of entities? Lines, curves, areas, texts and insertions of blocks, each with its looks.
//!
//! [`Record`] ─▶ cleaned text, some hundred objects at a time ─▶ crate `dxf` ─▶ [`Object`]
//!
//! The crate knows which code means what for which object. It is given only what it reads well, for four reasons: it recurses into nested
//! groups until the stack is full, gives up the whole file at one number that is none, loses the end of texts with a backslash, and needs
//! a kilobyte for each line. Hatches, which it leaves out, are read here.

use dxf::Drawing;
use dxf::entities::{Entity, EntityType};
use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};

use super::curves::{Affine, Arc, Curve, Point, rad, sweep_rad};
use super::hatch::hatch_rings;
use super::labels::{label, paragraphs, single_line};
use super::look::{self, Colour, Line, Looks};
use super::pairs::{Pair, Record};
use super::shapes::{area, axes, chain, heavy_polyline, insertion, light_polyline, line, plane, spline, vector};

/// Records given to the crate at a time: more take memory, fewer take time.
const BATCH: usize = 500;
/// Vertices and attributes of one object; what comes after is left out, and counts as one that is broken.
const PARTS_LIMIT: usize = 500_000;
/// Stands for the number of parts of what is left out: its parts are too.
const NO_PARTS: usize = usize::MAX;
/// Something drawn, or inserted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Object {
    /// Its number in [`Looks::layers`].
    pub layer: usize,
    pub colour: Colour,
    pub line: Line,
    /// Drawn on a sheet of paper, not in the model.
    pub on_paper: bool,
    /// From the object's own plane.
    pub plane: Affine,
    pub shape: Shape,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    Line {
        curve: Box<Curve>,
        closed: bool,
    },
    /// Rings of curves that follow each other.
    Area(Vec<Vec<Curve>>),
    Text {
        at: Point,
        height: f64,
        text: String,
    },
    Insert(Box<Insertion>),
}

/// A block drawn once more, or in rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Insertion {
    pub block: String,
    pub at: Point,
    pub scale: [f64; 2],
    pub turn_rad: f64,
    pub columns: u16,
    pub rows: u16,
    /// From column to column and from row to row, before turning.
    pub spacing: [f64; 2],
    /// Texts that belong to this insertion, such as a room's number; they are where they are, not where the block puts them.
    pub labels: Vec<Object>,
}

/// What was not read, for people.
#[derive(Debug, Default)]
pub(super) struct Lost {
    /// Kinds of objects that are not drawn, and how many.
    pub kinds: std::collections::BTreeMap<String, usize>,
    /// Objects with a pair that is none, or a number that is not finite.
    pub broken: usize,
    /// Objects that say of themselves that they are not seen.
    pub hidden: usize,
}

/// Kinds that are told by name in [`Lost::kinds`]; objects of further ones are counted together.
const KINDS_NAMED: usize = 100;

impl Lost {
    fn kind(&mut self, kind: &str) {
        let kind = if self.kinds.len() < KINDS_NAMED { kind } else { "others" };
        *self.kinds.entry(look::short(kind).to_owned()).or_default() += 1;
    }
}

/// The code page of the file's texts.
///
/// Since 2007 it is UTF-8. Before, files name it, e.g. `ANSI_1251`.
pub(super) fn encoding(version: &str, code_page: &str) -> &'static Encoding {
    let year_2007 = version.trim().strip_prefix("AC").and_then(|v| v.parse().ok()).is_some_and(|v: u32| v >= 1021);
    if year_2007 {
        return UTF_8;
    }
    let page = code_page.trim().to_ascii_lowercase().replace("ansi_", "").replace("dos", "");
    let label = match page.as_str() {
        "932" => "shift_jis".to_owned(),
        "936" => "gbk".to_owned(),
        "949" => "euc-kr".to_owned(),
        "950" => "big5".to_owned(),
        "866" => "ibm866".to_owned(),
        page => format!("windows-{page}"),
    };
    Encoding::for_label(label.as_bytes()).unwrap_or(WINDOWS_1252)
}

/// A text of the file. What is UTF-8 is taken as that, whatever the file says: no other code page looks like it by chance.
pub(super) fn decode(bytes: &[u8], encoding: &'static Encoding) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => encoding.decode_without_bom_handling(bytes).0.into_owned(),
    }
}

/// Reads the objects of one section, or of one block.
pub(super) struct Reader<'a> {
    pub looks: &'a mut Looks,
    pub lost: &'a mut Lost,
    pub encoding: &'static Encoding,
    /// What the crate is to read next, and how many records that is.
    batch: Vec<String>,
    records: usize,
    /// Parts of the last object of the batch.
    parts: usize,
    objects: Vec<(u64, Object)>,
    /// Numbers objects, so that they stay in order.
    number: u64,
}

impl<'a> Reader<'a> {
    pub(super) fn new(looks: &'a mut Looks, lost: &'a mut Lost, encoding: &'static Encoding) -> Self {
        Self { looks, lost, encoding, batch: Vec::new(), records: 0, parts: 0, objects: Vec::new(), number: 0 }
    }

    /// One more record.
    pub(super) fn add(&mut self, record: &Record) {
        match record.kind.as_str() {
            "VERTEX" | "ATTRIB" | "SEQEND" => self.add_part(record),
            "LINE" | "3DLINE" | "LWPOLYLINE" | "POLYLINE" | "ARC" | "CIRCLE" | "ELLIPSE" | "SPLINE" | "SOLID" | "TRACE" | "TEXT"
            | "MTEXT" | "INSERT" => self.add_whole(record),
            "HATCH" => self.add_hatch(record),
            // Places without extent, and where attributes of a block will stand: what they say stands with each insertion.
            "POINT" | "VIEWPORT" | "ATTDEF" => {}
            kind => self.lost.kind(kind),
        }
    }

    fn add_whole(&mut self, record: &Record) {
        if self.records >= BATCH {
            self.read_batch();
        }
        self.number += 1;
        self.parts = 0;
        if record.broken {
            self.lost.broken += 1;
            self.parts = NO_PARTS;
            return;
        }
        let text = self.cleaned(record);
        self.batch.push(text);
        self.records += 1;
    }

    /// Parts follow the object that they belong to.
    fn add_part(&mut self, record: &Record) {
        if self.parts == NO_PARTS {
            return;
        }
        if record.broken || self.parts >= PARTS_LIMIT {
            self.lost.broken += 1;
            self.parts = if record.broken { self.parts } else { NO_PARTS };
            return;
        }
        let text = self.cleaned(record);
        if let Some(object) = self.batch.last_mut() {
            object.push_str(&text);
            self.records += 1;
            self.parts += 1;
        }
    }

    /// The record as ASCII, its handle the object's number.
    fn cleaned(&self, record: &Record) -> String {
        let mut text = format!("0\n{}\n5\n{:X}\n", record.kind, self.number);
        for pair in &record.pairs {
            let Pair { code, .. } = pair;
            let value = match code {
                // Names of text styles would only be collected, identifiers of vertices are no one's.
                7 | 90..=98 => continue,
                // A circumflex begins an escape, and one that follows a circumflex is itself.
                1..=9 => decode(&pair.value, self.encoding).replace('^', "^ ").replace(|c: char| c.is_control(), " "),
                _ => String::from_utf8_lossy(&pair.value).trim().to_owned(),
            };
            text.push_str(&format!("{code}\n{value}\n"));
        }
        text
    }

    fn read_batch(&mut self) {
        let batch = std::mem::take(&mut self.batch);
        self.records = 0;
        if load(&batch).map(|entities| self.take(&entities)).is_none() {
            // One object is not what its kind needs. Then each has to stand alone.
            for object in batch.chunks(1) {
                match load(object) {
                    Some(entities) => self.take(&entities),
                    None => self.lost.broken += 1,
                }
            }
        }
    }

    fn take(&mut self, entities: &[Entity]) {
        for entity in entities {
            if !entity.common.is_visible {
                self.lost.hidden += 1;
            } else if let Some(object) = self.object(entity) {
                self.objects.push((entity.common.handle.0, object));
            }
        }
    }

    /// All objects in the order of their records.
    pub(super) fn finish(mut self) -> Vec<Object> {
        self.read_batch();
        self.objects.sort_by_key(|(number, _)| *number);
        self.objects.into_iter().map(|(_, object)| object).collect()
    }

    fn object(&mut self, entity: &Entity) -> Option<Object> {
        let (plane, shape) = match &entity.specific {
            EntityType::Line(line) => (Affine::IDENTITY, chain(&[&line.p1, &line.p2], false)),
            EntityType::Arc(arc) => {
                let (from, to) = (rad(arc.start_angle), rad(arc.end_angle));
                let curve = Arc::of_circle([arc.center.x, arc.center.y], arc.radius, from, sweep_rad(from, to));
                (plane(&arc.normal, arc.center.z), line(Curve::Arc(curve), false))
            }
            EntityType::Circle(circle) => {
                let curve = Arc::of_circle([circle.center.x, circle.center.y], circle.radius, 0.0, std::f64::consts::TAU);
                (plane(&circle.normal, circle.center.z), line(Curve::Arc(curve), true))
            }
            EntityType::Ellipse(ellipse) => {
                let sweep = sweep_rad(ellipse.start_parameter, ellipse.end_parameter);
                let [u, v] = axes(vector(&ellipse.major_axis), vector(&ellipse.normal), ellipse.minor_axis_ratio);
                let centre = [ellipse.center.x, ellipse.center.y];
                let arc = Arc { centre, u, v, from_rad: ellipse.start_parameter, sweep_rad: sweep };
                (Affine::IDENTITY, line(Curve::Arc(arc), arc.is_whole()))
            }
            EntityType::LwPolyline(polyline) => (plane(&polyline.extrusion_direction, entity.common.elevation), light_polyline(polyline)),
            EntityType::Polyline(mesh) if mesh.is_3d_polygon_mesh() || mesh.is_polyface_mesh() => {
                self.lost.kind("POLYLINE mesh");
                return None;
            }
            EntityType::Polyline(polyline) => heavy_polyline(polyline),
            EntityType::Spline(entity) => (Affine::IDENTITY, spline(entity)),
            EntityType::Solid(s) => {
                let corners = [&s.first_corner, &s.second_corner, &s.fourth_corner, &s.third_corner];
                (plane(&s.extrusion_direction, s.first_corner.z), area(corners))
            }
            EntityType::Trace(t) => {
                let corners = [&t.first_corner, &t.second_corner, &t.fourth_corner, &t.third_corner];
                (plane(&t.extrusion_direction, t.first_corner.z), area(corners))
            }
            EntityType::Text(text) => single_line(text)?,
            EntityType::MText(text) => paragraphs(text)?,
            EntityType::Attribute(attribute) => label(attribute)?,
            EntityType::Insert(insert) => {
                let labels = insert.attributes().filter_map(label).map(|(plane, shape)| self.looking(entity, plane, shape)).collect();
                (plane(&insert.extrusion_direction, insert.location.z), insertion(insert, labels))
            }
            _ => return None,
        };
        Some(self.looking(entity, plane, shape))
    }

    fn looking(&mut self, entity: &Entity, plane: Affine, shape: Shape) -> Object {
        let common = &entity.common;
        let index = common.color.index().map_or(if common.color.is_by_block() { 0 } else { 256 }, i32::from);
        // The crate has 0 for none. Black itself is then told by its index, which files give besides.
        let true_colour = Some(common.color_24_bit).filter(|rgb| *rgb != 0);
        Object {
            layer: self.looks.layer(&common.layer),
            colour: Colour::of(index, true_colour),
            line: self.looks.line(&common.line_type_name),
            on_paper: common.is_in_paper_space,
            plane,
            shape,
        }
    }

    /// Areas that are filled, or filled with a pattern of lines: their outline.
    fn add_hatch(&mut self, record: &Record) {
        self.number += 1;
        self.parts = NO_PARTS;
        if record.broken {
            self.lost.broken += 1;
            return;
        }
        if record.whole(60) == Some(1) {
            self.lost.hidden += 1;
            return;
        }
        let text = |code| record.first(code).map(|pair| decode(&pair.value, self.encoding)).unwrap_or_default();
        let (layer, line_type) = (text(8), text(6));
        let rings = hatch_rings(&record.pairs);
        // A pattern stands for a material or a floor: its outline is drawn, but it is not an area of one colour.
        let solid = record.whole(70) == Some(1);
        let normal = [210, 220, 230].map(|code| record.number(code));
        let normal = if let [Some(x), Some(y), Some(z)] = normal { [x, y, z] } else { [0.0, 0.0, 1.0] };
        if rings.is_empty() || !solid {
            self.lost.kind(if solid { "HATCH without an outline" } else { "HATCH of lines" });
            return;
        }
        let object = Object {
            layer: self.looks.layer(&layer),
            colour: Colour::of(record.whole(62).unwrap_or(256), record.whole(420)),
            line: self.looks.line(&line_type),
            on_paper: record.whole(67) == Some(1),
            plane: Affine::of_plane(normal, record.number(30).unwrap_or(0.0)),
            shape: Shape::Area(rings),
        };
        self.objects.push((self.number, object));
    }
}

/// Entities of these texts; `None` if the crate cannot read one of them.
fn load(objects: &[String]) -> Option<Vec<Entity>> {
    if objects.is_empty() {
        return Some(Vec::new());
    }
    let file = format!("0\nSECTION\n2\nENTITIES\n{}0\nENDSEC\n0\nEOF\n", objects.concat());
    let drawing = Drawing::load_with_encoding(&mut file.as_bytes(), UTF_8).ok()?;
    Some(drawing.entities().cloned().collect())
}
