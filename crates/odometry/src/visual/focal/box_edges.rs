//! How well do a picture's straight edges fit three directions at right angles, if the lens is so long?
//!
//! segments of a picture ─▶ for each focal length: the turn of a box whose edges they best are ─▶ log-likelihood
//!
//! Likelihood: of the angle *in the picture* between a segment and the line from its middle to the vanishing point: normal about zero for
//! edges of the box, even for others (Coughlan & Yuille 1999, for pixels; Košecká & Zhang 2002, for segments, unknown focal length too).
//! In the picture, not in space: an angle in space shrinks as the focal length grows, and every lens would seem long.
//!
//! Pitfall: a corridor seen along its axis has one vanishing point within reach, and says nothing; nor does a wall seen face to face. The
//! curve is flat then, and that is what it ought to be.

use nalgebra::{Matrix3, UnitQuaternion, Vector2, Vector3};

use crate::visual::lines::Segment;

/// How far the direction of an edge that a building made may be off, besides its noise: 0.5°, half of which is the lens' own bending.
const BUILT_RAD: f64 = 0.009;
/// Share of the segments that are edges of no box: furniture, people, reflections.
const OTHERS: f64 = 0.4;
/// Turns about the vertical that are tried, and tilts of the camera: 45° further the next wall comes.
const YAWS_DEG: [f64; 9] = [-40.0, -30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0];
const PITCHES_DEG: [f64; 3] = [-15.0, 0.0, 15.0];
/// Widening of the noise, so that a start that is some degrees off is drawn in, step by step.
const WIDER: [f64; 6] = [8.0, 5.0, 3.0, 2.0, 1.0, 1.0];
/// Fewest segments that say anything.
const FEWEST: usize = 10;

/// A segment as the likelihood wants it.
struct Needle {
    /// Middle, pixels from the principal point.
    middle: Vector2<f64>,
    /// Unit vector along it.
    along: Vector2<f64>,
    /// Noise of its direction, radians.
    sigma: f64,
}

/// Log-likelihood of a picture's segments for each of these focal lengths, pixels; `None` of too few.
pub(super) fn curve(segments: &[Segment], centre: Vector2<f64>, lenses: &[f64]) -> Option<Vec<f64>> {
    let needles: Vec<Needle> = segments.iter().filter_map(|segment| Needle::of(segment, centre)).collect();
    if needles.len() < FEWEST {
        return None;
    }
    let starts = PITCHES_DEG.iter().flat_map(|pitch| YAWS_DEG.map(|yaw| start(yaw, *pitch)));
    let starts: Vec<UnitQuaternion<f64>> = starts.collect();
    let mut last: Option<UnitQuaternion<f64>> = None;
    let mut values = Vec::with_capacity(lenses.len());
    for lens in lenses {
        // The best two starts by the widened likelihood, and where the next shorter lens came out.
        let mut ranked: Vec<(f64, UnitQuaternion<f64>)> = starts.iter().map(|r| (likelihood(&needles, r, *lens, WIDER[0]), *r)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let tried = ranked.iter().take(2).map(|r| (r.1, 0)).chain(last.map(|r| (r, 4)));
        let settled = tried.map(|(from, skip)| settle(&needles, from, *lens, &WIDER[skip..]));
        let best = settled.map(|r| (likelihood(&needles, &r, *lens, 1.0), r)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        last = Some(best.1);
        values.push(best.0);
    }
    Some(values)
}

/// The turn `camera ← box` of a camera that is held upright; the box's y axis is down.
fn start(yaw_deg: f64, pitch_deg: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::x() * pitch_deg.to_radians())
        * UnitQuaternion::from_scaled_axis(Vector3::y() * yaw_deg.to_radians())
}

impl Needle {
    fn of(segment: &Segment, centre: Vector2<f64>) -> Option<Self> {
        let [a, b] = segment.ends;
        let along = (b - a).try_normalize(1e-6)?;
        let sigma = libm::hypot(std::f64::consts::SQRT_2 * segment.sigma_px / (b - a).norm(), BUILT_RAD);
        Some(Self { middle: 0.5 * (a + b) - centre, along, sigma })
    }

    /// The sine of the angle to the vanishing point of a direction, and its slope by a turn of the camera frame.
    fn off(&self, direction: &Vector3<f64>, focal: f64) -> Option<(f64, Vector3<f64>)> {
        let to = |d: &Vector3<f64>| focal * d.xy() - self.middle * d.z;
        let way = to(direction);
        let length = way.norm();
        if !(length > 1e-6 * focal) {
            return None;
        }
        let cross = |w: &Vector2<f64>| (self.along.x * w.y - self.along.y * w.x) / length;
        let off = cross(&way);
        let slope = Vector3::from_fn(|k, _| {
            let mut axis = Vector3::zeros();
            axis[k] = 1.0;
            let moved = to(&axis.cross(direction));
            cross(&moved) - off * way.dot(&moved) / (length * length)
        });
        Some((off, slope))
    }
}

fn directions(turn: &UnitQuaternion<f64>) -> [Vector3<f64>; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| turn * axis)
}

