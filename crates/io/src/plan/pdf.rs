//! What is drawn on a page of a PDF? Lines, fillings and texts as a sketch, or one scanned picture.
//!
//! page ─▶ hayro: content streams, forms, colours, fonts ─▶ [`Recorder`] ─▶ [`Sketch`], or few lines over a picture ─▶ pixels
//!
//! Units are points (1/72 inch of paper), x right, y up, the origin at the bottom-left of the crop box as the page is shown: its
//! rotation is applied. Layers are optional content groups; those that are switched off are left out.
//! Pitfalls: the paper's size is no plan's; only a measuring viewport (`VP`, `Measure`) tells metres. Letters come one by one and
//! where the font says what they are. Patterns and shadings count as grey, soft masks as opaque; a group that is named on a form
//! instead of in the content hides it, but does not name it.

mod paint;
mod picture;
mod record;
mod words;

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::time::{Duration, Instant};

use hayro_interpret::hayro_syntax::page::Page;
use hayro_interpret::hayro_syntax::{DecryptionError, LoadPdfError, Pdf};
use hayro_interpret::kurbo::{Affine, Point, Rect};
use hayro_interpret::{Context, Device, InterpreterCache, InterpreterSettings, Paint, TransformExt, interpret_page};
use planwalk_types::GrayImage;

use super::PlanFileError;
use super::bounds::Bounds;
use super::sketch::{Sketch, SketchPoint, SketchText};
use paint::Painter;
use record::Recorder;
use words::metres_per_point;

/// All pages have this much time: drawings of a million lines take a few seconds. What is drawn is counted and bounded without a clock
/// (points, letters, forms, pixels); but hayro calls back for what is drawn only, so operators that draw nothing in forms that are
/// drawn often cannot be counted. The clock, asked at each thing drawn, ends these. It only ever refuses: what is read never hangs on it.
const LONGEST: Duration = Duration::from_secs(120);
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
    let Recorder { mut drafter, pictures, .. } = recorder;
    let covered: f64 = pictures.iter().map(|picture| picture.share).sum();
    let lines = drafter.sketch.paths.len();
    let straight = drafter.sketch.paths.iter().filter(|path| !path.curved).count();
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
        return Ok(Some(PdfPage::Scan { luma, page_pt: sheet.size_pt, texts: drafter.sketch.texts, notes }));
    }
    if lines == 0 {
        return Ok(None);
    }
    let mut note = |count: usize, what: &str| {
        if count > 0 {
            drafter.sketch.notes.push(format!("{count} {what}"));
        }
    };
    note(pictures.len(), "bitmaps in the PDF are not read");
    note(drafter.broken, "paths with coordinates that are no numbers are left out");
    drafter.sketch.metres_per_unit = metres_per_point(page.raw()).map(|metres| metres / sheet.user_unit);
    Ok(Some(PdfPage::Drawing(drafter.sketch)))
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

fn sketch_point(point: Point) -> SketchPoint {
    [point.x, point.y]
}

fn stop(why: PlanFileError) {
    resume_unwind(Box::new(Stop(why)));
}

fn check_clock(until: Instant) {
    if Instant::now() > until {
        stop(refused(&format!("its page takes more than {} s: leave layers away, or print it into a new PDF", LONGEST.as_secs())));
    }
}

#[cfg(test)]
mod tests;
