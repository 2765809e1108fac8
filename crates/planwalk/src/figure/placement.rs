//! Where on the plan does a path fit without hitting a wall? (Chu, figure 6.)

use planwalk_types::{FloorPlan, Plan, PlanPose, Pt2, Stamp};

use super::colour;
use super::map::{Bounds, MapView};
use super::marks;
use super::svg::{Anchor, Pen, Svg};

/// All possible starts of a path, and the path at one of them.
#[derive(Debug, Clone, Copy)]
pub struct PlacementPicture<'a> {
    /// What is shown, e.g. the names of the path and the plan.
    pub title: &'a str,
    /// The plan.
    pub plan: &'a FloorPlan,
    /// Whether the path can start there, one entry a plan cell, row 0 at the bottom.
    pub start_region: &'a [bool],
    /// Area of that region, m².
    pub area_m2: f64,
    /// Whether the path can end there.
    pub end_region: &'a [bool],
    /// Area of that region, m².
    pub end_area_m2: f64,
    /// The path at its best placements, the best first; empty where it fits nowhere.
    pub best: &'a [Vec<(Stamp, PlanPose)>],
    /// Whether the path drifts: it then fits bent, and is drawn as it was measured.
    pub drifts: bool,
    /// Under what the region holds, e.g. `all headings, scale 0.8 to 1.2`.
    pub conditions: &'a str,
}

const ROOM_PX: (f64, f64) = (1100.0, 820.0);
const LEFT_PX: f64 = 70.0;
const TOP_PX: f64 = 118.0;

impl PlacementPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let path: Vec<Pt2<Plan>> = self.best.iter().flatten().map(|(_, pose)| pose.origin()).collect();
        let bounds = Bounds::of_walls(self.plan).and(Bounds::of(path.into_iter())).grown(0.8);
        let view = MapView::fit(bounds, LEFT_PX, TOP_PX, ROOM_PX);
        let (width, height) = view.size_px();
        let mut svg = Svg::new("placement", LEFT_PX + width.max(900.0) + 30.0, TOP_PX + height + 92.0, self.title);
        let left = LEFT_PX - 40.0;
        svg.bold(&super::track::shortened(self.title, 80), (left, 36.0), 13.0, Anchor::Left, colour::INK);
        let found = if self.best.is_empty() {
            "The path fits nowhere on this plan".to_owned()
        } else {
            format!(
                "The path can start anywhere in the red region, {:.1} m², and end in the blue one, {:.1} m²",
                self.area_m2, self.end_area_m2
            )
        };
        svg.text(&format!("{found} ({}).", self.conditions), (left, 64.0), 10.0, Anchor::Left, colour::INK);
        view.draw_plan(&mut svg, self.plan);
        view.clip(&mut svg);
        // One possible start in a pooled cell is enough to show: a small region must not vanish.
        for (region, fill) in [(self.end_region, colour::PATH), (self.start_region, colour::RED)] {
            view.fill_cells(&mut svg, self.plan, fill, 0.5, true, &|i| region.get(i).copied().unwrap_or(false));
        }
        for (i, walk) in self.best.iter().enumerate().rev() {
            let pen = if i == 0 { Pen::new(colour::PATH, 3.0) } else { Pen::new(colour::OTHERS[(i - 1) % colour::OTHERS.len()], 2.0) };
            let pen = if self.drifts { pen.dashed("7 5") } else { pen };
            marks::plain_walk(&mut svg, &view, walk.iter().copied(), Pen::new("#ffffff", pen.width_px + 3.0).faint(0.8));
            marks::plain_walk(&mut svg, &view, walk.iter().copied(), pen);
        }
        if let (Some((_, first)), Some((_, last))) = (self.best.first().and_then(|w| w.first()), self.best.first().and_then(|w| w.last())) {
            marks::pose_marker(&mut svg, view.px(first.origin()), first.heading_rad, colour::START);
            marks::pose_marker(&mut svg, view.px(last.origin()), last.heading_rad, colour::END);
        }
        svg.end_clip();
        view.draw_axes(&mut svg);
        view.draw_scale_bar(&mut svg);
        self.legend(&mut svg, TOP_PX + height + 70.0);
        svg.finish()
    }

    fn legend(&self, svg: &mut Svg, y: f64) {
        let mut x = LEFT_PX;
        for (fill, words, wide) in [(colour::RED, "possible starts", 170.0), (colour::PATH, "possible ends", 165.0)] {
            svg.rect(x, y - 12.0, 26.0, 15.0, fill, 0.5);
            svg.text(words, (x + 34.0, y), 9.5, Anchor::Left, colour::INK);
            x += wide;
        }
        let pen = Pen::new(colour::PATH, 3.0);
        let (pen, words) = if self.drifts { (pen.dashed("7 5"), "as measured, at its best") } else { (pen, "the path at its best") };
        svg.line((x, y - 4.5), (x + 26.0, y - 4.5), pen);
        svg.text(words, (x + 34.0, y), 9.5, Anchor::Left, colour::INK);
        x += 235.0;
        marks::pose_marker(svg, (x, y - 4.5), 0.0, colour::START);
        svg.text("its start", (x + 28.0, y), 9.5, Anchor::Left, colour::INK);
        x += 110.0;
        marks::pose_marker(svg, (x, y - 4.5), 0.0, colour::END);
        svg.text("its end", (x + 28.0, y), 9.5, Anchor::Left, colour::INK);
    }
}
