//! What sort of plan is this file, and what is one unit of it? Told by the first bytes; names say little.
//!
//! file ─▶ [`Opened`]: a picture's pixels, cells of a robot's map, or a building in metres

use std::io::Read;
use std::path::Path;

use image::DynamicImage;
use planwalk_types::{Building, FloorPlan, Pt2};

use super::cells::Pixels;
use super::native::{PlanDocument, Source};
use super::pdf::PdfPage;
use super::scale::Scale;
use super::sketch::Sketch;
use super::{
    PlanFileError, PlanOptions, astray, audit, drawing, dxf, geojson, imdf, interpret, measure, native, osm, outline, pdf, ros, svg,
    wall_list,
};
use crate::raster::{self, SizeLimit};
use crate::text;

/// Bytes looked at to tell what a file is.
const LOOKED_AT: u64 = 4096;
/// Fewer bytes of a file are not called words: first bytes of a picture may happen to be letters.
const LEAST_WORDS: usize = 8;
/// Largest file of a kind that is read whole before it is looked at, bytes.
const LARGEST: u64 = 512 << 20;
/// Metres of a point, of which PDF has 72 in an inch, and of a pixel, of which SVG has 96.
const POINT_M: f64 = 0.0254 / 72.0;
const SVG_PIXEL_M: f64 = 0.0254 / 96.0;

/// A plan, before it is one storey on a grid.
pub(super) enum Opened {
    /// A bare picture; its origin is the bottom-left corner.
    Picture {
        /// Told apart.
        pixels: Pixels,
        /// Its scale.
        metres_per_pixel: f64,
    },
    /// A robot's map.
    Map(FloorPlan),
    /// Shapes.
    Drawn(Building),
    /// Shapes that were kept, with all that is known of them.
    Kept(Box<PlanDocument>),
}

/// Opens a plan of any format; with notes for people, and where it came from as far as the file says.
pub(super) fn open(path: &Path, options: &PlanOptions, notes: &mut Vec<String>) -> Result<(Opened, Source), PlanFileError> {
    let (opened, source) = by_kind(path, options, notes)?;
    match &opened {
        Opened::Drawn(building) => astray::check(building)?,
        Opened::Kept(document) => astray::check(&document.building)?,
        Opened::Picture { .. } | Opened::Map(_) => {}
    }
    Ok((opened, source))
}

fn by_kind(path: &Path, options: &PlanOptions, notes: &mut Vec<String>) -> Result<(Opened, Source), PlanFileError> {
    let stated = stated_scale(options, notes)?;
    let is_yaml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("yaml") || e.eq_ignore_ascii_case("yml"));
    if stated.is_some() && options.drawing_scale.is_some() {
        return Err(PlanFileError::TwoScales);
    }
    if is_yaml {
        only_level(options)?;
        no_pages(options)?;
        if options.drawing_scale.is_some() {
            return Err(PlanFileError::NotOnPaper);
        }
        let map = ros::read(path, stated)?;
        notes.extend(map.notes);
        return Ok((Opened::Map(map.plan), source("ros map", None, "the map.yaml")));
    }
    let head = head(path)?;
    if head.windows(5).any(|bytes| bytes == b"%PDF-") {
        return of_pdf(path, options, stated, notes);
    }
    no_pages(options)?;
    if imdf::is_one(&head) {
        if stated.is_some() || options.drawing_scale.is_some() {
            return Err(PlanFileError::ScaleNotNeeded);
        }
        return Ok((Opened::Drawn(imdf::read(&bytes(path)?, notes)?), source("imdf", None, "degrees on the globe")));
    }
    if dxf::is_one(&head) || dxf::is_dwg(&head) {
        let sketch = dxf::read(&bytes(path)?)?;
        let scale = Scale::of_drawing(stated, options, &sketch, None, notes)?;
        return of_sketch("dxf", &sketch, scale, notes);
    }
    let packed = head.starts_with(&[0x1f, 0x8b]) || head.starts_with(b"BZh");
    let begins = String::from_utf8_lossy(&head);
    if packed || Written::of(&begins).is_some() {
        let text = text::read(path)?;
        // What is packed shows only now.
        if let Some(written) = Written::of(text.get(..LOOKED_AT as usize).unwrap_or(&text)) {
            return of_text(written, &text, options, stated, notes);
        }
    }
    if is_words(&head) {
        let begins = text::short(begins.trim_start_matches('\u{feff}').trim().lines().next().unwrap_or_default());
        return Err(PlanFileError::UnknownText { begins });
    }
    only_level(options)?;
    let scale = Scale::of(stated, options, None, None)?;
    let picture = raster::open(path, SizeLimit::PLAN)?;
    Ok((of_picture(picture, scale.metres, notes)?, source("picture", Some(scale.metres), scale.from)))
}

