//! What does the camera see from here? One exact ray a pixel, against walls found by direction.
//!
//! Everything upright: which faces a ray can meet depends on its direction on the floor alone. So each frame first sorts the
//! faces into bins of direction and drops those hidden behind a wall; a pixel's ray then tests the few faces of its bin,
//! the floor and the ceiling. Pixels on an outline are averaged over four rays; surfaces average themselves (see `texture`).
//!
//! Frames: plan metres; `ray` in the camera frame, scaled to z = 1 where it points forward, so that a step of one pixel
//! moves it by 1/f; of length 1 behind a fisheye, where each pixel has its own step.

use nalgebra::{Matrix3, Vector3};
use planwalk_types::{Cam, Camera, Distortion, Plan, Rigid3};
use rayon::prelude::*;

use crate::texture::{self, Spot};
use crate::world::{Cast, Face, Met, SolidKind, World};

/// Bins of direction around the whole horizon: about 0.18° each, two or three pixels of an ordinary camera.
pub(crate) const BINS: usize = 2048;
/// Slack at the ends of faces, metres: closes the seams that round-off would open between neighbours.
const SEAM_M: f64 = 1e-5;

/// Draws pictures of a world for one camera.
#[derive(Debug, Clone)]
pub(crate) struct Renderer {
    camera: Camera,
    /// Ray of each pixel, row by row.
    rays: Vec<[f32; 3]>,
}

/// What a ray met, for finding outlines: a face, its lid, a limb of somebody, the floor, the ceiling.
pub(crate) type Surface = u32;
const FLOOR: Surface = u32::MAX;
const CEILING: Surface = u32::MAX - 1;
const LID: Surface = 1 << 31;
/// Marks the limbs of people.
pub(crate) const LIMB: Surface = 1 << 30;

/// What can be met in each direction from one place at one moment.
pub(crate) struct Stage {
    bins: Vec<Vec<u32>>,
    cast: Cast,
}

impl Stage {
    pub fn new(world: &World, cast: Cast, eye: [f64; 2]) -> Self {
        Self { bins: bins(&world.faces, eye), cast }
    }
}

/// A pose, and what can be met from there. The eye may be a millimetre from where the stage was set: a bin's slack.
pub(crate) struct View<'a> {
    world: &'a World,
    stage: &'a Stage,
    eye: [f64; 3],
    plan_from_camera: Matrix3<f64>,
    grain: Grain,
}

/// Change of a ray from one pixel to the next, along a row and along a column, plan axes.
#[derive(Clone, Copy)]
struct Grain {
    du: [f64; 3],
    dv: [f64; 3],
}

/// A ray and how far along it the first wall stands; infinite where it ends at the floor or the ceiling.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sightline {
    /// Plan axes.
    pub direction: [f64; 3],
    pub t: f64,
}

/// The view of each line of a picture: one for all, one for each row, or one for each column.
pub(crate) struct Lines<'a> {
    pub views: Vec<View<'a>>,
    /// How the index of the view grows from column to column and from row to row: 0 or 1.
    pub step: [usize; 2],
}

impl<'a> Lines<'a> {
    fn at(&self, u: usize, v: usize) -> &View<'a> {
        &self.views[u * self.step[0] + v * self.step[1]]
    }
}

