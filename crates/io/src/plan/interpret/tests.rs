//! Small drawings, in metres, as people draw them.

mod openings;

use super::*;
use planwalk_types::{Cell, FloorPlan};

/// A pen to draw with.
#[derive(Clone, Copy)]
struct With<'a> {
    layer: &'a str,
    fill: Option<[u8; 3]>,
    stroke: Option<[u8; 3]>,
    width: f64,
    dashed: bool,
}

const THICK: With<'static> = With { layer: "", fill: None, stroke: Some([0; 3]), width: 2.0, dashed: false };
const THIN: With<'static> = With { width: 0.5, ..THICK };

#[derive(Default)]
struct Sheet {
    sketch: Sketch,
}

impl Sheet {
    fn path(&mut self, with: With<'_>, points: &[SketchPoint], closed: bool, curved: bool) -> &mut Self {
        let group = self.sketch.paths.len();
        let layer = with.layer.to_owned();
        let (fill, stroke, width, dashed) = (with.fill, with.stroke, with.width, with.dashed);
        self.sketch.paths.push(SketchPath { points: points.to_vec(), closed, fill, stroke, width, dashed, curved, group, layer });
        self
    }

    fn line(&mut self, with: With<'_>, points: &[SketchPoint]) -> &mut Self {
        self.path(with, points, false, false)
    }

    fn rectangle(&mut self, with: With<'_>, x0: f64, y0: f64, x1: f64, y1: f64) -> &mut Self {
        self.path(with, &[[x0, y0], [x1, y0], [x1, y1], [x0, y1]], true, false)
    }

    /// From one direction to another, degrees.
    fn arc(&mut self, with: With<'_>, centre: SketchPoint, radius: f64, from: f64, to: f64) -> &mut Self {
        let at = |i: i32| {
            let (s, c) = (from + (to - from) * f64::from(i) / 12.0).to_radians().sin_cos();
            [centre[0] + radius * c, centre[1] + radius * s]
        };
        let points: Vec<SketchPoint> = (0..=12).map(at).collect();
        self.path(with, &points, false, true)
    }

    /// Two rooms of 4 m × 5 m with a way through of 0.9 m, and one out, in walls of one line.
    fn flat(&mut self, with: With<'_>) -> &mut Self {
        self.line(with, &[[1.9, 0.0], [0.0, 0.0], [0.0, 5.0], [8.0, 5.0], [8.0, 0.0], [2.8, 0.0]]);
        self.line(with, &[[4.0, 0.0], [4.0, 2.0]]).line(with, &[[4.0, 2.9], [4.0, 5.0]])
    }

    fn found(&self) -> Vec<Element> {
        elements(&self.sketch, 1.0, &mut Vec::new()).unwrap()
    }

    fn plan(&self) -> FloorPlan {
        super::super::vector::draw(&self.found(), &mut Vec::new()).unwrap()
    }
}

fn count(found: &[Element], kind: ElementKind) -> usize {
    found.iter().filter(|element| element.kind == kind).count()
}

fn at(plan: &FloorPlan, x: f64, y: f64) -> Cell {
    plan.at(Pt2::new(x, y))
}

#[test]
fn broad_long_lines_are_walls_and_furniture_dimensions_and_text_are_not() {
    let mut sheet = Sheet::default();
    sheet.flat(THICK).rectangle(THIN, 1.0, 3.0, 2.6, 3.8);
    // A dimension line outside, an axis across, letters.
    sheet.line(THIN, &[[0.0, -1.0], [8.0, -1.0]]).line(With { dashed: true, ..THICK }, &[[-1.0, 2.5], [9.0, 2.5]]);
    for i in 0..40 {
        let x = 4.3 + 0.08 * f64::from(i);
        sheet.line(THICK, &[[x, 1.0], [x + 0.05, 1.2]]);
    }
    let plan = sheet.plan();
    assert_eq!([at(&plan, 0.02, 2.0), at(&plan, 4.02, 1.0), at(&plan, 4.02, 2.5)], [Cell::Wall, Cell::Wall, Cell::Door]);
    assert_eq!([at(&plan, 1.02, 3.4), at(&plan, 3.0, -0.98), at(&plan, 6.0, 2.52)], [Cell::Free; 3]);
    assert!((0..40).all(|i| at(&plan, 4.32 + 0.08 * f64::from(i), 1.1) == Cell::Free), "letters");
}

