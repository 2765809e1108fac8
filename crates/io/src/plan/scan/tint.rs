//! What do a drawing's colours say? Ink is dark and grey; a strip of colour across a gap of a wall is a door, other colours are notes.
//!
//! A hue is one of twelve sectors of the colour circle. Edges of coloured lines and what JPEG makes of them are coloured too, faintly.

use image::DynamicImage;

use super::blobs::{Blob, Blobs, Run};
use super::strip::Strip;

/// Brightest and darkest channel of a colour differ by this much, of 255; less is grey that a scanner or JPEG has tinged.
const LEAST_CHROMA: u8 = 32;
/// Sectors of the colour circle.
pub(super) const HUES: u8 = 12;
/// A door is this wide, metres: from a cupboard's to a gate's.
const DOOR_M: std::ops::RangeInclusive<f64> = 0.4..=4.0;
/// … and no thicker than the thickest wall that is pierced by doors, metres.
const DOOR_THICKNESS_M: f64 = 0.6;
/// A strip is at least this much longer than thick.
const DOOR_SLENDER: f64 = 1.5;
/// Share of its rectangle that a strip covers at least.
const DOOR_FULL: f64 = 0.8;
/// … and no thinner than this, pixels: the fringes of a scanner's colours are.
const DOOR_LEAST_PX: f64 = 2.5;
/// A wall begins no farther than this from a door's end, metres, or pixels where they are coarse: a cupboard may stand between.
const JAMB: (f64, f64) = (0.3, 3.0);
/// … and it is at least this thick there: a wall, no dot.
const JAMB_THICK: (f64, f64) = (0.05, 3.0);
/// Pixels larger than this show no doors, metres.
const COARSEST_M: f64 = 0.1;
/// A sign is no larger than this share of the picture's longer side.
const SIGN_SHARE: f64 = 0.05;
/// Its ink runs along its box by no more than this share of the box's sides: stars and discs touch them, rooms run along them.
const SIGN_SIDES: f64 = 0.4;
/// A sign is drawn round; what is not may be a letter up to this size, pixels, else it is a dash of a line.
const STROKE_PX: u32 = 16;

/// A picture as two planes, row by row from the top.
pub(in crate::plan) struct Planes {
    pub width: usize,
    pub height: usize,
    /// The brightest of red, green and blue, over white paper where the picture is transparent.
    pub brightness: Vec<u8>,
    /// 0 for grey, else 1..=12: the sector of the hue. Empty where nothing is coloured.
    pub hue: Vec<u8>,
}

impl Planes {
    /// Splits a picture.
    pub fn of(picture: DynamicImage) -> Self {
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let (brightness, hue) = match picture {
            DynamicImage::ImageLuma8(grey) => (grey.into_raw(), Vec::new()),
            DynamicImage::ImageLumaA8(grey) => (grey.pixels().map(|p| over_white(p.0[0], p.0[1])).collect(), Vec::new()),
            // Without a copy in eight bits, which would be half as large as the picture again.
            DynamicImage::ImageLuma16(grey) => (grey.pixels().map(|p| of_16_bits(p.0[0])).collect(), Vec::new()),
            DynamicImage::ImageRgb16(rgb) => split(rgb.pixels().map(|p| p.0.map(of_16_bits))),
            DynamicImage::ImageRgba16(rgb) => split(rgb.pixels().map(|p| on_paper(p.0.map(of_16_bits)))),
            DynamicImage::ImageRgb8(rgb) => split(rgb.pixels().map(|p| p.0)),
            other => split(other.into_rgba8().pixels().map(|p| on_paper(p.0))),
        };
        Self { width, height, brightness, hue }
    }

    /// The sector of a place's hue, from 1; 0 where it is grey.
    pub fn hue_at(&self, place: usize) -> u8 {
        self.hue.get(place).copied().unwrap_or(0)
    }
}

fn split(pixels: impl ExactSizeIterator<Item = [u8; 3]>) -> (Vec<u8>, Vec<u8>) {
    let (mut brightness, mut hue) = (Vec::with_capacity(pixels.len()), Vec::with_capacity(pixels.len()));
    let mut is_coloured = false;
    for rgb in pixels {
        let sector = sector(rgb);
        is_coloured |= sector > 0;
        brightness.push(rgb[0].max(rgb[1]).max(rgb[2]));
        hue.push(sector);
    }
    (brightness, if is_coloured { hue } else { Vec::new() })
}

