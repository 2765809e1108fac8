//! What sort of plan is this file, and what is one unit of it? Told by the first bytes; names say little.
//!
//! file ─▶ [`Opened`]: a picture's pixels, cells of a robot's map, or a building in metres

use std::io::Read;
use std::path::Path;

use image::DynamicImage;
use planwalk_types::{Building, FloorPlan, Pt2};

use super::cells::Pixels;
use super::native::Source;
use super::pdf::PdfPage;
use super::sketch::Sketch;
use super::{PlanFileError, PlanOptions, drawing, dxf, geojson, imdf, interpret, measure, native, osm, outline, pdf, ros, svg, wall_list};
use crate::raster::{self, SizeLimit};
use crate::text;

/// Bytes looked at to tell what a file is.
const LOOKED_AT: u64 = 4096;
/// Largest file of a kind that is read whole before it is looked at, bytes.
const LARGEST: u64 = 512 << 20;
/// Metres of a point, of which PDF has 72 in an inch, and of a pixel, of which SVG has 96.
const POINT_M: f64 = 0.0254 / 72.0;
const SVG_PIXEL_M: f64 = 0.0254 / 96.0;
/// Floor plans are drawn to these scales; others on a sheet are dates, ratios or details.
const USUAL_SCALES: [f64; 8] = [20.0, 25.0, 50.0, 75.0, 100.0, 200.0, 250.0, 500.0];
const WRITTEN: &str = "the drawing's own words";
/// A floor by a drawing's own unit is neither smaller nor larger than this, metres across.
const PLAUSIBLE_M: std::ops::RangeInclusive<f64> = 2.0..=5000.0;

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
}

