//! What is drawn on a page of a PDF? Lines, fillings and texts as a sketch, or one scanned picture.
//!
//! page ─▶ hayro: content streams, forms, colours, fonts ─▶ [`Recorder`] ─▶ [`Sketch`], or few lines over a picture ─▶ pixels
//!
//! Units are points (1/72 inch of paper), x right, y up, the origin at the bottom-left of the crop box as the page is shown: its
//! rotation is applied. Layers are optional content groups; those that are switched off are left out.
//! Pitfalls: the paper's size is no plan's; only a measuring viewport (`VP`, `Measure`) tells metres. Letters come one by one and
//! where the font says what they are. Patterns and shadings count as grey, soft masks as opaque; a group that is named on a form
//! instead of in the content hides it, but does not name it.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::time::{Duration, Instant};

use hayro_interpret::font::GlyphRun;
use hayro_interpret::hayro_cmap::BfString;
use hayro_interpret::hayro_syntax::object::{Array, Dict, Object, Stream, String as PdfString};
use hayro_interpret::hayro_syntax::page::Page;
use hayro_interpret::hayro_syntax::{DecryptionError, LoadPdfError, Pdf};
use hayro_interpret::kurbo::{Affine, BezPath, PathEl, Point, Rect};
use hayro_interpret::{
    BlendMode, ClipPath, Context, Device, DrawMode, DrawProps, Image, ImageData, ImageDrawProps, InterpreterCache, InterpreterSettings,
    Paint, SoftMask, TransformExt, interpret_page,
};
use planwalk_types::GrayImage;

use super::PlanFileError;
use super::pen::{self, Bounds, FAINTEST, Look, Pen, Piece, Step};
use super::sketch::{Sketch, SketchPoint, SketchText};
use crate::raster::{RasterError, SizeLimit};

/// A page has this much time: drawings of a million lines take a few seconds. The clock is asked at each thing drawn.
const LONGEST: Duration = Duration::from_secs(120);
/// Most clips, groups and forms of a page: drawings have one a line at worst. Forms that draw forms grow without bound.
const MOST_FORMS: usize = 500_000;
/// Longest content of a page when unpacked, bytes: some ten million lines.
const LONGEST_CONTENT: usize = 256 << 20;
/// Longest that one packed stream may become, bytes: a scan of [`SizeLimit::PLAN`] in colour.
const LONGEST_STREAM: u64 = 1536 << 20;
/// What deflate makes of one byte at most.
const DEFLATE_GAIN: u64 = 1032;
/// Share of the page that pictures cover at least where it is a scan.
const SCANNED: f64 = 0.3;
/// A scan has fewer straight lines and areas over it: a frame, a stamp. A thousand dots of a route make no plan either, and are round.
const STRAIGHT_OVER_SCAN: usize = 100;
/// Most pixels that all pictures of a scan paint: a page in strips paints each once.
const MOST_PAINTED: f64 = 2e9;
/// Most pixels of the paper for each of the pictures on it: those of a scan cover at least [`SCANNED`] of it.
const MOST_PAPER: f64 = 4.0;
/// Pixels that any paper may have.
const FEWEST_PAPER: f64 = 4e6;
/// Font sizes in a unit of a glyph.
const GLYPH_UNITS: f64 = 1000.0;
/// Grey that stands for patterns and shadings.
const GREY: [u8; 3] = [128; 3];

/// A page as it can be used.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PdfPage {
    /// Lines and fillings.
    Drawing(Sketch),
    /// One picture, or several that make one.
    Scan {
        /// The page as it is shown, white where no picture is; row 0 on top.
        luma: GrayImage,
        /// Width and height of it, points of 1/72 inch.
        page_pt: [f64; 2],
        /// Texts over it, e.g. of character recognition; points from the bottom left.
        texts: Vec<SketchText>,
        /// What a person should know.
        notes: Vec<String>,
    },
}

/// Reads a page, counted from 1; without a number the first on which there is anything.
///
/// # Errors
/// [`PlanFileError::Pdf`] for what is no PDF, locked, or too much, [`PlanFileError::NoPage`],
/// [`PlanFileError::DrawingTooIntricate`], [`PlanFileError::NothingDrawn`], and [`PlanFileError::Raster`] for too large a scan.
pub(super) fn read(bytes: Vec<u8>, page: Option<usize>) -> Result<PdfPage, PlanFileError> {
    let until = Instant::now() + LONGEST;
    check_streams(&bytes)?;
    let pdf = Pdf::new(bytes).map_err(|why| match why {
        LoadPdfError::Decryption(DecryptionError::PasswordProtected) => {
            refused("it is locked by a password: open it with the password and print it into a new PDF")
        }
        LoadPdfError::Decryption(_) => refused("it is locked in a way that is not known here: print it into a new PDF"),
        LoadPdfError::Invalid => refused("it is damaged, cut off or no PDF: open it in a viewer and print it into a new PDF"),
    })?;
    let pages = pdf.pages().len();
    let numbers = match page {
        Some(page) if page == 0 || page > pages => return Err(PlanFileError::NoPage { page, pages }),
        Some(page) => page..=page,
        None => 1..=pages,
    };
    for number in numbers {
        let Some(sheet) = pdf.pages().get(number - 1) else { continue };
        let Some(mut found) = read_page(&pdf, sheet, until)? else { continue };
        if pages > 1 {
            let how = if page.is_some() { "" } else { ", the first with anything drawn on it" };
            found.notes_mut().push(format!("page {number} of {pages}{how}"));
        }
        return Ok(found);
    }
    let what = page.map_or_else(|| format!("none of its {pages} pages has"), |page| format!("page {page} of {pages} does not have"));
    Err(PlanFileError::NothingDrawn { format: "PDF", why: format!("{what} a line or a picture") })
}

impl PdfPage {
    fn notes_mut(&mut self) -> &mut Vec<String> {
        match self {
            Self::Drawing(sketch) => &mut sketch.notes,
            Self::Scan { notes, .. } => notes,
        }
    }
}

fn refused(why: &str) -> PlanFileError {
    PlanFileError::Pdf { why: why.to_owned() }
}

/// A stop that is thrown through the interpreter.
struct Stop(PlanFileError);