#[test]
fn layers_that_speak_are_believed() {
    let mut sheet = Sheet::default();
    sheet.flat(With { layer: "A-WALL-INTR", ..THIN });
    // Much more, broader and longer: a grid of axes, and furniture.
    for i in 0..20 {
        let k = 0.4 * f64::from(i);
        sheet.line(With { layer: "GRID", ..THICK }, &[[k, -2.0], [k, 7.0]]);
    }
    sheet.rectangle(With { layer: "A-FURN/table", ..THICK }, 5.0, 1.0, 7.0, 2.0);
    sheet.line(With { layer: "A-GLAZ-WINDOW", ..THIN }, &[[5.0, 5.0], [6.0, 5.0]]);
    let plan = sheet.plan();
    assert_eq!([at(&plan, 0.02, 2.0), at(&plan, 5.5, 5.0), at(&plan, 6.0, 1.02)], [Cell::Wall, Cell::Window, Cell::Free]);
    assert_eq!(at(&plan, 2.02, 3.0), Cell::Free);
}

#[test]
fn between_the_two_faces_of_a_wall_there_is_wall() {
    let mut sheet = Sheet::default();
    // Around 6 m × 4 m, 30 cm thick, slanted by 20°.
    let turned = |x: f64, y: f64| {
        let (s, c) = 20f64.to_radians().sin_cos();
        [c * x - s * y, s * x + c * y]
    };
    for (low, high) in [(0.0, 0.0), (-0.3, 0.3)] {
        let ring = [turned(low, low), turned(6.0 + high, low), turned(6.0 + high, 4.0 + high), turned(low, 4.0 + high)];
        sheet.path(THICK, &ring, true, false);
    }
    let plan = sheet.plan();
    for (x, y) in [(3.0, -0.15), (-0.15, 2.0), (6.15, 2.0), (3.0, 4.15)] {
        let [x, y] = turned(x, y);
        assert_eq!(at(&plan, x, y), Cell::Wall, "{x}, {y}");
    }
    let [x, y] = turned(3.0, 2.0);
    assert_eq!(at(&plan, x, y), Cell::Free);
}

#[test]
fn a_roof_below_is_no_wall_where_walls_are_filled_and_drawn_round_with_a_broader_pen() {
    let solid = With { fill: Some([90, 80, 70]), stroke: None, width: 0.0, ..THICK };
    let walls_with = |roof: With<'_>| {
        let mut sheet = Sheet::default();
        // A stairhead of 8 m × 5 m on a roof of 60 m × 40 m.
        for [x0, y0, x1, y1] in [[0.0, 0.0, 8.0, 0.25], [0.0, 4.75, 8.0, 5.0], [0.0, 0.0, 0.25, 5.0], [7.75, 0.0, 8.0, 5.0]] {
            sheet
                .rectangle(solid, x0, y0, x1, y1)
                .line(THICK, &[[x0, y0], [x1, y0], [x1, y1]])
                .line(THICK, &[[x1, y1], [x0, y1], [x0, y0]]);
        }
        sheet.line(roof, &[[8.0, 5.0], [50.0, 5.0], [50.0, -35.0], [-10.0, -35.0], [-10.0, 5.0], [0.0, 5.0]]);
        at(&sheet.plan(), 50.0, -20.0)
    };
    assert_eq!(walls_with(With { stroke: Some([191, 128, 128]), ..THIN }), Cell::Unknown, "beyond all walls");
    assert_eq!(walls_with(With { stroke: Some([191, 128, 128]), ..THICK }), Cell::Wall, "a pen as broad as theirs");
}

#[test]
fn filled_shapes_are_walls_if_they_are_thin_and_not_paper() {
    let solid = |fill: [u8; 3]| With { fill: Some(fill), stroke: None, width: 0.0, ..THICK };
    let mut sheet = Sheet::default();
    // A floor colour under all of it, four walls, and a white door over one of them.
    sheet.rectangle(solid([200, 220, 200]), 0.0, 0.0, 8.0, 5.0);
    for [x0, y0, x1, y1] in [[0.0, 0.0, 8.0, 0.25], [0.0, 4.75, 8.0, 5.0], [0.0, 0.0, 0.25, 5.0], [7.75, 0.0, 8.0, 5.0]] {
        sheet.rectangle(solid([90, 80, 70]), x0, y0, x1, y1);
    }
    let found = sheet.found();
    assert_eq!(count(&found, ElementKind::Wall), 4, "{found:?}");
    assert_eq!(at(&sheet.plan(), 4.0, 2.5), Cell::Free);
}

