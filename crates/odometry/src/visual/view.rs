//! What is there to see in this picture? Light, contrast, sharpness: why a stretch of video says nothing.
//!
//! picture ─▶ [`View`] ─▶ [`Views::why_blind`] (a cause in words)

use super::image::{Level, Pyramid};

/// How a picture is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Mean grey value, 0 to 255.
    pub light: f64,
    /// Root mean square about it, of the picture an eighth of its size: noise and codecs' crumbs are gone there.
    pub contrast: f64,
    /// Steepness at full size over that at a quarter of it: 0.6 to 1 of sharp pictures, half of that of one that is smeared over
    /// ten pixels.
    pub sharpness: f64,
}

/// Grey values under which a picture is dark, and contrasts under which it shows nothing.
const DARK: f64 = 16.0;
const BLANK: f64 = 6.0;
/// Sharpness as a share of the usual one under which a picture is blurred.
const BLURRED: f64 = 0.75;
/// Share that each picture has in what is usual: half a second at 30 frames/s.
const USUAL: f64 = 0.07;
/// Rows that are looked at: every so many-th.
const SPARSE: usize = 3;

impl View {
    /// Of a picture's pyramid.
    pub fn of(pyramid: &Pyramid) -> Self {
        let levels = &pyramid.levels;
        let small = pyramid.smallest();
        let count = small.data.len().max(1) as f64;
        let light = small.data.iter().map(|p| f64::from(*p)).sum::<f64>() / count;
        let square = small.data.iter().map(|p| (f64::from(*p) - light).powi(2)).sum::<f64>() / count;
        let coarse = steepness(&levels[2.min(levels.len() - 1)], 1);
        let sharpness = if coarse > 0.0 { steepness(&levels[0], SPARSE) / coarse } else { 0.0 };
        Self { light, contrast: square.sqrt(), sharpness }
    }

    /// Whether there is anything to see.
    pub fn shows(&self) -> bool {
        self.light >= DARK && self.contrast >= BLANK
    }
}

/// Root mean square of the difference between neighbours in a row, grey values.
fn steepness(level: &Level, every: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for row in level.data.chunks_exact(level.width).step_by(every) {
        for pair in row.windows(2) {
            sum += f64::from((pair[1] - pair[0]).powi(2));
            count += 1;
        }
    }
    (sum / count.max(1) as f64).sqrt()
}

/// Remembers how pictures usually are.
#[derive(Debug, Clone, Copy, Default)]
pub struct Views {
    usual_sharpness: Option<f64>,
}

impl Views {
    /// Takes in a picture in which something could be followed.
    pub fn usual(&mut self, view: &View) {
        let before = self.usual_sharpness.unwrap_or(view.sharpness);
        self.usual_sharpness = Some(before + USUAL * (view.sharpness - before));
    }

    /// Why nothing can be followed in this picture, as far as it shows.
    pub fn why_blind(&self, view: &View, points: usize) -> String {
        let sharp = self.usual_sharpness.map_or(1.0, |usual| view.sharpness / usual);
        match view {
            View { light, .. } if *light < DARK => format!("dark: mean grey value {light:.0} of 255"),
            View { contrast, .. } if *contrast < BLANK => {
                format!("blank: contrast of {contrast:.1} grey values (a bare wall, or a covered lens)")
            }
            _ if sharp < BLURRED => format!("blurred: {:.0} % as sharp as usual", 100.0 * sharp),
            _ => format!("only {points} points could be followed (little texture, or all of it in motion)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::GrayImage;

    fn view(picture: impl Fn(usize, usize) -> u8) -> View {
        View::of(&Pyramid::new(&GrayImage::from_fn(320, 240, picture), 4))
    }

    /// Squares of 24 px whose edges are smeared over this many pixels.
    fn squares(smear: usize) -> View {
        view(|u, v| {
            let side = |x: usize| (0..=smear).map(|k| f64::from(((x + k) / 24).is_multiple_of(2))).sum::<f64>() / (smear + 1) as f64;
            (60.0 + 120.0 * side(u) * side(v)) as u8
        })
    }

    #[test]
    fn what_a_picture_lacks_is_said() {
        let mut views = Views::default();
        let sharp = squares(0);
        for _ in 0..100 {
            views.usual(&sharp);
        }
        assert!(views.why_blind(&view(|_, _| 3), 0).starts_with("dark: mean grey value 3"));
        assert!(views.why_blind(&view(|u, _| (120 + u % 2) as u8), 0).starts_with("blank"));
        let blurred = squares(12);
        assert!(blurred.sharpness < 0.7 * sharp.sharpness, "{} {}", blurred.sharpness, sharp.sharpness);
        assert!(views.why_blind(&blurred, 2).starts_with("blurred"));
        assert!(views.why_blind(&sharp, 2).starts_with("only 2 points"));
    }
}
