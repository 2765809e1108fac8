//! Which chords stand for an arc, an ellipse, a bulge or a spline? Enough of them to be off by no more than an allowed error.
//!
//! [`Curve`] in an object's own plane ─▶ points ─▶ [`Affine`] ─▶ the drawing
//!
//! Pitfall: objects may be drawn in a plane of their own, given by its normal (the "extrusion direction"). One that points down,
//! (0, 0, -1), mirrors x: programmes write it whenever somebody mirrors an arc. Sources: the DXF reference's "arbitrary axis
//! algorithm"; Piegl & Tiller 1997, algorithm A4.1, for splines.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// A point.
pub(super) type Point = [f64; 2];
/// A point or a direction in space.
pub(super) type Space = [f64; 3];

/// Chords of a whole turn at the least: an octagon is still told from a square column.
const LEAST_CHORDS: f64 = 8.0;
/// And at the most: half a degree each.
const MOST_CHORDS: f64 = 720.0;
/// How often a piece of a spline between two of its knots is halved at the most: 128 chords a piece.
const HALVINGS: u32 = 7;
/// Degrees of splines that are evaluated; CAD programmes draw 2 to 11. The control polygon stands for others.
const DEGREES: std::ops::RangeInclusive<usize> = 1..=15;
/// A bulge below this is a straight line: it is off by less than a millionth of the length.
const STRAIGHT: f64 = 1e-6;

/// A way to move, turn, stretch and mirror: where the unit steps along x and y go, and where the origin goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Affine {
    x: Point,
    y: Point,
    at: Point,
}

impl Affine {
    pub(super) const IDENTITY: Self = Self { x: [1.0, 0.0], y: [0.0, 1.0], at: [0.0, 0.0] };

    pub(super) fn shift(by: Point) -> Self {
        Self { at: by, ..Self::IDENTITY }
    }

    pub(super) fn scale(x: f64, y: f64) -> Self {
        Self { x: [x, 0.0], y: [0.0, y], at: [0.0, 0.0] }
    }

    pub(super) fn turn(angle_rad: f64) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        Self { x: [cos, sin], y: [-sin, cos], at: [0.0, 0.0] }
    }

    /// From the plane with this normal, at this height along it, to the drawing seen from above.
    pub(super) fn of_plane(normal: Space, height: f64) -> Self {
        if normal == [0.0, 0.0, 1.0] {
            return Self::IDENTITY;
        }
        let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Self::IDENTITY;
        }
        let n = normal.map(|v| v / length);
        let upright = n[0].abs() < 1.0 / 64.0 && n[1].abs() < 1.0 / 64.0;
        let x = cross(if upright { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] }, n);
        let length = x.iter().map(|v| v * v).sum::<f64>().sqrt();
        let x = x.map(|v| v / length);
        let y = cross(n, x);
        Self { x: [x[0], x[1]], y: [y[0], y[1]], at: [n[0] * height, n[1] * height] }
    }

    /// First `inner`, then this.
    pub(super) fn after(&self, inner: &Self) -> Self {
        Self { x: self.direction(inner.x), y: self.direction(inner.y), at: self.point(inner.at) }
    }

    pub(super) fn point(&self, p: Point) -> Point {
        let d = self.direction(p);
        [d[0] + self.at[0], d[1] + self.at[1]]
    }

    fn direction(&self, d: Point) -> Point {
        [self.x[0] * d[0] + self.y[0] * d[1], self.x[1] * d[0] + self.y[1] * d[1]]
    }

    /// By how much the longest stretched length grows.
    pub(super) fn most(&self) -> f64 {
        longest_radius(self.x, self.y)
    }

    /// By how much lengths grow on average: the root of the growth of areas.
    pub(super) fn mean(&self) -> f64 {
        (self.x[0] * self.y[1] - self.x[1] * self.y[0]).abs().sqrt()
    }
}