impl Renderer {
    pub fn new(camera: Camera) -> Self {
        let (width, height) = (camera.width, camera.height);
        let rays =
            (0..width * height).into_par_iter().map(|i| ray(&camera, (i % width) as f64, (i / width) as f64).map(|c| c as f32)).collect();
        Self { camera, rays }
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Brightness of every pixel. The same on any number of threads: rows do not share anything.
    pub fn draw(&self, lines: &Lines) -> Vec<f32> {
        let (width, height) = (self.camera.width, self.camera.height);
        let pixels = self.shade(lines);
        let mut values = vec![0f32; width * height];
        values.par_chunks_mut(width).enumerate().for_each(|(v, row)| {
            for (u, out) in row.iter_mut().enumerate() {
                let (value, surface) = pixels[v * width + u];
                *out = if on_outline(&pixels, width, height, u, v, surface) { self.smooth(lines.at(u, v), u, v) } else { value };
            }
        });
        values
    }

    /// Brightness along the ray through every pixel's middle, and what it met.
    pub fn shade(&self, lines: &Lines) -> Vec<(f32, Surface)> {
        let width = self.camera.width;
        let mut pixels = vec![(0.0f32, 0 as Surface); self.rays.len()];
        pixels.par_chunks_mut(width).zip(self.rays.par_chunks(width)).enumerate().for_each(|(v, (row, rays))| {
            for (u, (pixel, ray)) in row.iter_mut().zip(rays).enumerate() {
                let view = lines.at(u, v);
                *pixel = view.shade(ray.map(f64::from), &self.grain(view, u, v));
            }
        });
        pixels
    }

    /// Along the ray through every pixel's middle: how far the walls let one see.
    pub fn sightlines(&self, view: &View) -> Vec<Sightline> {
        let line = |ray: &[f32; 3]| {
            let direction = view.turned(ray.map(f64::from));
            Sightline { direction, t: view.nearest_face(direction, bin(direction)).0 }
        };
        self.rays.iter().map(line).collect()
    }

    /// Mean over four rays inside the pixel.
    fn smooth(&self, view: &View, u: usize, v: usize) -> f32 {
        // A rotated square: four different columns and four different rows for edges along either.
        let offsets = [(-0.375, -0.125), (0.125, -0.375), (0.375, 0.125), (-0.125, 0.375)];
        let grain = self.grain(view, u, v);
        let inside = |(a, b): (f64, f64)| match self.steps(u, v) {
            None => ray(&self.camera, u as f64 + a, v as f64 + b),
            Some([along, down]) => {
                let middle = self.rays[v * self.camera.width + u];
                std::array::from_fn(|i| f64::from(middle[i]) + a * along[i] + b * down[i])
            }
        };
        offsets.map(|offset| view.shade(inside(offset), &grain).0).iter().sum::<f32>() * 0.25
    }

    /// How far one pixel's ray is from its neighbours': the same everywhere where the lens bends nothing, else each pixel's own.
    fn grain(&self, view: &View, u: usize, v: usize) -> Grain {
        match self.steps(u, v) {
            None => view.grain,
            Some([along, down]) => Grain { du: view.turned(along), dv: view.turned(down) },
        }
    }

    /// Change of the ray from a pixel to the next one along its row and down its column, camera axes; `None` where the lens bends
    /// nothing and all pixels have the same.
    fn steps(&self, u: usize, v: usize) -> Option<[[f64; 3]; 2]> {
        if self.camera.distortion == Distortion::NONE {
            return None;
        }
        let (width, height) = (self.camera.width, self.camera.height);
        let (i, j) = (u.min(width - 2), v.min(height - 2));
        let between = |a: usize, b: usize| std::array::from_fn(|k| f64::from(self.rays[b][k] - self.rays[a][k]));
        Some([between(v * width + i, v * width + i + 1), between(j * width + u, (j + 1) * width + u)])
    }
}

/// The ray of a pixel: one metre deep where the lens is nearly straight, unit where it is a fisheye.
pub(crate) fn ray(camera: &Camera, u: f64, v: f64) -> [f64; 3] {
    let unit = camera.ray(u, v);
    let straight = matches!(camera.distortion, Distortion::RadTan { .. });
    let scale = if straight && unit.z > 0.05 { 1.0 / unit.z } else { 1.0 };
    [unit.x * scale, unit.y * scale, unit.z * scale]
}

fn on_outline(pixels: &[(f32, Surface)], width: usize, height: usize, u: usize, v: usize, surface: Surface) -> bool {
    let differs = |u: usize, v: usize| pixels[v * width + u].1 != surface;
    (u > 0 && differs(u - 1, v))
        || (u + 1 < width && differs(u + 1, v))
        || (v > 0 && differs(u, v - 1))
        || (v + 1 < height && differs(u, v + 1))
}

/// Direction on the floor as a number in 0..4 that grows anticlockwise; cheaper than an angle.
#[inline]
pub(crate) fn diamond(dx: f64, dy: f64) -> f64 {
    let t = dy / (dx.abs() + dy.abs()).max(1e-12);
    if dx < 0.0 {
        2.0 - t
    } else if t < 0.0 {
        4.0 + t
    } else {
        t
    }
}

/// The bin of a ray.
#[inline]
pub(crate) fn bin(d: [f64; 3]) -> usize {
    (diamond(d[0], d[1]) * (BINS as f64 / 4.0)) as usize % BINS
}

/// The direction with this number.
fn direction(diamond: f64) -> [f64; 2] {
    let d = diamond.rem_euclid(4.0);
    let x = if d <= 2.0 { 1.0 - d } else { d - 3.0 };
    let y = if d <= 1.0 {
        d
    } else if d <= 3.0 {
        2.0 - d
    } else {
        d - 4.0
    };
    let norm = (x * x + y * y).sqrt();
    [x / norm, y / norm]
}

impl<'a> View<'a> {
    pub fn new(world: &'a World, stage: &'a Stage, plan_from_camera: &Rigid3<Plan, Cam>, camera: &Camera) -> Self {
        let rotation = plan_from_camera.iso.rotation.to_rotation_matrix().into_inner();
        let eye = plan_from_camera.iso.translation.vector;
        let along = |axis: Vector3<f64>| {
            let d = rotation * axis;
            [d.x, d.y, d.z]
        };
        let grain = Grain { du: along(Vector3::x() / camera.fx), dv: along(Vector3::y() / camera.fy) };
        Self { world, stage, eye: [eye.x, eye.y, eye.z], plan_from_camera: rotation, grain }
    }