#[test]
fn a_door_is_where_its_leaf_swings_shut() {
    let mut sheet = Sheet::default();
    // Hinge at the lower jamb, the leaf standing in the left room; another at the way out, drawn as its leaf and a swing.
    sheet.flat(THICK).arc(THIN, [4.0, 2.0], 0.9, 90.0, 180.0).line(THIN, &[[4.0, 2.0], [3.1, 2.0]]);
    sheet.arc(THIN, [1.9, 0.0], 0.9, 0.0, 90.0);
    // A round table, and a quarter circle in the middle of a room.
    sheet.arc(THIN, [6.0, 2.0], 0.5, 0.0, 360.0).arc(THIN, [6.0, 3.0], 0.8, 0.0, 90.0);
    assert_eq!(count(&sheet.found(), ElementKind::Door), 2, "{:?}", sheet.found());
    let plan = sheet.plan();
    assert_eq!([at(&plan, 4.0, 2.45), at(&plan, 2.35, 0.0), at(&plan, 3.55, 2.0)], [Cell::Door, Cell::Door, Cell::Free]);
}

#[test]
fn steps_are_stairs_and_no_walls() {
    let mut sheet = Sheet::default();
    sheet.flat(THICK);
    for i in 0..9 {
        let y = 1.0 + 0.28 * f64::from(i);
        sheet.line(THICK, &[[6.0, y], [7.2, y]]);
    }
    let found = sheet.found();
    assert_eq!(count(&found, ElementKind::Stairs), 1);
    assert_eq!(at(&sheet.plan(), 6.6, 1.28), Cell::Free);
}

#[test]
fn the_frame_of_the_sheet_is_no_wall_but_the_only_outline_is() {
    let mut sheet = Sheet::default();
    sheet.flat(THICK).rectangle(THICK, -5.0, -5.0, 14.0, 9.0).rectangle(THICK, -4.5, -4.5, 13.5, 8.5);
    assert_eq!(at(&sheet.plan(), 8.02, 2.0), Cell::Wall);
    let (width, _) = sheet.plan().size_m();
    assert!(width < 11.0, "{width}");
    let mut alone = Sheet::default();
    alone.rectangle(THICK, 0.0, 0.0, 8.0, 5.0).line(THICK, &[[4.0, 0.0], [4.0, 3.0]]);
    assert_eq!(at(&alone.plan(), 0.02, 2.0), Cell::Wall);
}

#[test]
fn what_is_turned_is_found_turned() {
    let mut sheet = Sheet::default();
    sheet.flat(THICK).rectangle(THIN, 1.0, 3.0, 2.6, 3.8).arc(THIN, [4.0, 2.0], 0.9, 90.0, 180.0);
    let straight = sheet.found();
    for path in &mut sheet.sketch.paths {
        path.points.iter_mut().for_each(|at| *at = [-at[1], at[0]]);
    }
    let turned = sheet.found();
    let kinds = |found: &[Element]| ElementKind::ALL.map(|kind| count(found, kind));
    assert_eq!(kinds(&straight), kinds(&turned));
}

#[test]
fn a_heap_of_lines_is_refused_in_bounded_time() {
    let mut sheet = Sheet::default();
    // A hundred thousand lines through one metre, and as many across a country.
    for i in 0..100_000 {
        let k = 1e-5 * f64::from(i);
        sheet.line(THICK, &[[k, 0.0], [k, 1.0]]);
    }
    assert!(matches!(elements(&sheet.sketch, 1.0, &mut Vec::new()), Err(PlanFileError::DrawingTooLarge { .. })));
    for path in &mut sheet.sketch.paths {
        path.points[1] = [1e6, 1e6];
    }
    assert!(matches!(elements(&sheet.sketch, 1.0, &mut Vec::new()), Err(PlanFileError::DrawingTooLarge { .. })));
}

#[test]
fn odd_paths_are_put_up_with() {
    let mut sheet = Sheet::default();
    assert!(sheet.found().is_empty());
    sheet.line(THICK, &[]).line(THICK, &[[1.0, 1.0]]).line(THICK, &[[2.0, 2.0], [2.0, 2.0]]);
    sheet.path(With { fill: Some([0; 3]), ..THICK }, &[[1.0, 1.0], [1.0, 1.0]], true, false);
    sheet.line(THICK, &[[0.0, 0.0], [1e12, 1e12]]).arc(THIN, [0.0, 0.0], 0.0, 0.0, 0.0);
    let _ = sheet.found();
}
