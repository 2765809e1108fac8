//! Which straight edges are in the picture? Line segments, as planes through the camera.
//!
//! level of the pyramid ─▶ gradient ─▶ regions of one direction ─▶ [`Edge`]s
//!
//! After LSD (von Gioi, Jakubowicz, Morel & Randall 2010, §2: regions grown by gradient direction, strongest first), with a plain
//! test of length, width and density in place of its count of false alarms.
//!
//! Pitfall: a codec draws edges of its own, along its blocks. They are weak, and left out by their gradient.

use nalgebra::{UnitQuaternion, Vector2, Vector3};
use planwalk_types::Camera;

use super::image::Level;

/// Least gradient, grey values a pixel: block edges and noise of usual video stay under it, the edge of a door does not.
const LEAST_GRADIENT: f32 = 5.0;
/// Cosine of how far a pixel's gradient may turn from its region's: 22.5°, as LSD.
const SAME_DIRECTION: f32 = 0.924;
/// Shortest segment, pixels of the level: its direction is then good to 2°.
const SHORTEST: f64 = 16.0;
/// Largest root mean square distance from the line, pixels of the level: an edge is two to three pixels wide.
const WIDEST: f64 = 1.2;
/// Least number of pixels per pixel of length.
const DENSEST: f64 = 1.0;
/// Noise of an end across the segment, pixels of the level.
const END_NOISE: f64 = 0.25;

/// A straight edge: the plane through it and the camera.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    /// Unit normal of the plane, camera frame.
    pub normal: Vector3<f64>,
    /// Ray to its middle, unit, camera frame.
    pub middle: Vector3<f64>,
    /// Angle that it spans, radians.
    pub length: f64,
    /// Noise of its ends across it, radians.
    pub sigma_rad: f64,
}

impl Edge {
    /// The same edge in the frame that a camera at `rotation` is seen from.
    pub fn turned(&self, rotation: &UnitQuaternion<f64>) -> Self {
        Self { normal: rotation * self.normal, middle: rotation * self.middle, ..*self }
    }

    /// How well the normal is known against this unit direction, radians: the ends' noise, longer by what lies beyond them.
    pub fn noise_towards(&self, direction: &Vector3<f64>) -> f64 {
        let along = self.middle.cross(direction).norm();
        self.sigma_rad * (0.5 + (2.0 * along / self.length).powi(2)).sqrt()
    }
}

/// A straight edge where it is seen: its ends, pixels of the full size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// The ends.
    pub ends: [Vector2<f64>; 2],
    /// Noise of either across the segment, pixels.
    pub sigma_px: f64,
}

impl Segment {
    /// The plane that it spans with this camera; `None` of one that is a point there.
    fn edge(&self, camera: &Camera) -> Option<Edge> {
        let [a, b] = self.ends.map(|end| camera.ray(end.x, end.y));
        Some(Edge {
            normal: a.cross(&b).try_normalize(1e-6)?,
            middle: (a + b).normalize(),
            length: a.angle(&b),
            sigma_rad: self.sigma_px / camera.focal_px(),
        })
    }
}

/// The straight edges of a level of the pyramid, whose pixels are `shrink` of the camera's wide.
pub fn edges(camera: &Camera, level: &Level, shrink: f64) -> Vec<Edge> {
    segments(level, shrink).iter().filter_map(|segment| segment.edge(camera)).collect()
}

/// The same as they are seen, whatever the camera.
pub fn segments(level: &Level, shrink: f64) -> Vec<Segment> {
    let gradients = Gradients::of(level);
    let mut taken = vec![false; gradients.size.len()];
    let mut segments = Vec::new();
    let mut region = Vec::new();
    for seed in gradients.strongest_first() {
        if taken[seed as usize] {
            continue;
        }
        gradients.grow(seed, &mut taken, &mut region);
        if let Some(ends) = gradients.segment(&region) {
            let ends = ends.map(|p| (p + Vector2::repeat(0.5)) * shrink - Vector2::repeat(0.5));
            segments.push(Segment { ends, sigma_px: END_NOISE * shrink });
        }
    }
    segments
}

/// Gradient between the pixels of a level: its size, and its direction as a unit vector.
struct Gradients {
    width: usize,
    size: Vec<f32>,
    direction: Vec<(f32, f32)>,
}

impl Gradients {
    fn of(level: &Level) -> Self {
        let (width, height) = (level.width.saturating_sub(1), level.height.saturating_sub(1));
        let (mut size, mut direction) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
        for v in 0..height {
            let (top, low) = (&level.data[v * level.width..], &level.data[(v + 1) * level.width..]);
            for u in 0..width {
                let (across, down) = (top[u + 1] - top[u], low[u + 1] - low[u]);
                let (x, y) = (0.5 * (across + down), 0.5 * (low[u] + low[u + 1] - top[u] - top[u + 1]));
                let norm = (x * x + y * y).sqrt();
                size.push(norm);
                direction.push(if norm > 0.0 { (x / norm, y / norm) } else { (0.0, 0.0) });
            }
        }
        Self { width, size, direction }
    }

    /// Pixels with an edge, the strongest first (to a grey value, as LSD; then in order of place).
    fn strongest_first(&self) -> Vec<u32> {
        let mut strong: Vec<u32> = (0..self.size.len() as u32).filter(|i| self.size[*i as usize] >= LEAST_GRADIENT).collect();
        strong.sort_by_key(|i| std::cmp::Reverse(self.size[*i as usize] as u32));
        strong
    }

