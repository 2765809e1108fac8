//! How long is the lens? The focal length of a video that comes without a camera file, from the video itself.
//!
//! frames ─▶ [`LensSample`] ─▶ pictures with straight edges ─▶ `box_edges`: likelihood of each focal length ─┐
//!                          ─▶ turns: points followed over some frames ─▶ `turns`: the same ────────────────┼─▶ [`FocalEstimate`]
//!                             a phone's usual lens ─▶ prior ───────────────────────────────────────────────┘
//!
//! No picture and no turn is trusted far: each says only so much for or against a lens, so that those before a round hall or a crowd are
//! outvoted, and the spread between stretches of the video is in the stated sigma. Where nothing speaks the prior comes back, as wide as it is.
//!
//! Pitfalls: the principal point is taken to be the centre and the lens to bend nothing: what it does bend pulls at the focal length, and
//! the sigma has a floor for that; a fisheye is out of reach. A zoom during the clip is not looked for.

mod box_edges;
mod posterior;
mod turns;

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector2};
use planwalk_types::{Camera, GrayImage, IntrinsicsSource, Seed, Stamp, VideoFrame};

use super::lines::Segment;
use super::track::{Track, TrackId, Tracker};
use posterior::{Cue, Posterior};

/// Frames are taken at most this often, seconds: points are followed well at 15 frames/s, and more would only take longer.
const EVERY_S: f64 = 0.06;
/// Most frames, and most pictures with edges and turns of each: half a minute of walking says what there is to say.
const MOST_FRAMES: usize = 600;
const MOST: usize = 100;
/// A longer side than this is halved until it is shorter, pixels: what matters is seen at that size.
const LARGEST_PX: usize = 1000;
/// How far points go, as a share of the longer side, until a turn is complete, and how far they have gone at least if it ends earlier.
const FAR: f64 = 0.12;
const FAR_ENOUGH: f64 = 0.04;
/// Frames after which a turn ends: points that were followed for two seconds have drifted.
const LONGEST: usize = 30;
/// Share of the points under which a turn ends: the rest would soon be too few.
const LEFT: f64 = 0.4;
/// Focal lengths that are tried, as shares of the longer side (from 103° of view to 26°), and how many.
const SHORTEST_LENS: f64 = 0.4;
const LONGEST_LENS: f64 = 2.2;
const LENSES: usize = 33;

/// A focal length and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FocalEstimate {
    /// Pixels of the video.
    pub focal_px: f64,
    /// Standard deviation of its logarithm.
    pub relative_sigma: f64,
    /// Pictures whose straight edges say something of it.
    pub pictures: usize,
    /// Turns that say something of it.
    pub turns: usize,
    /// Frames that were looked at.
    pub frames: usize,
}

impl FocalEstimate {
    /// Whether the video said anything: else it is a phone's usual lens.
    pub fn is_measured(&self) -> bool {
        self.pictures + self.turns > 0
    }

    /// A camera with this focal length for pictures of this size; the principal point in the centre, no distortion.
    pub fn camera(&self, width: usize, height: usize) -> Camera {
        let usual = Camera::phone_prior(width, height);
        let source = if self.is_measured() { IntrinsicsSource::Measured { relative_sigma: self.relative_sigma } } else { usual.source };
        Camera { fx: self.focal_px, fy: self.focal_px, source, ..usual }
    }
}

/// What a video shows of its lens.
#[derive(Debug)]
pub struct LensSample {
    /// How many pixels of the video one of the pictures here is wide.
    shrink: usize,
    camera: Camera,
    tracker: Tracker,
    /// Where the turn that goes on began: points in its first picture.
    began: BTreeMap<TrackId, (f64, f64)>,
    since: usize,
    last: Option<Stamp>,
    frames: usize,
    pictures: Vec<Vec<Segment>>,
    turns: Vec<Vec<turns::PixelPair>>,
}

impl LensSample {
    /// For pictures of this size, pixels.
    pub fn new(width: usize, height: usize) -> Self {
        let mut shrink = 1;
        while width.max(height) / shrink > LARGEST_PX {
            shrink *= 2;
        }
        let camera = Camera::phone_prior((width / shrink).max(1), (height / shrink).max(1));
        let tracker = Tracker::new(camera.clone());
        Self { shrink, camera, tracker, began: BTreeMap::new(), since: 0, last: None, frames: 0, pictures: Vec::new(), turns: Vec::new() }
    }

