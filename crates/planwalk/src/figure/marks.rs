//! How are a pose, a walk and its doubt drawn on a map?

use nalgebra::Matrix3;
use planwalk_locate::ContradictedKind;
use planwalk_types::{PlanPose, Pt2, Stamp};

use super::colour;
use super::map::{MapView, round_step};
use super::svg::{Anchor, Pen, Svg};

/// √ of the 95 % point of χ² with two degrees of freedom.
const SIGMAS_95: f64 = 2.447_746_830_680_816;

/// Points of a walk closer than this on the sheet are drawn as one.
const LEAST_MOVE_PX: f64 = 0.8;

/// The walk as points on the sheet, without those that would fall on the one before.
pub(super) fn walk_px(view: &MapView, walk: impl Iterator<Item = (Stamp, PlanPose)>) -> Vec<(Stamp, (f64, f64))> {
    let mut points: Vec<(Stamp, (f64, f64))> = Vec::new();
    let mut skipped = None;
    for (stamp, pose) in walk {
        let at = view.px(pose.origin());
        let far = points.last().is_none_or(|(_, b)| (at.0 - b.0).hypot(at.1 - b.1) >= LEAST_MOVE_PX);
        if !(at.0.is_finite() && at.1.is_finite()) {
            continue;
        }
        if far {
            points.push((stamp, at));
            skipped = None;
        } else {
            skipped = Some((stamp, at));
        }
    }
    points.extend(skipped);
    points
}

/// A walk in one colour.
pub(super) fn plain_walk(svg: &mut Svg, view: &MapView, walk: impl Iterator<Item = (Stamp, PlanPose)>, pen: Pen) {
    let points: Vec<(f64, f64)> = walk_px(view, walk).into_iter().map(|(_, p)| p).collect();
    svg.polyline(&points, pen);
}

/// A walk coloured by time, from `span.0` to `span.1`, in at most 160 pieces.
pub(super) fn timed_walk(svg: &mut Svg, view: &MapView, walk: impl Iterator<Item = (Stamp, PlanPose)>, span: (Stamp, Stamp)) {
    let points = walk_px(view, walk);
    let plain: Vec<(f64, f64)> = points.iter().map(|(_, p)| *p).collect();
    svg.polyline(&plain, Pen::new("#ffffff", 8.0).faint(0.9));
    svg.polyline(&plain, Pen::new(colour::INK, 5.4).faint(0.55));
    let length_s = span.1.secs_since(span.0).max(1e-9);
    let piece = points.len().div_ceil(160).max(1);
    for start in (0..points.len()).step_by(piece) {
        // Each piece reaches the first point of the next, so that no gap shows.
        let part = &points[start..(start + piece + 1).min(points.len())];
        let share = part[part.len() / 2].0.secs_since(span.0) / length_s;
        let line: Vec<(f64, f64)> = part.iter().map(|(_, p)| *p).collect();
        svg.polyline(&line, Pen::new(&colour::of_time(share), 4.2));
    }
}

/// The 95 % region of a Gaussian (x, y); nothing where the covariance is none.
pub(super) fn ellipse(svg: &mut Svg, view: &MapView, pose: PlanPose, covariance: &Matrix3<f64>) {
    let (a, b, c) = (covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]);
    let (mean, spread) = (0.5 * (a + c), (0.25 * (a - c).powi(2) + b * b).sqrt());
    let (long, short) = ((mean + spread).sqrt() * SIGMAS_95, (mean - spread).max(0.0).sqrt() * SIGMAS_95);
    if !(long.is_finite() && short.is_finite() && long > 0.0) {
        return;
    }
    let tilt = 0.5 * (2.0 * b).atan2(a - c);
    let (sin, cos) = tilt.sin_cos();
    let points: Vec<(f64, f64)> = (0..48)
        .map(|i| {
            let (s, c) = (f64::from(i) * std::f64::consts::TAU / 48.0).sin_cos();
            let (u, v) = (long * c, short * s);
            view.px(Pt2::new(pose.x + cos * u - sin * v, pose.y + sin * u + cos * v))
        })
        .collect();
    svg.polygon(&points, colour::DOUBT, 0.13, Pen::new(colour::DOUBT, 1.2).faint(0.75));
}

