//! How did the filter's belief shrink to a place? A few moments of the walk, each with its particles (Chu, figure 7).
//!
//! The same panel, alone and small, is a frame of the animation.

use planwalk_types::{FloorPlan, Plan, PlanPose, Pt2, Stamp, Status};

use super::colour;
use super::map::{Bounds, MapView};
use super::marks;
use super::svg::{Anchor, Pen, Svg};
use crate::words;

/// Particles over the plan at some moments.
#[derive(Debug, Clone, Copy)]
pub struct ParticlePicture<'a> {
    /// What is shown, e.g. the names of the video and the plan.
    pub title: &'a str,
    /// The plan.
    pub plan: &'a FloorPlan,
    /// The whole walk as known at its end.
    pub track: &'a [(Stamp, PlanPose)],
    /// The moments in time order, one panel each.
    pub moments: &'a [ParticleCloud],
}

/// Where the particles were at one moment.
#[derive(Debug, Clone)]
pub struct ParticleCloud {
    /// The moment.
    pub stamp: Stamp,
    /// How many particles there were; `places` may be a part of them.
    pub count: usize,
    /// Places on the plan.
    pub places: Vec<Pt2<Plan>>,
    /// Ground that they cover, m².
    pub area_m2: f64,
    /// Separate places with at least 1 % of the mass.
    pub modes: usize,
    /// The verdict at that moment.
    pub status: Status,
    /// Metres per unit of odometry: mean of the particles.
    pub metres_per_unit: f64,
    /// Its relative standard deviation.
    pub relative_sigma: f64,
}

const LEFT_PX: f64 = 34.0;
const TOP_PX: f64 = 84.0;
const GAP_PX: f64 = 26.0;
const CAPTION_PX: f64 = 46.0;
/// Radius of the ring around a cloud that is so small that it would be overlooked.
const RING_PX: f64 = 17.0;
/// A heap larger than a room is no place, m².
const ROOM_M2: f64 = 30.0;
/// Width of the room for all panels.
const ROOM_PX: f64 = 1360.0;

