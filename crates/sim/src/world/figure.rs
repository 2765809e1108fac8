//! What does a ray meet of a person? A head, a trunk, arms and legs: capsules in clothes whose pattern moves with the limb.
//!
//! Frames: a figure's own axes are x forward, y left, z up from the floor under it, metres. A capsule may be flattened from front
//! to back: space is then stretched along the figure's forward axis, which leaves the parameter of rays as it is. Limbs are posed once
//! for an eye, and sorted into the renderer's bins of direction, so that a ray is tested against the few limbs of its bin.

use crate::render::{BINS, LIMB, Surface, diamond};
use crate::texture::cell;

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
pub(super) enum Cover {
    Skin,
    Head,
    Trunk,
    Sleeve,
    Trousers,
    Shoe,
    Bag,
}

/// One limb in its figure's own axes.
#[derive(Debug, Clone, Copy)]
struct Limb {
    a: [f64; 3],
    b: [f64; 3],
    radius: f64,
    /// How much thinner it is from front to back than from side to side.
    squeeze: f64,
    cover: Cover,
}

/// A posed body, where it stands.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    place: [f64; 2],
    /// Forward, on the floor.
    forward: [f64; 2],
    seed: u32,
    id: u32,
    limbs: Vec<Limb>,
}

/// A limb as it is seen from one eye: plan axes, stretched along its figure's forward axis.
#[derive(Debug, Clone)]
struct Target {
    /// From one end of the limb to the eye, and from that end to the other.
    o: [f64; 3],
    axis: [f64; 3],
    length2: f64,
    radius: f64,
    /// What does not depend on the ray: `o` along the axis, and the cylinder's constant term.
    ow: f64,
    c: f64,
    /// Square of the least distance on the floor at which it can be met.
    near2: f64,
    /// Stretch less one, and the direction in which.
    stretch: f64,
    forward: [f64; 2],
    /// The eye in the figure's own axes.
    eye: [f64; 3],
    surface: Surface,
    cover: Cover,
    seed: u32,
}

/// Where a ray met a limb.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Met {
    /// How far along the ray.
    pub t: f64,
    /// Outward normal, plan axes.
    pub normal: [f64; 3],
    pub surface: Surface,
    /// The same normal in the figure's own axes.
    pub(super) own: [f64; 3],
    /// Around the limb and along it, metres; on the trunk across and up.
    pub(super) u: f64,
    pub(super) v: f64,
    pub(super) cover: Cover,
    pub(super) seed: u32,
}

/// Everybody who can be seen from one place at one moment.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cast {
    targets: Vec<Target>,
    /// For each bin of direction, what may be met there; empty when nobody is there at all.
    bins: Vec<Vec<u16>>,
}

impl Cast {
    /// These people as they are seen from `eye`.
    pub fn new(figures: &[Figure], eye: [f64; 3]) -> Self {
        let mut cast = Self::default();
        if figures.is_empty() {
            return cast;
        }
        cast.bins = vec![Vec::new(); BINS];
        for figure in figures {
            for limb in &figure.limbs {
                let number = cast.targets.len().min(usize::from(u16::MAX)) as u16;
                let (first, count) = figure.directions(limb, eye);
                for bin in first..first + count {
                    cast.bins[bin % BINS].push(number);
                }
                cast.targets.push(figure.target(limb, eye));
            }
        }
        cast
    }

    /// The first limb that a ray in a bin of direction meets nearer than `limit`.
    pub fn meet(&self, bin: usize, d: [f64; 3], limit: f64) -> Option<Met> {
        let mut limit = limit;
        let mut nearest = None;
        let level2 = d[0] * d[0] + d[1] * d[1];
        for k in self.bins.get(bin)? {
            let target = &self.targets[usize::from(*k)];
            if target.near2 < limit * limit * level2
                && let Some(t) = target.meet(d)
                && t < limit
            {
                (limit, nearest) = (t, Some(target));
            }
        }
        nearest.map(|target| target.met(d, limit))
    }
}

impl Figure {
    /// Somebody in a posture; `id` tells people apart.
    pub fn new(body: &Body, posture: &Posture, id: u32) -> Self {
        let (sin, cos) = libm::sincos(posture.heading_rad);
        Self { place: [posture.x, posture.y], forward: [cos, sin], seed: body.seed, id, limbs: pose(body, posture) }
    }

