//! What does a ray meet of a person? A head, a trunk, arms and legs: capsules in clothes whose pattern moves with the limb.
//!
//! Frames: a figure's own axes are x forward, y left, z up from the floor under it, metres. A capsule may be flattened from front
//! to back: rays are then squeezed alike, which leaves their parameter as it is.

use crate::render::{BINS, LIMB, Surface, diamond};
use crate::texture::{Spot, band, cell, hash, lines, mosaic, noise};

/// Radius of the upright cylinder that holds a walking figure, metres.
const REACH_M: f64 = 0.62;
/// Angle of the legs' swing at 1.2 m/s, radians: steps of about 0.7 m.
const SWING_RAD: f64 = 0.42;

/// Somebody at one moment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Posture {
    pub x: f64,
    pub y: f64,
    pub heading_rad: f64,
    pub speed_mps: f64,
    /// Steps walked so far; whole numbers are footfalls.
    pub steps: f64,
}

/// Who it is: height and clothes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body {
    pub height_m: f64,
    pub seed: u32,
}

/// What a limb is covered with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cover {
    Skin,
    Head,
    Shirt,
    Trousers,
    Shoe,
    Bag,
}

/// One limb, in the figure's axes squeezed by `squeeze` along x.
#[derive(Debug, Clone, Copy)]
struct Limb {
    a: [f64; 3],
    axis: [f64; 3],
    length2: f64,
    radius: f64,
    squeeze: f64,
    cover: Cover,
}

/// A posed body.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    x: f64,
    y: f64,
    cos: f64,
    sin: f64,
    seed: u32,
    limbs: Vec<Limb>,
    id: u32,
}

/// Where a ray met a limb.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Met {
    /// How far along the ray.
    pub t: f64,
    /// Outward normal, plan axes.
    pub normal: [f64; 3],
    pub surface: Surface,
    /// The same normal in the figure's axes.
    own: [f64; 3],
    /// Along the limb and around it, metres.
    along: f64,
    around: f64,
    cover: Cover,
    seed: u32,
}

/// Everybody who can be seen from one place at one moment.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cast {
    figures: Vec<Figure>,
    /// For each bin of direction, who may be met there; empty when nobody is there at all.
    bins: Vec<Vec<u16>>,
}

impl Cast {
    /// These people as they are seen from `eye`.
    pub fn new(figures: Vec<Figure>, eye: [f64; 2]) -> Self {
        if figures.is_empty() {
            return Self::default();
        }
        let mut bins = vec![Vec::new(); BINS];
        for (k, figure) in figures.iter().enumerate() {
            let (first, count) = directions(figure.x - eye[0], figure.y - eye[1]);
            for bin in first..first + count {
                bins[bin % BINS].push(k as u16);
            }
        }
        Self { figures, bins }
    }

    /// The first limb that a ray in a bin of direction meets nearer than `limit`.
    pub fn meet(&self, bin: usize, eye: [f64; 3], d: [f64; 3], limit: f64) -> Option<Met> {
        let mut nearest: Option<Met> = None;
        for k in self.bins.get(bin)? {
            let limit = nearest.as_ref().map_or(limit, |met| met.t);
            nearest = self.figures[usize::from(*k)].meet(eye, d, limit).or(nearest);
        }
        nearest
    }
}

/// The bins that a figure at this place may fill: the first one and their number.
fn directions(dx: f64, dy: f64) -> (usize, usize) {
    let distance = libm::hypot(dx, dy);
    if distance < 1.1 * REACH_M {
        return (0, BINS);
    }
    let s = REACH_M / distance;
    let c = (1.0 - s * s).sqrt();
    let (from, to) = (diamond(dx * c + dy * s, dy * c - dx * s), diamond(dx * c - dy * s, dy * c + dx * s));
    let first = (from * (BINS as f64 / 4.0)) as usize + BINS - 1;
    (first, (((to - from).rem_euclid(4.0) * (BINS as f64 / 4.0)) as usize + 3).min(BINS))
}