/// Interprets until the end or a [`Stop`]: hayro cannot be told to stop, and a form that draws ten forms that draw ten forms would
/// never end, so its device throws. That is no panic and prints nothing. (400,000 damaged files made hayro itself never panic; should
/// it do so, the file is refused as well.) A build that aborts on panics would end here.
fn until_stop(work: impl FnOnce()) -> Result<(), PlanFileError> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|thrown: Box<dyn Any + Send>| match thrown.downcast::<Stop>() {
        Ok(stop) => stop.0,
        Err(_) => refused("its reader fails on what is in it: print it into a new PDF"),
    })
}

/// Streams are unpacked by hayro in one go: those that could become too long are tried before.
fn check_streams(bytes: &[u8]) -> Result<(), PlanFileError> {
    const BEGIN: &[u8] = b"stream";
    let mut rest = bytes;
    while let Some(at) = rest.windows(BEGIN.len()).position(|w| w == BEGIN) {
        rest = rest.get(at + BEGIN.len()..).unwrap_or_default();
        let data = rest.strip_prefix(b"\r").unwrap_or(rest);
        let data = data.strip_prefix(b"\n").unwrap_or(data);
        if data.len() as u64 * DEFLATE_GAIN <= LONGEST_STREAM {
            break;
        }
        let end = data.windows(BEGIN.len() + 3).position(|w| w == b"endstream").unwrap_or(data.len());
        let (data, tail) = data.split_at(end);
        rest = tail.get(3 + BEGIN.len()..).unwrap_or_default();
        if data.len() as u64 * DEFLATE_GAIN > LONGEST_STREAM {
            let mut unpacked = std::io::Read::take(flate2::read::ZlibDecoder::new(data), LONGEST_STREAM + 1);
            // What is not deflated ends at once.
            let length = std::io::copy(&mut unpacked, &mut std::io::sink()).unwrap_or(0);
            if length > LONGEST_STREAM {
                return Err(refused(&format!("one of its streams is over {} MB when unpacked", LONGEST_STREAM >> 20)));
            }
        }
    }
    Ok(())
}

/// What is on a page; `None` where nothing is.
fn read_page<'a>(pdf: &'a Pdf, page: &Page<'a>, until: Instant) -> Result<Option<PdfPage>, PlanFileError> {
    let content = page.page_stream().map_or(0, <[u8]>::len);
    if content > LONGEST_CONTENT {
        let (length, limit) = (content >> 20, LONGEST_CONTENT >> 20);
        return Err(refused(&format!("its page's content is {length} MB, over {limit} MB: leave layers away, or simplify it")));
    }
    let sheet = Sheet::of(page);
    let mut recorder = Recorder::new(sheet, until);
    sheet.interpret(pdf, page, &mut recorder)?;
    let Recorder { mut pen, pictures, .. } = recorder;
    let covered: f64 = pictures.iter().map(|picture| picture.share).sum();
    let lines = pen.sketch.paths.len();
    let straight = pen.sketch.paths.iter().filter(|path| !path.curved).count();
    let scanned = !pictures.is_empty() && (lines == 0 || (straight < STRAIGHT_OVER_SCAN && covered >= SCANNED));
    if scanned {
        let largest = pictures.iter().max_by(|a, b| a.share.total_cmp(&b.share));
        let pixels: f64 = pictures.iter().map(|picture| picture.pixels).sum();
        let mut painter = Painter::new(sheet, largest.map_or(1.0, |picture| picture.pixel_pt), pixels, until)?;
        sheet.interpret(pdf, page, &mut painter)?;
        let luma = GrayImage::new(painter.width, painter.height, painter.luma).ok_or_else(|| refused("its page is empty"))?;
        let [width, height] = sheet.size_pt;
        let mut notes = vec![format!("the page is a scan: {} × {} px on {width:.0} × {height:.0} pt", luma.width(), luma.height())];
        if lines > 0 {
            notes.push(format!("{lines} lines and areas over the scan are not read"));
        }
        return Ok(Some(PdfPage::Scan { luma, page_pt: sheet.size_pt, texts: pen.sketch.texts, notes }));
    }
    if lines == 0 {
        return Ok(None);
    }
    let mut note = |count: usize, what: &str| {
        if count > 0 {
            pen.sketch.notes.push(format!("{count} {what}"));
        }
    };
    note(pictures.len(), "bitmaps in the PDF are not read");
    note(pen.broken, "paths with coordinates that are no numbers are left out");
    pen.sketch.metres_per_unit = metres_per_point(page.raw()).map(|metres| metres / sheet.user_unit);
    Ok(Some(PdfPage::Drawing(pen.sketch)))
}

/// The paper.
#[derive(Debug, Clone, Copy)]
struct Sheet {
    /// As it is shown.
    size_pt: [f64; 2],
    /// Points in one unit of the page: drawings over 5 m wide have more than 1.
    user_unit: f64,
    sheet_from_page: Affine,
}

impl Sheet {
    fn of(page: &Page) -> Self {
        let unit = page.raw().get::<f64>(b"UserUnit").filter(|unit| (1e-3..1e5).contains(unit)).unwrap_or(1.0);
        let (width, height) = page.render_dimensions();
        let sheet_from_page = Affine::scale(unit) * page.initial_transform(false).to_kurbo();
        Self { size_pt: [f64::from(width) * unit, f64::from(height) * unit], user_unit: unit, sheet_from_page }
    }

    fn bounds(&self) -> Bounds {
        Bounds { low: [0.0; 2], high: self.size_pt }
    }

    fn interpret<'a>(&self, pdf: &'a Pdf, page: &Page<'a>, device: &mut impl Device<'a>) -> Result<(), PlanFileError> {
        let shown = Rect::new(0.0, 0.0, self.size_pt[0], self.size_pt[1]);
        until_stop(|| {
            let cache = InterpreterCache::new();
            let mut context = Context::new(self.sheet_from_page, shown, &cache, pdf.xref(), InterpreterSettings::default());
            interpret_page(page, &mut context, device);
        })
    }
}

