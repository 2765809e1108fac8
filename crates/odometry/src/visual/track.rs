//! Which points are followed from frame to frame? The front end: corners, followed by KLT, each with an id for life.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Camera, GrayImage};

use super::corners::{self, CornerOptions};
use super::image::{Level, Pyramid};
use super::klt::{self, KltOptions};
use super::lines::{self, Edge, Segment};
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
/// Correlation over which two small pictures show the same.
const ALIKE: f64 = 0.85;

/// A turn from one frame to the next that is more than a glance begins or ends with: 4°.
const FAST_TURN_RAD: f64 = 0.07;

/// The turn from the last picture to this one. A head in the middle of a glance speeds up or slows down by more than what is found
/// from the expected turn: where neither that nor none aligns the pictures, shares of it are tried.
fn turned(camera: &Camera, last: &SmallPicture, now: &SmallPicture, expected: &UnitQuaternion<f64>) -> Option<Turn> {
    let usual = turn::align(camera, last, now, &[*expected, UnitQuaternion::identity()]);
    if usual.is_some_and(|t| t.correlation > ALIKE) || expected.angle() < FAST_TURN_RAD {
        return usual;
    }
    let shares = [0.5, 1.5, 2.0].map(|share| UnitQuaternion::from_scaled_axis(expected.scaled_axis() * share));
    turn::align(camera, last, now, &shares).into_iter().chain(usual).max_by(|a, b| a.correlation.total_cmp(&b.correlation))
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
    likeness: Option<f64>,
}

impl Tracker {
    /// A tracker for images of this camera.
    pub fn new(camera: Camera) -> Self {
        // A cell a twentieth of the width: up to 300 corners at 4:3, whatever the resolution.
        let corners = CornerOptions { cell_px: (camera.width / 20).max(12), ..CornerOptions::default() };
        Self { camera, corners, klt: KltOptions::default(), last: None, tracks: Vec::new(), next_id: 0, likeness: None }
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
        let small = SmallPicture::new(&next.levels[next.levels.len() - 1], image.width());
        let turn = self.last.as_ref().and_then(|last| turned(&self.camera, &last.small, &small, &expected_turn));
        self.likeness = turn.map(|t| t.correlation);
        let mut predict = predict(turn.filter(|t| t.correlation > ALIKE).map(|t| t.now_from_last));
        if let Some(Seen { pyramid: last, .. }) = &self.last {
            let mut kept = Vec::with_capacity(self.tracks.len());
            for track in &self.tracks {
                let guess = predict(track).unwrap_or(track.pixel);
                let found = klt::follow(last, &next, track.pixel, guess, &self.klt);
                // A prediction may be worse than none, when the head stops turning.
                let found = found.or_else(|| klt::follow(last, &next, track.pixel, track.pixel, &self.klt));
                if let Some(pixel) = found {
                    kept.push(Track { pixel, ray: self.camera.ray(pixel.0, pixel.1), age: track.age + 1, ..*track });
                }
            }
            self.tracks = kept;
            self.drop_crowded();
        }
        self.last = Some(Seen { view: View::of(&next), pyramid: next, small });
    }

    /// How the newest picture is.
    pub fn view(&self) -> Option<View> {
        self.last.as_ref().map(|last| last.view)
    }

    /// Correlation of the newest two pictures after the turn that aligns them best; `None` of pictures that show too little to tell,
    /// or that have too little in common.
    pub fn likeness(&self) -> Option<f64> {
        self.likeness
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
        let fresh: Vec<Track> = found
            .into_iter()
            .zip(self.next_id..)
            .map(|(pixel, id)| Track { id: TrackId(id), pixel, ray: self.camera.ray(pixel.0, pixel.1), age: 0 })
            .collect();
        self.next_id += fresh.len() as u64;
        self.tracks.extend(&fresh);
        fresh
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