    /// Square of the distance on the floor from a place.
    pub fn distance2(&self, from: [f64; 2]) -> f64 {
        let (dx, dy) = (self.place[0] - from[0], self.place[1] - from[1]);
        dx * dx + dy * dy
    }

    fn target(&self, limb: &Limb, eye: [f64; 3]) -> Target {
        let [fx, fy] = self.forward;
        let (px, py) = (eye[0] - self.place[0], eye[1] - self.place[1]);
        let stretch = limb.squeeze - 1.0;
        // From the figure's axes to the plan's, stretched.
        let turned = |p: [f64; 3]| {
            let x = p[0] * limb.squeeze;
            [x * fx - p[1] * fy, x * fy + p[1] * fx, p[2]]
        };
        let own = [px * fx + py * fy, py * fx - px * fy, eye[2]];
        let (a, b, at) = (turned(limb.a), turned(limb.b), turned(own));
        let (o, axis) = (sub(at, a), sub(b, a));
        // On the floor it reaches no further from its middle than half of its length and its radius.
        let middle: [f64; 2] = std::array::from_fn(|i| 0.5 * (limb.a[i] + limb.b[i]) - own[i]);
        let half_m = 0.5 * libm::hypot(limb.b[0] - limb.a[0], limb.b[1] - limb.a[1]);
        let near_m = (libm::hypot(middle[0], middle[1]) - half_m - limb.radius).max(0.0);
        let (length2, ow) = (dot(axis, axis).max(1e-9), dot(o, axis));
        Target {
            o,
            axis,
            length2,
            radius: limb.radius,
            ow,
            c: length2 * (dot(o, o) - limb.radius * limb.radius) - ow * ow,
            near2: near_m * near_m,
            stretch,
            forward: self.forward,
            eye: own,
            surface: LIMB | (self.id << 3) | limb.cover as u32,
            cover: limb.cover,
            seed: self.seed,
        }
    }

    /// The bins that a limb may fill: the first one and their number.
    fn directions(&self, limb: &Limb, eye: [f64; 3]) -> (usize, usize) {
        let [fx, fy] = self.forward;
        let ends =
            [limb.a, limb.b].map(|p| [self.place[0] + p[0] * fx - p[1] * fy - eye[0], self.place[1] + p[0] * fy + p[1] * fx - eye[1]]);
        let reach = limb.radius + 0.002;
        let spans = ends.map(|[dx, dy]| {
            let distance = libm::hypot(dx, dy);
            if distance < 1.05 * reach {
                return None;
            }
            let s = reach / distance;
            let c = (1.0 - s * s).sqrt();
            let from = diamond(dx * c + dy * s, dy * c - dx * s);
            Some((from, (diamond(dx * c - dy * s, dy * c + dx * s) - from).rem_euclid(4.0)))
        });
        let [Some((from, width)), Some((other, other_width))] = spans else { return (0, BINS) };
        // The other end's span beside this one's: half of the circle to either side.
        let off = (other - from + 2.0).rem_euclid(4.0) - 2.0;
        let (low, high) = (off.min(0.0), width.max(off + other_width));
        if high - low > 1.9 {
            return (0, BINS);
        }
        let scale = BINS as f64 / 4.0;
        let first = ((from + low).rem_euclid(4.0) * scale) as usize + BINS - 1;
        (first, ((high - low) * scale) as usize + 4)
    }
}

impl Target {
    fn stretched(&self, d: [f64; 3]) -> [f64; 3] {
        let along = self.stretch * (d[0] * self.forward[0] + d[1] * self.forward[1]);
        [d[0] + along * self.forward[0], d[1] + along * self.forward[1], d[2]]
    }

    /// Where a ray enters the capsule: the cylinder's side, else the nearer ball.
    #[inline]
    fn meet(&self, d: [f64; 3]) -> Option<f64> {
        let d = self.stretched(d);
        let (dd, dw, od) = (dot(d, d), dot(d, self.axis), dot(self.o, d));
        let (a, b) = (self.length2 * dd - dw * dw, self.length2 * od - self.ow * dw);
        let h = b * b - a * self.c;
        if h < 0.0 {
            return None;
        }
        let t = (-b - h.sqrt()) / a.max(1e-12);
        let along = self.ow + t * dw;
        if along > 0.0 && along < self.length2 {
            return (t > 0.0).then_some(t);
        }
        let o = if along <= 0.0 { self.o } else { sub(self.o, self.axis) };
        let b = dot(o, d);
        let h = b * b - dd * (dot(o, o) - self.radius * self.radius);
        let t = (-b - h.max(0.0).sqrt()) / dd;
        (h >= 0.0 && t > 0.0).then_some(t)
    }