fn likelihood(needles: &[Needle], turn: &UnitQuaternion<f64>, focal: f64, wider: f64) -> f64 {
    let directions = directions(turn);
    let of = |needle: &Needle| {
        let sigma = wider * needle.sigma;
        let peak = (1.0 - OTHERS) / (3.0 * sigma * (2.0 * std::f64::consts::PI).sqrt());
        let fits: f64 = directions
            .iter()
            .map(|d| {
                let way = focal * d.xy() - needle.middle * d.z;
                let cross = needle.along.x * way.y - needle.along.y * way.x;
                let square = cross * cross / (way.norm_squared().max(1e-9) * sigma * sigma);
                if square < 40.0 { libm::exp(-0.5 * square) } else { 0.0 }
            })
            .sum();
        libm::log(OTHERS / std::f64::consts::PI + peak * fits)
    };
    needles.iter().map(of).sum()
}

/// Expectation–maximisation over the box's turn, the noise narrowing.
fn settle(needles: &[Needle], from: UnitQuaternion<f64>, focal: f64, wider: &[f64]) -> UnitQuaternion<f64> {
    let mut turn = from;
    for wider in wider {
        let directions = directions(&turn);
        let (mut normal, mut pull) = (Matrix3::identity() * 10.0, Vector3::zeros());
        for needle in needles {
            let sigma = wider * needle.sigma;
            let floor = OTHERS / std::f64::consts::PI / ((1.0 - OTHERS) / (3.0 * sigma * (2.0 * std::f64::consts::PI).sqrt()));
            let offs = directions.map(|d| needle.off(&d, focal));
            let fits = offs.map(|off| off.map_or(0.0, |(off, _)| libm::exp(-0.5 * (off / sigma).powi(2))));
            let all = floor + fits.iter().sum::<f64>();
            for (off, fit) in offs.into_iter().zip(fits) {
                let Some((off, slope)) = off.filter(|_| fit > 1e-4 * all) else { continue };
                let weight = fit / (all * sigma * sigma);
                normal += slope * slope.transpose() * weight;
                pull -= slope * (off * weight);
            }
        }
        let Some(inverse) = normal.try_inverse() else { return turn };
        let step = inverse * pull;
        let step = step * (0.2 / step.norm().max(0.2));
        turn = UnitQuaternion::from_scaled_axis(step) * turn;
    }
    turn
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::visual::two_view::scene::uniform;
    use planwalk_types::Seed;

    pub const LENSES: [f64; 11] = [300.0, 350.0, 400.0, 440.0, 480.0, 500.0, 520.0, 560.0, 600.0, 700.0, 800.0];

    /// Edges of a box as a lens of 500 px sees them from a camera that is turned like this, and others that lie anyhow.
    pub fn seen(seed: u64, count: usize, turn: &UnitQuaternion<f64>, others: f64) -> Vec<Segment> {
        let mut rng = Seed(seed).derive("box", 0);
        let mut segments = Vec::new();
        while segments.len() < count {
            let middle = Vector2::new(uniform(&mut rng, -280.0, 280.0), uniform(&mut rng, -200.0, 200.0));
            let direction = directions(turn)[segments.len() % 3];
            let way = 500.0 * direction.xy() - middle * direction.z;
            let other = uniform(&mut rng, 0.0, std::f64::consts::TAU);
            let along = if uniform(&mut rng, 0.0, 1.0) < others { Vector2::new(other.cos(), other.sin()) } else { way.normalize() };
            let half = uniform(&mut rng, 15.0, 60.0);
            let mut end = |by: f64| middle + along * by + Vector2::new(-along.y, along.x) * uniform(&mut rng, -0.6, 0.6);
            segments.push(Segment { ends: [end(-half), end(half)], sigma_px: 0.5 });
        }
        segments
    }

    fn best(curve: &[f64]) -> f64 {
        LENSES[(0..LENSES.len()).max_by(|a, b| curve[*a].total_cmp(&curve[*b])).unwrap()]
    }

    #[test]
    fn a_corner_seen_aslant_shows_its_lens() {
        let aslant = start(30.0, 12.0);
        let right = (0..20).filter(|seed| {
            let curve = curve(&seen(*seed, 60, &aslant, 0.3), Vector2::zeros(), &LENSES).unwrap();
            (best(&curve) - 500.0).abs() <= 40.0
        });
        // Forty edges, each good to 1°, whose vanishing points lie a focal length away: 3 % of it, so that 8 % are two sigmas and more.
        let right = right.count();
        assert!(right >= 18, "{right} of 20");
    }

    #[test]
    fn a_wall_seen_face_to_face_says_nothing() {
        // Upright and level edges of a wall, as parallel in the picture as they are: every long lens sees that.
        let face: Vec<Segment> = (0..20)
            .flat_map(|i| {
                let at = 20.0 * f64::from(i) - 200.0;
                let (from, to) = (Vector2::new(at, -40.0), Vector2::new(at, 40.0));
                [[from, to], [from.yx(), to.yx()]].map(|ends| Segment { ends, sigma_px: 0.5 })
            })
            .collect();
        let curve = curve(&face, Vector2::zeros(), &LENSES).unwrap();
        let (low, high) = curve.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        assert!(high - low < 1.0, "{curve:?}");
    }

    #[test]
    fn too_few_edges_or_points_say_nothing() {
        assert!(curve(&[], Vector2::zeros(), &LENSES).is_none());
        let point = Segment { ends: [Vector2::new(3.0, 4.0); 2], sigma_px: 0.5 };
        assert!(curve(&[point; 30], Vector2::zeros(), &LENSES).is_none());
    }
}