    /// A direction of the camera in plan axes.
    fn turned(&self, ray: [f64; 3]) -> [f64; 3] {
        let d = self.plan_from_camera * Vector3::new(ray[0], ray[1], ray[2]);
        [d.x, d.y, d.z]
    }

    /// Brightness along a ray of the camera, and what it met.
    fn shade(&self, ray: [f64; 3], grain: &Grain) -> (f32, Surface) {
        let d = self.turned(ray);
        let bin = bin(d);
        let (t, index, from_behind) = self.nearest_face(d, bin);
        // Nobody is seen through the floor.
        let limit = if d[2] < 0.0 { t.min(-self.eye[2] / d[2]) } else { t };
        if let Some(limb) = self.stage.cast.meet(bin, d, limit) {
            return (self.skin(&limb, d, grain), limb.surface);
        }
        if t == f64::INFINITY {
            return self.level(d, grain);
        }
        let face = &self.world.faces[index as usize];
        if from_behind { (self.lid(face, d, grain), index | LID) } else { (self.upright(face, d, t, grain), index) }
    }

    /// The first face along a ray: how far along it, which one, and whether it was met from behind.
    fn nearest_face(&self, d: [f64; 3], bin: usize) -> (f64, u32, bool) {
        let eye = self.eye;
        let mut nearest = (f64::INFINITY, 0u32, false);
        for &index in &self.stage.bins[bin] {
            let face = &self.world.faces[index as usize];
            let toward = d[0] * face.n[0] + d[1] * face.n[1];
            let t = ((face.a[0] - eye[0]) * face.n[0] + (face.a[1] - eye[1]) * face.n[1]) / toward;
            // Not "t <= 0": a ray along the face gives NaN.
            if !(t > 0.0 && t < nearest.0) {
                continue;
            }
            let s = (eye[0] + t * d[0] - face.a[0]) * face.e[0] + (eye[1] + t * d[1] - face.a[1]) * face.e[1];
            let z = eye[2] + t * d[2];
            let met = s >= -SEAM_M && s <= face.length + SEAM_M && z >= face.z[0] && z <= face.z[1];
            // A wall has no lid that could be seen: its back faces are other walls' insides.
            if met && (toward < 0.0 || face.kind != SolidKind::Wall) {
                nearest = (t, index, toward > 0.0);
            }
        }
        nearest
    }

    /// A limb: its cloth, lit from above.
    fn skin(&self, limb: &Met, d: [f64; 3], grain: &Grain) -> f32 {
        let pixel = (0.5 * (dot(grain.du, grain.du) + dot(grain.dv, grain.dv))).sqrt() * limb.t;
        // Seen at a slant a pixel covers more of the cloth.
        let slant = (-dot(limb.normal, d) / dot(d, d).sqrt()).clamp(0.15, 1.0);
        let (x, y) = (self.eye[0] + limb.t * d[0], self.eye[1] + limb.t * d[1]);
        limb.brightness((pixel / slant) as f32) * self.world.light.at(x, y)
    }

