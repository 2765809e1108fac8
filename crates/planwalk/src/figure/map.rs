//! How does the plan lie on the sheet? The plan's walls and floor, metres along the edges, a scale bar.

use std::fmt::Write as _;

use planwalk_types::{Cell, FloorPlan, Plan, Pt2};

use super::colour;
use super::svg::{Anchor, Pen, Svg, number};

/// A rectangle of the plan, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub low: (f64, f64),
    pub high: (f64, f64),
}

impl Bounds {
    /// Around all finite points; `None` without any.
    pub(super) fn of(points: impl Iterator<Item = Pt2<Plan>>) -> Option<Self> {
        points.filter(|p| p.x.is_finite() && p.y.is_finite()).fold(None, |bounds: Option<Self>, p| {
            let b = bounds.unwrap_or(Self { low: (p.x, p.y), high: (p.x, p.y) });
            Some(Self { low: (b.low.0.min(p.x), b.low.1.min(p.y)), high: (b.high.0.max(p.x), b.high.1.max(p.y)) })
        })
    }

    /// Around the walls of a plan.
    pub(super) fn of_walls(plan: &FloorPlan) -> Self {
        let half = 0.5 * plan.cell_m();
        let walls = plan.cells().iter().enumerate().filter(|(_, cell)| cell.blocks());
        let centres = walls.map(|(i, _)| plan.centre(i % plan.width(), i / plan.width()));
        // A plan has walls, so the fallback is never seen.
        Self::of(centres).map_or(Self { low: (0.0, 0.0), high: (1.0, 1.0) }, |b| b.grown(half))
    }

    /// Around both.
    pub(super) fn and(self, other: Option<Self>) -> Self {
        let Some(o) = other else { return self };
        Self { low: (self.low.0.min(o.low.0), self.low.1.min(o.low.1)), high: (self.high.0.max(o.high.0), self.high.1.max(o.high.1)) }
    }

    /// With a margin all around.
    pub(super) fn grown(self, by_m: f64) -> Self {
        Self { low: (self.low.0 - by_m, self.low.1 - by_m), high: (self.high.0 + by_m, self.high.1 + by_m) }
    }

    /// Width and height, metres.
    pub(super) fn size(self) -> (f64, f64) {
        (self.high.0 - self.low.0, self.high.1 - self.low.1)
    }
}

/// Where on the sheet the map is, and what of the plan it shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct MapView {
    pub bounds: Bounds,
    pub left_px: f64,
    pub top_px: f64,
    pub px_per_m: f64,
}

impl MapView {
    /// As large as fits into `room_px`.
    pub(super) fn fit(bounds: Bounds, left_px: f64, top_px: f64, room_px: (f64, f64)) -> Self {
        let (width, height) = bounds.size();
        let px_per_m = (room_px.0 / width.max(0.1)).min(room_px.1 / height.max(0.1));
        Self { bounds, left_px, top_px, px_per_m }
    }

    /// Width and height on the sheet.
    pub(super) fn size_px(&self) -> (f64, f64) {
        let (width, height) = self.bounds.size();
        (width * self.px_per_m, height * self.px_per_m)
    }

    /// Where a point of the plan is on the sheet.
    pub(super) fn px(&self, point: Pt2<Plan>) -> (f64, f64) {
        (self.left_px + (point.x - self.bounds.low.0) * self.px_per_m, self.top_px + (self.bounds.high.1 - point.y) * self.px_per_m)
    }

    /// What follows, up to [`Svg::end_clip`], shows on the map only.
    pub(super) fn clip(&self, svg: &mut Svg) {
        let (width, height) = self.size_px();
        svg.begin_clip(self.left_px, self.top_px, width, height);
    }

    /// Floor, outside and walls.
    pub(super) fn draw_plan(&self, svg: &mut Svg, plan: &FloorPlan) {
        let (width, height) = self.size_px();
        svg.rect(self.left_px, self.top_px, width, height, colour::OUTSIDE, 1.0);
        self.clip(svg);
        self.fill_cells(svg, plan, colour::FLOOR, 1.0, false, &|i| plan.inside()[i] > 0.5 || plan.cells()[i].blocks());
        self.fill_cells(svg, plan, colour::DOOR, 1.0, true, &|i| plan.cells()[i] == Cell::Door);
        self.fill_cells(svg, plan, colour::WINDOW, 1.0, true, &|i| plan.cells()[i] == Cell::Window);
        self.fill_cells(svg, plan, colour::WALL, 1.0, true, &|i| plan.cells()[i] == Cell::Wall);
        svg.end_clip();
    }

