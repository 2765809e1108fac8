//! What did the last metres look like, as one piece? Motion and sightings of the newest updates, in the frame of their middle.
//!
//! update after update ──[`Window::push`]──▶ the last metres ──[`Window::scene`]──▶ rays and way around one reference pose
//!
//! Odometry over some metres is stiff: it drifts by less than walls and noise blur. The reference is in the middle, so that
//! headings and scales that are a little off move the ends by half as much.

use std::collections::VecDeque;

use crate::likelihood::Ray;
use crate::motion::Motion;

/// Way kept, in the odometry's unit times the prior's metres: what a look may want.
pub(super) const KEPT_M: f64 = 24.0;

/// One update of the filter.
#[derive(Debug, Clone)]
struct Entry {
    motion: Motion,
    /// In the body frame at the update's end.
    rays: Vec<Ray>,
}

/// The newest updates.
#[derive(Debug, Clone, Default)]
pub(crate) struct Window {
    entries: VecDeque<Entry>,
}

/// Rays and way in the body frame of the reference pose, odometry's unit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scene {
    pub rays: Vec<Ray>,
    /// Where the body was, update by update.
    pub way: Vec<(f64, f64)>,
    /// From the reference pose to the newest one.
    pub to_end: Motion,
    /// What the filter itself would have counted: rays after its own thinning.
    pub counted: usize,
}

impl Window {
    /// Adds an update; `metres_per_unit` says what is too old to keep.
    pub(crate) fn push(&mut self, motion: Motion, rays: &[Ray], metres_per_unit: f64) {
        self.entries.push_back(Entry { motion, rays: rays.to_vec() });
        let mut way = 0.0;
        let keep = self.entries.iter().rev().take_while(|e| {
            way += way_of(&e.motion, metres_per_unit);
            way <= KEPT_M
        });
        let keep = keep.count().max(1);
        self.entries.drain(..self.entries.len() - keep);
    }

    /// The newest `way_m` metres as one piece, with at most `most` rays; `None` while nothing was seen.
    pub(crate) fn scene(&self, way_m: f64, metres_per_unit: f64, most: usize) -> Option<Scene> {
        let (mut way, mut count) = (0.0, 0);
        for entry in self.entries.iter().rev() {
            // An entry's rays are of its end: the motion that led there is not part of the window.
            count += 1;
            way += way_of(&entry.motion, metres_per_unit);
            if way > way_m {
                break;
            }
        }
        let entries: Vec<&Entry> = self.entries.iter().skip(self.entries.len() - count).collect();
        let counted: usize = entries.iter().map(|e| e.rays.len()).sum();
        if counted == 0 {
            return None;
        }
        // Poses of all entries as seen from the first.
        let mut poses = vec![Pose::default()];
        for entry in &entries[1..] {
            let last = poses[poses.len() - 1];
            poses.push(last.moved(&entry.motion));
        }
        let middle = middle_of(&entries);
        let reference = poses[middle];
        let way = poses.iter().map(|p| reference.sees(p.x, p.y)).collect();
        let mut to_end = Motion::none();
        for entry in &entries[middle + 1..] {
            to_end = to_end.then(&entry.motion);
        }
        let all = poses.iter().zip(&entries).flat_map(|(pose, entry)| {
            entry.rays.iter().map(|ray| Ray {
                from: reference.sees_of(pose, ray.from),
                to: reference.sees_of(pose, ray.to),
                sigma: ray.sigma,
            })
        });
        let all: Vec<Ray> = all.collect();
        let rays = evenly(all.len().min(most), all.len()).map(|i| all[i]).collect();
        Some(Scene { rays, way, to_end, counted })
    }
}

/// `count` indices, evenly over `of`.
pub(crate) fn evenly(count: usize, of: usize) -> impl Iterator<Item = usize> {
    (0..count).map(move |i| (2 * i + 1) * of / (2 * count))
}

/// Way that an update counts for. Turning on the spot counts too: whoever only turns must not fill the memory.
pub(crate) fn way_of(motion: &Motion, metres_per_unit: f64) -> f64 {
    (motion.length * metres_per_unit).max(0.1)
}

/// The entry nearest to half of the way.
fn middle_of(entries: &[&Entry]) -> usize {
    let whole: f64 = entries.iter().skip(1).map(|e| e.motion.length).sum();
    let mut way = 0.0;
    for (i, entry) in entries.iter().enumerate().skip(1) {
        way += entry.motion.length;
        if way >= 0.5 * whole {
            return i;
        }
    }
    entries.len() - 1
}

/// A pose on the odometry's floor.
#[derive(Debug, Clone, Copy, Default)]
struct Pose {
    x: f64,
    y: f64,
    heading: f64,
}

impl Pose {
    fn moved(self, motion: &Motion) -> Self {
        let (s, c) = libm::sincos(self.heading);
        Self {
            x: self.x + c * motion.forward - s * motion.left,
            y: self.y + s * motion.forward + c * motion.left,
            heading: self.heading + motion.turn_rad,
        }
    }

    /// A point of the common frame in this pose's own.
    fn sees(self, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = libm::sincos(self.heading);
        let (dx, dy) = (x - self.x, y - self.y);
        (c * dx + s * dy, -s * dx + c * dy)
    }

    /// A point of another pose's frame in this one's.
    fn sees_of(self, other: &Pose, (x, y): (f64, f64)) -> (f64, f64) {
        let (s, c) = libm::sincos(other.heading);
        self.sees(other.x + c * x - s * y, other.y + s * x + c * y)
    }
}
