//! How did the camera move by itself, without any plan? Seen from above: X to the right, Z ahead of the first frame.
//!
//! The first frame looks along +Z; red needles show where the camera looked (Chu, figure 9), dots the points that it saw.

use nalgebra::Vector3;
use planwalk_types::{CameraPose, Sighting, TrackingState};

use super::colour;
use super::map::{multiples, round_step, tick_text};
use super::marks::round_moments;
use super::svg::{Anchor, Pen, Svg};

/// The camera's path in the first camera's X–Z plane.
#[derive(Debug, Clone, Copy)]
pub struct TrajectoryPicture<'a> {
    /// What is shown, e.g. the video's name and the solver.
    pub title: &'a str,
    /// One pose a frame, in time order.
    pub poses: &'a [CameraPose],
    /// Points of the map as the poses saw them, in time order.
    pub sightings: &'a [Sighting],
}

const LEFT_PX: f64 = 86.0;
const TOP_PX: f64 = 92.0;
const ROOM_PX: f64 = 760.0;
/// Needles along the whole path; more would be a comb.
const NEEDLES: usize = 60;
const NEEDLE_PX: f64 = 24.0;
/// Points that are drawn at most, and how well their distance must be known, as a share of it: vaguer ones smear every wall.
const POINTS: usize = 4000;
const SURE: f64 = 0.1;
/// Share of the points, at each end of each axis, for which the sheet is not made larger.
const STRAY: f64 = 0.02;

/// One frame in the plane.
struct Flat {
    x: f64,
    z: f64,
    /// Where the camera looks, in the plane; shorter than 1 when it looks up or down.
    look: (f64, f64),
}