/// Whether a file that no reader of texts knows is a text all the same, and no picture. Pictures in text begin with P1 to P6.
fn is_words(head: &[u8]) -> bool {
    let is_word = |byte: &u8| !byte.is_ascii_control() || byte.is_ascii_whitespace();
    let is_netpbm = matches!(head, [b'P', b'1'..=b'7', ..]);
    // What is shorter than any picture's header may be a picture that was cut off.
    !is_netpbm && head.len() >= LEAST_WORDS && head.iter().all(is_word)
}

/// A picture is of one storey.
fn only_level(options: &PlanOptions) -> Result<(), PlanFileError> {
    match &options.level {
        Some(wish) if wish.trim() != "0" => {
            Err(PlanFileError::NoSuchLevel { wish: wish.clone(), levels: "0 only: it is a picture".to_owned() })
        }
        _ => Ok(()),
    }
}

fn no_pages(options: &PlanOptions) -> Result<(), PlanFileError> {
    options.page.map_or(Ok(()), |page| Err(PlanFileError::NoPages { page }))
}

/// What a text is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Written {
    Native,
    GeoJson,
    Svg,
    Osm,
    WallList,
}

impl Written {
    /// By its beginning.
    fn of(head: &str) -> Option<Self> {
        let head = head.trim_start_matches('\u{feff}').trim_start();
        match head.chars().next()? {
            '{' if native::is_one(head) => Some(Self::Native),
            '{' => Some(Self::GeoJson),
            '<' if osm::is_one(head) => Some(Self::Osm),
            '<' if head.contains("<svg") => Some(Self::Svg),
            _ if wall_list::is_one(head) => Some(Self::WallList),
            _ => None,
        }
    }
}