    /// Fills the cells that `holds` names by their index. Cells smaller than a pixel are pooled: with `any`, one is enough.
    pub(super) fn fill_cells(&self, svg: &mut Svg, plan: &FloorPlan, fill: &str, opacity: f64, any: bool, holds: &dyn Fn(usize) -> bool) {
        let cell_px = plan.cell_m() * self.px_per_m;
        // Thinner walls would fade: a line of less than 1.2 px is drawn grey.
        let pool = (1.2 / cell_px).ceil().clamp(1.0, 64.0) as usize;
        let (columns, rows) = (plan.width().div_ceil(pool), plan.height().div_ceil(pool));
        let held = |column: usize, row: usize| {
            let cells = (row * pool..((row + 1) * pool).min(plan.height()))
                .flat_map(|r| (column * pool..((column + 1) * pool).min(plan.width())).map(move |c| r * plan.width() + c));
            let (mut yes, mut all) = (0, 0);
            for i in cells {
                yes += usize::from(holds(i));
                all += 1;
            }
            if any { yes > 0 } else { 2 * yes > all }
        };
        let data = path_of(&merged_rectangles(columns, rows, &held));
        let corner = self.px(plan.origin());
        let side = cell_px * pool as f64;
        let transform = format!("matrix({side:.6} 0 0 {:.6} {} {})", -side, number(corner.0), number(corner.1));
        svg.filled(&data, &transform, fill, opacity);
    }

    /// A frame with metres along the left and lower edge.
    pub(super) fn draw_axes(&self, svg: &mut Svg) {
        let (width, height) = self.size_px();
        let (right, bottom) = (self.left_px + width, self.top_px + height);
        let step = round_step(70.0 / self.px_per_m);
        let pen = Pen::new(colour::FAINT_INK, 1.0);
        for x in multiples(step, self.bounds.low.0, self.bounds.high.0) {
            let u = self.left_px + (x - self.bounds.low.0) * self.px_per_m;
            svg.line((u, bottom), (u, bottom + 5.0), pen);
            svg.text(&tick_text(x, step), (u, bottom + 18.0), 9.0, Anchor::Middle, colour::FAINT_INK);
        }
        for y in multiples(step, self.bounds.low.1, self.bounds.high.1) {
            let v = self.top_px + (self.bounds.high.1 - y) * self.px_per_m;
            svg.line((self.left_px - 5.0, v), (self.left_px, v), pen);
            svg.text(&tick_text(y, step), (self.left_px - 9.0, v + 4.5), 9.0, Anchor::Right, colour::FAINT_INK);
        }
        svg.text("x / m", (right, bottom + 36.0), 9.0, Anchor::Right, colour::FAINT_INK);
        svg.text("y / m", (self.left_px - 9.0, self.top_px - 9.0), 9.0, Anchor::Middle, colour::FAINT_INK);
        svg.frame(self.left_px, self.top_px, width, height, pen);
    }

    /// A bar of a round number of metres below the map's lower left corner.
    pub(super) fn draw_scale_bar(&self, svg: &mut Svg) {
        let bottom = self.top_px + self.size_px().1;
        let metres = round_step(90.0 / self.px_per_m);
        let (left, y) = (self.left_px, bottom + 38.0);
        let right = left + metres * self.px_per_m;
        let pen = Pen::new(colour::INK, 2.0);
        svg.polyline(&[(left, y - 5.0), (left, y), (right, y), (right, y - 5.0)], pen);
        svg.text(&format!("{} m", tick_text(metres, metres)), (right + 8.0, y), 10.0, Anchor::Left, colour::INK);
    }
}

