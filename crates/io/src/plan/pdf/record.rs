//! What does a page draw? Paths, letters, pictures and layers, as the interpreter calls them out.

use std::time::Instant;

use hayro_interpret::font::GlyphRun;
use hayro_interpret::hayro_cmap::BfString;
use hayro_interpret::hayro_syntax::object::Dict;
use hayro_interpret::kurbo::{Affine, BezPath, PathEl, Point};
use hayro_interpret::{BlendMode, ClipPath, Device, DrawMode, DrawProps, Image, ImageDrawProps, SoftMask};

use super::super::bounds::Bounds;
use super::super::drafter::{self, Drafter, FAINTEST, Letters, Look, Step};
use super::super::sketch::SketchPoint;
use super::words::group_names;
use super::{Sheet, check_clock, colour, refused, sketch_point, stop};

/// Most clips, groups and forms of a page: drawings have one a line at worst. Forms that draw forms grow without bound.
const MOST_FORMS: usize = 500_000;
/// Font sizes in a unit of a glyph.
const GLYPH_UNITS: f64 = 1000.0;

/// A picture on the page.
pub(super) struct Picture {
    /// Share of the page that its box covers.
    pub share: f64,
    /// Its pixel's shorter side, points.
    pub pixel_pt: f64,
    /// How many it has.
    pub pixels: f64,
}

/// Writes down what a page draws.
pub(super) struct Recorder {
    sheet: Sheet,
    pub drafter: Drafter,
    pub pictures: Vec<Picture>,
    clips: Vec<Bounds>,
    opacities: Vec<f64>,
    /// Layer of each open mark; `None` for marks that are no groups.
    layers: Vec<Option<String>>,
    forms: usize,
    until: Instant,
}

impl Recorder {
    pub(super) fn new(sheet: Sheet, until: Instant) -> Self {
        Self {
            sheet,
            drafter: Drafter::new(sheet.size_pt[0].max(sheet.size_pt[1])),
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
        if let Err(why) = self.drafter.draw(steps, clip, &look) {
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
            let piece = Letters {
                at,
                em: [0, 1].map(|k| on[k] - at[k]),
                width_em: f64::from(width.unwrap_or(0.5 * GLYPH_UNITS as f32)) / GLYPH_UNITS,
                text: text.chars().filter(|c| !c.is_control()).collect(),
                layer: self.layer().to_owned(),
            };
            let written = if self.sheet.bounds().holds(at) { self.drafter.write(piece) } else { Ok(()) };
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
        let layer = (!names.is_empty()).then(|| drafter::layer_within(self.layer(), names.iter().map(String::as_str)));
        self.spend_form();
        self.layers.push(layer);
    }

    fn end_marked_content(&mut self) {
        self.layers.pop();
    }
}