/// Metres in a point, where all measuring viewports of the page say the same (ISO 32000-1, 12.9: rectilinear measures).
fn metres_per_point(page: &Dict) -> Option<f64> {
    let viewports = page.get::<Array>(b"VP")?;
    let mut scales = viewports.iter::<Dict>().filter_map(|viewport| {
        let measure = viewport.get::<Dict>(b"Measure")?;
        let along_x = measure.get::<Array>(b"X")?.iter::<Dict>().next()?;
        let metres = match text_of(&along_x.get::<PdfString>(b"U")?).trim() {
            "mm" => 1e-3,
            "cm" => 1e-2,
            "m" => 1.0,
            "km" => 1e3,
            "in" | "\"" => 0.0254,
            "ft" | "'" => 0.3048,
            "yd" => 0.9144,
            _ => return None,
        };
        along_x.get::<f64>(b"C").map(|per_point| per_point * metres).filter(|scale| *scale > 0.0 && scale.is_finite())
    });
    let first = scales.next()?;
    // Viewports of one scale differ by what was rounded.
    scales.all(|scale| (scale / first - 1.0).abs() < 1e-3).then_some(first)
}

/// Text of a name or a unit: UTF-16 with its mark, else what is taken as UTF-8.
fn text_of(bytes: &[u8]) -> String {
    match bytes.strip_prefix(b"\xfe\xff") {
        Some(wide) => {
            let units = wide.chunks_exact(2).map(|pair| pair.iter().fold(0, |unit, byte| (unit << 8) | u16::from(*byte)));
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
        }
        None => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// Names of a content group, or of the groups of a membership.
fn group_names(properties: &Dict) -> Vec<String> {
    let name = |group: &Dict| group.get::<PdfString>(b"Name").map(|name| text_of(&name));
    match properties.get::<Object>(b"OCGs") {
        Some(Object::Dict(group)) => name(&group).into_iter().collect(),
        Some(Object::Array(groups)) => groups.iter::<Dict>().filter_map(|group| name(&group)).take(8).collect(),
        _ => name(properties).into_iter().collect(),
    }
}

/// Colour, and how opaque it is.
fn colour(paint: &Paint) -> ([u8; 3], f64) {
    match paint {
        Paint::Color(colour) => {
            let [r, g, b, alpha] = colour.to_rgba().to_rgba8();
            ([r, g, b], f64::from(alpha) / 255.0)
        }
        Paint::Pattern(_) => (GREY, 1.0),
    }
}

/// Brightness (ITU-R BT.601).
fn luma([r, g, b]: [u8; 3]) -> u8 {
    ((299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) + 500) / 1000) as u8
}

fn sketch_point(point: Point) -> SketchPoint {
    [point.x, point.y]
}

/// A picture on the page.
struct Picture {
    /// Share of the page that its box covers.
    share: f64,
    /// Its pixel's shorter side, points.
    pixel_pt: f64,
    /// How many it has.
    pixels: f64,
}

/// Writes down what a page draws.
struct Recorder {
    sheet: Sheet,
    pen: Pen,
    pictures: Vec<Picture>,
    clips: Vec<Bounds>,
    opacities: Vec<f64>,
    /// Layer of each open mark; `None` for marks that are no groups.
    layers: Vec<Option<String>>,
    forms: usize,
    until: Instant,
}

impl Recorder {
    fn new(sheet: Sheet, until: Instant) -> Self {
        Self {
            sheet,
            pen: Pen::new(sheet.size_pt[0].max(sheet.size_pt[1])),
            pictures: Vec::new(),
            clips: Vec::new(),
            opacities: Vec::new(),
            layers: Vec::new(),
            forms: 0,
            until,
        }
    }

    fn clip(&self) -> Bounds {
        self.clips.last().copied().unwrap_or_else(|| self.sheet.bounds())
    }

    fn layer(&self) -> &str {
        self.layers.iter().rev().find_map(Option::as_deref).unwrap_or_default()
    }

    fn spend_form(&mut self) {
        self.forms += 1;
        if self.forms > MOST_FORMS {
            stop(refused(&format!(
                "its page has more than {MOST_FORMS} forms, groups and clips: does one draw itself? Print it into a new PDF"
            )));
        }
        check_clock(self.until);
    }
}

fn stop(why: PlanFileError) {
    resume_unwind(Box::new(Stop(why)));
}

fn check_clock(until: Instant) {
    if Instant::now() > until {
        stop(refused(&format!("its page takes more than {} s: leave layers away, or print it into a new PDF", LONGEST.as_secs())));
    }
}

impl<'a> Device<'a> for Recorder {
    fn draw_path(&mut self, path: &BezPath, props: DrawProps<'a>, draw_mode: &DrawMode) {
        check_clock(self.until);
        let opacity = self.opacities.last().copied().unwrap_or(1.0);
        let (colour, own) = colour(&props.paint);
        let (filled, line) = match draw_mode {
            DrawMode::Fill(_) => (true, None),
            DrawMode::Stroke(line) => (false, Some(line)),
            DrawMode::FillAndStroke(_, line) => (true, Some(line)),
            DrawMode::Invisible => (false, None),
        };
        if opacity * own < FAINTEST || (!filled && line.is_none()) {
            return;
        }
        let look = Look {
            fill: filled.then_some(colour),
            stroke: line.map(|_| colour),
            width: line.map_or(0.0, |line| f64::from(line.line_width) * props.transform.determinant().abs().sqrt()),
            dashed: line.is_some_and(|line| !line.dash_array.is_empty()),
            layer: self.layer().to_owned(),
        };
        let at = |point: Point| sketch_point(props.transform * point);
        let steps = path.elements().iter().map(|element| match *element {
            PathEl::MoveTo(p) => Step::Move(at(p)),
            PathEl::LineTo(p) => Step::Line(at(p)),
            PathEl::QuadTo(a, p) => Step::Quadratic(at(a), at(p)),
            PathEl::CurveTo(a, b, p) => Step::Cubic(at(a), at(b), at(p)),
            PathEl::ClosePath => Step::Close,
        });
        let clip = self.clip();
        if let Err(why) = self.pen.draw(steps, clip, &look) {
            stop(why);
        }
    }

    fn push_clip_path(&mut self, clip_path: &ClipPath) {
        self.spend_form();
        let points = clip_path.path.elements().iter().flat_map(|element| match *element {
            PathEl::MoveTo(p) | PathEl::LineTo(p) => vec![p],
            PathEl::QuadTo(a, p) => vec![a, p],
            PathEl::CurveTo(a, b, p) => vec![a, b, p],
            PathEl::ClosePath => Vec::new(),
        });
        let points: Vec<SketchPoint> = points.map(sketch_point).collect();
        let clip = self.clip();
        self.clips.push(Bounds::of(&points).map_or(clip, |bounds| clip.both(bounds)));
    }

    fn pop_clip(&mut self) {
        self.clips.pop();
    }

    fn push_transparency_group(&mut self, opacity: f32, _: Option<SoftMask<'a>>, _: BlendMode) {
        self.spend_form();
        let outer = self.opacities.last().copied().unwrap_or(1.0);
        self.opacities.push(outer * f64::from(opacity));
    }

    fn pop_transparency_group(&mut self) {
        self.opacities.pop();
    }

    fn draw_glyph_run(&mut self, glyph_run: &GlyphRun<'_, 'a>, props: DrawProps<'a>, _: &DrawMode) {
        check_clock(self.until);
        for glyph in glyph_run.glyphs() {
            let text = match glyph.as_unicode() {
                Some(BfString::Char(c)) => c.to_string(),
                Some(BfString::String(text)) => text,
                None => continue,
            };
            let placed = props.transform * glyph.transform();
            let (at, on) = (sketch_point(placed * Point::ZERO), sketch_point(placed * Point::new(GLYPH_UNITS, 0.0)));
            let width = match &**glyph {
                hayro_interpret::font::Glyph::Outline(glyph) => glyph.advance_width(),
                hayro_interpret::font::Glyph::Type3(glyph) => glyph.advance_width(),
            };
            let piece = Piece {
                at,
                em: [0, 1].map(|k| on[k] - at[k]),
                width_em: f64::from(width.unwrap_or(0.5 * GLYPH_UNITS as f32)) / GLYPH_UNITS,
                text: text.chars().filter(|c| !c.is_control()).collect(),
                layer: self.layer().to_owned(),
            };
            let written = if self.sheet.bounds().holds(at) { self.pen.write(piece) } else { Ok(()) };
            if let Err(why) = written {
                stop(why);
            }
        }
    }

    fn draw_image(&mut self, image: Image<'a, '_>, props: ImageDrawProps<'a>) {
        let frame = Affine::scale_non_uniform(f64::from(image.width()), f64::from(image.height()));
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|p| sketch_point(props.transform * frame * Point::from(p)));
        let Some(bounds) = Bounds::of(&corners) else { return };
        let [width, height] = self.clip().both(bounds).size().map(|side| side.max(0.0));
        let [a, b, c, d, ..] = props.transform.as_coeffs();
        let pixel_pt = a.hypot(b).min(c.hypot(d));
        let share = width * height / (self.sheet.size_pt[0] * self.sheet.size_pt[1]);
        if share > 0.0 && pixel_pt > 0.0 {
            let pixels = f64::from(image.width()) * f64::from(image.height());
            self.pictures.push(Picture { share, pixel_pt, pixels });
        }
    }

    fn begin_marked_content(&mut self, tag: &[u8], properties: Option<&Dict<'_>>) {
        let names = properties.filter(|_| tag == b"OC").map(group_names).unwrap_or_default();
        let layer = (!names.is_empty()).then(|| pen::layer_within(self.layer(), names.iter().map(String::as_str)));
        self.spend_form();
        self.layers.push(layer);
    }

    fn end_marked_content(&mut self) {
        self.layers.pop();
    }
}