/// The smallest of 1, 2, 5, 10, … (and 0.1, 0.2, …) that is not under `least`.
pub(super) fn round_step(least: f64) -> f64 {
    if !(least > 0.0 && least.is_finite()) {
        return 1.0;
    }
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].iter().map(|f| f * power).find(|s| *s >= least * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// Multiples of `step` from `low` to `high`; never more than a sheet can hold.
pub(super) fn multiples(step: f64, low: f64, high: f64) -> Vec<f64> {
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    (0..).map(|i| first + f64::from(i)).take_while(|k| *k <= last).take(500).map(|k| k * step).collect()
}

/// A tick's number with as many decimals as its step needs.
pub(super) fn tick_text(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{:.decimals$}", value + 0.0);
    let zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

/// Columns, rows, width and height of rectangles that cover the held cells once: runs of a row, joined with equal runs above.
fn merged_rectangles(columns: usize, rows: usize, held: &dyn Fn(usize, usize) -> bool) -> Vec<[usize; 4]> {
    let mut done = Vec::new();
    let mut open: Vec<[usize; 4]> = Vec::new();
    for row in 0..rows {
        let mut next: Vec<[usize; 4]> = Vec::new();
        let mut above = open.into_iter().peekable();
        for [start, length] in runs(columns, &|column| held(column, row)) {
            done.extend(std::iter::from_fn(|| above.next_if(|r| r[0] < start)));
            match above.next_if(|r| (r[0], r[2]) == (start, length)) {
                Some([c, r, w, h]) => next.push([c, r, w, h + 1]),
                None => next.push([start, row, length, 1]),
            }
        }
        done.extend(above);
        open = next;
    }
    done.extend(open);
    done
}

/// Start and length of each run of held columns.
fn runs(columns: usize, held: &dyn Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut all: Vec<[usize; 2]> = Vec::new();
    for column in (0..columns).filter(|c| held(*c)) {
        match all.last_mut() {
            Some([start, length]) if *start + *length == column => *length += 1,
            _ => all.push([column, 1]),
        }
    }
    all
}

fn path_of(rectangles: &[[usize; 4]]) -> String {
    let mut data = String::with_capacity(24 * rectangles.len());
    for [column, row, width, height] in rectangles {
        let _ = write!(data, "M{column} {row}h{width}v{height}h-{width}z");
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_cover_each_held_cell_once() {
        // A letter-like pattern with runs that begin, end, split and join.
        let pattern = ["##..##..#", "##..##..#", "####.#...", "..###.###", "#.......#", "#########"];
        let held = |c: usize, r: usize| pattern[r].as_bytes()[c] == b'#';
        let mut seen = vec![0; 9 * pattern.len()];
        let all = merged_rectangles(9, pattern.len(), &held);
        for [c, r, w, h] in &all {
            for row in *r..r + h {
                for column in *c..c + w {
                    seen[row * 9 + column] += 1;
                }
            }
        }
        for (i, count) in seen.iter().enumerate() {
            assert_eq!(*count, i32::from(held(i % 9, i / 9)), "cell {i}");
        }
        assert!(all.len() <= 12, "{} rectangles are no merger", all.len());
    }

    #[test]
    fn up_on_the_plan_is_up_on_the_sheet() {
        let view = MapView::fit(Bounds { low: (0.0, 0.0), high: (10.0, 5.0) }, 100.0, 50.0, (1000.0, 1000.0));
        assert_eq!(view.px(Pt2::new(0.0, 0.0)), (100.0, 550.0));
        assert_eq!(view.px(Pt2::new(10.0, 5.0)), (1100.0, 50.0));
    }

    #[test]
    fn steps_are_round_and_ticks_are_short() {
        let pairs = [(0.7, 1.0), (1.0, 1.0), (1.2, 2.0), (3.0, 5.0), (7.0, 10.0), (0.03, 0.05), (f64::NAN, 1.0)];
        for (least, step) in pairs {
            assert!((round_step(least) - step).abs() < 1e-9, "{least}");
        }
        assert_eq!(tick_text(-0.0, 1.0), "0");
        assert_eq!(tick_text(-2.5, 0.5), "−2.5");
        assert_eq!(multiples(2.0, -3.0, 4.0), [-2.0, 0.0, 2.0, 4.0]);
    }
}