impl TrajectoryPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let (flat, points) = (self.flat(), self.points());
        let side = |walked: &dyn Fn(&Flat) -> f64, seen: &dyn Fn(&(f64, f64)) -> f64| {
            let (low, high) = span(points.iter().map(seen).collect());
            let low = flat.iter().map(walked).fold(low, f64::min);
            let high = flat.iter().map(walked).fold(high, f64::max);
            (low, high)
        };
        let (xs, zs) = (side(&|f| f.x, &|p| p.0), side(&|f| f.z, &|p| p.1));
        // A standing camera still gets a sheet with a scale.
        let margin = 0.07 * (xs.1 - xs.0).max(zs.1 - zs.0).max(1e-6);
        let (xs, zs) = ((xs.0 - margin, xs.1 + margin), (zs.0 - margin, zs.1 + margin));
        let px_per_unit = ROOM_PX / (xs.1 - xs.0).max(zs.1 - zs.0);
        let (width, height) = ((xs.1 - xs.0) * px_per_unit, (zs.1 - zs.0) * px_per_unit);
        let place = |x: f64, z: f64| (LEFT_PX + (x - xs.0) * px_per_unit, TOP_PX + (zs.1 - z) * px_per_unit);
        let mut svg = Svg::new("trajectory", LEFT_PX + width.max(470.0) + 40.0, TOP_PX + height + 96.0, self.title);
        self.header(&mut svg);
        axes(&mut svg, xs, zs, px_per_unit);
        svg.begin_clip(LEFT_PX - 24.0, TOP_PX - 24.0, width + 48.0, height + 48.0);
        for (x, z) in &points {
            svg.circle(place(*x, *z), 1.3, colour::FAINT_INK, Pen::new("none", 0.0));
        }
        self.curve(&mut svg, &flat, &place);
        self.needles(&mut svg, &flat, &place);
        self.moments(&mut svg, &flat, &place);
        svg.end_clip();
        legend(&mut svg, TOP_PX + height + 72.0);
        svg.finish()
    }

    fn flat(&self) -> Vec<Flat> {
        let Some(first) = self.poses.first() else { return Vec::new() };
        let first_from_odom = first.odom_from_camera.inverse();
        self.poses
            .iter()
            .map(|pose| {
                let first_from_camera = first_from_odom * pose.odom_from_camera;
                let at = first_from_camera.iso.translation.vector;
                let look = first_from_camera.iso.rotation * Vector3::z();
                Flat { x: at.x, z: at.z, look: (look.x, look.z) }
            })
            .collect()
    }

    /// The points that it saw, in the plane.
    fn points(&self) -> Vec<(f64, f64)> {
        let Some(first) = self.poses.first() else { return Vec::new() };
        let first_from_odom = first.odom_from_camera.inverse();
        let sure: Vec<&Sighting> = self.sightings.iter().filter(|s| s.sigma < SURE * s.range).collect();
        let every = sure.len().div_ceil(POINTS).max(1);
        let point = |sighting: &&Sighting| {
            let at = self.poses.binary_search_by_key(&sighting.stamp, |p| p.stamp).ok()?;
            let iso = self.poses[at].odom_from_camera.iso;
            let ahead = iso.rotation * Vector3::z();
            let heading_rad = ahead.y.atan2(ahead.x) + sighting.bearing_rad;
            let way = Vector3::new(heading_rad.cos(), heading_rad.sin(), 0.0) * sighting.range;
            let seen = first_from_odom.iso * nalgebra::Point3::from(iso.translation.vector + way);
            Some((seen.x, seen.z))
        };
        sure.into_iter().step_by(every).filter_map(|s| point(&s)).collect()
    }

    fn header(&self, svg: &mut Svg) {
        svg.bold(&super::track::shortened(self.title, 56), (LEFT_PX - 50.0, 34.0), 12.5, Anchor::Left, colour::INK);
        let seen = self.poses.iter().filter(|p| p.state == TrackingState::Mapped).count();
        let turned = self.poses.iter().filter(|p| p.state == TrackingState::RotationOnly).count();
        let guessed = self.poses.len() - seen - turned;
        let line = format!("{} frames: {seen} posed on the map, {turned} by rotation only, {guessed} carried on unseen", self.poses.len());
        svg.text(&line, (LEFT_PX - 50.0, 58.0), 9.0, Anchor::Left, colour::FAINT_INK);
    }

    fn needles(&self, svg: &mut Svg, flat: &[Flat], place: &dyn Fn(f64, f64) -> (f64, f64)) {
        let every = flat.len().div_ceil(NEEDLES).max(1);
        for frame in flat.iter().step_by(every) {
            let at = place(frame.x, frame.z);
            svg.line(at, (at.0 + NEEDLE_PX * frame.look.0, at.1 - NEEDLE_PX * frame.look.1), Pen::new(colour::RED, 1.5));
        }
    }

    /// Blue where the camera saw its way; grey and dotted where the motion was only carried on.
    fn curve(&self, svg: &mut Svg, flat: &[Flat], place: &dyn Fn(f64, f64) -> (f64, f64)) {
        let unseen = |i: usize| self.poses[i].state == TrackingState::Propagated;
        let mut start = 0;
        while start + 1 < flat.len() {
            // A step is as good as the frame it leads to.
            let kind = unseen(start + 1);
            let end = (start + 1..flat.len()).find(|i| unseen(*i) != kind).unwrap_or(flat.len());
            let line: Vec<_> = flat[start..end].iter().map(|f| place(f.x, f.z)).collect();
            let pen = if kind { Pen::new(colour::FAINT_INK, 2.4).dashed("2 5") } else { Pen::new(colour::PATH, 2.6) };
            svg.polyline(&line, pen);
            start = end - 1;
        }
    }

    fn moments(&self, svg: &mut Svg, flat: &[Flat], place: &dyn Fn(f64, f64) -> (f64, f64)) {
        let (Some(first), Some(last), Some(end)) = (self.poses.first(), self.poses.last(), flat.last()) else { return };
        let mut taken = vec![place(0.0, 0.0), place(end.x, end.z)];
        for seconds in round_moments(first.stamp, last.stamp).1 {
            let i = self.poses.partition_point(|p| p.stamp.secs_since(first.stamp) < seconds).min(flat.len() - 1);
            let heading_rad = flat[i].look.1.atan2(flat[i].look.0);
            super::marks::time_tick(svg, place(flat[i].x, flat[i].z), heading_rad, &format!("{seconds} s"), &mut taken);
        }
        svg.circle(place(0.0, 0.0), 6.0, colour::START, Pen::new("#ffffff", 1.5));
        svg.circle(place(end.x, end.z), 6.0, colour::END, Pen::new("#ffffff", 1.5));
    }
}

