//! Where are areas of colour outlined? Lines around and across pale fills, as on the maps of malls, though no ink is dark there.
//!
//! A fill is a hue with one brightness over a good part of the picture; a line is darker, of its hue or grey, and lies at it.

use super::tint::{HUES, Planes};

/// A hue fills areas where this share of the picture has it, at one brightness.
const LEAST_SHARE: f64 = 0.03;
/// Brightness of one fill differs by no more than this, of 255.
const EVEN: u8 = 10;
/// Lines are darker than what they outline by this.
const DARKER: u8 = 40;
/// Lines are no farther from the fill than this, pixels: half of a line and its blurred edge.
const NEAR_PX: usize = 2;

/// Places of lines around fills. `is_left_out`: letters and the like, with their edges.
pub(super) fn outlines(fills: &[Fill], planes: &Planes, is_ink: &[bool], is_left_out: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut lines = Vec::new();
    for fill in fills {
        for (place, is_ink) in is_ink.iter().enumerate() {
            let hue = planes.hue[place];
            let is_of_it = hue == 0 || (hue + HUES + 1 - fill.hue) % HUES <= 2;
            let is_dark = planes.brightness[place] <= fill.line();
            if is_dark && is_of_it && !is_ink && !is_left_out(place) && fill.is_near(planes, place) {
                lines.push(place);
            }
        }
    }
    lines.sort_unstable();
    lines.dedup();
    lines
}

/// A hue at a brightness.
pub(super) struct Fill {
    hue: u8,
    brightness: u8,
}

impl Fill {
    /// Lines around it are no brighter than this.
    pub fn line(&self) -> u8 {
        self.brightness.saturating_sub(DARKER)
    }

    fn is_at(&self, planes: &Planes, place: usize) -> bool {
        planes.hue[place] == self.hue && planes.brightness[place].abs_diff(self.brightness) <= EVEN
    }

    fn is_near(&self, planes: &Planes, place: usize) -> bool {
        let (u, v) = (place % planes.width, place / planes.width);
        let span = |at: usize, end: usize| at.saturating_sub(NEAR_PX)..(at + NEAR_PX + 1).min(end);
        span(v, planes.height).any(|v| span(u, planes.width).any(|u| self.is_at(planes, v * planes.width + u)))
    }
}

/// Fills of the picture: pale ones; dark areas are ink.
pub(super) fn fills(planes: &Planes) -> Vec<Fill> {
    let mut counts = vec![[0u64; 256]; usize::from(HUES) + 1];
    for (hue, brightness) in planes.hue.iter().zip(&planes.brightness) {
        counts[usize::from(*hue)][usize::from(*brightness)] += 1;
    }
    let least = LEAST_SHARE * planes.brightness.len() as f64;
    let of = |(hue, levels): (usize, &[u64; 256])| {
        let around = |b: usize| levels[b.saturating_sub(EVEN.into())..(b + usize::from(EVEN) + 1).min(256)].iter().sum::<u64>();
        // The first of the fullest levels.
        let brightness = (0..256).rev().max_by_key(|b| levels[*b])?;
        (hue > 0 && around(brightness) as f64 >= least).then_some(Fill { hue: hue as u8, brightness: brightness as u8 })
    };
    counts.iter().enumerate().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Rgb, RgbImage};

    /// A pale room with a line of this colour around it.
    fn outlined(fill: [u8; 3], line: [u8; 3]) -> usize {
        let picture = RgbImage::from_fn(100, 100, |u, v| {
            let from_edge = |x: u32| if x < 50 { i64::from(x) - 20 } else { 79 - i64::from(x) };
            match from_edge(u).min(from_edge(v)) {
                0 => Rgb(line),
                d if d > 0 => Rgb(fill),
                _ => Rgb([255, 255, 255]),
            }
        });
        let planes = Planes::of(picture.into());
        if planes.hue.is_empty() {
            return 0;
        }
        outlines(&fills(&planes), &planes, &vec![false; 100 * 100], |_| false).len()
    }

    #[test]
    fn a_fills_outline_is_a_line_and_other_colours_are_not() {
        let around = 4 * 60 - 4;
        assert_eq!(outlined([195, 235, 245], [117, 167, 177]), around);
        assert_eq!(outlined([195, 235, 245], [140, 140, 140]), around);
        // Without an outline, with one of another colour, and grey without colour.
        assert_eq!(outlined([195, 235, 245], [255, 255, 255]), 0);
        assert_eq!(outlined([195, 235, 245], [200, 60, 60]), 0);
        assert_eq!(outlined([200, 200, 200], [140, 140, 140]), 0);
    }
}