pub(super) fn cross(a: Space, b: Space) -> Space {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Of the ellipse `cos t · u + sin t · v`.
fn longest_radius(u: Point, v: Point) -> f64 {
    let sum = u[0] * u[0] + u[1] * u[1] + v[0] * v[0] + v[1] * v[1];
    let area = u[0] * v[1] - u[1] * v[0];
    (0.5 * (sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt())).sqrt()
}

/// A point of a chain, and how it goes on to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vertex {
    pub at: Point,
    /// Tangent of a quarter of the arc's angle, to the left if negative; 0 is straight.
    pub bulge: f64,
    /// Width of the line up to the next.
    pub width: f64,
}

/// A line of one piece.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Curve {
    /// Straight pieces and arcs of circles.
    Chain(Vec<Vertex>),
    Arc(Arc),
    Spline(Spline),
}

/// A piece of an ellipse: `centre + cos t · u + sin t · v`, t from `from` on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    pub centre: Point,
    pub u: Point,
    pub v: Point,
    pub from_rad: f64,
    /// Negative runs clockwise.
    pub sweep_rad: f64,
}

/// A B-spline, rational if its weights differ.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spline {
    pub degree: usize,
    pub knots: Vec<f64>,
    /// x and y times the weight, and the weight.
    pub controls: Vec<Space>,
}

impl Curve {
    pub(super) fn is_curved(&self) -> bool {
        match self {
            Self::Chain(vertices) => vertices.iter().any(|v| v.bulge.abs() > STRAIGHT),
            Self::Arc(_) => true,
            Self::Spline(spline) => spline.degree > 1,
        }
    }

    /// Points along it, off by `error` at the most. Of a closed chain, the first point comes last again, so that its last piece is drawn.
    /// It ends early, with at least `enough` points, if there are as many: who asks has no room for them.
    pub(super) fn points(&self, closed: bool, error: f64, enough: usize) -> Vec<Point> {
        match self {
            Self::Chain(vertices) => chain_points(vertices, closed, error, enough),
            Self::Arc(arc) => arc.points(error).collect(),
            Self::Spline(spline) => spline.points(error, enough),
        }
    }
}

fn chain_points(vertices: &[Vertex], closed: bool, error: f64, enough: usize) -> Vec<Point> {
    let mut points: Vec<Point> = vertices.first().map(|v| v.at).into_iter().collect();
    let again = vertices.first().filter(|_| closed);
    for (from, to) in vertices.iter().zip(vertices.iter().skip(1).chain(again)) {
        if points.len() >= enough {
            break;
        }
        if let Some(arc) = Arc::of_bulge(from.at, to.at, from.bulge) {
            let inner = arc.points(error).skip(1);
            let count = arc.chords(error).saturating_sub(1);
            points.extend(inner.take(count));
        }
        points.push(to.at);
    }
    points
}

impl Arc {
    /// Part of a circle, counter-clockwise.
    pub(super) fn of_circle(centre: Point, radius: f64, from_rad: f64, sweep_rad: f64) -> Self {
        Self { centre, u: [radius, 0.0], v: [0.0, radius], from_rad, sweep_rad }
    }

    /// The arc over a chord; `None` if it is straight.
    fn of_bulge(from: Point, to: Point, bulge: f64) -> Option<Self> {
        let chord = [to[0] - from[0], to[1] - from[1]];
        if bulge.abs() <= STRAIGHT || chord == [0.0, 0.0] {
            return None;
        }
        let away = (1.0 - bulge * bulge) / (4.0 * bulge);
        let centre = [0.5 * (from[0] + to[0]) - away * chord[1], 0.5 * (from[1] + to[1]) + away * chord[0]];
        let u = [from[0] - centre[0], from[1] - centre[1]];
        Some(Self { centre, u, v: [-u[1], u[0]], from_rad: 0.0, sweep_rad: 4.0 * bulge.atan() })
    }

    pub(super) fn is_whole(&self) -> bool {
        self.sweep_rad.abs() >= TAU - 1e-9
    }

