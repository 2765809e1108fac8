//! How far must one walk on this plan to know where one is? A heat map, and the places that are confused longest.

use std::collections::BTreeMap;

use planwalk_locate::Ambiguity;
use planwalk_types::{Cell, FloorPlan, Plan, Pt2};

use super::colour;
use super::map::{Bounds, MapView};
use super::marks;
use super::svg::{Anchor, Pen, Svg};

/// Metres to know one's place, over the plan.
#[derive(Debug, Clone, Copy)]
pub struct AmbiguityPicture<'a> {
    /// What is shown, e.g. the plan's name.
    pub title: &'a str,
    /// The plan.
    pub plan: &'a FloorPlan,
    /// What was found on it.
    pub ambiguity: &'a Ambiguity,
    /// The same in a sentence.
    pub words: &'a str,
}

const ROOM_PX: (f64, f64) = (1100.0, 820.0);
const LEFT_PX: f64 = 70.0;
const TOP_PX: f64 = 118.0;
/// Pairs that are drawn: more would hide the map.
const PAIRS: usize = 5;
/// Upper ends of the classes, metres; the last class is "never".
const CLASSES_M: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, f64::INFINITY];

impl AmbiguityPicture<'_> {
    /// The drawing.
    pub fn svg(&self) -> String {
        let view = MapView::fit(Bounds::of_walls(self.plan).grown(0.8), LEFT_PX, TOP_PX, ROOM_PX);
        let (width, height) = view.size_px();
        let mut svg = Svg::new("ambiguity", LEFT_PX + width.max(980.0) + 30.0, TOP_PX + height + 118.0, self.title);
        let left = LEFT_PX - 40.0;
        svg.bold(&super::track::shortened(self.title, 80), (left, 36.0), 13.0, Anchor::Left, colour::INK);
        svg.text(self.words, (left, 64.0), 10.0, Anchor::Left, colour::INK);
        view.draw_plan(&mut svg, self.plan);
        view.clip(&mut svg);
        let classes = self.classes();
        for (class, fill) in colour::HEAT.iter().enumerate() {
            // Where two classes share a pixel, the worse one is shown.
            view.fill_cells(&mut svg, self.plan, fill, 0.9, true, &|i| self.class_at(&classes, i) == Some(class));
        }
        view.fill_cells(&mut svg, self.plan, colour::WALL, 1.0, true, &|i| self.plan.cells()[i] == Cell::Wall);
        for (i, pair) in self.ambiguity.pairs.iter().take(PAIRS).enumerate() {
            self.draw_pair(&mut svg, &view, i, [pair.a, pair.b].map(|pose| (pose.origin(), pose.heading_rad)));
        }
        svg.end_clip();
        view.draw_axes(&mut svg);
        view.draw_scale_bar(&mut svg);
        self.legend(&mut svg, TOP_PX + height + 74.0);
        svg.finish()
    }

    fn draw_pair(&self, svg: &mut Svg, view: &MapView, i: usize, ends: [(Pt2<Plan>, f64); 2]) {
        let fill = colour::OTHERS[i % colour::OTHERS.len()];
        let places = ends.map(|(at, _)| view.px(at));
        svg.line(places[0], places[1], Pen::new("#ffffff", 4.5).faint(0.7));
        svg.line(places[0], places[1], Pen::new(fill, 1.8).dashed("6 5"));
        for ((_, heading), place) in ends.iter().zip(places) {
            marks::pose_marker(svg, place, *heading, fill);
            svg.label(&format!("{}", i + 1), (place.0 + 13.0, place.1 - 11.0), 10.0, Anchor::Left, colour::INK);
        }
    }

    /// Class of each place of the lattice: the worse of its walks.
    fn classes(&self) -> BTreeMap<(i64, i64), usize> {
        let mut classes = BTreeMap::new();
        for walk in &self.ambiguity.walks {
            let class = match walk.known_after_m {
                Some(metres) => CLASSES_M.iter().position(|upper| metres <= *upper).unwrap_or(CLASSES_M.len() - 1),
                None => CLASSES_M.len(),
            };
            let worst = classes.entry(self.lattice(walk.start.origin())).or_insert(class);
            *worst = class.max(*worst);
        }
        classes
    }

    fn lattice(&self, at: Pt2<Plan>) -> (i64, i64) {
        let (origin, side) = (self.plan.origin(), self.ambiguity.spacing_m);
        (((at.x - origin.x) / side).floor() as i64, ((at.y - origin.y) / side).floor() as i64)
    }

    fn class_at(&self, classes: &BTreeMap<(i64, i64), usize>, index: usize) -> Option<usize> {
        let inside = self.plan.inside()[index] > 0.5 && self.plan.cells()[index].is_floor();
        let centre = self.plan.centre(index % self.plan.width(), index / self.plan.width());
        inside.then(|| classes.get(&self.lattice(centre)).copied()).flatten()
    }

    fn legend(&self, svg: &mut Svg, y: f64) {
        let whole = self.ambiguity.lengths_m.last().copied().unwrap_or(0.0);
        let words = ["≤ 1 m".to_owned(), "≤ 2 m".to_owned(), "≤ 4 m".to_owned(), "≤ 8 m".to_owned(), "≤ 16 m".to_owned()];
        let words = words.into_iter().chain(["more".to_owned(), format!("not in {whole:.0} m")]);
        svg.text("metres walked until the place is known:", (LEFT_PX, y), 9.5, Anchor::Left, colour::INK);
        let mut x = LEFT_PX + 330.0;
        for (fill, words) in colour::HEAT.iter().zip(words) {
            svg.rect(x, y - 12.0, 22.0, 15.0, fill, 1.0);
            svg.frame(x, y - 12.0, 22.0, 15.0, Pen::new(colour::FAINT_INK, 0.8));
            svg.text(&words, (x + 28.0, y), 9.5, Anchor::Left, colour::INK);
            x += 92.0;
        }
        let (y, pen) = (y + 26.0, Pen::new(colour::OTHERS[0], 1.8));
        svg.line((LEFT_PX, y - 4.5), (LEFT_PX + 40.0, y - 4.5), pen.dashed("6 5"));
        let words = "pairs of places from which the same walk looks the same for longest, and which way it goes";
        svg.text(words, (LEFT_PX + 52.0, y), 9.5, Anchor::Left, colour::INK);
    }
}
