//! Where was the walk, how sure is that, and where else could it be? The picture a person checks.

use planwalk_locate::{ContradictedKind, ContradictedWall};
use planwalk_types::{Estimate, FloorPlan, Hypothesis, Plan, PlanPose, Pt2, ScaleEstimate, Stamp, Status};

use super::colour;
use super::map::{Bounds, MapView};
use super::marks;
use super::svg::{Anchor, Pen, Svg};
use crate::words;

/// The whole walk on the plan.
#[derive(Debug, Clone, Copy)]
pub struct TrackPicture<'a> {
    /// What is shown, e.g. the names of the video and the plan.
    pub title: &'a str,
    /// The plan.
    pub plan: &'a FloorPlan,
    /// The walk in time order.
    pub track: &'a [Estimate],
    /// All places that explain it, likeliest first; the first one is the track's own.
    pub hypotheses: &'a [Hypothesis],
    /// The verdict.
    pub status: Status,
    /// Metres per unit of odometry.
    pub scale: ScaleEstimate,
    /// The true walk where it is known, else empty.
    pub truth: &'a [(Stamp, PlanPose)],
    /// Drawn walls that the walk contradicts.
    pub contradicted: &'a [ContradictedWall],
}

/// Largest map, pixels.
const ROOM_PX: (f64, f64) = (1060.0, 820.0);
const LEFT_PX: f64 = 70.0;
const TOP_PX: f64 = 142.0;
/// Space below the map for metres and scale bar.
const BOTTOM_PX: f64 = 60.0;
const LEGEND_PX: f64 = 290.0;
/// The map shows a part of the plan when the walk needs less than this share of its width and height.
const ZOOM_BELOW: f64 = 0.45;

