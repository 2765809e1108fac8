//! Which points are followed from frame to frame? The front end: corners, followed by KLT, each with an id for life.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Camera, GrayImage};

use super::corners::{self, CornerOptions};
use super::grain;
use super::image::{Level, Pyramid};
use super::klt::{self, KltOptions};
use super::lines::{self, Edge, Segment};
use super::recall::descriptor::{Descriptor, Pattern};
use super::turn::{self, SmallPicture, Turn};
use super::view::View;

/// A point followed through the video.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrackId(pub u64);

/// Where a followed point is now.
#[derive(Debug, Clone, Copy)]
pub struct Track {
    /// Its name for life.
    pub id: TrackId,
    /// Pixel (u, v).
    pub pixel: (f64, f64),
    /// Unit ray, camera frame.
    pub ray: Vector3<f64>,
    /// Frames since it was found.
    pub age: u32,
}

/// Points under which a turn is a guess: what 1 to 4 points say of it, carried on, turns a camera by degrees a frame into the dark.
pub const FEW: usize = 8;
/// Pyramid levels: with 4, a patch of 11 px sees motions of ±40 px at full size.
const LEVELS: usize = 4;
/// Correlation over which two small pictures show the same, and under which they do not, however they are turned. (Uncut clips have 0.82
/// and more where most points are lost, cut ones 0.45 to 0.66: rooms are alike.)
const ALIKE: f64 = 0.85;
const PARTED: f64 = 0.75;

/// Share of the points up to which they count as lost, and then are looked for wherever a head may have turned.
const LOST: f64 = 0.35;
/// How far a point may be from where a turn alone has it: a step past something near.
const NEAR_RAD: f64 = 0.07;

/// The turns from the last picture to this one, the best first: the expected one or none, improved; where neither aligns the pictures,
/// all that a head can make. A head in the middle of a glance speeds up or slows down by more than what is found from the expected turn.
fn turned(camera: &Camera, last: &SmallPicture, now: &SmallPicture, expected: &UnitQuaternion<f64>) -> Vec<Turn> {
    let usual = turn::align(camera, last, now, &[*expected, UnitQuaternion::identity()]);
    if usual.is_some_and(|t| t.correlation > ALIKE) {
        return usual.into_iter().collect();
    }
    let mut turns = turn::search(camera, last, now);
    turns.extend(usual);
    turns.sort_by(|a, b| b.correlation.total_cmp(&a.correlation));
    turns
}

/// The newest picture.
#[derive(Debug)]
struct Seen {
    pyramid: Pyramid,
    small: SmallPicture,
    view: View,
}

/// Follows points; holds the last frame only.
#[derive(Debug)]
pub struct Tracker {
    camera: Camera,
    corners: CornerOptions,
    klt: KltOptions,
    last: Option<Seen>,
    tracks: Vec<Track>,
    next_id: u64,
    parted: bool,
    leap: Option<UnitQuaternion<f64>>,
}

impl Tracker {
    /// A tracker for images of this camera.
    pub fn new(camera: Camera) -> Self {
        // A cell a twentieth of the width: up to 300 corners at 4:3, whatever the resolution.
        let corners = CornerOptions { cell_px: (camera.width / 20).max(12), ..CornerOptions::default() };
        Self { camera, corners, klt: KltOptions::default(), last: None, tracks: Vec::new(), next_id: 0, parted: false, leap: None }
    }

    /// The points that are followed now.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// Follows all points into the next frame. `predict` says where a track's pixel should be now, as far as can be told, when
    /// it is told how the camera turned since the last frame (`now ← last`), if the pictures say so at all.
    pub fn advance<P: FnMut(&Track) -> Option<(f64, f64)>>(
        &mut self,
        image: &GrayImage,
        expected_turn: UnitQuaternion<f64>,
        predict: impl FnOnce(Option<UnitQuaternion<f64>>) -> P,
    ) {
        let next = Pyramid::new(image, LEVELS);
        let small = SmallPicture::new(next.smallest(), image.width());
        let mut turns = self.last.as_ref().map_or_else(Vec::new, |last| turned(&self.camera, &last.small, &small, &expected_turn));
        let turn = turns.first().copied();
        (self.parted, self.leap) = (turn.is_some_and(|t| t.correlation < PARTED), None);
        let mut predict = predict(turn.filter(|t| t.correlation > ALIKE).map(|t| t.now_from_last));
        if let Some(last) = &self.last {
            let kept = self.followed(&last.pyramid, &next, |track| predict(track));
            // People that fill the picture, each on a way of his own, look like another place.
            if let Some(turn) = self.parted.then(|| grain::turn_of_area(&self.camera, last.pyramid.smallest(), next.smallest())).flatten() {
                self.parted = false;
                turns.insert(0, turn);
            }
            let alike = turn.is_some_and(|t| t.correlation > ALIKE);
            if let Some((turn, again)) = self.leapt(last, &next, &turns, kept.len()) {
                (self.leap, self.tracks) = (Some(turn), again);
            } else {
                let blank = kept.len() < FEW && !alike;
                let grain = || grain::turn_of_blank(&self.camera, last.pyramid.smallest(), next.smallest());
                self.leap = blank.then(grain).flatten().map(|t| t.now_from_last);
                self.tracks = kept;
            }
            self.drop_crowded();
        }
        self.last = Some(Seen { view: View::of(&next), pyramid: next, small });
    }

