//! What does a hatch fill? Rings of curves, read pair by pair, as the crate leaves hatches out.

use super::curves::{Arc, Curve, Point, Spline, Vertex, rad, sweep_rad};
use super::pairs::Pair;
use super::shapes::straight;

/// Reads the outline of a hatch pair by pair: each code's meaning hangs on those before it.
struct HatchPairs<'a> {
    rest: std::iter::Peekable<std::slice::Iter<'a, Pair<'a>>>,
}

impl HatchPairs<'_> {
    /// The next pair's number, if it has this code.
    fn take(&mut self, code: i32) -> Option<f64> {
        self.rest.next_if(|pair| pair.code == code)?.number()
    }

    fn point(&mut self, code: i32) -> Option<Point> {
        Some([self.take(code)?, self.take(code + 10)?])
    }

    fn polyline(&mut self) -> Option<Vec<Curve>> {
        let has_bulges = self.take(72)? != 0.0;
        // Always closed: code 73 says so once more.
        self.take(73);
        let count = self.take(93)? as usize;
        let mut vertices = Vec::new();
        for _ in 0..count {
            let at = self.point(10)?;
            let bulge = if has_bulges { self.take(42).unwrap_or(0.0) } else { 0.0 };
            vertices.push(Vertex { at, bulge, width: 0.0 });
        }
        // Closing it here lets all rings end where they begin.
        vertices.extend(vertices.first().copied());
        Some(vec![Curve::Chain(vertices)])
    }

    fn edges(&mut self) -> Option<Vec<Curve>> {
        let count = self.take(93)? as usize;
        let mut edges = Vec::new();
        for _ in 0..count {
            edges.push(match self.take(72)? as i32 {
                1 => Curve::Chain(vec![straight(self.point(10)?), straight(self.point(11)?)]),
                2 => {
                    let (centre, radius) = (self.point(10)?, self.take(40)?);
                    self.arc(centre, [radius, 0.0], 1.0)?
                }
                3 => {
                    let (centre, major, ratio) = (self.point(10)?, self.point(11)?, self.take(40)?);
                    self.arc(centre, major, ratio)?
                }
                4 => self.spline()?,
                _ => return None,
            });
        }
        Some(edges)
    }

    /// Angles are those seen from the centre, other than of ellipses outside of hatches; of clockwise arcs, they are counted clockwise.
    fn arc(&mut self, centre: Point, u: Point, ratio: f64) -> Option<Curve> {
        let (from, to) = (rad(self.take(50)?), rad(self.take(51)?));
        let sign = if self.take(73)? != 0.0 { 1.0 } else { -1.0 };
        let parameter = |angle: f64| (angle.sin() / ratio.max(1e-9)).atan2(angle.cos());
        let (from, to) = (parameter(from), parameter(to));
        let v = [-u[1] * ratio, u[0] * ratio];
        Some(Curve::Arc(Arc { centre, u, v, from_rad: sign * from, sweep_rad: sign * sweep_rad(from, to) }))
    }

    fn spline(&mut self) -> Option<Curve> {
        let degree = self.take(94)? as usize;
        self.take(73);
        self.take(74);
        let (knots, controls) = (self.take(95)? as usize, self.take(96)? as usize);
        let mut spline = Spline { degree, knots: Vec::new(), controls: Vec::new() };
        for _ in 0..knots {
            spline.knots.push(self.take(40)?);
        }
        for _ in 0..controls {
            let [x, y] = self.point(10)?;
            let weight = self.take(42).unwrap_or(1.0);
            spline.controls.push([x * weight, y * weight, weight]);
        }
        // Points that it was fitted to, and its directions at the ends.
        while self.rest.next_if(|pair| matches!(pair.code, 97 | 11..=13 | 21..=23)).is_some() {}
        Some(Curve::Spline(spline))
    }
}

/// All rings up to the first that is not what it should be.
pub(super) fn hatch_rings(pairs: &[Pair]) -> Vec<Vec<Curve>> {
    let mut rings = Vec::new();
    let Some(start) = pairs.iter().position(|pair| pair.code == 91) else { return rings };
    let mut pairs = HatchPairs { rest: pairs[start + 1..].iter().peekable() };
    while let Some(flags) = pairs.take(92) {
        let is_polyline = flags as i32 & 2 != 0;
        let Some(ring) = (if is_polyline { pairs.polyline() } else { pairs.edges() }) else { break };
        rings.push(ring);
        // Which objects it was made from.
        pairs.take(97);
    }
    rings
}