impl Figure {
    /// Somebody in a posture; `id` tells people apart.
    pub fn new(body: &Body, posture: &Posture, id: u32) -> Self {
        let (sin, cos) = libm::sincos(posture.heading_rad);
        let limbs = pose(body, posture);
        Self { x: posture.x, y: posture.y, cos, sin, seed: body.seed, limbs, id }
    }

    /// The first limb that a ray meets nearer than `limit`.
    pub fn meet(&self, eye: [f64; 3], d: [f64; 3], limit: f64) -> Option<Met> {
        let (px, py) = (eye[0] - self.x, eye[1] - self.y);
        // Passing by the whole figure?
        let cross = px * d[1] - py * d[0];
        if cross * cross > REACH_M * REACH_M * (d[0] * d[0] + d[1] * d[1]) {
            return None;
        }
        let o = [px * self.cos + py * self.sin, py * self.cos - px * self.sin, eye[2]];
        let d = [d[0] * self.cos + d[1] * self.sin, d[1] * self.cos - d[0] * self.sin, d[2]];
        let mut nearest: Option<(f64, usize)> = None;
        let mut limit = limit;
        for (i, limb) in self.limbs.iter().enumerate() {
            if let Some(t) = limb.meet(o, d)
                && t < limit
            {
                (nearest, limit) = (Some((t, i)), t);
            }
        }
        let (t, i) = nearest?;
        let limb = &self.limbs[i];
        let (own, along, around) = limb.place([o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]);
        let normal = [own[0] * self.cos - own[1] * self.sin, own[0] * self.sin + own[1] * self.cos, own[2]];
        Some(Met { t, normal, surface: LIMB | (self.id << 5) | i as u32, own, along, around, cover: limb.cover, seed: self.seed })
    }
}

impl Limb {
    fn new(a: [f64; 3], b: [f64; 3], radius: f64, squeeze: f64, cover: Cover) -> Self {
        let axis = [(b[0] - a[0]) * squeeze, b[1] - a[1], b[2] - a[2]];
        Self { a: [a[0] * squeeze, a[1], a[2]], axis, length2: dot(axis, axis).max(1e-9), radius, squeeze, cover }
    }

    /// Where a ray enters the capsule: the cylinder's side, else the nearer ball.
    fn meet(&self, o: [f64; 3], d: [f64; 3]) -> Option<f64> {
        let o = [o[0] * self.squeeze - self.a[0], o[1] - self.a[1], o[2] - self.a[2]];
        let d = [d[0] * self.squeeze, d[1], d[2]];
        let (dd, dw, od, ow) = (dot(d, d), dot(d, self.axis), dot(o, d), dot(o, self.axis));
        let r2 = self.radius * self.radius;
        let (a, b) = (self.length2 * dd - dw * dw, self.length2 * od - ow * dw);
        let c = self.length2 * (dot(o, o) - r2) - ow * ow;
        let h = b * b - a * c;
        if h < 0.0 {
            return None;
        }
        let t = (-b - h.sqrt()) / a.max(1e-12);
        let along = ow + t * dw;
        if along > 0.0 && along < self.length2 {
            return (t > 0.0).then_some(t);
        }
        let o = if along <= 0.0 { o } else { [o[0] - self.axis[0], o[1] - self.axis[1], o[2] - self.axis[2]] };
        let b = dot(o, d);
        let h = b * b - dd * (dot(o, o) - r2);
        let t = (-b - h.max(0.0).sqrt()) / dd;
        (h >= 0.0 && t > 0.0).then_some(t)
    }