    /// All points that are found in the next picture, each looked for where it is predicted, else where it was.
    fn followed(&self, last: &Pyramid, next: &Pyramid, mut predict: impl FnMut(&Track) -> Option<(f64, f64)>) -> Vec<Track> {
        let follow = |track: &Track| {
            let guess = predict(track).unwrap_or(track.pixel);
            let found = klt::follow(last, next, track.pixel, guess, &self.klt);
            // A prediction may be worse than none, when the head stops turning.
            let pixel = found.or_else(|| klt::follow(last, next, track.pixel, track.pixel, &self.klt))?;
            Some(Track { pixel, ray: self.camera.ray(pixel.0, pixel.1), age: track.age + 1, ..*track })
        };
        self.tracks.iter().filter_map(follow).collect()
    }

    /// Where most points were lost, but not by a turn that was looked for: the turn by which most of them are found again, and they.
    fn leapt(&self, last: &Seen, next: &Pyramid, turns: &[Turn], kept: usize) -> Option<(UnitQuaternion<f64>, Vec<Track>)> {
        if self.tracks.len() < FEW || kept as f64 > LOST * self.tracks.len() as f64 {
            return None;
        }
        let again = turns.iter().map(|Turn { now_from_last: turn, .. }| {
            let found = self.followed(&last.pyramid, next, |track| self.camera.project(&(turn * track.ray)).map(|p| (p.x, p.y)));
            // What was found elsewhere than that turn has it did not turn with the rest.
            let with: Vec<Track> =
                found.into_iter().filter(|t| self.tracks.iter().any(|b| b.id == t.id && (turn * b.ray).angle(&t.ray) < NEAR_RAD)).collect();
            let in_view = self.tracks.iter().filter(|t| self.sees(&(turn * t.ray))).count();
            (*turn, in_view, with)
        });
        let (turn, in_view, with) = again.max_by_key(|(_, _, with)| with.len())?;
        (with.len() >= FEW.max(2 * kept) && with.len() as f64 > LOST * in_view as f64).then_some((turn, with))
    }

    /// Whether a ray lies in the picture.
    pub fn sees(&self, ray: &Vector3<f64>) -> bool {
        let (width, height) = (self.camera.width as f64, self.camera.height as f64);
        self.camera.project(ray).is_some_and(|p| p.x >= 0.0 && p.y >= 0.0 && p.x < width && p.y < height)
    }

    /// The turn (`now ← last`) by which points were found again that the expected one had lost, or that a blank wall's grain made, if it
    /// took either to tell.
    pub fn leap(&self) -> Option<UnitQuaternion<f64>> {
        self.leap
    }

    /// How the newest picture is.
    pub fn view(&self) -> Option<View> {
        self.last.as_ref().map(|last| last.view)
    }

    /// Whether no turn makes the newest picture of the one before it: as on the two sides of a cut. Not of pictures that show too little
    /// to tell, or that have too little in common.
    pub fn parted(&self) -> bool {
        self.parted
    }

    /// Two tracks that ended on one spot follow one point: the older stays.
    fn drop_crowded(&mut self) {
        let near = (self.corners.cell_px as f64 / 6.0).powi(2);
        let mut order: Vec<usize> = (0..self.tracks.len()).collect();
        order.sort_by_key(|i| (std::cmp::Reverse(self.tracks[*i].age), self.tracks[*i].id));
        let mut kept: Vec<usize> = Vec::with_capacity(order.len());
        for i in order {
            let p = self.tracks[i].pixel;
            let crowded = kept.iter().any(|k| {
                let q = self.tracks[*k].pixel;
                (p.0 - q.0).powi(2) + (p.1 - q.1).powi(2) < near
            });
            if !crowded {
                kept.push(i);
            }
        }
        kept.sort_unstable();
        self.tracks = kept.into_iter().map(|i| self.tracks[i]).collect();
    }

    /// Looks for new corners where no point is followed; returns the new tracks.
    pub fn replenish(&mut self) -> Vec<Track> {
        let Some(Seen { pyramid: last, .. }) = &self.last else { return Vec::new() };
        let taken: Vec<(f64, f64)> = self.tracks.iter().map(|t| t.pixel).collect();
        let found = corners::detect(&last.levels[0], &taken, &self.corners);
        self.follow_from(&found)
    }

    /// Follows what is at these pixels from now on; returns the new tracks.
    pub fn follow_from(&mut self, pixels: &[(f64, f64)]) -> Vec<Track> {
        let track =
            |(pixel, id): (&(f64, f64), u64)| Track { id: TrackId(id), pixel: *pixel, ray: self.camera.ray(pixel.0, pixel.1), age: 0 };
        let fresh: Vec<Track> = pixels.iter().zip(self.next_id..).map(track).collect();
        self.next_id += fresh.len() as u64;
        self.tracks.extend(&fresh);
        fresh
    }