fn of_text(
    written: Written,
    text: &str,
    options: &PlanOptions,
    stated: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<(Opened, Source), PlanFileError> {
    if written != Written::Svg && (stated.is_some() || options.drawing_scale.is_some()) {
        return Err(PlanFileError::ScaleNotNeeded);
    }
    let metric = |format: &str| source(format, None, "the file's own metres");
    Ok(match written {
        Written::Svg => {
            let sketch = svg::read(text)?;
            let scale = Scale::of_drawing(stated, options, &sketch, Some(SVG_PIXEL_M), notes)?;
            of_sketch("svg", &sketch, scale, notes)?
        }
        Written::GeoJson => (Opened::Drawn(geojson::read(text, notes)?), metric("geojson")),
        Written::Osm => (Opened::Drawn(osm::read(text, notes)?), source("osm", None, "degrees on the globe")),
        Written::WallList => (Opened::Drawn(wall_list::read(text, notes)?), metric("wall list")),
        Written::Native => {
            let mut document = native::read(text)?;
            notes.append(&mut document.notes);
            let source = document.source.clone();
            (Opened::Kept(Box::new(document)), source)
        }
    })
}

fn of_picture(picture: DynamicImage, metres_per_pixel: f64, notes: &mut Vec<String>) -> Result<Opened, PlanFileError> {
    let (pixels, found) = drawing::classify(picture, metres_per_pixel)?;
    notes.extend(found);
    Ok(Opened::Picture { pixels, metres_per_pixel })
}

fn of_sketch(format: &str, sketch: &Sketch, scale: Scale, notes: &mut Vec<String>) -> Result<(Opened, Source), PlanFileError> {
    notes.extend(sketch.notes.iter().cloned());
    let mut elements = match sketch.exported_from {
        Some(origin) if scale.is_files => interpret::exported(sketch, scale.metres, origin),
        _ => interpret::elements(sketch, scale.metres, notes)?,
    };
    if sketch.exported_from.is_none() {
        elements.extend(audit::labels(sketch, scale.metres));
    }
    Ok((Opened::Drawn(Building::of_one_level(elements)), source(format, Some(scale.metres), scale.from)))
}

fn of_pdf(path: &Path, options: &PlanOptions, stated: Option<f64>, notes: &mut Vec<String>) -> Result<(Opened, Source), PlanFileError> {
    match pdf::read(bytes(path)?, options.page)? {
        PdfPage::Drawing(sketch) => {
            let scale = Scale::of_drawing(stated, options, &sketch, Some(POINT_M), notes)?;
            of_sketch("pdf", &sketch, scale, notes)
        }
        PdfPage::Scan { luma, page_pt, notes: found, .. } => {
            only_level(options)?;
            notes.extend(found);
            // What was measured on the page is in points; the picture has pixels of its own.
            let points_per_pixel = page_pt[0] / luma.width().max(1) as f64;
            let scale = Scale::of(stated, options, None, Some(POINT_M))?;
            let metres_per_pixel = scale.metres * points_per_pixel;
            let grey = image::GrayImage::from_raw(luma.width() as u32, luma.height() as u32, luma.data().to_vec());
            let picture = DynamicImage::ImageLuma8(grey.unwrap_or_default());
            Ok((of_picture(picture, metres_per_pixel, notes)?, source("pdf scan", Some(metres_per_pixel), scale.from)))
        }
    }
}

/// Outlines of what a picture or a robot's map shows.
pub(super) fn building(opened: Opened, notes: &mut Vec<String>) -> Result<Building, PlanFileError> {
    let (pixels, metres_per_pixel, corner) = match opened {
        Opened::Drawn(building) => return Ok(building),
        Opened::Kept(document) => return Ok(document.building),
        Opened::Picture { pixels, metres_per_pixel } => (pixels, metres_per_pixel, Pt2::new(0.0, 0.0)),
        Opened::Map(plan) => {
            let cells = plan.cells().chunks(plan.width()).rev().flatten().copied().collect();
            (Pixels { width: plan.width(), height: plan.height(), cells }, plan.cell_m(), plan.origin())
        }
    };
    let mut outlines = outline::trace(&pixels, metres_per_pixel)?;
    if outlines.specks > 0 {
        notes.push(format!("{} specks are smaller than any wall, and left out", outlines.specks));
    }
    let height_m = pixels.height as f64 * metres_per_pixel;
    for element in outlines.elements.iter_mut().filter(|element| element.source.is_none()) {
        // Where to look in a viewer: from the top left corner.
        let at = element.form.points().next().map(|at| [at.x / metres_per_pixel, (height_m - at.y) / metres_per_pixel]);
        element.source = at.map(|[u, v]| format!("pixel {u:.0} {v:.0}"));
    }
    for point in outlines.elements.iter_mut().flat_map(|element| element.form.points_mut()) {
        *point = Pt2::new(point.x + corner.x, point.y + corner.y);
    }
    Ok(Building::of_one_level(outlines.elements))
}

fn source(format: &str, metres_per_unit: Option<f64>, scale_from: &str) -> Source {
    Source { format: Some(format.to_owned()), metres_per_unit, scale_from: Some(scale_from.to_owned()), ..Source::default() }
}

fn stated_scale(options: &PlanOptions, notes: &mut Vec<String>) -> Result<Option<f64>, PlanFileError> {
    let scale = match (options.metres_per_pixel, measure::together(&options.measures, notes)) {
        (Some(_), Some(_)) => return Err(PlanFileError::TwoScales),
        (Some(scale), None) => Some(scale),
        (None, Some(measured)) => Some(measured),
        (None, None) => None,
    };
    match scale {
        Some(metres_per_pixel) if !(metres_per_pixel > 0.0 && metres_per_pixel <= 10.0) => {
            Err(PlanFileError::BadScale { metres_per_pixel })
        }
        scale => Ok(scale),
    }
}

fn head(path: &Path) -> Result<Vec<u8>, PlanFileError> {
    let mut head = Vec::new();
    std::fs::File::open(path)?.take(LOOKED_AT).read_to_end(&mut head)?;
    Ok(head)
}

/// All of a file, if it is no larger than any plan.
fn bytes(path: &Path) -> Result<Vec<u8>, PlanFileError> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(LARGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST {
        return Err(PlanFileError::FileTooLarge { limit_mb: LARGEST >> 20 });
    }
    Ok(bytes)
}