    /// Outward normal at a point of the surface, and the place along the limb and around it, metres.
    fn place(&self, p: [f64; 3]) -> ([f64; 3], f64, f64) {
        let q = [p[0] * self.squeeze - self.a[0], p[1] - self.a[1], p[2] - self.a[2]];
        let along = dot(q, self.axis) / self.length2;
        let foot = along.clamp(0.0, 1.0);
        let out = [q[0] - foot * self.axis[0], q[1] - foot * self.axis[1], q[2] - foot * self.axis[2]];
        // Undo the squeeze for the normal: a gradient stretches the other way.
        let n = [out[0] * self.squeeze, out[1], out[2]];
        let norm = dot(n, n).sqrt().max(1e-12);
        // Around the limb from its left side; a diamond's corner is a quarter of the way round.
        let w = [self.axis[0], self.axis[1], self.axis[2]];
        let across = if w[1] * w[1] < 0.5 * self.length2 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let other = [w[1] * across[2] - w[2] * across[1], w[2] * across[0] - w[0] * across[2], w[0] * across[1] - w[1] * across[0]];
        let length = self.length2.sqrt();
        let angle = diamond(dot(out, across), dot(out, other) / length);
        (n.map(|v| v / norm), along * length, angle * self.radius * 1.5708)
    }
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The limbs of a body in its stride. Proportions of the height are those of adults (Winter 2009, fig. 4.1, rounded).
fn pose(body: &Body, posture: &Posture) -> Vec<Limb> {
    let h = body.height_m;
    let amount = (posture.speed_mps / 1.2).clamp(0.0, 1.2);
    // One cycle is two steps.
    let (swing, lift) = libm::sincos(std::f64::consts::PI * posture.steps);
    let legs = [1.0, -1.0].map(|side| Leg::new(SWING_RAD * amount * swing * side, 0.1 + 0.75 * amount * (lift * side).max(0.0), h));
    let hip_z = legs.iter().map(|leg| leg.drop).fold(0.0, f64::max) + 0.035 * h;
    let mut limbs = Vec::with_capacity(20);
    let sway = 0.006 * h * amount * swing;
    let at = |x: f64, y: f64, z: f64| [x * h, y * h + sway, hip_z + (z - 0.53) * h];
    let stout = 0.92 + 0.22 * f64::from(cell(9, 0, body.seed));
    limbs.push(Limb::new(at(0.012, 0.0, 0.908), at(0.006, 0.0, 0.945), 0.047 * h, 0.86, Cover::Head));
    limbs.push(Limb::new(at(0.0, 0.0, 0.83), at(0.004, 0.0, 0.88), 0.034 * h, 1.0, Cover::Skin));
    limbs.push(Limb::new(at(0.0, 0.0, 0.57), at(0.0, 0.0, 0.725), 0.092 * h * stout, 1.45, Cover::Shirt));
    limbs.push(Limb::new(at(0.0, -0.082, 0.788), at(0.0, 0.082, 0.788), 0.05 * h, 1.1, Cover::Shirt));
    limbs.push(Limb::new(at(0.0, -0.032, 0.525), at(0.0, 0.032, 0.525), 0.064 * h * stout, 1.15, Cover::Trousers));
    if cell(8, 0, body.seed) < 0.3 {
        limbs.push(Limb::new(at(-0.095, 0.0, 0.63), at(-0.095, 0.0, 0.74), 0.075 * h, 1.6, Cover::Bag));
    }
    let bare_arms = cell(7, 0, body.seed) < 0.3;
    for (side, leg) in [1.0, -1.0].into_iter().zip(&legs) {
        // Arms swing against the legs.
        let (upper, fore) = (-0.8 * leg.thigh_rad, -0.8 * leg.thigh_rad + 0.25 + 0.25 * amount);
        let shoulder = at(0.0, 0.118 * side, 0.795);
        let elbow = below(shoulder, upper, 0.165 * h);
        let elbow = [elbow[0], elbow[1] + 0.02 * h * side, elbow[2]];
        let wrist = below(elbow, fore, 0.145 * h);
        let hand = below(wrist, fore, 0.045 * h);
        limbs.push(Limb::new(shoulder, elbow, 0.0285 * h * stout, 1.0, Cover::Shirt));
        limbs.push(Limb::new(elbow, wrist, 0.022 * h, 1.0, if bare_arms { Cover::Skin } else { Cover::Shirt }));
        limbs.push(Limb::new(wrist, hand, 0.021 * h, 1.0, Cover::Skin));
        let hip = at(0.0, 0.05 * side, 0.53);
        let knee = below(hip, leg.thigh_rad, 0.245 * h);
        let ankle = below(knee, leg.shin_rad, 0.246 * h);
        limbs.push(Limb::new(hip, knee, 0.047 * h * stout, 1.0, Cover::Trousers));
        limbs.push(Limb::new(knee, ankle, 0.033 * h, 1.0, Cover::Trousers));
        let toe = below(ankle, leg.shin_rad + 1.45, 0.1 * h);
        limbs.push(Limb::new([ankle[0], ankle[1], ankle[2] - 0.01 * h], [toe[0], toe[1], toe[2] - 0.01 * h], 0.026 * h, 1.0, Cover::Shoe));
    }
    limbs
}

/// Angles of a leg, from straight down, forward positive, and how far the foot is under the hip.
struct Leg {
    thigh_rad: f64,
    shin_rad: f64,
    drop: f64,
}

impl Leg {
    fn new(thigh_rad: f64, flex_rad: f64, h: f64) -> Self {
        let shin_rad = thigh_rad - flex_rad;
        Self { thigh_rad, shin_rad, drop: 0.245 * h * libm::cos(thigh_rad) + 0.246 * h * libm::cos(shin_rad) }
    }
}

/// The point `length` from `from`, hanging down and swung forward by an angle.
fn below(from: [f64; 3], forward_rad: f64, length: f64) -> [f64; 3] {
    let (s, c) = libm::sincos(forward_rad);
    [from[0] + length * s, from[1], from[2] - length * c]
}

impl Met {
    /// Brightness of the cloth in full light, averaged over a pixel that is `footprint` metres wide there; lit from above.
    pub fn brightness(&self, footprint: f32) -> f32 {
        let shade = 0.76 + 0.20 * self.own[2] as f32 + 0.05 * self.normal[0] as f32 + 0.03 * self.normal[1] as f32;
        self.cloth(footprint) * shade
    }