    /// Corners beside the followed points, more than would be followed: what was lost may be any of them. Pixels and unit rays.
    pub fn unfollowed(&self) -> Vec<((f64, f64), Vector3<f64>)> {
        let Some(Seen { pyramid: last, .. }) = &self.last else { return Vec::new() };
        let taken: Vec<(f64, f64)> = self.tracks.iter().map(|t| t.pixel).collect();
        let dense = CornerOptions { cell_px: self.corners.cell_px / 2, ..self.corners };
        let found = corners::detect(&last.levels[0], &taken, &dense);
        found.into_iter().map(|pixel| (pixel, self.camera.ray(pixel.0, pixel.1))).collect()
    }

    /// How these pixels of the newest picture look to a camera that leans by so much.
    pub fn describe(&self, pixels: impl Iterator<Item = (f64, f64)>, roll: f64) -> Vec<Option<Descriptor>> {
        let pattern = Pattern::new(roll);
        let pyramid = self.last.as_ref().map(|last| &last.pyramid);
        pixels.map(|pixel| pattern.describe(pyramid?, pixel)).collect()
    }

    /// Straight edges of the newest picture, found at half its size.
    pub fn edges(&self) -> Vec<Edge> {
        self.halved().map_or_else(Vec::new, |(level, shrink)| lines::edges(&self.camera, level, shrink))
    }

    /// The same as they are seen.
    pub fn segments(&self) -> Vec<Segment> {
        self.halved().map_or_else(Vec::new, |(level, shrink)| lines::segments(level, shrink))
    }

    /// The newest picture at half its size, and how many pixels one of it is wide.
    fn halved(&self) -> Option<(&Level, f64)> {
        let Seen { pyramid, .. } = self.last.as_ref()?;
        let level = pyramid.levels.get(1).unwrap_or(&pyramid.levels[0]);
        Some((level, self.camera.width as f64 / level.width as f64))
    }

    /// Stops following these.
    pub fn drop_tracks(&mut self, mut dead: impl FnMut(TrackId) -> bool) {
        self.tracks.retain(|t| !dead(t.id));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a camera turned by `world_from_camera` sees of a far world of squares of all greys, half a metre wide at ten metres.
    fn squares(camera: &Camera, world_from_camera: &UnitQuaternion<f64>) -> GrayImage {
        GrayImage::from_fn(camera.width, camera.height, |u, v| {
            let ray = world_from_camera * camera.ray(u as f64, v as f64);
            let (a, b) = ((20.0 * ray.x / ray.z).floor() as i64, (20.0 * ray.y / ray.z).floor() as i64);
            (60 + (a * 7919 + b * 104_729 + a * b * 31).rem_euclid(151)) as u8
        })
    }

    fn tracker_of(camera: &Camera, image: &GrayImage) -> Tracker {
        let mut tracker = Tracker::new(camera.clone());
        tracker.advance(image, UnitQuaternion::identity(), |_| |_: &Track| None);
        tracker.replenish();
        tracker
    }

    #[test]
    fn a_head_that_leaps_loses_no_more_points_than_leave_the_picture() {
        let camera = Camera::phone_prior(640, 480);
        let mut tracker = tracker_of(&camera, &squares(&camera, &UnitQuaternion::identity()));
        let before = tracker.tracks().to_vec();
        // 14° between two pictures, after standing still: 130 px, which no pyramid bridges.
        let turned = UnitQuaternion::from_scaled_axis(Vector3::new(0.02, 0.25, 0.0));
        tracker.advance(&squares(&camera, &turned), UnitQuaternion::identity(), |_| |_: &Track| None);
        let leap = tracker.leap().expect("the leap is told");
        assert!(leap.angle_to(&turned.inverse()) < 0.03, "half a small pixel: {}", leap.scaled_axis());
        let in_view = before.iter().filter(|t| tracker.sees(&(turned.inverse() * t.ray))).count();
        let right = |t: &&Track| before.iter().any(|b| b.id == t.id && (turned.inverse() * b.ray).angle(&t.ray) < 2e-3);
        let kept = tracker.tracks().iter().filter(right).count();
        // Patches at the border are lost, and those that the lens has stretched.
        assert!(2 * kept > in_view, "{kept} of {in_view} points that stay in the picture are where they must be");
        assert!(!tracker.parted(), "and this is no cut");
    }

    #[test]
    fn another_picture_is_no_leap() {
        let camera = Camera::phone_prior(640, 480);
        let mut tracker = tracker_of(&camera, &squares(&camera, &UnitQuaternion::identity()));
        let elsewhere = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 1.2, 0.0));
        tracker.advance(&squares(&camera, &elsewhere), UnitQuaternion::identity(), |_| |_: &Track| None);
        assert!(tracker.leap().is_none() && tracker.parted());
    }
}
