//! Is this the picture before it once more? Frame-rate converters, screen recorders and dropped frames show pictures twice.
//!
//! A picture shown twice says that the camera stood still, and the next one that it leapt: both are lies. Such a frame tells
//! nothing; its pose lies between its neighbours'.
//!
//! Pitfall: a camera that stands still, and a blank wall, look the same twice, too. A pose between the neighbours' is right there
//! as well, as long as it is not for long: hence [`MOST_IN_A_ROW`].

use planwalk_types::GrayImage;

/// Side of the blocks that are compared, pixels: a codec's macroblock, so that one that it did not skip stands out.
const BLOCK: usize = 16;
/// Mean difference of a block's pixels, grey values, up to which it shows the same: above what a codec changes when it codes a
/// picture once more, below what an edge does that moves by half a pixel.
const SAME: u32 = 5;
/// Frames in a row that may be taken for repeats; more of them are a camera that stands still.
const MOST_IN_A_ROW: u32 = 2;

/// Tells repeats; holds the last picture that was none.
#[derive(Debug, Default)]
pub struct Repeats {
    last: Option<GrayImage>,
    in_a_row: u32,
}

impl Repeats {
    /// Whether the picture is the last one once more.
    pub fn is_repeat(&mut self, image: &GrayImage) -> bool {
        let same = self.last.as_ref().is_some_and(|last| largest_change(last, image) <= SAME);
        if same && self.in_a_row < MOST_IN_A_ROW {
            self.in_a_row += 1;
            return true;
        }
        self.in_a_row = 0;
        self.last = Some(image.clone());
        false
    }
}

/// Largest mean difference of any block, grey values.
fn largest_change(a: &GrayImage, b: &GrayImage) -> u32 {
    if (a.width(), a.height()) != (b.width(), b.height()) {
        return u32::MAX;
    }
    let mut most = 0;
    for top in (0..a.height()).step_by(BLOCK) {
        let bottom = (top + BLOCK).min(a.height());
        let mut sums = vec![0u32; a.width().div_ceil(BLOCK)];
        for v in top..bottom {
            for ((sum, p), q) in sums.iter_mut().zip(a.row(v).chunks(BLOCK)).zip(b.row(v).chunks(BLOCK)) {
                *sum += p.iter().zip(q).map(|(p, q)| u32::from(p.abs_diff(*q))).sum::<u32>();
            }
        }
        let area = |i: usize| ((bottom - top) * BLOCK.min(a.width() - i * BLOCK)) as u32;
        most = sums.iter().enumerate().map(|(i, sum)| sum / area(i)).fold(most, u32::max);
        if most > SAME {
            return most;
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stripes, moved by a share of a pixel, with a little noise.
    fn picture(moved: f64, noise: u8) -> GrayImage {
        GrayImage::from_fn(64, 48, |u, v| {
            let stripe = 120.0 + 100.0 * (0.7 * (u as f64 - moved)).sin();
            stripe as u8 + ((u * 7 + v * 13) % 3) as u8 * noise
        })
    }

    #[test]
    fn a_picture_coded_once_more_is_a_repeat_and_one_that_moved_is_not() {
        let mut repeats = Repeats::default();
        assert!(!repeats.is_repeat(&picture(0.0, 0)), "nothing came before");
        assert!(repeats.is_repeat(&picture(0.0, 1)));
        assert!(!repeats.is_repeat(&picture(0.3, 0)), "a third of a pixel is a motion");
        assert!(!repeats.is_repeat(&picture(0.9, 0)));
    }

    #[test]
    fn a_camera_that_stands_still_is_not_a_repeat_for_long() {
        let mut repeats = Repeats::default();
        let told: Vec<bool> = (0..7).map(|_| repeats.is_repeat(&picture(0.0, 0))).collect();
        assert_eq!(told, [false, true, true, false, true, true, false]);
    }

    #[test]
    fn one_block_that_changed_is_enough() {
        let mut repeats = Repeats::default();
        repeats.is_repeat(&picture(0.0, 0));
        let person = GrayImage::from_fn(64, 48, |u, v| if u < 16 && v >= 32 { 20 } else { picture(0.0, 0).at(u, v) });
        assert!(!repeats.is_repeat(&person));
    }
}