    /// A face, met from in front.
    fn upright(&self, face: &Face, d: [f64; 3], t: f64, grain: &Grain) -> f32 {
        let (n, e) = (face.n, face.e);
        let toward = d[0] * n[0] + d[1] * n[1];
        let (x, y) = (self.eye[0] + t * d[0], self.eye[1] + t * d[1]);
        let z = self.eye[2] + t * d[2];
        let s = (x - face.a[0]) * e[0] + (y - face.a[1]) * e[1];
        let along = d[0] * e[0] + d[1] * e[1];
        // How the hit moves along the face when the ray moves by one pixel.
        let moved = |delta: [f64; 3]| {
            let lag = (delta[0] * n[0] + delta[1] * n[1]) / toward;
            (t * (delta[0] * e[0] + delta[1] * e[1] - along * lag), t * (delta[2] - d[2] * lag))
        };
        let (a, b) = (moved(grain.du), moved(grain.dv));
        let spot = Spot { u: s as f32, v: z as f32, fu: (a.0.abs() + b.0.abs()) as f32, fv: (a.1.abs() + b.1.abs()) as f32 };
        let light = self.world.light.at(x + 0.2 * n[0], y + 0.2 * n[1]);
        // Sides differ a little, or corners of a room would vanish.
        let side = 0.95 + 0.06 * n[0] as f32 + 0.03 * n[1] as f32;
        let edge = |distance: f32, depth: f32| 1.0 - depth / (1.0 + (distance / 0.12) * (distance / 0.12));
        let top = if face.z[1] >= self.world.height_m { (self.world.height_m - z) as f32 } else { 9.0 };
        // Corners darken, the edges of doorways do not.
        let to_corner = |distance: f64, jamb: bool| if jamb { 9.0 } else { distance.max(0.0) };
        let end = to_corner(s, face.jamb[0]).min(to_corner(face.length - s, face.jamb[1])) as f32;
        let corner = if face.full && face.length > 0.3 { edge(end, 0.10) } else { 1.0 };
        texture::face(face, spot) * light * side * edge(z as f32, 0.2) * edge(top, 0.15) * corner
    }

    /// The top or bottom of a box whose side was met from behind.
    fn lid(&self, face: &Face, d: [f64; 3], grain: &Grain) -> f32 {
        let z = if self.eye[2] > face.z[1] { face.z[1] } else { face.z[0] };
        let (t, x, y, spot) = self.flat(d, z, grain);
        if t <= 0.0 {
            return 0.0;
        }
        let shadow = if z == face.z[0] { 0.6 } else { 1.0 };
        texture::lid(face.kind, spot) * self.world.light.at(x, y) * shadow
    }

    /// The floor or the ceiling.
    fn level(&self, d: [f64; 3], grain: &Grain) -> (f32, Surface) {
        let down = d[2] < 0.0;
        let (t, x, y, spot) = self.flat(d, if down { 0.0 } else { self.world.height_m }, grain);
        let light = &self.world.light;
        let surface = if down { FLOOR } else { CEILING };
        let room = light.room(x, y);
        let (Some(room), true) = (room, t.is_finite() && t > 0.0) else {
            // Outdoors: seen only through what is left open.
            return (if down { 0.5 } else { 1.0 }, surface);
        };
        if down {
            return (texture::floor(light.kinds[room], spot) * light.at(x, y), surface);
        }
        let mut value = texture::ceiling(spot) * (0.45 + 0.5 * light.at(x, y));
        for lamp in &light.lamps[room] {
            let share = texture::share_in(spot, lamp.low, lamp.high);
            value += share * (1.25 - value);
        }
        (value, surface)
    }

