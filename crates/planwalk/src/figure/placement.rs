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
    /// The path at its best placement; empty where it fits nowhere.
    pub best: &'a [(Stamp, PlanPose)],
    /// Under what the region holds, e.g. `all headings, scale 0.8 to 1.2`.
    pub conditions: &'a str,
}

const ROOM_PX: (f64, f64) = (1100.0, 820.0);
const LEFT_PX: f64 = 70.0;
const TOP_PX: f64 = 118.0;

impl PlacementPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let path: Vec<Pt2<Plan>> = self.best.iter().map(|(_, pose)| pose.origin()).collect();
        let bounds = Bounds::of_walls(self.plan).and(Bounds::of(path.into_iter())).grown(0.8);
        let view = MapView::fit(bounds, LEFT_PX, TOP_PX, ROOM_PX);
        let (width, height) = view.size_px();
        let mut svg = Svg::new("placement", LEFT_PX + width.max(640.0) + 30.0, TOP_PX + height + 92.0, self.title);
        let left = LEFT_PX - 40.0;
        svg.bold(&super::track::shortened(self.title, 80), (left, 36.0), 13.0, Anchor::Left, colour::INK);
        let found = if self.best.is_empty() {
            "The path fits nowhere on this plan".to_owned()
        } else {
            format!("The path can start anywhere in the red region: {:.1} m²", self.area_m2)
        };
        svg.text(&format!("{found} ({}).", self.conditions), (left, 64.0), 10.0, Anchor::Left, colour::INK);
        view.draw_plan(&mut svg, self.plan);
        view.clip(&mut svg);
        // One possible start in a pooled cell is enough to show: a small region must not vanish.
        view.fill_cells(&mut svg, self.plan, colour::RED, 0.6, true, &|i| self.start_region.get(i).copied().unwrap_or(false));
        marks::plain_walk(&mut svg, &view, self.best.iter().copied(), Pen::new("#ffffff", 6.0).faint(0.8));
        marks::plain_walk(&mut svg, &view, self.best.iter().copied(), Pen::new(colour::PATH, 3.0));
        if let (Some((_, first)), Some((_, last))) = (self.best.first(), self.best.last()) {
            marks::pose_marker(&mut svg, view.px(first.origin()), first.heading_rad, colour::START);
            marks::pose_marker(&mut svg, view.px(last.origin()), last.heading_rad, colour::END);
        }
        svg.end_clip();
        view.draw_axes(&mut svg);
        view.draw_scale_bar(&mut svg);
        legend(&mut svg, TOP_PX + height + 70.0);
        svg.finish()
    }
}

fn legend(svg: &mut Svg, y: f64) {
    let mut x = LEFT_PX;
    svg.rect(x, y - 12.0, 26.0, 15.0, colour::RED, 0.6);
    svg.text("possible starts", (x + 34.0, y), 9.5, Anchor::Left, colour::INK);
    x += 170.0;
    svg.line((x, y - 4.5), (x + 26.0, y - 4.5), Pen::new(colour::PATH, 3.0));
    svg.text("the path at its best placement", (x + 34.0, y), 9.5, Anchor::Left, colour::INK);
    x += 282.0;
    marks::pose_marker(svg, (x, y - 4.5), 0.0, colour::START);
    svg.text("its start", (x + 28.0, y), 9.5, Anchor::Left, colour::INK);
    x += 110.0;
    marks::pose_marker(svg, (x, y - 4.5), 0.0, colour::END);
    svg.text("its end", (x + 28.0, y), 9.5, Anchor::Left, colour::INK);
}