    /// What there is to know about the place that a ray meets.
    fn met(&self, d: [f64; 3], t: f64) -> Met {
        let [fx, fy] = self.forward;
        let s = self.stretched(d);
        let q = [self.o[0] + t * s[0], self.o[1] + t * s[1], self.o[2] + t * s[2]];
        let along = dot(q, self.axis) / self.length2;
        let foot = along.clamp(0.0, 1.0);
        let out = [q[0] - foot * self.axis[0], q[1] - foot * self.axis[1], q[2] - foot * self.axis[2]];
        // A gradient stretches as space does.
        let n = self.stretched(out);
        let norm = dot(n, n).sqrt().max(1e-12);
        let normal = n.map(|v| v / norm);
        let own = [normal[0] * fx + normal[1] * fy, normal[1] * fx - normal[0] * fy, normal[2]];
        let (u, v) = if self.cover == Cover::Trunk {
            let left = self.eye[1] + t * (d[1] * fx - d[0] * fy);
            (left, self.eye[2] + t * d[2])
        } else {
            // Around the limb from its left side; a diamond's corner is a quarter of the way round.
            let across = [-fy, fx, 0.0];
            let w = self.axis;
            let other = [w[1] * across[2] - w[2] * across[1], w[2] * across[0] - w[0] * across[2], w[0] * across[1] - w[1] * across[0]];
            let length = self.length2.sqrt();
            (diamond(dot(out, across), dot(out, other) / length) * self.radius * std::f64::consts::FRAC_PI_2, along * length)
        };
        Met { t, normal, surface: self.surface, own, u, v, cover: self.cover, seed: self.seed }
    }
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The limbs of a body in its stride. Proportions of the height are those of adults (Winter 2009, fig. 4.1, rounded).
fn pose(body: &Body, posture: &Posture) -> Vec<Limb> {
    let h = body.height_m;
    let amount = (posture.speed_mps / 1.2).clamp(0.0, 1.2);
    // One cycle is two steps.
    let (swing, lift) = libm::sincos(std::f64::consts::PI * posture.steps);
    let legs = [1.0, -1.0].map(|side| Leg::new(SWING_RAD * amount * swing * side, 0.1 + 0.75 * amount * (lift * side).max(0.0), h));
    let hip_z = legs.iter().map(|leg| leg.drop).fold(0.0, f64::max) + 0.035 * h;
    let sway = 0.006 * h * amount * swing;
    let at = |x: f64, y: f64, z: f64| [x * h, y * h + sway, hip_z + (z - 0.53) * h];
    let stout = 0.92 + 0.22 * f64::from(cell(9, 0, body.seed));
    let limb = |a: [f64; 3], b: [f64; 3], radius: f64, squeeze: f64, cover: Cover| Limb { a, b, radius: radius * h, squeeze, cover };
    let level =
        |half: f64, z: f64, radius: f64, squeeze: f64, cover: Cover| limb(at(0.0, -half, z), at(0.0, half, z), radius, squeeze, cover);
    let mut limbs = vec![
        limb(at(0.012, 0.0, 0.908), at(0.006, 0.0, 0.945), 0.047, 0.86, Cover::Head),
        limb(at(0.0, 0.0, 0.82), at(0.004, 0.0, 0.88), 0.031, 1.0, Cover::Skin),
        // Shoulders, chest, waist and hem, and what is between them.
        level(0.078, 0.797, 0.036, 1.0, Cover::Trunk),
        level(0.05, 0.745, 0.054 * stout, 1.0, Cover::Trunk),
        limb(at(0.0, 0.0, 0.60), at(0.0, 0.0, 0.755), 0.088 * stout, 1.45, Cover::Trunk),
        level(0.045, 0.565, 0.054 * stout, 1.0, Cover::Trunk),
        level(0.045, 0.525, 0.052 * stout, 1.05, Cover::Trousers),
    ];
    if cell(8, 0, body.seed) < 0.3 {
        limbs.push(limb(at(-0.085, 0.0, 0.63), at(-0.085, 0.0, 0.74), 0.072, 1.6, Cover::Bag));
    }
    let bare_arms = cell(7, 0, body.seed) < 0.3;
    for (side, leg) in [1.0, -1.0].into_iter().zip(&legs) {
        // Arms swing against the legs.
        let (upper, fore) = (-0.8 * leg.thigh_rad, -0.8 * leg.thigh_rad + 0.25 + 0.25 * amount);
        let shoulder = at(0.0, 0.108 * side, 0.797);
        let elbow = below(shoulder, upper, 0.165 * h);
        let elbow = [elbow[0], elbow[1] + 0.02 * h * side, elbow[2]];
        let wrist = below(elbow, fore, 0.145 * h);
        limbs.push(limb(shoulder, elbow, 0.028 * stout, 1.0, Cover::Sleeve));
        limbs.push(limb(elbow, wrist, 0.022, 1.0, if bare_arms { Cover::Skin } else { Cover::Sleeve }));
        limbs.push(limb(wrist, below(wrist, fore, 0.045 * h), 0.02, 1.0, Cover::Skin));
        let hip = at(0.0, 0.048 * side, 0.53);
        let knee = below(hip, leg.thigh_rad, 0.245 * h);
        let ankle = below(knee, leg.shin_rad, 0.246 * h);
        limbs.push(limb(hip, knee, 0.045 * stout, 1.0, Cover::Trousers));
        limbs.push(limb(knee, ankle, 0.033, 1.0, Cover::Trousers));
        let (heel, toe) =
            (below(ankle, 0.0, 0.01 * h), below(below(ankle, 0.0, 0.01 * h), std::f64::consts::FRAC_PI_2 + 0.6 * leg.shin_rad, 0.1 * h));
        limbs.push(limb(heel, toe, 0.026, 1.0, Cover::Shoe));
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

#[cfg(test)]
mod tests {
    use super::*;

    const EYE: [f64; 3] = [0.0, 0.0, 1.5];

    fn figure(x: f64, y: f64, steps: f64) -> Figure {
        let body = Body { height_m: 1.8, seed: 4 };
        Figure::new(&body, &Posture { x, y, heading_rad: 0.3, speed_mps: 1.2, steps }, 1)
    }

    fn somebody(x: f64, steps: f64) -> Cast {
        Cast::new(&[figure(x, 0.0, steps)], EYE)
    }

    fn look(cast: &Cast, d: [f64; 3]) -> Option<Met> {
        let bin = (diamond(d[0], d[1]) * (BINS as f64 / 4.0)) as usize % BINS;
        cast.meet(bin, d, f64::INFINITY)
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
    fn the_bins_hold_every_limb_that_a_full_search_finds() {
        for (x, y) in [(3.0, 0.0), (-2.0, 0.7), (0.6, -0.5), (-0.4, -0.3)] {
            let cast = Cast::new(&[figure(x, y, 0.5)], EYE);
            let mut met = 0;
            for k in 0..20_000 {
                let angle = 0.001 * f64::from(k);
                let d = [angle.cos(), angle.sin(), -1.2 + 0.0011 * f64::from(k % 1000)];
                let all = cast.targets.iter().filter_map(|target| target.meet(d)).fold(f64::INFINITY, f64::min);
                let found = look(&cast, d).map_or(f64::INFINITY, |m| m.t);
                assert_eq!(found, all, "towards {d:?} from a person at {x}, {y}");
                met += usize::from(all.is_finite());
            }
            assert!(met > 100, "{met} rays");
        }
    }

    #[test]
    fn normals_point_at_whoever_looks_and_limbs_swing() {
        let cast = somebody(3.0, 0.5);
        for k in -40..40 {
            let d = [3.0, f64::from(k) * 0.01, -0.5];
            let Some(met) = look(&cast, d) else { continue };
            assert!(dot(met.normal, d) < 1e-9 && (dot(met.normal, met.normal) - 1.0).abs() < 1e-9);
        }
        let shape =
            |cast: &Cast| (-40..40).map(|k| look(cast, [3.0, f64::from(k) * 0.01, -1.2]).map(|m| m.t.to_bits())).collect::<Vec<_>>();
        assert_ne!(shape(&cast), shape(&somebody(3.0, 1.5)), "half a cycle later the other leg is in front");
    }

    #[test]
    fn a_wall_in_front_hides_people() {
        let cast = somebody(3.0, 0.0);
        let bin = (diamond(1.0, 0.0) * (BINS as f64 / 4.0)) as usize % BINS;
        assert!(cast.meet(bin, [1.0, 0.0, -0.1], 5.0).is_some());
        assert!(cast.meet(bin, [1.0, 0.0, -0.1], 2.0).is_none());
    }
}
