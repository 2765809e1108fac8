//! Which pixels of a bare picture are walls? The dark ones; or the light lines of a drawing on a dark ground.
//!
//! picture ─▶ brightness and hue ─▶ brightness relative to the paper, where that is lit unevenly ([`light`]) ─▶ ink ─▶ [`scan`]: walls
//! and doors, without words and signs ─▶ [`Pixels`]
//!
//! Darkness is the brightest of red, green and blue, over white paper where the picture is transparent: black and grey are
//! dark, a red door or a blue note is not.

use image::DynamicImage;
use planwalk_types::Cell;

use super::PlanFileError;
use super::cells::Pixels;
use super::scan::{self, Planes, for_runs, light, tilt};

/// Halfway between black and white.
const MID_GREY: u8 = 128;
/// Share of dark pixels below which the threshold is taken to have missed the drawing: 1 cm of line in a 10 m × 10 m picture.
const LEAST_SHARE: f64 = 1e-4;
/// Where less of the light lines than this share is grey or white, the coloured ones are walls.
const LEAST_GREY: f64 = 0.2;
/// Colour is of lines where it is no wider than this along a row, pixels; else it fills an area.
const WIDEST_LINE_PX: usize = 12;
/// A drawing has at least this share as much wall as coloured lines.
const LEAST_DARK: f64 = 0.05;
/// No wall is thicker than this, metres; light areas wider than this in both directions are floor.
const THICKEST_WALL_M: f64 = 1.0;

/// Wall and free pixels, and what was decided.
///
/// # Errors
/// [`PlanFileError::ColouredLines`] for a drawing in which next to nothing is dark.
pub(super) fn classify(picture: DynamicImage, metres_per_pixel: f64) -> Result<(Pixels, Vec<String>), PlanFileError> {
    let mut planes = Planes::of(picture);
    let (width, height) = (planes.width, planes.height);
    let mut notes = Vec::new();
    if let Some((darkest, brightest, tile_px)) = light::level(&mut planes.brightness, width) {
        notes.push(format!(
            "the light is uneven, the paper {darkest} to {brightest} of 255 bright: dark is what is darker than half of the paper around \
             ({tile_px} px)"
        ));
    }
    let threshold = threshold(&planes.brightness, &mut notes);
    let mut is_wall: Vec<bool> = planes.brightness.iter().map(|b| *b < threshold).collect();
    let dark = is_wall.iter().filter(|d| **d).count();
    if 2 * dark > is_wall.len() && dark < is_wall.len() {
        let light_is_floor = thick_share(&is_wall, width, THICKEST_WALL_M / metres_per_pixel) > 0.5;
        let percent = 100.0 * dark as f64 / is_wall.len() as f64;
        if light_is_floor {
            notes.push(format!(
                "{percent:.0} % of the picture is dark; the light areas are as wide as rooms, so dark is wall and light is floor"
            ));
        } else {
            notes.push(format!(
                "{percent:.0} % of the picture is dark and the light parts are thin: it is read as light walls on dark ground"
            ));
            is_wall.iter_mut().for_each(|wall| *wall = !*wall);
            leave_colours_out(&planes, &mut is_wall, &mut notes);
        }
    }
    if let Some(deg) = tilt::of(&is_wall, width) {
        let way = if deg > 0.0 { "anticlockwise" } else { "clockwise" };
        notes.push(format!(
            "most lines are turned by {:.1}° {way} against the picture's sides: a sheet that lies askew is read as it lies; for an upright \
             plan, turn the picture first (e.g. magick IN -rotate {deg:.1} OUT.png)",
            deg.abs()
        ));
    }
    if planes.hue.is_empty() {
        // A large picture's brightness is not needed any more.
        planes.brightness = Vec::new();
    }
    let cells = scan::cells(&planes, is_wall, metres_per_pixel, &mut notes);
    check_colours(&planes, &cells)?;
    Ok((Pixels { width, height, cells }, notes))
}

/// A drawing in colour, without walls in black, is not understood: to read its few dark words as walls would be worse than to say so.
fn check_colours(planes: &Planes, cells: &[Cell]) -> Result<(), PlanFileError> {
    if planes.hue.is_empty() {
        return Ok(());
    }
    let mut coloured = 0;
    for row in planes.hue.chunks(planes.width) {
        for_runs(row.len(), |u| row[u] > 0, |run| coloured += if run.len() <= WIDEST_LINE_PX { run.len() } else { 0 });
    }
    let walls = cells.iter().filter(|cell| **cell == Cell::Wall).count();
    if (walls as f64) < LEAST_DARK * coloured as f64 {
        return Err(PlanFileError::ColouredLines { coloured, walls });
    }
    Ok(())
}

/// On a dark ground, grey and white lines are walls and coloured ones are notes, if there are grey ones to speak of.
fn leave_colours_out(planes: &Planes, is_wall: &mut [bool], notes: &mut Vec<String>) {
    let light = is_wall.iter().filter(|wall| **wall).count();
    let coloured = (0..is_wall.len()).filter(|i| is_wall[*i] && planes.hue_at(*i) > 0).count();
    if coloured == 0 || ((light - coloured) as f64) < LEAST_GREY * light as f64 {
        return;
    }
    is_wall.iter_mut().enumerate().for_each(|(i, wall)| *wall &= planes.hue_at(i) == 0);
    notes.push(format!("coloured lines, {:.0} % of what is light, left out: the walls are white", 100.0 * coloured as f64 / light as f64));
}