/// As the image library rounds it.
fn of_16_bits(value: u16) -> u8 {
    ((u32::from(value) * 255 + 32_767) / 65_535) as u8
}

fn on_paper([r, g, b, a]: [u8; 4]) -> [u8; 3] {
    [over_white(r, a), over_white(g, a), over_white(b, a)]
}

fn over_white(value: u8, alpha: u8) -> u8 {
    let (value, alpha) = (u32::from(value), u32::from(alpha));
    ((value * alpha + 255 * (255 - alpha) + 127) / 255) as u8
}

/// The hexagon's hue (Smith 1978), rounded to twelfths; red is 1.
fn sector([r, g, b]: [u8; 3]) -> u8 {
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = most - least;
    if chroma < LEAST_CHROMA {
        return 0;
    }
    let step = |a: u8, b: u8| (f64::from(a) - f64::from(b)) / f64::from(chroma);
    let sixths = match most {
        _ if most == r => step(g, b),
        _ if most == g => 2.0 + step(b, r),
        _ => 4.0 + step(r, g),
    };
    1 + (2.0 * sixths).round().rem_euclid(f64::from(HUES)) as u8
}

/// Doors: strips of one colour between two pieces of wall, each as the runs of its pixels.
pub(super) fn doors(planes: &Planes, is_ink: &[bool], metres_per_pixel: f64) -> Vec<Vec<Run>> {
    let mut doors: Vec<Vec<Run>> = Vec::new();
    if metres_per_pixel > COARSEST_M {
        return doors;
    }
    for hue in 1..=HUES {
        if !planes.hue.contains(&hue) {
            continue;
        }
        // Neighbouring sectors: a colour's shade varies across its edge.
        let is_near = |i: usize| (planes.hue[i] + HUES - hue) % HUES <= 1 && planes.hue[i] > 0 && !is_ink[i];
        let Some(found) = Blobs::of(planes.hue.len(), planes.width, is_near) else { continue };
        let largest = (*DOOR_M.end() / metres_per_pixel).ceil() as u32 + 2;
        let fits = |blob: &Blob| blob.reach() <= largest && f64::from(blob.reach()) * metres_per_pixel >= 0.7 * DOOR_M.start();
        for (_, runs) in found.by_blob().into_iter().enumerate().filter(|(blob, _)| fits(&found.blobs[*blob])) {
            let runs: Vec<Run> = runs.iter().map(|i| found.runs[*i as usize]).collect();
            // A colour between two sectors is met twice.
            let is_met = |door: &Vec<Run>| {
                door.first().zip(runs.first()).is_some_and(|(a, b)| a.row.abs_diff(b.row) <= 1 && a.start.abs_diff(b.start) <= 2)
            };
            if !doors.iter().any(is_met) && Strip::of(runs.iter().copied()).is_door(planes, is_ink, metres_per_pixel) {
                doors.push(runs);
            }
        }
    }
    doors
}

impl Strip {
    /// Whether it is as long and thick as doors are, straight, full, and ends at ink on both sides.
    fn is_door(&self, planes: &Planes, is_ink: &[bool], metres_per_pixel: f64) -> bool {
        let is_strip = DOOR_M.contains(&(self.length * metres_per_pixel))
            && self.thickness * metres_per_pixel <= DOOR_THICKNESS_M
            && self.thickness >= DOOR_LEAST_PX
            && self.length >= DOOR_SLENDER * self.thickness
            && self.area >= DOOR_FULL * self.length * self.thickness;
        let [reach, thick] = [JAMB, JAMB_THICK].map(|(metres, pixels)| pixels.max(metres / metres_per_pixel));
        let is_jamb = |sign: f64, aside: f64| {
            let has_ink = |ahead: f64| {
                let far = sign * (0.5 * self.length + ahead);
                let at = [0, 1].map(|k| self.centre[k] + far * self.way[k] + aside * [-self.way[1], self.way[0]][k]);
                let inside = at[0] >= 0.0 && at[1] >= 0.0 && (at[0] as usize) < planes.width && (at[1] as usize) < planes.height;
                inside && is_ink[at[1] as usize * planes.width + at[0] as usize]
            };
            let begin = (0..=2 * reach as usize).map(|i| 0.5 * i as f64).find(|ahead| has_ink(*ahead));
            begin.is_some_and(|begin| (0..=thick as usize).all(|i| has_ink(begin + i as f64)))
        };
        let is_jamb = |sign: f64| [-0.4, 0.0, 0.4].iter().any(|part| is_jamb(sign, part * self.thickness));
        is_strip && is_jamb(1.0) && is_jamb(-1.0)
    }
}