    /// The middle of a chord over the angle d is off by r (1 - cos d/2).
    fn chords(&self, error: f64) -> usize {
        let radius = longest_radius(self.u, self.v);
        let step = 2.0 * (1.0 - error / radius).clamp(-1.0, 1.0).acos();
        let step = if step.is_nan() { FRAC_PI_4 } else { step.clamp(TAU / MOST_CHORDS, TAU / LEAST_CHORDS) };
        // Round-off must not make nine chords of eight. Casts saturate.
        ((self.sweep_rad.abs().min(TAU) / step - 1e-9).ceil() as usize).max(1)
    }

    fn points(&self, error: f64) -> impl Iterator<Item = Point> + use<> {
        let arc = *self;
        let chords = arc.chords(error);
        (0..=chords).map(move |k| {
            let (sin, cos) = (arc.from_rad + arc.sweep_rad * k as f64 / chords as f64).sin_cos();
            [0, 1].map(|i| arc.centre[i] + cos * arc.u[i] + sin * arc.v[i])
        })
    }
}

/// The counter-clockwise way from one angle to another, above 0 and at most one turn.
pub(super) fn sweep_rad(from_rad: f64, to_rad: f64) -> f64 {
    let sweep = (to_rad - from_rad).rem_euclid(TAU);
    if sweep < 1e-9 { TAU } else { sweep }
}

/// Degrees as files have them.
pub(super) fn rad(degrees: f64) -> f64 {
    degrees * PI / 180.0
}

impl Spline {
    /// A smooth way through points, for files that say no more (Catmull & Rom 1974): between two points, its directions at both are those
    /// from the point before to the point after. CAD programmes have their own ways, which are near it.
    pub(super) fn through(points: &[Point]) -> Self {
        let at = |k: usize| points.get(k).or(points.last()).copied().unwrap_or_default();
        let lean = |k: usize| [0, 1].map(|i| (at(k + 1)[i] - at(k.saturating_sub(1))[i]) / 6.0);
        let mut spline = Self { degree: 3, knots: vec![0.0], controls: Vec::new() };
        for (k, p) in points.iter().enumerate() {
            let before = [0, 1].map(|i| p[i] - lean(k)[i]);
            let after = [0, 1].map(|i| p[i] + lean(k)[i]);
            // The outermost handles lead nowhere.
            let handles = [(k > 0).then_some(before), Some(*p), (k + 1 < points.len()).then_some(after)];
            spline.controls.extend(handles.into_iter().flatten().map(|c| [c[0], c[1], 1.0]));
            spline.knots.extend([k as f64; 3]);
        }
        spline.knots.push(points.len().saturating_sub(1) as f64);
        spline
    }

    /// Whether knots and control points fit together.
    fn is_sound(&self) -> bool {
        DEGREES.contains(&self.degree)
            && self.controls.len() > self.degree
            && self.knots.len() == self.controls.len() + self.degree + 1
            && self.knots.is_sorted()
            && self.controls.iter().all(|c| c[2] > 0.0)
    }

    fn points(&self, error: f64, enough: usize) -> Vec<Point> {
        if !self.is_sound() {
            return self.controls.iter().map(|c| if c[2] > 0.0 { [c[0] / c[2], c[1] / c[2]] } else { [c[0], c[1]] }).collect();
        }
        let mut points = Vec::new();
        for (k, ends) in self.knots.windows(2).enumerate().take(self.controls.len()).skip(self.degree) {
            if ends[0] < ends[1] && points.len() < enough {
                let (from, to) = (self.at(k, ends[0]), self.at(k, ends[1]));
                if points.is_empty() {
                    points.push(from);
                }
                self.halve(k, [(ends[0], from), (ends[1], to)], error, HALVINGS, &mut points);
            }
        }
        points
    }

    /// Points after the first end of a piece, up to its second.
    fn halve(&self, span: usize, ends: [(f64, Point); 2], error: f64, left: u32, points: &mut Vec<Point>) {
        let [(t0, from), (t1, to)] = ends;
        let at = |share: f64| t0 + share * (t1 - t0);
        // Bends that a few places miss are small: between knots a spline is one polynomial.
        let flat = || self.degree == 1 || (1..8).all(|k| distance(self.at(span, at(f64::from(k) / 8.0)), from, to) <= error);
        if left == 0 || flat() {
            points.push(to);
            return;
        }
        let middle = (at(0.5), self.at(span, at(0.5)));
        self.halve(span, [ends[0], middle], error, left - 1, points);
        self.halve(span, [middle, ends[1]], error, left - 1, points);
    }