/// From where to where most of these lie, and zero.
fn span(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1) as f64;
    let at = |share: f64| values.get((share * last).round() as usize).copied().unwrap_or(0.0);
    (at(STRAY).min(0.0), at(1.0 - STRAY).max(0.0))
}

fn axes(svg: &mut Svg, xs: (f64, f64), zs: (f64, f64), px_per_unit: f64) {
    let (width, height) = ((xs.1 - xs.0) * px_per_unit, (zs.1 - zs.0) * px_per_unit);
    let bottom = TOP_PX + height;
    let step = round_step(70.0 / px_per_unit);
    let (pen, grid) = (Pen::new(colour::FAINT_INK, 1.0), Pen::new(colour::OUTSIDE, 1.0));
    for x in multiples(step, xs.0, xs.1) {
        let u = LEFT_PX + (x - xs.0) * px_per_unit;
        svg.line((u, TOP_PX), (u, bottom), grid);
        svg.text(&tick_text(x, step), (u, bottom + 18.0), 9.0, Anchor::Middle, colour::FAINT_INK);
    }
    for z in multiples(step, zs.0, zs.1) {
        let v = TOP_PX + (zs.1 - z) * px_per_unit;
        svg.line((LEFT_PX, v), (LEFT_PX + width, v), grid);
        svg.text(&tick_text(z, step), (LEFT_PX - 9.0, v + 4.5), 9.0, Anchor::Right, colour::FAINT_INK);
    }
    svg.frame(LEFT_PX, TOP_PX, width, height, pen);
    svg.text("X / units of odometry", (LEFT_PX + width, bottom + 38.0), 9.0, Anchor::Right, colour::FAINT_INK);
    svg.text("Z / units (the first frame looks up the sheet)", (LEFT_PX - 50.0, TOP_PX - 12.0), 9.0, Anchor::Left, colour::FAINT_INK);
}

fn legend(svg: &mut Svg, y: f64) {
    let mut x = LEFT_PX - 40.0;
    svg.circle((x, y - 4.0), 6.0, colour::START, Pen::new("#ffffff", 1.5));
    svg.text("start", (x + 12.0, y), 9.0, Anchor::Left, colour::INK);
    x += 72.0;
    svg.circle((x, y - 4.0), 6.0, colour::END, Pen::new("#ffffff", 1.5));
    svg.text("end", (x + 12.0, y), 9.0, Anchor::Left, colour::INK);
    x += 56.0;
    svg.line((x, y - 4.0), (x + 26.0, y - 4.0), Pen::new(colour::PATH, 2.6));
    svg.text("seen", (x + 34.0, y), 9.0, Anchor::Left, colour::INK);
    x += 88.0;
    svg.line((x, y - 4.0), (x + 26.0, y - 4.0), Pen::new(colour::FAINT_INK, 2.4).dashed("2 5"));
    svg.text("unseen", (x + 34.0, y), 9.0, Anchor::Left, colour::INK);
    x += 104.0;
    svg.line((x, y - 4.0), (x + 24.0, y - 4.0), Pen::new(colour::RED, 1.5));
    svg.text("looks there", (x + 32.0, y), 9.0, Anchor::Left, colour::INK);
    x += 118.0;
    [0.0, 6.0, 12.0].iter().for_each(|right| svg.circle((x + right, y - 4.0), 1.3, colour::FAINT_INK, Pen::new("none", 0.0)));
    svg.text("points", (x + 20.0, y), 9.0, Anchor::Left, colour::INK);
}
