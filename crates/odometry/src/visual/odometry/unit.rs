//! How long is a unit of length, when all that had a distance has gone from view? As long as the floor says.

use nalgebra::Vector3;

use super::{Stage, VisualOdometry};
use crate::ground;
use crate::visual::map::KeyframeId;
use crate::visual::track::TrackId;

/// Points with a distance that hold the unit of length.
const UNIT_NEEDS: usize = 10;

impl VisualOdometry {
    /// Lays points on the floor and the ceiling; where these say that the unit of length was lost, it is put right.
    pub(super) fn keep_unit(&mut self, id: KeyframeId) {
        let up = self.compass.up();
        if self.in_view().filter(|l| l.has_depth()).count() < UNIT_NEEDS {
            self.map.planes.lose();
            self.unit_lost.get_or_insert(id);
            if self.map.planes.camera_height().is_none() {
                self.first_unit_ends.get_or_insert(id);
            }
        }
        let in_view: Vec<TrackId> = self.tracker.tracks().iter().map(|t| t.id).collect();
        if let Some(factor) = self.map.learn_planes(&up, &in_view) {
            if factor != 1.0 {
                self.regain_unit(factor);
            }
            self.unit_lost = None;
        }
        self.map.lay_on_planes(&up);
    }

    /// The floor is nearer, or farther, than it was: since nothing with a distance was seen, lengths are in another unit.
    fn regain_unit(&mut self, factor: f64) {
        let oldest = self.map.oldest_live(self.options.window);
        let since = self.unit_lost.unwrap_or(oldest);
        self.map.rescale(factor, since);
        self.memory.rescale(factor, since);
        self.rescale_links(factor, |k| k >= since);
        for posed in self.posed.iter_mut().rev().take_while(|p| p.reference >= Some(since)) {
            posed.reference_from_camera.translation.vector *= factor;
        }
        let stamp = self.map.keyframes[since.0].stamp;
        for seen in self.seen_points.iter_mut().rev().take_while(|s| s.stamp >= stamp) {
            *seen = seen.scaled(factor);
        }
        if let (Stage::Tracking(motion), Some(newest)) = (&mut self.stage, self.map.keyframes.last()) {
            motion.pose.translation = newest.pose.translation;
        }
        if let Stage::Tracking(motion) = &mut self.stage {
            motion.velocity *= factor;
            motion.usual_speed *= factor;
        }
    }

    /// Puts the walk's first lengths right, if their unit was lost before the floor was known: people start from standing, and
    /// who takes that for walking has another unit than he has later.
    pub(super) fn right_first_unit(&mut self, up: &Vector3<f64>) {
        let (Some(end), Some(height)) = (self.first_unit_ends, self.map.planes.camera_height()) else { return };
        let Some(stamp) = self.map.keyframes.get(end.0).map(|k| k.stamp) else { return };
        let first = self.seen_points.iter().take_while(|s| s.stamp < stamp);
        let offsets = first.filter_map(|s| {
            let at = self.map.keyframes.binary_search_by_key(&s.stamp, |k| k.stamp).ok()?;
            let offset = self.map.keyframes[at].pose.rotation * s.point;
            let rise = up.dot(&offset);
            Some(Vector3::new((offset - up * rise).norm(), 0.0, rise))
        });
        let Some(found) = ground::floor_below(offsets) else { return };
        self.map.rescale_before(height / found, end);
        self.rescale_links(height / found, |k| k < end);
        for posed in self.posed.iter_mut().take_while(|p| p.reference < Some(end)) {
            match posed.reference {
                Some(_) => posed.reference_from_camera.translation.vector *= height / found,
                None => posed.reference_from_camera.translation = self.map.keyframes[0].pose.translation,
            }
        }
        for seen in self.seen_points.iter_mut().take_while(|s| s.stamp < stamp) {
            *seen = seen.scaled(height / found);
        }
    }
}