/// Paints the pictures of a page onto one.
struct Painter {
    sheet: Sheet,
    luma: Vec<u8>,
    width: usize,
    height: usize,
    painted: f64,
    until: Instant,
}

impl Painter {
    /// White paper with pixels of this size, or larger where the pictures have few: one that is squeezed flat, or a mere stamp, would
    /// ask for millions of pixels that say nothing.
    fn new(sheet: Sheet, pixel_pt: f64, pixels: f64, until: Instant) -> Result<Self, PlanFileError> {
        let most = (MOST_PAPER * pixels).max(FEWEST_PAPER);
        let finest_pt = (sheet.size_pt[0] * sheet.size_pt[1] / most).sqrt();
        let [width, height] = sheet.size_pt.map(|side| (side / pixel_pt.max(finest_pt)).round().max(1.0));
        check_size(width as u32, height as u32)?;
        let (width, height) = (width as usize, height as usize);
        Ok(Self { sheet, luma: vec![255; width * height], width, height, painted: 0.0, until })
    }

    /// Puts the picture's pixels where it lies: `value` has brightness and opacity of its column and row.
    fn paint(&mut self, columns: u32, rows: u32, sheet_from_picture: Affine, value: impl Fn(usize) -> (u8, u8)) {
        let scale = Affine::scale_non_uniform(self.width as f64 / self.sheet.size_pt[0], -(self.height as f64) / self.sheet.size_pt[1]);
        let canvas_from_picture = Affine::translate((0.0, self.height as f64)) * scale * sheet_from_picture;
        let (columns, rows) = (columns as usize, rows as usize);
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(|(u, v)| sketch_point(canvas_from_picture * Point::new(u * columns as f64, v * rows as f64)));
        let Some(bounds) = Bounds::of(&corners).filter(|_| canvas_from_picture.determinant().abs() > 1e-12) else { return };
        let canvas = Bounds { low: [0.0; 2], high: [self.width as f64, self.height as f64] };
        let part = canvas.both(bounds);
        let [from, to] = [part.low.map(|v| v.floor() as usize), part.high.map(|v| v.ceil().max(0.0) as usize)];
        self.painted += part.size()[0].max(0.0) * part.size()[1].max(0.0);
        if self.painted > MOST_PAINTED {
            stop(refused(&format!("its pictures lie over each other and have more than {MOST_PAINTED:e} pixels: print it as one picture")));
        }
        let picture_from_canvas = canvas_from_picture.inverse();
        for v in from[1]..to[1] {
            for u in from[0]..to[0] {
                let at = picture_from_canvas * Point::new(u as f64 + 0.5, v as f64 + 0.5);
                let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < columns as f64 && at.y < rows as f64;
                if let Some(below) = self.luma.get_mut(v * self.width + u).filter(|_| inside) {
                    let (bright, opaque) = value(at.y as usize * columns + at.x as usize);
                    let (bright, opaque) = (u32::from(bright), u32::from(opaque));
                    *below = ((bright * opaque + u32::from(*below) * (255 - opaque) + 127) / 255) as u8;
                }
            }
        }
    }
}