    /// Where a ray meets the level plane at height `z`: distance along the ray, place, and the pixel's spot there.
    fn flat(&self, d: [f64; 3], z: f64, grain: &Grain) -> (f64, f64, f64, Spot) {
        let t = (z - self.eye[2]) / d[2];
        let (x, y) = (self.eye[0] + t * d[0], self.eye[1] + t * d[1]);
        let moved = |delta: [f64; 3]| {
            let lag = delta[2] / d[2];
            (t * (delta[0] - d[0] * lag), t * (delta[1] - d[1] * lag))
        };
        let (a, b) = (moved(grain.du), moved(grain.dv));
        let spot = Spot { u: x as f32, v: y as f32, fu: (a.0.abs() + b.0.abs()) as f32, fv: (a.1.abs() + b.1.abs()) as f32 };
        (t, x, y, spot)
    }
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// For each bin of direction, the faces that a ray from `eye` in it may meet first.
fn bins(faces: &[Face], eye: [f64; 2]) -> Vec<Vec<u32>> {
    let mut bins: Vec<Vec<u32>> = vec![Vec::new(); BINS];
    for (index, face) in faces.iter().enumerate() {
        let (ax, ay) = (face.a[0] - eye[0], face.a[1] - eye[1]);
        let (bx, by) = (ax + face.length * face.e[0], ay + face.length * face.e[1]);
        // Backs of walls are never seen.
        if face.kind == SolidKind::Wall && ax * face.n[0] + ay * face.n[1] >= 0.0 {
            continue;
        }
        let (from, to) = if ax * by - ay * bx >= 0.0 { (diamond(ax, ay), diamond(bx, by)) } else { (diamond(bx, by), diamond(ax, ay)) };
        // One bin more on each side: round-off and the seam.
        let first = (from * (BINS as f64 / 4.0)) as usize + BINS - 1;
        let span = ((to - from).rem_euclid(4.0) * (BINS as f64 / 4.0)) as usize + 4;
        for k in 0..span.min(BINS) {
            bins[(first + k) % BINS].push(index as u32);
        }
    }
    for (k, bin) in bins.iter_mut().enumerate() {
        drop_hidden(bin, faces, eye, k);
    }
    bins
}

/// Drops the faces that lie wholly behind one from floor to ceiling that fills the bin.
fn drop_hidden(bin: &mut Vec<u32>, faces: &[Face], eye: [f64; 2], k: usize) {
    let edges = [direction(k as f64 * 4.0 / BINS as f64), direction((k + 1) as f64 * 4.0 / BINS as f64)];
    let hit = |face: &Face, d: [f64; 2]| {
        let toward = d[0] * face.n[0] + d[1] * face.n[1];
        let t = ((face.a[0] - eye[0]) * face.n[0] + (face.a[1] - eye[1]) * face.n[1]) / toward;
        let s = (eye[0] + t * d[0] - face.a[0]) * face.e[0] + (eye[1] + t * d[1] - face.a[1]) * face.e[1];
        (t, s)
    };
    let mut limit = f64::INFINITY;
    for face in bin.iter().map(|i| &faces[*i as usize]).filter(|f| f.full) {
        let hits = edges.map(|d| hit(face, d));
        if hits.iter().all(|(t, s)| *t > 0.0 && *s >= 0.0 && *s <= face.length) {
            limit = limit.min(hits[0].0.max(hits[1].0));
        }
    }
    bin.retain(|i| {
        let face = &faces[*i as usize];
        let hits = edges.map(|d| hit(face, d));
        let (mut low, mut high) = (0.0, face.length);
        if hits.iter().all(|(t, s)| *t > 0.0 && s.is_finite()) {
            low = hits[0].1.min(hits[1].1).clamp(0.0, face.length);
            high = hits[0].1.max(hits[1].1).clamp(0.0, face.length);
        }
        // Nearest place of the part that the bin shows.
        let foot = ((eye[0] - face.a[0]) * face.e[0] + (eye[1] - face.a[1]) * face.e[1]).clamp(low, high);
        let near = libm::hypot(face.a[0] + foot * face.e[0] - eye[0], face.a[1] + foot * face.e[1] - eye[1]);
        near <= limit + 1e-6
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_comes_back_from_its_number() {
        for k in 0..400 {
            let number = k as f64 * 0.01;
            let [x, y] = direction(number);
            assert!((diamond(x, y) - number).abs() < 1e-9, "{number}");
        }
    }
}