    fn cloth(&self, f: f32) -> f32 {
        let (u, v, seed) = (self.around as f32, self.along as f32, self.seed);
        let spot = Spot { u, v, fu: f, fv: f };
        let tone = |key: i32| cell(key, 0, seed);
        let skin = 0.42 + 0.32 * tone(1);
        // Cloth folds: soft, along the limb.
        let folds = 0.07 * noise(u * 9.0, v * 4.0, 9.0 * f, seed ^ 5) + 0.04 * noise(u * 30.0, v * 14.0, 30.0 * f, seed ^ 6);
        match self.cover {
            Cover::Skin => skin + 0.02 * noise(u * 40.0, v * 40.0, 40.0 * f, seed),
            Cover::Head => self.head(skin, f),
            Cover::Shirt => self.shirt(spot, tone(2), tone(3)) * (1.0 + 1.6 * folds),
            Cover::Trousers => {
                (0.10 + 0.38 * tone(4) * tone(4)) * (1.0 + 2.2 * folds) + 0.02 * noise(u * 90.0, v * 90.0, 90.0 * f, seed ^ 7)
            }
            Cover::Shoe => 0.08 + 0.6 * tone(5) * tone(5) * tone(5),
            Cover::Bag => {
                let seam = lines(v / 0.16, 0.08, f / 0.16);
                let bag = 0.12 + 0.5 * tone(6) + folds;
                bag + seam * (0.08 - bag)
            }
        }
    }

    /// Plain, striped, checked or printed.
    fn shirt(&self, spot: Spot, tone: f32, other: f32) -> f32 {
        let base = 0.10 + 0.75 * tone;
        let ink = if base > 0.5 { 0.06 + 0.3 * other } else { 0.55 + 0.4 * other };
        match hash(11, 3, self.seed) % 5 {
            0 => base + lines(spot.v / 0.06, 0.45, spot.fv / 0.06) * (ink - base),
            1 => {
                let check = 0.5 * (lines(spot.v / 0.07, 0.5, spot.fv / 0.07) + lines(spot.u / 0.07, 0.5, spot.fu / 0.07));
                base + check * (ink - base)
            }
            2 => {
                // A print on the chest and one on the back.
                let print = mosaic(spot.scaled(0.0, 0.0, 0.022, 0.03), self.seed ^ 9);
                let share = band(spot.v, 0.02, 0.17, spot.fv) * band((self.own[1] as f32).abs(), -1.0, 0.6, 10.0 * spot.fu);
                base + share * (print - 0.3).clamp(0.0, 0.7) / 0.7 * (ink - base)
            }
            _ => base,
        }
    }

