//! What is on a CAD drawing? DXF of any release, ASCII or binary, as a [`Sketch`].
//!
//! pairs ─▶ tables: layers, line types ─┐
//!      ─▶ blocks and entities ─────────┴─▶ objects ─▶ blocks put where they are inserted, curves made chords ─▶ [`Sketch`]
//!
//! Only the model is read, not the sheets of paper around it, and only layers that are shown. A thing inside of a block is on the layer
//! "LAYER/BLOCK": what a block is called often says what it is. DWG, the programmes' own format, is recognised and refused.
//! Pitfall: `$INSUNITS` is often wrong, because nobody needs it while drawing; who has the scale from elsewhere should trust that.

mod curves;
mod hatch;
mod labels;
mod look;
mod objects;
mod pairs;
mod place;
mod shapes;
mod words;

use std::collections::HashMap;

use curves::{Affine, Point};
use look::Looks;
use objects::{Lost, Object, Reader};
use pairs::{Record, Records};
use place::{Frame, Placer};

use super::PlanFileError;
use super::sketch::Sketch;

/// Largest file, bytes: a million lines take about 150 MB as ASCII.
const FILE_LIMIT: usize = 256 << 20;
/// Most objects that a file may define, blocks' own ones included.
const OBJECTS_LIMIT: usize = 3_000_000;
/// Most memory that all blocks put in their places may take, bytes: about four million short lines.
const DRAWN_LIMIT: usize = 1 << 30;
/// Allowed error of chords, metres.
const ERROR_M: f64 = 0.01;
/// And as a share of the drawing's size, which counts where it is smaller: the unit may be missing, or wrong.
const ERROR_SHARE: f64 = 1.0 / 2000.0;
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
        let mut placer = self.drawn(on_paper, stated.min(size * ERROR_SHARE), ink)?;
        if placer.sketch.paths.is_empty() && placer.sketch.texts.is_empty() {
            return Err(PlanFileError::Dxf { why: self.emptiness(&placer) });
        }
        placer.sketch.metres_per_unit = unit.map(|(_, metres)| metres);
        placer.sketch.notes = self.notes(&placer, on_paper);
        Ok(placer.sketch)
    }

    fn drawn(&self, on_paper: bool, error: f64, ink: usize) -> Result<Placer<'_>, PlanFileError> {
        let mut placer = Placer::new(self, error, ink);
        let sheet = Frame { place: Affine::IDENTITY, layer: None, colour: [0; 3], dashed: false, names: String::new() };
        for object in self.objects.iter().filter(|object| object.on_paper == on_paper) {
            placer.object(object, &sheet)?;
        }
        Ok(placer)
    }

    /// Why nothing is drawn.
    fn emptiness(&self, placer: &Placer) -> String {
        let notes = self.notes(placer, false);
        let details = notes.get(1..).unwrap_or_default().join("; ");
        format!("none of its {} objects is a line, an area or a text that is shown ({details})", self.objects.len())
    }

    fn notes(&self, placer: &Placer, on_paper: bool) -> Vec<String> {
        let [paths, texts] = [placer.sketch.paths.len(), placer.sketch.texts.len()];
        let mut notes = vec![format!("a CAD drawing: {paths} lines and areas and {texts} texts of {} objects", self.objects.len())];
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} {what}"));
            }
        };
        let papers = self.objects.iter().filter(|object| object.on_paper).count();
        note(if on_paper { 0 } else { papers }, "objects on sheets of paper are left out");
        note(
            placer.on_hidden_layers.values().sum(),
            &format!("objects on layers that are off or frozen are left out: {}", placer.hidden_layers()),
        );
        note(self.lost.hidden, "objects are marked as not seen and left out");
        note(self.lost.broken, "objects are broken and left out");
        note(placer.not_finite, "lines or texts are infinitely far off and left out");
        note(placer.missing, "insertions are of blocks that are not in the file: bind external references, then save it again");
        note(placer.endless, "insertions of blocks into themselves, or too deep in others, are left out");
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

#[cfg(test)]
mod tests;