impl ParticlePicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let walk = self.track.iter().map(|(_, pose)| pose.origin());
        let bounds = Bounds::of_walls(self.plan).and(Bounds::of(walk)).grown(0.8);
        let (width_m, height_m) = bounds.size();
        // Tall plans stand side by side, wide ones in two rows.
        let most = if height_m > 1.4 * width_m || self.moments.len() > 6 { 4 } else { self.moments.len().min(6).div_ceil(2) };
        let columns = self.moments.len().clamp(1, most.max(1));
        let panel = ((ROOM_PX - GAP_PX * (columns as f64 - 1.0)) / columns as f64, 620.0);
        let (mut right, mut bottom) = (LEFT_PX + 520.0, TOP_PX);
        let mut panels = Vec::new();
        for i in 0..self.moments.len() {
            let size = MapView::fit(bounds, 0.0, 0.0, panel).size_px();
            let left = LEFT_PX + (i % columns) as f64 * (size.0 + GAP_PX);
            let top = TOP_PX + CAPTION_PX + (i / columns) as f64 * (size.1 + GAP_PX + CAPTION_PX);
            panels.push(MapView::fit(bounds, left, top, panel));
            right = right.max(left + size.0);
            bottom = top + size.1;
        }
        let mut svg = Svg::new("particles", right + LEFT_PX, bottom + 70.0, self.title);
        svg.bold(&super::track::shortened(self.title, 80), (LEFT_PX, 36.0), 13.0, Anchor::Left, colour::INK);
        let line = "Each red dot is a guess of where the walker is at that moment; the blue curve is the walk up to then.";
        svg.text(line, (LEFT_PX, 62.0), 9.0, Anchor::Left, colour::FAINT_INK);
        for (view, cloud) in panels.iter().zip(self.moments) {
            self.panel(&mut svg, view, cloud);
        }
        if let Some(last) = panels.get((panels.len().max(1) - 1) / columns * columns) {
            last.draw_scale_bar(&mut svg);
        }
        svg.finish()
    }

    /// One frame of an animation for each moment, all of one size, at most `width_px` wide.
    pub fn frames(&self, width_px: f64) -> Vec<String> {
        let walk = self.track.iter().map(|(_, pose)| pose.origin());
        let bounds = Bounds::of_walls(self.plan).and(Bounds::of(walk)).grown(0.8);
        let view = MapView::fit(bounds, 12.0, 12.0 + CAPTION_PX, (width_px - 24.0, width_px));
        let size = view.size_px();
        let frame = |cloud: &ParticleCloud| {
            // Whole pixels, and wide enough for the words.
            let mut svg = Svg::new("frame", (size.0 + 24.0).max(360.0).ceil(), (size.1 + CAPTION_PX + 24.0).ceil(), self.title);
            self.panel(&mut svg, &view, cloud);
            svg.finish()
        };
        self.moments.iter().map(frame).collect()
    }

    /// Metres of the track up to a moment.
    fn walked_m(&self, until: Stamp) -> f64 {
        let so_far = self.track.windows(2).take_while(|pair| pair[1].0 <= until);
        so_far.map(|pair| pair[0].1.origin().distance(pair[1].1.origin())).sum()
    }

    fn panel(&self, svg: &mut Svg, view: &MapView, cloud: &ParticleCloud) {
        let begin = self.track.first().map_or(cloud.stamp, |(stamp, _)| *stamp);
        let (seconds, walked_m) = (cloud.stamp.secs_since(begin), self.walked_m(cloud.stamp));
        let caption = format!("after {seconds:.1} s, {walked_m:.1} m: {}", cloud.status);
        svg.bold(&caption, (view.left_px, view.top_px - 26.0), 9.5, Anchor::Left, colour::of_status(cloud.status));
        let places = match cloud.modes {
            // One heap, but as large as a floor.
            0 | 1 if cloud.area_m2 > ROOM_M2 => format!("spread over {:.0} m²", cloud.area_m2),
            1 => "1 place".to_owned(),
            count => format!("{count} places"),
        };
        let (scale, sigma) = (words::significant(cloud.metres_per_unit), 100.0 * cloud.relative_sigma);
        let line = format!("{places}, {} particles, scale {scale} ± {sigma:.0} %", words::grouped(cloud.count));
        svg.text(&line, (view.left_px, view.top_px - 9.0), 8.5, Anchor::Left, colour::FAINT_INK);
        view.draw_plan(svg, self.plan);
        view.clip(svg);
        svg.dots(cloud.places.iter().map(|place| view.px(*place)), 2.2, colour::RED, 0.6);
        let so_far = self.track.iter().copied().take_while(|(stamp, _)| *stamp <= cloud.stamp);
        marks::plain_walk(svg, view, so_far.clone(), Pen::new("#ffffff", 4.6).faint(0.8));
        marks::plain_walk(svg, view, so_far, Pen::new(colour::PATH, 2.4));
        if let Some(centre) = small_heap(view, &cloud.places) {
            svg.circle(centre, RING_PX, "none", Pen::new(colour::RED, 2.0));
        }
        svg.end_clip();
        let (width, height) = view.size_px();
        svg.frame(view.left_px, view.top_px, width, height, Pen::new(colour::FAINT_INK, 1.0));
    }
}

/// The middle of a cloud that has shrunk to a dot on the sheet.
fn small_heap(view: &MapView, places: &[Pt2<Plan>]) -> Option<(f64, f64)> {
    let bounds = Bounds::of(places.iter().copied())?;
    let (low, high) = (view.px(Pt2::new(bounds.low.0, bounds.low.1)), view.px(Pt2::new(bounds.high.0, bounds.high.1)));
    let small = (high.0 - low.0).max(low.1 - high.1) < 2.0 * RING_PX;
    small.then_some((0.5 * (low.0 + high.0), 0.5 * (low.1 + high.1)))
}