    /// All pixels that hang together with the seed and have its direction.
    fn grow(&self, seed: u32, taken: &mut [bool], region: &mut Vec<u32>) {
        region.clear();
        region.push(seed);
        taken[seed as usize] = true;
        let mut sum = self.direction[seed as usize];
        let height = self.size.len() / self.width;
        let mut next = 0;
        while let Some(at) = region.get(next).map(|i| *i as usize) {
            next += 1;
            let (u, v) = (at % self.width, at / self.width);
            for y in v.saturating_sub(1)..(v + 2).min(height) {
                for x in u.saturating_sub(1)..(u + 2).min(self.width) {
                    let i = y * self.width + x;
                    if taken[i] || self.size[i] < LEAST_GRADIENT {
                        continue;
                    }
                    let d = self.direction[i];
                    let norm = (sum.0 * sum.0 + sum.1 * sum.1).sqrt();
                    if d.0 * sum.0 + d.1 * sum.1 < SAME_DIRECTION * norm {
                        continue;
                    }
                    taken[i] = true;
                    sum = (sum.0 + d.0, sum.1 + d.1);
                    region.push(i as u32);
                }
            }
        }
    }

    /// The line through a region, weighed by the gradient, from end to end, pixels of the level; `None` if it is none.
    fn segment(&self, region: &[u32]) -> Option<[Vector2<f64>; 2]> {
        if (region.len() as f64) < SHORTEST * DENSEST {
            return None;
        }
        // A gradient lies between four pixels.
        let at = |i: &u32| Vector2::new((*i as usize % self.width) as f64 + 0.5, (*i as usize / self.width) as f64 + 0.5);
        let weight = |i: &u32| f64::from(self.size[*i as usize]);
        let total: f64 = region.iter().map(weight).sum();
        let centre = region.iter().map(|i| at(i) * weight(i)).sum::<Vector2<f64>>() / total;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for i in region {
            let (off, w) = (at(i) - centre, weight(i) / total);
            xx += w * off.x * off.x;
            xy += w * off.x * off.y;
            yy += w * off.y * off.y;
        }
        let half_turn = 0.5 * libm::atan2(2.0 * xy, xx - yy);
        let (s, c) = libm::sincos(half_turn);
        let (along, across) = (Vector2::new(c, s), Vector2::new(-s, c));
        let width = region.iter().map(|i| weight(i) * across.dot(&(at(i) - centre)).powi(2)).sum::<f64>() / total;
        let reach = region.iter().map(|i| along.dot(&(at(i) - centre)));
        let (from, to) = reach.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let straight = width < WIDEST * WIDEST && to - from >= SHORTEST && region.len() as f64 >= DENSEST * (to - from);
        straight.then(|| [centre + along * from, centre + along * to])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene::uniform;
    use planwalk_types::Seed;

    /// A level that is dark on one side of a line and bright on the other, with noise, blurred by a pixel.
    fn half_plane(angle: f64, offset: f64, contrast: f64, noise: f64) -> Level {
        let mut rng = Seed(3).derive("lines", 0);
        let (width, height) = (160, 120);
        let mut data = Vec::with_capacity(width * height);
        for v in 0..height {
            for u in 0..width {
                let across = (v as f64 - 60.0) * angle.cos() - (u as f64 - 80.0) * angle.sin() - offset;
                let edge = (across / 1.5).clamp(-0.5, 0.5);
                data.push((100.0 + contrast * edge + noise * uniform(&mut rng, -1.7, 1.7)) as f32);
            }
        }
        Level { width, height, data }
    }

    #[test]
    fn an_edge_is_found_where_it_is() {
        let camera = Camera::phone_prior(320, 240);
        for (angle, offset) in [(0.0, 3.3), (0.3, -10.0), (1.2, 5.0), (-0.7, 0.0), (std::f64::consts::FRAC_PI_2, 7.2)] {
            let found = edges(&camera, &half_plane(angle, offset, 60.0, 1.0), 2.0);
            let longest = found.iter().max_by(|a, b| a.length.total_cmp(&b.length)).unwrap();
            let at = |along: f64| {
                let (u, v) = (80.0 + along * angle.cos() - offset * angle.sin(), 60.0 + along * angle.sin() + offset * angle.cos());
                camera.ray((u + 0.5) * 2.0 - 0.5, (v + 0.5) * 2.0 - 0.5)
            };
            // Half a pixel of the level over a hundred of length.
            let (a, b) = (longest.normal.dot(&at(-40.0)), longest.normal.dot(&at(40.0)));
            assert!(a.abs() < 3e-3 && b.abs() < 3e-3, "{angle} {offset}: {a} {b}");
            assert!(longest.length > 0.3, "{angle} {offset}: {}", longest.length);
        }
    }

    #[test]
    fn noise_and_blocks_are_no_edges() {
        let camera = Camera::phone_prior(320, 240);
        assert!(edges(&camera, &half_plane(0.0, 0.0, 0.0, 4.0), 2.0).is_empty(), "noise");
        let blocks = |u: usize, v: usize| 100.0 + 3.0 * ((u / 8 * 7 + v / 8 * 13) % 2) as f32;
        let data = (0..160 * 120).map(|i| blocks(i % 160, i / 160)).collect();
        assert!(edges(&camera, &Level { width: 160, height: 120, data }, 2.0).is_empty(), "blocks of three grey values");
        let blank = Level { width: 160, height: 120, data: vec![80.0; 160 * 120] };
        assert!(edges(&camera, &blank, 2.0).is_empty());
        assert!(edges(&camera, &Level { width: 1, height: 1, data: vec![1.0] }, 2.0).is_empty());
    }
}