    /// Whether more frames would add little.
    pub fn is_enough(&self) -> bool {
        self.frames >= MOST_FRAMES || self.pictures.len() >= MOST && self.turns.len() >= MOST
    }

    /// Takes in a frame, if it is not too soon after the last; one of another size is left out.
    pub fn push(&mut self, frame: &VideoFrame) {
        let soon = self.last.is_some_and(|last| frame.stamp.secs_since(last) < EVERY_S);
        let size = (frame.image.width() / self.shrink, frame.image.height() / self.shrink);
        if soon || self.is_enough() || size != (self.camera.width, self.camera.height) {
            return;
        }
        self.last = Some(frame.stamp);
        (self.frames, self.since) = (self.frames + 1, self.since + 1);
        if self.shrink == 1 {
            self.follow(&frame.image)
        } else {
            self.follow(&shrunk(&frame.image, self.shrink))
        }
        if let Some(turn) = self.complete_turn() {
            if self.turns.len() < MOST && !turn.is_empty() {
                self.turns.push(turn);
            }
            self.begin_turn();
        }
    }

    fn follow(&mut self, image: &GrayImage) {
        let camera = self.camera.clone();
        // For a lens that is off, the turn is so too, and the pixel that follows from it nearly right.
        self.tracker.advance(image, UnitQuaternion::identity(), |turn| {
            move |track: &Track| {
                let pixel = camera.project(&(turn? * track.ray))?;
                Some((pixel.x, pixel.y))
            }
        });
    }

    /// The points of a turn that is to end here; none of them where it was too short to say anything.
    fn complete_turn(&self) -> Option<Vec<turns::PixelPair>> {
        let centre = Vector2::new(self.camera.cx, self.camera.cy);
        let at = |p: (f64, f64)| Vector2::new(p.0, p.1) - centre;
        let pair = |t: &Track| self.began.get(&t.id).map(|first| [at(*first), at(t.pixel)]);
        let pairs: Vec<turns::PixelPair> = self.tracker.tracks().iter().filter_map(pair).collect();
        let way = super::two_view::rotation::median(pairs.iter().map(|[a, b]| (b - a).norm()).collect()) / self.long_side();
        let ends = way > FAR || self.since > LONGEST || (pairs.len() as f64) < LEFT * self.began.len() as f64 || self.began.is_empty();
        ends.then(|| if way > FAR_ENOUGH { pairs } else { Vec::new() })
    }

    fn begin_turn(&mut self) {
        self.tracker.replenish();
        self.began = self.tracker.tracks().iter().map(|t| (t.id, t.pixel)).collect();
        self.since = 0;
        if self.pictures.len() < MOST {
            self.pictures.push(self.tracker.segments());
        }
    }

    fn long_side(&self) -> f64 {
        self.camera.width.max(self.camera.height) as f64
    }

    /// The focal length. The same frames and seed give the same answer.
    pub fn estimate(&self, seed: Seed) -> FocalEstimate {
        let ratio = libm::log(LONGEST_LENS / SHORTEST_LENS) / (LENSES - 1) as f64;
        let logs: Vec<f64> = (0..LENSES).map(|i| libm::log(SHORTEST_LENS * self.long_side()) + i as f64 * ratio).collect();
        let lenses: Vec<f64> = logs.iter().map(|log| libm::exp(*log)).collect();
        let usual = self.camera.focal_px();
        let middle = lenses.iter().position(|focal| *focal >= usual).unwrap_or(0);
        let centre = Vector2::new(self.camera.cx, self.camera.cy);
        let edges = self.pictures.iter().filter_map(|segments| box_edges::curve(segments, centre, &lenses));
        let turn = |(i, pairs): (usize, &Vec<turns::PixelPair>)| {
            turns::curve(pairs, self.long_side(), &lenses, middle, &mut seed.derive("turn", i as u64))
        };
        let cues = [Cue::of_edges(edges.collect()), Cue::of_turns(self.turns.iter().enumerate().filter_map(turn).collect())];
        let Posterior { log, sigma, said } = Posterior::of(&cues, &logs, (libm::log(usual), prior_sigma(&self.camera)));
        let focal_px = libm::exp(log) * self.shrink as f64;
        FocalEstimate { focal_px, relative_sigma: sigma, pictures: said[0], turns: said[1], frames: self.frames }
    }
}