    /// Hair above and behind, a face in front.
    fn head(&self, skin: f32, f: f32) -> f32 {
        let [x, y, z] = self.own.map(|v| v as f32);
        let (hair, soft) = (0.05 + 0.5 * cell(10, 0, self.seed) * cell(10, 0, self.seed), (f / 0.08).max(0.12));
        // Higher in front than behind.
        let line = z - 0.75 * x + 0.1;
        let share = (line / soft + 0.5).clamp(0.0, 1.0);
        let height = self.along as f32 + 0.08 * z;
        let eyes = band(y.abs(), 0.22, 0.5, soft) * band(height, 0.035, 0.055, f)
            + band(y.abs(), -1.0, 0.3, soft) * band(height, -0.045, -0.033, f);
        let face = skin * (1.0 - 0.55 * eyes * (2.0 * x - 1.0).clamp(0.0, 1.0));
        let strands = hair * (1.0 + 0.5 * noise(y * 9.0, z * 3.0 + 5.0, 9.0 * f / 0.08, self.seed ^ 3));
        face + share * (strands - face)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn somebody(x: f64, steps: f64) -> Cast {
        let body = Body { height_m: 1.8, seed: 4 };
        Cast::new(vec![Figure::new(&body, &Posture { x, y: 0.0, heading_rad: 0.3, speed_mps: 1.2, steps }, 1)], [0.0, 0.0])
    }

    fn look(cast: &Cast, d: [f64; 3]) -> Option<Met> {
        let bin = (diamond(d[0], d[1]) * (BINS as f64 / 4.0)) as usize % BINS;
        cast.meet(bin, [0.0, 0.0, 1.5], d, f64::INFINITY)
    }

    #[test]
    fn a_person_is_as_tall_as_said_and_stands_on_the_floor() {
        for steps in 0..20 {
            let cast = somebody(4.0, 0.13 * f64::from(steps));
            let heights = (0..4000)
                .map(|k| f64::from(k) * 0.0005)
                .filter(|z| (-40..=40).any(|y| look(&cast, [4.0, f64::from(y) * 0.01, z - 1.5]).is_some()));
            let heights: Vec<f64> = heights.collect();
            let (low, high) = (heights[0], heights[heights.len() - 1]);
            // A stride lowers the head by a few centimetres; a lifted heel or the eye's own height moves where the rays pass.
            assert!(high > 1.70 && high < 1.83, "{high} m");
            assert!(low < 0.06, "{low} m");
        }
    }

    #[test]
    fn limbs_swing_but_hide_nothing_beyond_the_figures_reach() {
        let cast = somebody(3.0, 0.5);
        // The bins hold everything that a full search finds.
        for k in -400..400 {
            let d = [3.0, f64::from(k) * 0.004, -0.3];
            let all = cast.figures[0].meet([0.0, 0.0, 1.5], d, f64::INFINITY).map(|m| m.t);
            assert_eq!(look(&cast, d).map(|m| m.t), all);
        }
        let other = somebody(3.0, 1.5);
        let shape = |cast: &Cast| (-40..40).map(|k| look(cast, [3.0, f64::from(k) * 0.01, -1.2]).is_some()).collect::<Vec<_>>();
        assert_ne!(shape(&cast), shape(&other), "half a cycle later the other leg is in front");
    }

    #[test]
    fn a_wall_in_front_hides_people() {
        let cast = somebody(3.0, 0.0);
        let bin = (diamond(1.0, 0.0) * (BINS as f64 / 4.0)) as usize % BINS;
        assert!(cast.meet(bin, [0.0, 0.0, 1.5], [1.0, 0.0, -0.1], 5.0).is_some());
        assert!(cast.meet(bin, [0.0, 0.0, 1.5], [1.0, 0.0, -0.1], 2.0).is_none());
    }
}