/// Pixels darker than this are dark: mid-grey, or, where that misses a faint drawing, the split after Otsu (1979).
fn threshold(brightness: &[u8], notes: &mut Vec<String>) -> u8 {
    let mut histogram = [0u64; 256];
    for b in brightness {
        histogram[usize::from(*b)] += 1;
    }
    let dark: u64 = histogram[..usize::from(MID_GREY)].iter().sum();
    let levels = histogram.iter().filter(|n| **n > 0).count();
    let share = dark as f64 / brightness.len() as f64;
    if (LEAST_SHARE..=1.0 - LEAST_SHARE).contains(&share) || levels < 2 {
        return MID_GREY;
    }
    let split = otsu(&histogram);
    notes.push(format!("the drawing is faint: brightness below {split} of 255 is taken as dark, not below {MID_GREY}"));
    split
}

fn otsu(histogram: &[u64; 256]) -> u8 {
    let moments = |levels: std::ops::Range<usize>| {
        levels.fold((0.0, 0.0), |(n, sum), level| (n + histogram[level] as f64, sum + (level as u64 * histogram[level]) as f64))
    };
    let between = |split: usize| {
        let ((n0, s0), (n1, s1)) = (moments(0..split), moments(split..256));
        if n0 == 0.0 || n1 == 0.0 { 0.0 } else { n0 * n1 * (s0 / n0 - s1 / n1).powi(2) }
    };
    // The first best split of equals: the darkest level that counts as light lies at it.
    let best = (1..256).fold((1, 0.0), |best, split| if between(split) > best.1 { (split, between(split)) } else { best });
    best.0 as u8
}

/// Share of the light pixels whose row *and* column of light are both longer than `thick_px`.
fn thick_share(is_dark: &[bool], width: usize, thick_px: f64) -> f64 {
    let height = is_dark.len() / width;
    let long = |length: usize| length as f64 > thick_px;
    let mut thick_in_row = vec![false; is_dark.len()];
    for v in 0..height {
        let row = v * width;
        for_runs(width, |u| !is_dark[row + u], |run| thick_in_row[row + run.start..row + run.end].fill(long(run.len())));
    }
    let mut thick = 0usize;
    for u in 0..width {
        for_runs(
            height,
            |v| !is_dark[v * width + u],
            |run| {
                if long(run.len()) {
                    thick += run.filter(|v| thick_in_row[v * width + u]).count();
                }
            },
        );
    }
    thick as f64 / is_dark.iter().filter(|d| !**d).count().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, Luma, Rgba, RgbaImage};

    fn walls(picture: DynamicImage) -> (usize, Vec<String>) {
        let (pixels, notes) = classify(picture, 0.1).unwrap();
        (pixels.cells.iter().filter(|c| **c == Cell::Wall).count(), notes)
    }

    /// 100 × 100 px with a frame of one pixel.
    fn frame(line: u8, ground: u8) -> DynamicImage {
        let is_line = |u, v| u == 10 || v == 10 || u == 90 || v == 90;
        GrayImage::from_fn(100, 100, |u, v| Luma([if is_line(u, v) { line } else { ground }])).into()
    }

    #[test]
    fn dark_lines_are_walls_on_paper_and_light_lines_on_a_blackboard() {
        let lines = 4 * 100 - 4;
        assert_eq!(walls(frame(0, 255)).0, lines);
        assert_eq!(walls(frame(100, 255)).0, lines);
        let (count, notes) = walls(frame(255, 0));
        assert_eq!(count, lines);
        assert!(notes.iter().any(|n| n.contains("light walls")), "{notes:?}");
    }

    #[test]
    fn faint_drawings_are_found_and_said_to_be_faint() {
        let (count, notes) = walls(frame(200, 250));
        assert_eq!(count, 4 * 100 - 4);
        assert!(notes.iter().any(|n| n.contains("faint")), "{notes:?}");
    }

    #[test]
    fn light_rooms_in_solid_black_are_not_taken_for_walls() {
        // Scanned maps draw all that is not floor in black. A room of 4 m × 4 m.
        let room = |u, v| (30..70).contains(&u) && (30..70).contains(&v);
        let picture = GrayImage::from_fn(100, 100, |u, v| Luma([if room(u, v) { 255 } else { 0 }]));
        assert_eq!(walls(picture.into()).0, 100 * 100 - 40 * 40);
    }

    #[test]
    fn transparency_is_paper_and_colours_are_notes() {
        let mut picture = RgbaImage::from_pixel(20, 20, Rgba([0, 0, 0, 0]));
        picture.put_pixel(3, 3, Rgba([0, 0, 0, 255]));
        picture.put_pixel(4, 4, Rgba([255, 0, 0, 255]));
        assert_eq!(walls(picture.into()).0, 1);
    }

    #[test]
    fn a_drawing_in_colour_without_a_dark_wall_is_refused_with_what_to_do() {
        // A blue frame of three pixels, and a dark dot.
        let is_line = |u: u32| (20..23).contains(&u) || (70..73).contains(&u);
        let picture = image::RgbImage::from_fn(100, 100, |u, v| match (u, v) {
            (5, 5) => image::Rgb([0, 0, 0]),
            _ if is_line(u) => image::Rgb([0, 0, 255]),
            _ => image::Rgb([255, 255, 255]),
        });
        let error = classify(picture.into(), 0.1).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("600") && error.contains("black and white"), "{error}");
    }

    #[test]
    fn one_colour_stays_one_colour() {
        assert_eq!(walls(GrayImage::from_pixel(9, 9, Luma([255])).into()).0, 0);
        assert_eq!(walls(GrayImage::from_pixel(9, 9, Luma([0])).into()).0, 81);
    }
}