fn prior_sigma(camera: &Camera) -> f64 {
    match camera.source {
        IntrinsicsSource::PhonePrior { relative_sigma } | IntrinsicsSource::Measured { relative_sigma } => relative_sigma,
        IntrinsicsSource::Stated => 0.0,
    }
}

/// The picture so many times smaller: means of squares.
fn shrunk(image: &GrayImage, by: usize) -> GrayImage {
    let (data, width) = (image.data(), image.width());
    GrayImage::from_fn(width / by, image.height() / by, |u, v| {
        let rows = (0..by).map(|j| &data[(v * by + j) * width + u * by..][..by]);
        let sum: u32 = rows.flatten().map(|p| u32::from(*p)).sum();
        (sum / (by * by) as u32) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(pictures: usize, turns: usize) -> LensSample {
        let turned = |yaw: f64| UnitQuaternion::from_scaled_axis(nalgebra::Vector3::new(0.2, yaw, 0.0));
        let mut sample = LensSample::new(640, 480);
        let centre = Vector2::new(319.5, 239.5);
        let moved = |s: Segment| Segment { ends: s.ends.map(|end| end + centre), ..s };
        sample.pictures = (0..pictures as u64)
            .map(|seed| box_edges::tests::seen(seed, 50, &turned(0.35 + 0.02 * seed as f64), 0.3).into_iter().map(moved).collect())
            .collect();
        let way = nalgebra::Vector3::new(0.1, 0.0, -0.3);
        sample.turns = (0..turns as u64).map(|seed| turns::tests::pairs(seed, 0.15, way, 0.2)).collect();
        sample
    }

    #[test]
    fn edges_turns_and_both_show_a_lens_of_500_px() {
        for (pictures, turns) in [(15, 0), (0, 15), (15, 15)] {
            let lens = sample(pictures, turns).estimate(Seed(1));
            let off = libm::log(lens.focal_px / 500.0);
            assert!(off.abs() < 0.05 && off.abs() < 3.0 * lens.relative_sigma, "{pictures}, {turns}: {lens:?}");
            assert!(lens.relative_sigma < 0.06 && lens.is_measured(), "{lens:?}");
            let camera = lens.camera(640, 480);
            assert_eq!(camera.source, IntrinsicsSource::Measured { relative_sigma: lens.relative_sigma });
        }
    }

    #[test]
    fn a_video_that_shows_nothing_gives_a_phones_usual_camera() {
        let mut sample = LensSample::new(640, 480);
        for i in 0..40 {
            sample.push(&VideoFrame { stamp: Stamp(i * 100_000_000), image: GrayImage::from_fn(640, 480, |_, _| 90) });
        }
        let lens = sample.estimate(Seed(1));
        assert!(!lens.is_measured() && lens.frames == 40, "{lens:?}");
        let (camera, usual) = (lens.camera(640, 480), Camera::phone_prior(640, 480));
        assert!((camera.fx - usual.fx).abs() < 1e-9 && camera.source == usual.source, "{camera:?}");
    }

    #[test]
    fn large_pictures_are_looked_at_smaller_and_those_of_another_size_are_not() {
        let mut sample = LensSample::new(1920, 1080);
        assert_eq!((sample.shrink, sample.camera.width, sample.camera.height), (2, 960, 540));
        sample.push(&VideoFrame { stamp: Stamp(0), image: GrayImage::from_fn(640, 480, |_, _| 90) });
        assert_eq!(sample.frames, 0);
        sample.push(&VideoFrame { stamp: Stamp(1), image: GrayImage::from_fn(1920, 1080, |_, _| 90) });
        sample.push(&VideoFrame { stamp: Stamp(2), image: GrayImage::from_fn(1920, 1080, |_, _| 90) });
        assert_eq!(sample.frames, 1, "a frame that comes too soon is left out");
        assert!((sample.estimate(Seed(1)).focal_px - 0.78 * 1920.0).abs() < 1e-6);
        let squares = shrunk(&GrayImage::from_fn(4, 2, |u, _| if u < 2 { 10 } else { 20 }), 2);
        assert_eq!(squares.data(), [10, 20]);
    }
}