/// Pieces of ink that are the outline of a coloured sign: a star, a disc, an arrow. A stroke that is none of a letter is a piece of a line.
pub(super) fn signs(planes: &Planes, found: &Blobs) -> Vec<bool> {
    let mut is_sign = vec![false; found.blobs.len()];
    if planes.hue.is_empty() {
        return is_sign;
    }
    let largest = (SIGN_SHARE * planes.width.max(planes.height) as f64) as u32;
    let lists = found.by_blob();
    for (blob, b) in found.blobs.iter().enumerate().filter(|(_, b)| b.reach() <= largest && b.reach() >= 5) {
        let runs = || lists[blob].iter().map(|i| found.runs[*i as usize]);
        let [columns, rows] = b.size();
        let on_sides: u32 = runs()
            .map(|run| {
                let ends = u32::from(run.start == b.low[0]) + u32::from(run.end == b.high[0]);
                let edge = run.row == b.low[1] || run.row + 1 == b.high[1];
                ends + if edge { run.end - run.start } else { 0 }
            })
            .sum();
        let mut coloured = 0;
        for row in b.low[1]..b.high[1] {
            let start = row as usize * planes.width;
            coloured += planes.hue[start + b.low[0] as usize..start + b.high[0] as usize].iter().filter(|hue| **hue > 0).count();
        }
        let open = (u64::from(columns) * u64::from(rows)).saturating_sub(b.area);
        is_sign[blob] = f64::from(on_sides) <= SIGN_SIDES * f64::from(2 * (columns + rows))
            && 4 * coloured as u64 >= open
            && (b.is_closed() || b.reach() <= STROKE_PX && !Strip::of(runs()).is_bar());
    }
    is_sign
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_on_a_fill_is_a_sign_and_a_dash_of_the_fills_outline_is_none() {
        // On pale blue: a ring; and a long slanted stroke, two pixels thick, as a dark outline leaves them.
        let is_ring = |u: f64, v: f64| (libm::hypot(u - 40.0, v - 40.0) - 15.0).abs() < 1.0;
        let is_dash = |u: f64, v: f64| (100.0..112.0).contains(&v) && (u - 100.0 - 0.5 * (v - 100.0)).abs() <= 1.0;
        let is_drawn = |u: u32, v: u32| is_ring(f64::from(u), f64::from(v)) || is_dash(f64::from(u), f64::from(v));
        let picture = image::RgbImage::from_fn(800, 200, |u, v| image::Rgb(if is_drawn(u, v) { [20, 30, 30] } else { [195, 235, 245] }));
        let planes = Planes::of(picture.into());
        let found = Blobs::of(planes.brightness.len(), planes.width, |i| planes.brightness[i] < 128).unwrap();
        assert_eq!(signs(&planes, &found), [true, false]);
    }

    #[test]
    fn pictures_of_16_bits_are_those_of_8_bits() {
        let shade = |u: u32, v: u32| ((u * 997 + v * 8_191) % 65_536) as u16;
        let grey = image::ImageBuffer::from_fn(64, 64, |u, v| image::Luma([shade(u, v)]));
        let rgb = image::ImageBuffer::from_fn(64, 64, |u, v| image::Rgb([shade(u, v), shade(v, u), 40_000]));
        let rgba = image::ImageBuffer::from_fn(64, 64, |u, v| image::Rgba([shade(u, v), shade(v, u), 300, shade(u + v, 1)]));
        for deep in [DynamicImage::ImageLuma16(grey), DynamicImage::ImageRgb16(rgb), DynamicImage::ImageRgba16(rgba)] {
            let (planes, flat) = (Planes::of(deep.clone()), Planes::of(DynamicImage::ImageRgba8(deep.to_rgba8())));
            assert_eq!((planes.brightness, planes.hue), (flat.brightness, flat.hue));
        }
    }
}