impl TrackPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let whole = Bounds::of_walls(self.plan).and(Bounds::of(self.places())).grown(0.8);
        let shown = self.shown(whole);
        let view = MapView::fit(shown, LEFT_PX, TOP_PX, ROOM_PX);
        let (map_width, map_height) = view.size_px();
        let legend_left = LEFT_PX + map_width.max(560.0) + 34.0;
        let inset = (shown != whole).then(|| MapView::fit(whole, legend_left, 0.0, (LEGEND_PX - 40.0, 240.0)));
        let legend_height = self.legend_height() + inset.map_or(0.0, |i| i.size_px().1 + 50.0);
        let height = TOP_PX + (map_height + BOTTOM_PX).max(legend_height);
        let mut svg = Svg::new("track", legend_left + LEGEND_PX, height, self.title);
        self.header(&mut svg, legend_left + LEGEND_PX - 24.0);
        view.draw_plan(&mut svg, self.plan);
        view.clip(&mut svg);
        self.walks(&mut svg, &view);
        svg.end_clip();
        view.draw_axes(&mut svg);
        view.draw_scale_bar(&mut svg);
        let below = self.legend(&mut svg, legend_left);
        if let Some(inset) = inset {
            self.overview(&mut svg, MapView { top_px: below + 34.0, ..inset }, shown);
        }
        svg.finish()
    }

    fn places(&self) -> impl Iterator<Item = Pt2<Plan>> + '_ {
        let others = self.hypotheses.iter().flat_map(|h| &h.track).chain(self.truth).map(|(_, pose)| pose.origin());
        self.track.iter().map(|e| e.pose.origin()).chain(others)
    }

    /// All of the plan, or, where the walk needs little of it, the walk and its surroundings.
    fn shown(&self, whole: Bounds) -> Bounds {
        let Some(walk) = Bounds::of(self.places()) else { return whole };
        let near = walk.grown(3.0);
        let (near_size, whole_size) = (near.size(), whole.size());
        if near_size.0 > ZOOM_BELOW * whole_size.0 || near_size.1 > ZOOM_BELOW * whole_size.1 {
            return whole;
        }
        near.grown(0.15 * near_size.0.max(near_size.1))
    }

    fn header(&self, svg: &mut Svg, right: f64) {
        svg.bold(&shortened(self.title, 90), (LEFT_PX - 40.0, 36.0), 14.0, Anchor::Left, colour::INK);
        let verdict = self.status.to_string().to_uppercase();
        let fill = colour::of_status(self.status);
        let pill_width = super::font::width_px(&verdict, 11.0) + 24.0;
        svg.rect(LEFT_PX - 40.0, 54.0, pill_width, 25.0, fill, 1.0);
        svg.bold(&verdict, (LEFT_PX - 28.0, 72.0), 11.0, Anchor::Left, "#ffffff");
        let probability = self.hypotheses.first().map_or(1.0, |h| h.probability);
        svg.text(&words::verdict(self.status, probability), (LEFT_PX - 28.0 + pill_width, 72.0), 11.0, Anchor::Left, colour::INK);
        if let (Some(first), Some(end)) = (self.track.first(), self.track.last()) {
            let seconds = end.stamp.secs_since(first.stamp);
            let line = format!("Ends after {seconds:.1} s at {} · {}", words::end_pose(end), words::scale(&self.scale));
            svg.text(&line, (LEFT_PX - 40.0, 104.0), 9.5, Anchor::Left, colour::FAINT_INK);
        }
        svg.text("planwalk", (right, 36.0), 10.0, Anchor::Right, colour::FAINT_INK);
    }

    fn others(&self) -> impl Iterator<Item = (&Hypothesis, &'static str)> {
        self.hypotheses.iter().skip(1).zip(colour::OTHERS)
    }

    fn walks(&self, svg: &mut Svg, view: &MapView) {
        for (other, colour) in self.others() {
            let pen = Pen::new(colour, 2.2).dashed("7 5");
            marks::plain_walk(svg, view, other.track.iter().copied(), pen);
            if let Some((_, end)) = other.track.last() {
                marks::pose_marker(svg, view.px(end.origin()), end.heading_rad, colour);
            }
        }
        let (Some(first), Some(last)) = (self.track.first(), self.track.last()) else { return };
        let moments = self.at_round_moments(first.stamp, last.stamp);
        for estimate in std::iter::once(first).chain(moments.iter().map(|(_, e)| *e)).chain([last]) {
            marks::ellipse(svg, view, estimate.pose, &estimate.covariance);
        }
        marks::timed_walk(svg, view, self.track.iter().map(|e| (e.stamp, e.pose)), (first.stamp, last.stamp));
        marks::plain_walk(svg, view, self.truth.iter().copied(), Pen::new(colour::TRUTH, 1.8).dashed("1 5"));
        for wall in self.contradicted {
            marks::contradiction(svg, view.px(wall.place), wall.kind, 0.5 * wall.length_m * view.px_per_m);
        }
        let (start_px, end_px) = (view.px(first.pose.origin()), view.px(last.pose.origin()));
        let mut taken = vec![beside(start_px), beside(end_px)];
        for (seconds, estimate) in moments {
            let text = format!("{} s", words::significant(seconds).trim_end_matches('0').trim_end_matches('.'));
            let text = if seconds.fract() == 0.0 { format!("{seconds:.0} s") } else { text };
            marks::time_tick(svg, view.px(estimate.pose.origin()), estimate.pose.heading_rad, &text, &mut taken);
        }
        marks::pose_marker(svg, start_px, first.pose.heading_rad, colour::START);
        marks::pose_marker(svg, end_px, last.pose.heading_rad, colour::END);
        svg.label("start", beside(start_px), 10.0, Anchor::Middle, colour::START);
        svg.label("end", beside(end_px), 10.0, Anchor::Middle, colour::END);
        for (other, colour) in self.others() {
            if let Some((_, end)) = other.track.last() {
                svg.label(&words::percent(other.probability), beside(view.px(end.origin())), 9.5, Anchor::Middle, colour);
            }
        }
    }

    /// The estimates nearest to round moments of the walk.
    fn at_round_moments(&self, first: Stamp, last: Stamp) -> Vec<(f64, &Estimate)> {
        let (_, moments) = marks::round_moments(first, last);
        let nearest = |t: f64| {
            let later = self.track.partition_point(|e| e.stamp.secs_since(first) < t);
            self.track.get(later.min(self.track.len().saturating_sub(1)))
        };
        moments.into_iter().filter_map(|t| Some((t, nearest(t)?))).collect()
    }

    fn legend_height(&self) -> f64 {
        let rows = 6
            + usize::from(!self.truth.is_empty())
            + 2 * usize::from(!self.contradicted.is_empty())
            + self.others().count()
            + usize::from(self.hypotheses.len() > 6);
        90.0 + 30.0 * rows as f64
    }

    /// Draws the legend and tells where it ends.
    fn legend(&self, svg: &mut Svg, left: f64) -> f64 {
        let mut y = TOP_PX + 8.0;
        svg.bold("The walk, coloured by time", (left, y), 9.5, Anchor::Left, colour::INK);
        for i in 0..46 {
            // Whole pixels: no seams.
            let share = f64::from(i) / 45.0;
            svg.rect(left.round() + 5.0 * f64::from(i), (y + 10.0).round(), 5.0, 13.0, &colour::of_time(share), 1.0);
        }
        let seconds = self.track.first().zip(self.track.last()).map_or(0.0, |(a, b)| b.stamp.secs_since(a.stamp));
        svg.text("0 s", (left, y + 40.0), 9.0, Anchor::Left, colour::FAINT_INK);
        svg.text(&format!("{seconds:.1} s"), (left + 230.0, y + 40.0), 9.0, Anchor::Right, colour::FAINT_INK);
        y += 74.0;
        let mut row = |svg: &mut Svg, text: &str, draw: &dyn Fn(&mut Svg, f64, f64)| {
            draw(svg, left + 18.0, y - 4.5);
            svg.text(text, (left + 48.0, y), 9.5, Anchor::Left, colour::INK);
            y += 30.0;
        };
        row(svg, "start, and where it faces", &|svg, x, y| marks::pose_marker(svg, (x - 4.0, y), 0.0, colour::START));
        row(svg, "end, and where it faces", &|svg, x, y| marks::pose_marker(svg, (x - 4.0, y), 0.0, colour::END));
        row(svg, "95 % region", &|svg, x, y| {
            let ring: Vec<_> = (0..32).map(|i| (f64::from(i) * 0.19635).sin_cos()).map(|(s, c)| (x + 14.0 * c, y + 8.0 * s)).collect();
            svg.polygon(&ring, colour::DOUBT, 0.13, Pen::new(colour::DOUBT, 1.2).faint(0.75));
        });
        row(svg, "wall", &|svg, x, y| svg.rect(x - 14.0, y - 3.0, 28.0, 6.0, colour::WALL, 1.0));
        row(svg, "outside or unknown", &|svg, x, y| svg.rect(x - 14.0, y - 8.0, 28.0, 16.0, colour::OUTSIDE, 1.0));
        if !self.truth.is_empty() {
            row(svg, "true walk", &|svg, x, y| svg.line((x - 14.0, y), (x + 14.0, y), Pen::new(colour::TRUTH, 1.8).dashed("1 5")));
        }
        for (kind, text) in
            [(ContradictedKind::Crossed, "drawn wall, yet walked through"), (ContradictedKind::SeenThrough, "drawn wall, yet seen through")]
        {
            if self.contradicted.iter().any(|w| w.kind == kind) {
                row(svg, text, &|svg, x, y| marks::contradiction(svg, (x, y), kind, 0.0));
            }
        }
        for (other, colour) in self.others() {
            let text = format!("other place, {}", words::percent(other.probability));
            row(svg, &text, &|svg, x, y| svg.line((x - 14.0, y), (x + 14.0, y), Pen::new(colour, 2.2).dashed("7 5")));
        }
        let more = self.hypotheses.len().saturating_sub(1 + colour::OTHERS.len());
        if more > 0 {
            row(svg, &format!("and {more} less likely, not drawn"), &|_, _, _| ());
        }
        y
    }

    /// The whole plan, small, with what the map shows of it.
    fn overview(&self, svg: &mut Svg, inset: MapView, shown: Bounds) {
        svg.text("The whole plan", (inset.left_px, inset.top_px - 10.0), 9.5, Anchor::Left, colour::INK);
        inset.draw_plan(svg, self.plan);
        let (low, high) = (inset.px(Pt2::new(shown.low.0, shown.low.1)), inset.px(Pt2::new(shown.high.0, shown.high.1)));
        inset.clip(svg);
        marks::plain_walk(svg, &inset, self.track.iter().map(|e| (e.stamp, e.pose)), Pen::new(colour::PATH, 1.6));
        svg.frame(low.0, high.1, high.0 - low.0, low.1 - high.1, Pen::new(colour::RED, 1.4));
        svg.end_clip();
        let (width, height) = inset.size_px();
        svg.frame(inset.left_px, inset.top_px, width, height, Pen::new(colour::FAINT_INK, 1.0));
    }
}

/// Where the words next to a marker stand.
fn beside(marker: (f64, f64)) -> (f64, f64) {
    (marker.0, marker.1 + 27.0)
}

/// At most `letters` letters; what is cut is shown by an ellipsis.
pub(super) fn shortened(text: &str, letters: usize) -> String {
    if text.chars().count() <= letters {
        return text.to_owned();
    }
    text.chars().take(letters.saturating_sub(1)).chain(['…']).collect()
}
