//! How does an odometry lie over the truth? Both from above, after alignment.

use planwalk_types::{Plan, Pt2};

use super::colour;
use super::map::{Bounds, MapView};
use super::svg::{Anchor, Pen, Svg};
use super::track::shortened;
use crate::evaluate::odometry::AlignedPair;

/// An aligned odometry and the truth, from above.
#[derive(Debug, Clone, Copy)]
pub struct OverlayPicture<'a> {
    /// What is shown, e.g. the name of the walk.
    pub title: &'a str,
    /// The scores in a sentence.
    pub subtitle: &'a str,
    /// Pairs in the truth's frame, in time order.
    pub pairs: &'a [AlignedPair],
}

const LEFT_PX: f64 = 76.0;
const TOP_PX: f64 = 100.0;
/// Lines between estimate and truth along the whole walk; more would be a comb.
const RUNGS: usize = 60;

impl OverlayPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let place = |pose: &nalgebra::Isometry3<f64>| Pt2::<Plan>::new(pose.translation.x, pose.translation.y);
        let both = self.pairs.iter().flat_map(|p| [place(&p.estimate), place(&p.truth)]);
        let bounds = Bounds::of(both).unwrap_or(Bounds { low: (0.0, 0.0), high: (1.0, 1.0) });
        let size = bounds.size();
        let view = MapView::fit(bounds.grown(0.06 * size.0.max(size.1).max(1.0)), LEFT_PX, TOP_PX, (860.0, 680.0));
        let (width, height) = view.size_px();
        let mut svg = Svg::new("overlay", LEFT_PX + width.max(520.0) + 40.0, TOP_PX + height + 100.0, self.title);
        svg.bold(&shortened(self.title, 60), (30.0, 34.0), 12.5, Anchor::Left, colour::INK);
        svg.text(&shortened(self.subtitle, 90), (30.0, 58.0), 9.0, Anchor::Left, colour::FAINT_INK);
        view.clip(&mut svg);
        for pair in self.pairs.iter().step_by(self.pairs.len().div_ceil(RUNGS).max(1)) {
            svg.line(view.px(place(&pair.estimate)), view.px(place(&pair.truth)), Pen::new(colour::RED, 1.0).faint(0.7));
        }
        let line = |of: &dyn Fn(&AlignedPair) -> Pt2<Plan>| self.pairs.iter().map(|p| view.px(of(p))).collect::<Vec<_>>();
        let finite = |line: Vec<(f64, f64)>| line.into_iter().filter(|p| p.0.is_finite() && p.1.is_finite()).collect::<Vec<_>>();
        svg.polyline(&finite(line(&|p| place(&p.truth))), Pen::new(colour::TRUTH, 1.6).dashed("4 4"));
        svg.polyline(&finite(line(&|p| place(&p.estimate))), Pen::new(colour::PATH, 2.2));
        if let Some(first) = self.pairs.first() {
            svg.circle(view.px(place(&first.estimate)), 5.5, colour::START, Pen::new("#ffffff", 1.4));
        }
        svg.end_clip();
        view.draw_axes(&mut svg);
        let y = TOP_PX + height + 76.0;
        let items = [("odometry, aligned", Pen::new(colour::PATH, 2.2)), ("truth", Pen::new(colour::TRUTH, 1.6).dashed("4 4"))];
        for (i, (name, pen)) in items.into_iter().chain([("error", Pen::new(colour::RED, 1.0))]).enumerate() {
            let x = 40.0 + 170.0 * i as f64;
            svg.line((x, y - 4.0), (x + 28.0, y - 4.0), pen);
            svg.text(name, (x + 36.0, y), 9.0, Anchor::Left, colour::INK);
        }
        svg.finish()
    }
}