    /// The point at `t`, between the knots `span` and the next (de Boor).
    fn at(&self, span: usize, t: f64) -> Point {
        let p = self.degree;
        let mut d: Vec<Space> = self.controls[span - p..=span].to_vec();
        for r in 1..=p {
            for j in (r..=p).rev() {
                let (low, high) = (self.knots[span - p + j], self.knots[span + 1 + j - r]);
                let share = if high > low { (t - low) / (high - low) } else { 0.0 };
                let before = d[j - 1];
                d[j] = [0, 1, 2].map(|i| (1.0 - share) * before[i] + share * d[j][i]);
            }
        }
        [d[p][0] / d[p][2], d[p][1] / d[p][2]]
    }
}

/// From a point to a straight piece.
fn distance(p: Point, from: Point, to: Point) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let off = [p[0] - from[0], p[1] - from[1]];
    let length = way[0] * way[0] + way[1] * way[1];
    let share = if length > 0.0 { ((off[0] * way[0] + off[1] * way[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    (off[0] - share * way[0]).hypot(off[1] - share * way[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn worst(points: &[Point], chords: &[Point]) -> f64 {
        let nearest = |p: &Point| chords.windows(2).map(|w| distance(*p, w[0], w[1])).fold(f64::INFINITY, f64::min);
        points.iter().map(nearest).fold(0.0, f64::max)
    }

    fn near(a: Point, b: Point) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9
    }

    #[test]
    fn a_normal_that_points_down_mirrors_x() {
        let down = Affine::of_plane([0.0, 0.0, -1.0], 5.0);
        assert!(near(down.point([2.0, 3.0]), [-2.0, 3.0]));
        assert_eq!(Affine::of_plane([0.0; 3], 0.0), Affine::IDENTITY);
        // Seen from above, a wall's elevation is a line.
        let wall = Affine::of_plane([0.0, -1.0, 0.0], -2.0);
        assert!(near(wall.point([3.0, 7.0]), [3.0, 2.0]));
    }

    #[test]
    fn a_door_leafs_arc_bulges_to_the_right_of_its_chord() {
        // Counter-clockwise from (1, 0) to (0, 1) around the origin: a quarter.
        let quarter = [Vertex { at: [1.0, 0.0], bulge: (PI / 8.0).tan(), width: 0.0 }, Vertex { at: [0.0, 1.0], bulge: 0.0, width: 0.0 }];
        let points = Curve::Chain(quarter.to_vec()).points(false, 1e-4, usize::MAX);
        assert!(points.len() > 20 && points.iter().all(|p| (p[0].hypot(p[1]) - 1.0).abs() < 1e-12), "{points:?}");
        let ring = Curve::Chain(vec![Vertex { bulge: 1.0, ..quarter[0] }, Vertex { at: [-1.0, 0.0], bulge: 1.0, width: 0.0 }]);
        let points = ring.points(true, 1e-4, usize::MAX);
        assert!(near(points[0], *points.last().unwrap()) && points.iter().any(|p| p[1] < -0.99) && points.iter().any(|p| p[1] > 0.99));
    }

    #[test]
    fn chords_are_few_on_small_circles_and_bounded_on_large_ones() {
        let count = |radius, error| Arc::of_circle([0.0; 2], radius, 0.0, TAU).chords(error);
        assert_eq!([count(1.0, f64::INFINITY), count(0.0, 0.01), count(1e300, 0.01), count(f64::NAN, 0.01)], [8, 8, 720, 8]);
    }

    #[test]
    fn a_way_through_points_goes_through_them_and_straight_ones_stay_straight() {
        let points: Vec<Point> = vec![[0.0, 0.0], [3.0, 4.0], [6.0, -1.0], [9.0, 2.0]];
        let way = Spline::through(&points);
        assert!(way.is_sound());
        let chords = way.points(1e-3, usize::MAX);
        assert!(chords.len() > 20 && worst(&points, &chords) < 1e-12, "{chords:?}");
        let straight: Vec<Point> = (0..5).map(|k| [f64::from(k), 2.0 * f64::from(k)]).collect();
        assert!(worst(&Spline::through(&straight).points(1e-3, usize::MAX), &straight) < 1e-12);
        assert!(Spline::through(&[]).points(1e-3, usize::MAX).is_empty());
        assert_eq!(Spline::through(&points[..1]).points(1e-3, usize::MAX), points[..1]);
    }

    #[test]
    fn there_are_not_many_more_points_than_room() {
        let wave: Vec<Vertex> = (0..1000).map(|k| Vertex { at: [f64::from(k), 0.0], bulge: 1.0, width: 0.0 }).collect();
        assert!((50..1000).contains(&Curve::Chain(wave).points(false, 0.0, 50).len()));
    }

    #[test]
    fn a_rational_spline_is_a_circle() {
        let half = 0.5f64.sqrt();
        let quarter = Spline {
            degree: 2,
            knots: vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            controls: vec![[1.0, 0.0, 1.0], [half, half, half], [0.0, 1.0, 1.0]],
        };
        let points = quarter.points(1e-4, usize::MAX);
        assert!(points.len() > 8 && points.iter().all(|p| (p[0].hypot(p[1]) - 1.0).abs() < 1e-12), "{points:?}");
        let unsound = Spline { knots: vec![0.0], ..quarter };
        assert_eq!(unsound.points(1e-4, usize::MAX).len(), 3, "the control polygon stands for it");
    }

    proptest! {
        #[test]
        fn chords_keep_to_the_error(
            (a, b) in (0.1..9.0f64, 0.1..9.0f64), from_rad in -7.0..7.0f64, sweep in 0.01..TAU, error in 0.001..0.1f64,
        ) {
            let arc = Arc { centre: [3.0, -2.0], u: [a, 0.5 * b], v: [-0.3 * b, b], from_rad, sweep_rad: sweep };
            let chords: Vec<Point> = arc.points(error).collect();
            let dense: Vec<Point> = arc.points(0.0).collect();
            prop_assert!(worst(&dense, &chords) <= error * (1.0 + 1e-9));
        }

        #[test]
        fn splines_keep_to_the_error(
            controls in prop::collection::vec((-9.0..9.0f64, -9.0..9.0f64, 0.5..2.0f64), 4..9), error in 0.001..0.1f64,
        ) {
            let inner = controls.len() - 3;
            let knots = [0; 3].into_iter().chain(0..=inner).chain([inner; 3]).map(|k| k as f64).collect();
            let controls = controls.into_iter().map(|(x, y, w)| [x * w, y * w, w]).collect();
            let spline = Spline { degree: 3, knots, controls };
            let (chords, dense) = (spline.points(error, usize::MAX), spline.points(0.0, usize::MAX));
            // Seven places of each piece are looked at, not all: in between it may be a little worse.
            prop_assert!(worst(&dense, &chords) <= 1.5 * error, "{} of {error}", worst(&dense, &chords));
            let ends = [spline.controls[0], *spline.controls.last().unwrap()].map(|c| [c[0] / c[2], c[1] / c[2]]);
            prop_assert!(near(chords[0], ends[0]) && near(*chords.last().unwrap(), ends[1]));
        }

        #[test]
        fn moves_compose(v in prop::array::uniform8(-5.0..5.0f64)) {
            let a = Affine::turn(v[0]).after(&Affine::scale(v[1], v[2])).after(&Affine::shift([v[3], v[4]]));
            let b = Affine::of_plane([v[5], v[6], v[7]], v[0]);
            let p = [v[2], v[6]];
            prop_assert!(near(a.after(&b).point(p), a.point(b.point(p))));
        }
    }
}