/// Opens a plan of any format; with notes for people, and where it came from as far as the file says.
pub(super) fn open(path: &Path, options: &PlanOptions, notes: &mut Vec<String>) -> Result<(Opened, Source), PlanFileError> {
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
        let scale = Scale::of(stated, options, sketch.metres_per_unit, None)?;
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
    only_level(options)?;
    let scale = Scale::of(stated, options, None, None)?;
    let picture = raster::open(path, SizeLimit::PLAN)?;
    Ok((of_picture(picture, scale.metres, notes)?, source("picture", Some(scale.metres), scale.from)))
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
    if written == Written::Svg {
        let sketch = svg::read(text)?;
        let scale = Scale::of_paper(stated, options, &sketch, SVG_PIXEL_M)?;
        return of_sketch("svg", &sketch, scale, notes);
    }
    if stated.is_some() || options.drawing_scale.is_some() {
        return Err(PlanFileError::ScaleNotNeeded);
    }
    let metric = |format: &str| source(format, None, "the file's own metres");
    Ok(match written {
        Written::GeoJson => (Opened::Drawn(geojson::read(text, notes)?), metric("geojson")),
        Written::Osm => (Opened::Drawn(osm::read(text, notes)?), source("osm", None, "degrees on the globe")),
        Written::WallList => (Opened::Drawn(wall_list::read(text, notes)?), metric("wall list")),
        Written::Native | Written::Svg => {
            let document = native::read(text)?;
            notes.extend(document.notes);
            (Opened::Drawn(document.building), document.source)
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
    if scale.from == WRITTEN {
        notes.push(format!("the scale is what the drawing says of itself: {} m a unit", scale.metres));
    }
    scale.check(sketch)?;
    let elements = match sketch.exported_from {
        Some(origin) if scale.is_files => interpret::exported(sketch, scale.metres, origin),
        _ => interpret::elements(sketch, scale.metres, notes)?,
    };
    Ok((Opened::Drawn(Building::of_one_level(elements)), source(format, Some(scale.metres), scale.from)))
}

fn of_pdf(path: &Path, options: &PlanOptions, stated: Option<f64>, notes: &mut Vec<String>) -> Result<(Opened, Source), PlanFileError> {
    match pdf::read(bytes(path)?, options.page)? {
        PdfPage::Drawing(sketch) => {
            let scale = Scale::of_paper(stated, options, &sketch, POINT_M)?;
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
    for point in outlines.elements.iter_mut().flat_map(|element| element.form.points_mut()) {
        *point = Pt2::new(point.x + corner.x, point.y + corner.y);
    }
    Ok(Building::of_one_level(outlines.elements))
}

/// Metres in a unit, and who says so.
#[derive(Debug, Clone, Copy)]
struct Scale {
    metres: f64,
    from: &'static str,
    /// The file's own unit may be a slip.
    is_files: bool,
}

impl Scale {
    /// As [`Scale::of`]; a drawing that nobody says anything of may say it itself, in words.
    fn of_paper(stated: Option<f64>, options: &PlanOptions, sketch: &Sketch, paper_m: f64) -> Result<Self, PlanFileError> {
        let scale = Self::of(stated, options, sketch.metres_per_unit, Some(paper_m));
        match (scale, written_scale(sketch)) {
            (Err(PlanFileError::NoDrawingScale), Some(scale)) => Ok(Self { metres: scale * paper_m, from: WRITTEN, is_files: true }),
            (scale, _) => scale,
        }
    }

    /// What a person says goes before what the file says; `paper_m` is the unit's size on paper.
    fn of(stated: Option<f64>, options: &PlanOptions, files: Option<f64>, paper_m: Option<f64>) -> Result<Self, PlanFileError> {
        if let Some(metres) = stated {
            let from = if !options.measures.is_empty() { "a measured length" } else { "given" };
            return Ok(Self { metres, from, is_files: false });
        }
        match (options.drawing_scale, paper_m, files) {
            (Some(scale), _, _) if !(1.0..=100_000.0).contains(&scale) => Err(PlanFileError::BadDrawingScale { scale }),
            (Some(_), None, _) => Err(PlanFileError::NotOnPaper),
            (Some(scale), Some(paper_m), _) => Ok(Self { metres: scale * paper_m, from: "the drawing's scale, given", is_files: false }),
            (_, _, Some(metres)) => Ok(Self { metres, from: "the file's own unit", is_files: true }),
            (_, Some(_), None) => Err(PlanFileError::NoDrawingScale),
            (_, None, None) => Err(PlanFileError::NoScale),
        }
    }

    /// A unit that makes the drawing no building is a slip.
    fn check(&self, sketch: &Sketch) -> Result<(), PlanFileError> {
        let points = || sketch.paths.iter().flat_map(|path| &path.points);
        let size_m = [0, 1].map(|k| {
            let (low, high) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), at| (l.min(at[k]), h.max(at[k])));
            self.metres * (high - low).max(0.0)
        });
        if self.is_files && !PLAUSIBLE_M.contains(&size_m[0].max(size_m[1])) {
            return Err(PlanFileError::ImplausibleUnit { metres_per_unit: self.metres, width_m: size_m[0], height_m: size_m[1] });
        }
        Ok(())
    }
}

/// The scale that is written on a drawing, as 100 of 1:100; `None` where there is none, or several.
fn written_scale(sketch: &Sketch) -> Option<f64> {
    let mut found: Vec<f64> = sketch.texts.iter().flat_map(|text| scales_in(&text.text)).collect();
    found.sort_by(f64::total_cmp);
    found.dedup();
    if let [scale] = found[..] { Some(scale) } else { None }
}

/// All "1:100", "1 : 50", "1/200" in a text that are usual scales of floor plans.
fn scales_in(text: &str) -> Vec<f64> {
    let bare: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    // No other digit goes before the 1, nor a decimal point with one before it.
    let is_digit = |c: char| c.is_ascii_digit();
    let ends_alone = |before: &str| {
        before
            .strip_suffix('1')
            .is_some_and(|rest| !rest.ends_with(is_digit) && !rest.strip_suffix('.').is_some_and(|r| r.ends_with(is_digit)))
    };
    let scale = |(at, _): (usize, &str)| {
        let digits: String = bare[at + 1..].chars().take_while(|c| is_digit(*c)).collect();
        digits.parse().ok().filter(|scale: &f64| ends_alone(&bare[..at]) && USUAL_SCALES.contains(scale))
    };
    bare.match_indices([':', '/']).filter_map(scale).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::sketch::SketchText;

    #[test]
    fn a_scale_that_is_written_on_a_drawing_is_understood_if_it_is_the_only_one() {
        let saying = |texts: &[&str]| {
            let text = |text: &&str| SketchText { at: [0.0; 2], height: 1.0, text: (*text).to_owned(), layer: String::new() };
            written_scale(&Sketch { texts: texts.iter().map(text).collect(), ..Sketch::default() })
        };
        for (texts, scale) in [
            (&["Scale 1:100"][..], Some(100.0)),
            (&["M 1 : 50 (A1)", "Erdgeschoss", "1:50"], Some(50.0)),
            (&["ech. 1/200"], Some(200.0)),
            (&["1:100", "Detail 1:20"], None),
            (&["11:50 h", "21/25", "4.1:100", "1:37", "1:", "x1", ""], None),
        ] {
            assert_eq!(saying(texts), scale, "{texts:?}");
        }
    }
}
