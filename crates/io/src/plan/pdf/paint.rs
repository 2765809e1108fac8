//! What does a scanned page look like? Its pictures, painted onto one.

use std::time::Instant;

use hayro_interpret::font::GlyphRun;
use hayro_interpret::kurbo::{Affine, BezPath, Point};
use hayro_interpret::{BlendMode, ClipPath, Device, DrawMode, DrawProps, Image, ImageData, ImageDrawProps, SoftMask};

use super::super::PlanFileError;
use super::super::bounds::Bounds;
use super::picture::{check_picture, check_size};
use super::{Sheet, check_clock, colour, refused, sketch_point, stop};

/// Most pixels that all pictures of a scan paint: a page in strips paints each once.
const MOST_PAINTED: f64 = 2e9;

/// Most pixels of the paper for each of the pictures on it: those of a scan cover at least [`super::SCANNED`] of it.
const MOST_PAPER: f64 = 4.0;
/// Pixels that any paper may have.
pub(super) const FEWEST_PAPER: f64 = 4e6;

/// Paints the pictures of a page onto one.
pub(super) struct Painter {
    sheet: Sheet,
    pub luma: Vec<u8>,
    pub width: usize,
    pub height: usize,
    painted: f64,
    until: Instant,
}

impl Painter {
    /// White paper with pixels of this size, or larger where the pictures have few: one that is squeezed flat, or a mere stamp, would
    /// ask for millions of pixels that say nothing.
    pub(super) fn new(sheet: Sheet, pixel_pt: f64, pixels: f64, until: Instant) -> Result<Self, PlanFileError> {
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

/// Brightness (ITU-R BT.601).
fn luma([r, g, b]: [u8; 3]) -> u8 {
    ((299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) + 500) / 1000) as u8
}