/// As of pictures in files.
fn check_size(width: u32, height: u32) -> Result<(), PlanFileError> {
    let SizeLimit { side, megapixels } = SizeLimit::PLAN;
    if width.max(height) > side || u64::from(width) * u64::from(height) > megapixels * 1_000_000 {
        return Err(RasterError::TooLarge { width, height, limit_side: side, limit_megapixels: megapixels }.into());
    }
    Ok(())
}

/// Whether what a picture says of its size, wherever it does, may be believed: its memory is taken before its pixels are read.
fn check_picture(picture: &Stream) -> Result<(), PlanFileError> {
    let number = |dict: &Dict, name: &[u8], short: &[u8]| {
        let stated = dict.get::<usize>(name).or_else(|| dict.get::<usize>(short)).unwrap_or(0);
        u32::try_from(stated).unwrap_or(u32::MAX)
    };
    let stated = |dict: &Dict| (number(dict, b"Width", b"W"), number(dict, b"Height", b"H"));
    let dict = picture.dict();
    let mut sizes = vec![stated(dict)];
    for mask in [b"SMask".as_slice(), b"Mask"] {
        sizes.extend(dict.get::<Stream>(mask).map(|mask| stated(mask.dict())));
    }
    // Fax.
    let fax = |parameters: &Dict| (number(parameters, b"Columns", b"Columns"), number(parameters, b"Rows", b"Rows").max(stated(dict).1));
    match dict.get::<Object>(b"DecodeParms").or_else(|| dict.get::<Object>(b"DP")) {
        Some(Object::Dict(parameters)) => sizes.push(fax(&parameters)),
        Some(Object::Array(filters)) => sizes.extend(filters.iter::<Object>().filter_map(Object::into_dict).map(|dict| fax(&dict))),
        _ => {}
    }
    sizes.extend(size_in_jpeg(&picture.raw_data()));
    sizes.into_iter().try_for_each(|(width, height)| check_size(width, height))
}

/// Size that a JPEG or JPEG 2000 has in its own header.
fn size_in_jpeg(data: &[u8]) -> Option<(u32, u32)> {
    let number = |at: usize, length: usize| Some(data.get(at..at + length)?.iter().fold(0, |n, byte| (n << 8) | u32::from(*byte)));
    if let Some(at) = data.get(..1024.min(data.len()))?.windows(4).position(|w| w == [0xff, 0x4f, 0xff, 0x51]) {
        return Some((number(at + 8, 4)?, number(at + 12, 4)?));
    }
    let mut at = data.starts_with(&[0xff, 0xd8]).then_some(2)?;
    loop {
        let marker = number(at, 2)?;
        match marker {
            0xffc4 | 0xffc8 | 0xffcc => {}
            0xffc0..=0xffcf => return Some((number(at + 7, 2)?, number(at + 5, 2)?)),
            0xff00..=0xffff => {}
            _ => return None,
        }
        at += 2 + number(at + 2, 2)? as usize;
    }
}

