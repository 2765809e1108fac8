//! How did the filter's belief shrink to a place? A few moments of the walk, each with its particles (Chu, figure 7).

use planwalk_types::{FloorPlan, Plan, PlanPose, Pt2, Stamp};

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
}

const LEFT_PX: f64 = 34.0;
const TOP_PX: f64 = 84.0;
const GAP_PX: f64 = 26.0;
const CAPTION_PX: f64 = 30.0;
/// Radius of the ring around a cloud that is so small that it would be overlooked.
const RING_PX: f64 = 17.0;
/// Width of the room for all panels.
const ROOM_PX: f64 = 1360.0;

impl ParticlePicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let walk = self.track.iter().map(|(_, pose)| pose.origin());
        let bounds = Bounds::of_walls(self.plan).and(Bounds::of(walk)).grown(0.8);
        let (width_m, height_m) = bounds.size();
        // Tall plans stand side by side, wide ones two by two.
        let columns = if height_m > 1.4 * width_m { self.moments.len().clamp(1, 4) } else { self.moments.len().clamp(1, 2) };
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

    fn panel(&self, svg: &mut Svg, view: &MapView, cloud: &ParticleCloud) {
        let begin = self.track.first().map_or(cloud.stamp, |(stamp, _)| *stamp);
        let caption = format!("after {:.1} s: {} particles", cloud.stamp.secs_since(begin), words::grouped(cloud.count));
        svg.text(&caption, (view.left_px, view.top_px - 10.0), 10.0, Anchor::Left, colour::INK);
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