/// A disc with a needle to where the walker faces.
pub(super) fn pose_marker(svg: &mut Svg, at: (f64, f64), heading_rad: f64, fill: &str) {
    // y is down on the sheet.
    let (dx, dy) = (heading_rad.cos(), -heading_rad.sin());
    let reach = |r: f64, side: f64| (at.0 + r * dx - side * dy, at.1 + r * dy + side * dx);
    let pen = Pen::new("#ffffff", 1.6);
    svg.polygon(&[reach(20.0, 0.0), reach(6.0, 6.5), reach(6.0, -6.5)], fill, 1.0, pen);
    svg.circle(at, 7.5, fill, pen);
}

/// A cross where a drawn wall was walked through; a ring, at least as wide as `reach_px`, around what was seen through.
pub(super) fn contradiction(svg: &mut Svg, at: (f64, f64), kind: ContradictedKind, reach_px: f64) {
    match kind {
        ContradictedKind::Crossed => {
            for pen in [Pen::new("#ffffff", 6.0), Pen::new(colour::RED, 3.0)] {
                svg.line((at.0 - 6.0, at.1 - 6.0), (at.0 + 6.0, at.1 + 6.0), pen);
                svg.line((at.0 - 6.0, at.1 + 6.0), (at.0 + 6.0, at.1 - 6.0), pen);
            }
        }
        ContradictedKind::SeenThrough => svg.circle(at, reach_px.clamp(8.0, 400.0), "none", Pen::new(colour::RED, 2.0).dashed("4 3")),
    }
}

/// Round moments after `start`: every 10 s; more often on a short walk, and a dozen at most on a long one.
pub(super) fn round_moments(start: Stamp, end: Stamp) -> (f64, Vec<f64>) {
    let length_s = end.secs_since(start);
    let step_s = if length_s > 130.0 {
        round_step(length_s / 12.0)
    } else if length_s < 25.0 {
        round_step(length_s / 5.0)
    } else {
        10.0
    };
    let all = (1..).map(|i| f64::from(i) * step_s).take_while(|t| *t < length_s - 0.3 * step_s).take(100).collect();
    (step_s, all)
}

/// A small dot across the walk with its time beside it; `false` when the label would lie on one of `taken`.
pub(super) fn time_tick(svg: &mut Svg, at: (f64, f64), heading_rad: f64, text: &str, taken: &mut Vec<(f64, f64)>) {
    svg.circle(at, 3.4, "#ffffff", Pen::new(colour::INK, 1.6));
    let sides = [1.0, -1.0].map(|side: f64| {
        let (dx, dy) = (-heading_rad.sin() * side, -heading_rad.cos() * side);
        (at.0 + 22.0 * dx, at.1 + 18.0 * dy + 4.5)
    });
    let free = |p: &(f64, f64)| taken.iter().all(|q| (p.0 - q.0).abs() > 38.0 || (p.1 - q.1).abs() > 15.0);
    if let Some(place) = sides.into_iter().find(free) {
        svg.label(text, place, 9.0, Anchor::Middle, colour::INK);
        taken.push(place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_every_ten_seconds_and_never_too_many() {
        let end = |s: f64| Stamp::from_secs(s).unwrap();
        assert_eq!(round_moments(Stamp(0), end(32.0)), (10.0, vec![10.0, 20.0]));
        assert_eq!(round_moments(Stamp(0), end(9.0)).0, 2.0);
        assert!(round_moments(Stamp(0), end(36_000.0)).1.len() <= 12);
        assert!(round_moments(Stamp(0), Stamp(0)).1.is_empty());
    }
}