impl<'a> Device<'a> for Painter {
    fn draw_path(&mut self, _: &BezPath, _: DrawProps<'a>, _: &DrawMode) {}
    // Whoever is here has passed the recorder's limits: only pictures are new work.
    fn push_clip_path(&mut self, _: &ClipPath) {}
    fn pop_clip(&mut self) {}
    fn push_transparency_group(&mut self, _: f32, _: Option<SoftMask<'a>>, _: BlendMode) {}
    fn pop_transparency_group(&mut self) {}
    fn draw_glyph_run(&mut self, _: &GlyphRun<'_, 'a>, _: DrawProps<'a>, _: &DrawMode) {}

    fn draw_image(&mut self, image: Image<'a, '_>, props: ImageDrawProps<'a>) {
        check_clock(self.until);
        let stream = match &image {
            Image::Stencil(stencil) => stencil.stream(),
            Image::Raster(raster) => raster.stream(),
        };
        if let Err(why) = check_picture(stream) {
            stop(why);
        }
        // A picture may hold fewer pixels than it says.
        let scaled = |(x, y): (f32, f32)| props.transform * Affine::scale_non_uniform(f64::from(x), f64::from(y));
        match image {
            Image::Stencil(stencil) => stencil.with_stencil(
                |mask, paint| {
                    let (colour, opacity) = colour(paint);
                    let bright = luma(colour);
                    self.paint(mask.width, mask.height, scaled(mask.scale_factors), |i| {
                        (bright, (f64::from(mask.data.get(i).copied().unwrap_or(0)) * opacity) as u8)
                    });
                },
                None,
            ),
            Image::Raster(raster) => raster.with_rgba(
                |data, alpha| {
                    let same = |a: &hayro_interpret::LumaData| (a.width, a.height) == (data.width(), data.height());
                    let alpha = alpha.filter(same);
                    let opaque = |i: usize| alpha.as_ref().map_or(255, |alpha| alpha.data.get(i).copied().unwrap_or(255));
                    let transform = scaled(data.scale_factors());
                    match &data {
                        ImageData::Luma(grey) => {
                            self.paint(grey.width, grey.height, transform, |i| (grey.data.get(i).copied().unwrap_or(255), opaque(i)))
                        }
                        ImageData::Rgb(rgb) => self.paint(rgb.width, rgb.height, transform, |i| {
                            let pixel = rgb.data.get(3 * i..3 * i + 3).and_then(|p| <[u8; 3]>::try_from(p).ok());
                            (pixel.map_or(255, luma), opaque(i))
                        }),
                    }
                },
                None,
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;

    /// A file of these objects, numbered from 1: the first is the catalogue, the second the pages.
    fn pdf(objects: &[Vec<u8>]) -> Vec<u8> {
        let mut file = b"%PDF-1.7\n".to_vec();
        let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
        for (number, object) in (1..).zip(objects) {
            let _ = writeln!(table, "{:010} 00000 n ", file.len());
            file.extend(format!("{number} 0 obj\n").bytes());
            file.extend(object);
            file.extend(b"\nendobj\n");
        }
        let start = file.len();
        file.extend(table.bytes());
        file.extend(format!("trailer\n<</Size {}/Root 1 0 R>>\nstartxref\n{start}\n%%EOF\n", objects.len() + 1).bytes());
        file
    }

    fn stream(head: &str, data: &[u8]) -> Vec<u8> {
        [format!("<<{head}/Length {}>>\nstream\n", data.len()).as_bytes(), data, b"\nendstream"].concat()
    }

    /// Pages of 200 × 100 pt with these contents; `page` goes into their dictionaries, `more` are objects 10, 11 …
    fn pages(contents: &[&str], page: &str, catalogue: &str, more: &[Vec<u8>]) -> Vec<u8> {
        let at = |i: usize| 10 + more.len() + 2 * i;
        let kids: String = (0..contents.len()).map(|i| format!("{} 0 R ", at(i))).collect();
        let mut objects = vec![
            format!("<</Type/Catalog/Pages 2 0 R{catalogue}>>").into_bytes(),
            format!("<</Type/Pages/Kids[{kids}]/Count {}>>", contents.len()).into_bytes(),
        ];
        objects.resize(9, b"null".to_vec());
        objects.extend(more.iter().cloned());
        for (i, content) in contents.iter().enumerate() {
            objects.push(format!("<</Type/Page/Parent 2 0 R/MediaBox[0 0 200 100]/Contents {} 0 R{page}>>", at(i) + 1).into_bytes());
            objects.push(stream("", content.as_bytes()));
        }
        pdf(&objects)
    }

    fn drawing(file: Vec<u8>) -> Sketch {
        match read(file, None).unwrap() {
            PdfPage::Drawing(sketch) => sketch,
            PdfPage::Scan { notes, .. } => panic!("{notes:?}"),
        }
    }

    fn drawn(content: &str) -> Sketch {
        drawing(pages(&[content], "", "", &[]))
    }

    fn error(file: Vec<u8>) -> String {
        read(file, None).unwrap_err().to_string()
    }

    fn near(points: &[SketchPoint], wanted: &[SketchPoint]) -> bool {
        points.len() == wanted.len() && points.iter().zip(wanted).all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9)
    }

    #[test]
    fn lines_and_areas_keep_their_looks() {
        let sketch = drawn(
            "1 0 0 RG 2 w [3] 0 d 10 10 m 90 10 l S q 0.5 0 0 0.5 0 0 cm [] 0 d 0 1 0 rg 20 20 40 60 re B Q 0 0 m 50 0 50 50 0 50 c h f",
        );
        let [line, area, curve] = &sketch.paths[..] else { panic!("{:?}", sketch.paths) };
        assert_eq!(line.points, [[10.0, 10.0], [90.0, 10.0]]);
        assert_eq!((line.stroke, line.width, line.dashed, line.closed, line.fill), (Some([255, 0, 0]), 2.0, true, false, None));
        assert!(near(&area.points, &[[10.0, 10.0], [30.0, 10.0], [30.0, 40.0], [10.0, 40.0]]), "{:?}", area.points);
        assert_eq!(
            (area.stroke, area.width, area.dashed, area.closed, area.fill),
            (Some([255, 0, 0]), 1.0, false, true, Some([0, 255, 0]))
        );
        assert!(curve.curved && curve.closed && curve.fill == Some([0; 3]) && curve.stroke.is_none());
        assert_eq!([line.group, area.group, curve.group], [0, 1, 2]);
        assert_eq!((sketch.metres_per_unit, sketch.notes), (None, Vec::new()));
    }

    #[test]
    fn the_page_is_as_it_is_shown() {
        let line = ["30 20 m 60 20 l S"];
        let points = |page: &str| drawing(pages(&line, page, "", &[])).paths[0].points.clone();
        assert!(near(&points("/CropBox[20 10 120 60]"), &[[10.0, 10.0], [40.0, 10.0]]));
        // Turned clockwise: what was left is on top.
        assert!(near(&points("/Rotate 90"), &[[20.0, 170.0], [20.0, 140.0]]), "{:?}", points("/Rotate 90"));
        assert!(near(&points("/Rotate 180"), &[[170.0, 80.0], [140.0, 80.0]]));
        assert!(near(&points("/Rotate -90"), &[[80.0, 30.0], [80.0, 60.0]]), "{:?}", points("/Rotate -90"));
        assert!(near(&points("/UserUnit 10"), &[[300.0, 200.0], [600.0, 200.0]]));
        // What leaves the crop box is not shown.
        assert!(near(&points("/CropBox[20 10 50 60]"), &[[10.0, 10.0], [30.0, 10.0]]));
    }

    #[test]
    fn clips_cut_and_faint_things_are_hidden() {
        let state = "/Resources<</ExtGState<</G<</CA 0/ca 0>>>>>>";
        let content = "q 10 0 20 100 re W n 0 50 m 100 50 l S 50 50 m 100 50 l S Q /G gs 0 10 m 9 10 l S";
        let sketch = drawing(pages(&[content], state, "", &[]));
        assert_eq!(sketch.paths.len(), 1);
        assert!(near(&sketch.paths[0].points, &[[10.0, 50.0], [30.0, 50.0]]));
    }

    #[test]
    fn content_groups_are_layers_and_those_switched_off_are_left_out() {
        let more =
            [b"<</Type/OCG/Name(A-WALL)>>".to_vec(), b"<</Type/OCG/Name<FEFF0054006f0072>>>".to_vec(), b"<</Type/OCG/Name(Off)>>".to_vec()];
        let page = "/Resources<</Properties<</W 10 0 R/T 11 0 R/O 12 0 R>>>>";
        let catalogue = "/OCProperties<</OCGs[10 0 R 11 0 R 12 0 R]/D<</OFF[12 0 R]>>>>";
        let content =
            "/OC /W BDC 0 0 m 9 0 l S /Span BMC /OC /T BDC 0 1 m 9 1 l S EMC EMC EMC /OC /O BDC 0 2 m 9 2 l S EMC 0 3 m 9 3 l S EMC EMC";
        let sketch = drawing(pages(&[content], page, catalogue, &more));
        let layers: Vec<&str> = sketch.paths.iter().map(|p| p.layer.as_str()).collect();
        assert_eq!(layers, ["A-WALL", "A-WALL/Tor", ""]);
    }

    #[test]
    fn letters_are_texts() {
        let font = "/Resources<</Font<</F<</Type/Font/Subtype/Type1/BaseFont/Helvetica/Encoding/WinAnsiEncoding>>>>>>";
        let content =
            "0 0 m 9 0 l S BT /F 10 Tf 20 30 Td (Scale) Tj ( 1:100) Tj 0 20 Td [(K) -50 (\\374che)] TJ 0 1 -1 0 150 10 Tm (Lift) Tj ET";
        let sketch = drawing(pages(&[content], font, "", &[]));
        let texts: Vec<_> = sketch.texts.iter().map(|t| (t.text.as_str(), t.at)).collect();
        assert_eq!(texts, [("Scale 1:100", [20.0, 30.0]), ("K\u{fc}che", [20.0, 50.0]), ("Lift", [150.0, 10.0])]);
        assert!((sketch.texts[0].height - 7.0).abs() < 1e-6, "{}", sketch.texts[0].height);
    }

    #[test]
    fn only_a_measure_tells_metres() {
        let viewport = |unit: &str, per_point: f64| format!("<</Measure<</Subtype/RL/X[<</U({unit})/C {per_point}>>]>>>>");
        let scale = |viewports: String| drawing(pages(&["0 0 m 9 0 l S"], &format!("/VP[{viewports}]"), "", &[])).metres_per_unit;
        // 1:100: a point is 0.3528 mm of paper.
        assert!((scale(viewport("mm", 35.28)).unwrap() - 0.03528).abs() < 1e-12);
        assert!((scale(viewport("ft", 0.115_75)).unwrap() - 0.035_28).abs() < 1e-5);
        assert_eq!(scale(viewport("mm", 35.28) + &viewport("mm", 70.56)), None);
        assert_eq!(scale(viewport("cubits", 1.0) + &viewport("m", -1.0)), None);
    }

    #[test]
    fn a_page_of_one_picture_is_a_scan() {
        // 4 × 2 pixels, the top left one black, over the left half of the page's middle.
        let picture = stream(
            "/Type/XObject/Subtype/Image/Width 4/Height 2/BitsPerComponent 8/ColorSpace/DeviceGray",
            &[0, 250, 250, 250, 250, 250, 250, 90],
        );
        let resources = "/Resources<</XObject<</P 10 0 R>>/Font<</F<</Type/Font/Subtype/Type1/BaseFont/Helvetica>>>>>>";
        let content = "q 100 0 0 50 0 50 cm /P Do Q 0 0 m 9 0 l S BT /F 8 Tf 50 20 Td (1:50) Tj ET";
        let found = read(pages(&[content], resources, "", std::slice::from_ref(&picture)), None).unwrap();
        // A quarter of the page is too little for a scan, where there is a line too.
        assert!(matches!(found, PdfPage::Drawing(sketch) if sketch.notes == ["1 bitmaps in the PDF are not read"]));
        let content = content.replace("50 cm", "0 cm").replace("100 0 0 50", "200 0 0 100");
        let found = read(pages(&[&content], resources, "", std::slice::from_ref(&picture)), None).unwrap();
        let PdfPage::Scan { luma, page_pt, texts, notes } = found else { panic!("{found:?}") };
        assert_eq!((luma.width(), luma.height(), luma.data(), page_pt), (4, 2, &[0, 250, 250, 250, 250, 250, 250, 90][..], [200.0, 100.0]));
        assert_eq!((texts[0].text.as_str(), notes.len()), ("1:50", 2));
        // Upright where the page is turned.
        let turned = read(pages(&[&content], &format!("{resources}/Rotate 90"), "", &[picture]), None).unwrap();
        let PdfPage::Scan { luma, page_pt, .. } = turned else { panic!("{turned:?}") };
        assert_eq!((luma.width(), luma.height(), luma.data(), page_pt), (2, 4, &[250, 0, 250, 250, 250, 250, 90, 250][..], [100.0, 200.0]));
    }

    #[test]
    fn a_scan_in_strips_and_bits_is_put_together() {
        // One bit a pixel, painted in red where it is 0; two strips of 8 × 1.
        let strip = |bits: u8| stream("/Type/XObject/Subtype/Image/ImageMask true/Width 8/Height 1/BitsPerComponent 1", &[bits]);
        let content = "1 0 0 rg q 200 0 0 50 0 50 cm /A Do Q q 200 0 0 50 0 0 cm /B Do Q";
        let found =
            read(pages(&[content], "/Resources<</XObject<</A 10 0 R/B 11 0 R>>>>", "", &[strip(0b0111_1111), strip(0b1111_1110)]), None)
                .unwrap();
        let PdfPage::Scan { luma, .. } = found else { panic!("{found:?}") };
        assert_eq!((luma.width(), luma.height()), (8, 4));
        let dark: Vec<usize> = (0..32).filter(|i| luma.data()[*i] == 76).collect();
        assert_eq!(dark, [0, 8, 23, 31]);
        assert!(luma.data().iter().all(|v| matches!(v, 76 | 255)));
    }

    #[test]
    fn a_picture_squeezed_flat_makes_no_paper_of_millions() {
        // 8 × 8 px on a thousandth of a point's height: paper of its shorter side would be 50 million times as fine.
        let picture = stream("/Type/XObject/Subtype/Image/Width 8/Height 8/BitsPerComponent 8/ColorSpace/DeviceGray", &[0; 64]);
        let file = pages(&["200 0 0 0.001 0 50 cm /I Do"], "/Resources<</XObject<</I 10 0 R>>>>", "", &[picture]);
        match read(file, None) {
            Ok(PdfPage::Scan { luma, .. }) => assert!(luma.data().len() <= FEWEST_PAPER as usize + 10_000, "{}", luma.data().len()),
            Ok(PdfPage::Drawing(sketch)) => panic!("{:?}", sketch.notes),
            Err(why) => assert!(matches!(why, PlanFileError::NothingDrawn { .. }), "{why}"),
        }
    }

    #[test]
    fn pages_that_lead_in_circles_end() {
        let page = b"<</Type/Page/Parent 2 0 R/MediaBox[0 0 200 100]/Contents 4 0 R>>".to_vec();
        let content = stream("", b"0 0 m 9 0 l S");
        for kids in ["2 0 R", "3 0 R 2 0 R", "5 0 R 3 0 R"] {
            let tree = format!("<</Type/Pages/Parent 2 0 R/Kids[{kids}]/Count 3>>").into_bytes();
            let other = b"<</Type/Pages/Parent 2 0 R/Kids[2 0 R 5 0 R]/Count 2>>".to_vec();
            let read = read(pdf(&[b"<</Type/Catalog/Pages 2 0 R>>".to_vec(), tree, page.clone(), content.clone(), other]), None);
            assert!(read.is_ok() || read.is_err_and(|why| why.to_string().len() > 30), "{kids}");
        }
    }

    #[test]
    fn a_huge_picture_is_refused_before_memory_is_taken() {
        let jpeg = [0xff, 0xd8, 0xff, 0xe0, 0, 4, 0, 0, 0xff, 0xc0, 0, 17, 8, 0xff, 0xff, 0xff, 0xff];
        for (head, data) in [
            ("/Width 90000/Height 90000/BitsPerComponent 1", &b"x"[..]),
            ("/Width 8/Height 9999/BitsPerComponent 1/Filter/CCITTFaxDecode/DecodeParms<</K -1/Columns 99999999999>>", b"x"),
            ("/Width 8/Height 8/BitsPerComponent 8/SMask 11 0 R", b"x"),
            ("/Width 8/Height 8/BitsPerComponent 8/Filter/DCTDecode", &jpeg),
        ] {
            let picture = stream(&format!("/Type/XObject/Subtype/Image/ColorSpace/DeviceGray{head}"), data);
            let mask = stream("/Type/XObject/Subtype/Image/Width 90000/Height 90000", b"x");
            let file = pages(&["200 0 0 100 0 0 cm /P Do"], "/Resources<</XObject<</P 10 0 R>>>>", "", &[picture, mask]);
            assert!(matches!(read(file, None), Err(PlanFileError::Raster(RasterError::TooLarge { .. }))), "{head}");
        }
    }

    #[test]
    fn pages_are_counted_from_one() {
        let file = || pages(&["", "0 0 m 9 0 l S", "0 0 m 9 9 l S"], "", "", &[]);
        let notes = |page| match read(file(), page).unwrap() {
            PdfPage::Drawing(sketch) => sketch.notes,
            PdfPage::Scan { .. } => panic!("a scan"),
        };
        assert_eq!(notes(None), ["page 2 of 3, the first with anything drawn on it"]);
        assert_eq!(notes(Some(3)), ["page 3 of 3"]);
        for page in [0, 4, usize::MAX] {
            assert!(matches!(read(file(), Some(page)), Err(PlanFileError::NoPage { pages: 3, .. })));
        }
        assert!(read(file(), Some(1)).unwrap_err().to_string().contains("page 1 of 3 does not have a line"));
    }

    #[test]
    fn what_is_no_pdf_or_shows_nothing_is_refused_with_a_remedy() {
        for file in [&b""[..], b"%PDF-1.7\n", b"0,0,4,0\n", &[0xff; 5000]] {
            assert!(error(file.to_vec()).contains("print it into a new PDF"), "{}", error(file.to_vec()));
        }
        assert!(error(pages(&["", "BT ET"], "", "", &[])).contains("none of its 2 pages"));
        let whole = pages(&["0 0 m 9 0 l S"], "", "", &[]);
        // Cut off anywhere: an answer or an error, but an end.
        for end in 0..whole.len() {
            let _ = read(whole[..end].to_vec(), None);
        }
    }

    #[test]
    fn locked_files_say_so() {
        let objects = pages(&["0 0 m 9 0 l S"], "", "", &[]);
        let text = String::from_utf8(objects).unwrap();
        let key = "00".repeat(32);
        let lock = format!("/Encrypt<</Filter/Standard/V 2/R 3/Length 128/P -44/O<{key}>/U<{key}>>>/ID[<00><00>]/Root 1 0 R");
        assert!(error(text.replace("/Root 1 0 R", &lock).into_bytes()).contains("locked by a password"));
    }

    #[test]
    fn forms_that_draw_themselves_end() {
        let form = |n: usize, content: &str| {
            let resources = format!("/Resources<</XObject<</N {n} 0 R>>>>");
            stream(&format!("/Type/XObject/Subtype/Form/BBox[0 0 200 100]{resources}"), content.as_bytes())
        };
        let page = "/Resources<</XObject<</N 10 0 R>>>>";
        let own = drawing(pages(&["0 0 m 9 0 l S /N Do"], page, "", &[form(10, "0 1 m 9 1 l S /N Do")]));
        assert!((2..200).contains(&own.paths.len()), "{}", own.paths.len());
        // Ten of ten of ten …
        let bomb: Vec<_> = (0..12).map(|i| form(11 + i, &"/N Do ".repeat(10))).chain([form(9, "")]).collect();
        assert!(error(pages(&["/N Do"], page, "", &bomb)).contains("does one draw itself"));
    }

    #[test]
    fn gigantic_and_broken_content_is_bounded() {
        let zigzag: String = (0..MOST_POINTS_AND_ONE).map(|i| if i == 0 { "0 0 m " } else { "9 9 l 0 0 l " }).collect();
        assert!(error(pages(&[&(zigzag + "S")], "", "", &[])).contains("more than 5000000 points"));
        let nested = format!("{}0 0 m 9 0 l S{}", "q ".repeat(200_000), " Q".repeat(200_000));
        assert_eq!(drawn(&nested).paths.len(), 1);
        let odd = "0 0 m 99999999999999999999999999999999999999999 0 l S 1e999 nan m 5 5 l S /None Do /None gs BT /No 1e38 Tf (x) Tj ET 9 l S Q Q Q EMC 0 0 0 0 0 0 cm 0 0 m 9 9 l S";
        assert!(drawn(&format!("0 0 m 9 0 l S {odd}")).paths.iter().flat_map(|p| &p.points).flatten().all(|v| v.is_finite()));
        let deep = format!("0 0 m 9 0 l S {} TJ", "[".repeat(100_000));
        assert_eq!(drawn(&deep).paths.len(), 1);
    }

    /// One over the pen's limit, two a step.
    const MOST_POINTS_AND_ONE: usize = 2_500_002;

    #[test]
    fn packed_bombs_are_found_before_they_are_unpacked() {
        use std::io::Write;
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        let zeros = vec![b' '; 1 << 24];
        for _ in 0..(LONGEST_STREAM >> 24) + 1 {
            packer.write_all(&zeros).unwrap();
        }
        let packed = packer.finish().unwrap();
        let mut file = pages(&["0 0 m 9 0 l S"], "", "", &[stream("/Filter/FlateDecode", &packed)]);
        file.extend(vec![b' '; 2 << 20]);
        assert!(error(file).contains("over 1536 MB when unpacked"));
    }
}
