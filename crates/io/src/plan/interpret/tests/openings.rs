//! Gaps in walls, in metres, as people draw what is in them.

use super::*;
use planwalk_types::Cell;

const SOLID: With<'static> = With { fill: Some([90, 80, 70]), stroke: None, width: 0.0, ..THICK };
const PAPERY: With<'static> = With { fill: Some([255; 3]), stroke: None, width: 0.0, ..THICK };

/// A room of 8 m × 5 m in solid walls 0.4 m thick, with a gap of this width in the lower one, from x = 3 m on.
fn room(gap_m: f64) -> Sheet {
    let mut sheet = Sheet::default();
    for [x0, y0, x1, y1] in
        [[0.0, 4.6, 8.0, 5.0], [0.0, 0.4, 0.4, 4.6], [7.6, 0.4, 8.0, 4.6], [0.0, 0.0, 3.0, 0.4], [3.0 + gap_m, 0.0, 8.0, 0.4]]
    {
        sheet.rectangle(SOLID, x0, y0, x1, y1);
    }
    sheet
}

fn openings(sheet: &Sheet) -> [usize; 2] {
    let found = sheet.found();
    [count(&found, ElementKind::Window), count(&found, ElementKind::Door)]
}

#[test]
fn glass_between_the_ends_of_a_wall_is_a_window_and_closes_the_outline() {
    let mut sheet = room(2.0);
    // Both faces, and a pane with its frame.
    for y in [0.0, 0.4, 0.18, 0.22] {
        sheet.line(THIN, &[[3.0, y], [5.0, y]]);
    }
    assert_eq!(openings(&sheet), [1, 0]);
    let plan = sheet.plan();
    assert!([3.2, 4.0, 4.8].iter().all(|x| at(&plan, *x, 0.2) == Cell::Window), "all of the gap");
    assert_eq!([at(&plan, 2.5, 0.2), at(&plan, 4.0, 1.0)], [Cell::Wall, Cell::Free]);
}

#[test]
fn a_gap_with_nothing_or_a_threshold_in_it_is_a_way_through() {
    assert_eq!(openings(&room(1.0)), [0, 1]);
    assert_eq!(at(&room(1.0).plan(), 3.5, 0.2), Cell::Door);
    let mut threshold = room(1.0);
    threshold.line(THIN, &[[3.0, 0.0], [4.0, 0.0]]).line(THIN, &[[3.0, 0.4], [4.0, 0.4]]);
    assert_eq!(openings(&threshold), [0, 1]);
    // A leaf that swings is the same door.
    threshold.arc(THIN, [3.0, 0.4], 1.0, 0.0, 90.0).line(THIN, &[[3.0, 0.4], [3.0, 1.4]]);
    assert_eq!(openings(&threshold), [0, 1]);
    // Too wide for a door, and nothing says that it is one.
    assert_eq!(openings(&room(3.5)), [0, 0]);
}

#[test]
fn walls_of_one_line_have_gaps_too() {
    let mut sheet = Sheet::default();
    sheet.flat(THICK);
    assert_eq!(openings(&sheet), [0, 2]);
    let plan = sheet.plan();
    assert_eq!([at(&plan, 4.0, 2.45), at(&plan, 2.35, 0.0), at(&plan, 4.0, 1.0)], [Cell::Door, Cell::Door, Cell::Wall]);
}

#[test]
fn paper_over_a_wall_is_an_opening_and_what_lies_under_the_wall_is_none() {
    let mut glazed = room(0.0);
    glazed.rectangle(PAPERY, 4.0, 0.0, 5.5, 0.4).line(THIN, &[[4.0, 0.2], [5.5, 0.2]]);
    assert_eq!(openings(&glazed), [1, 0]);
    assert_eq!(at(&glazed.plan(), 4.75, 0.2), Cell::Window);
    let mut bare = room(0.0);
    bare.rectangle(PAPERY, 4.0, -0.01, 5.0, 0.41);
    assert_eq!(openings(&bare), [0, 1]);
    // Drawn before the wall it hides nothing; within the wall, it cuts nothing through.
    let mut under = Sheet::default();
    under.rectangle(PAPERY, 4.0, 0.0, 5.5, 0.4);
    under.sketch.paths.extend(room(0.0).sketch.paths);
    under.sketch.paths.iter_mut().enumerate().for_each(|(i, path)| path.group = i);
    assert_eq!(openings(&under), [0, 0]);
    let mut within = room(0.0);
    within.rectangle(PAPERY, 4.0, 0.1, 5.5, 0.3);
    assert_eq!(openings(&within), [0, 0]);
}

#[test]
fn steps_sills_and_columns_are_no_openings() {
    let mut sheet = room(0.0);
    // Steps from wall to wall, a sill along a wall between two pilasters, two columns.
    for i in 0..4 {
        let y = 1.0 + 0.7 * f64::from(i);
        sheet.line(THIN, &[[0.4, y], [7.6, y]]);
    }
    sheet.rectangle(SOLID, 2.0, 4.3, 2.3, 4.6).rectangle(SOLID, 4.0, 4.3, 4.3, 4.6).line(THIN, &[[2.3, 4.45], [4.0, 4.45]]);
    sheet.rectangle(SOLID, 3.0, 2.0, 3.3, 2.3).rectangle(SOLID, 5.0, 2.0, 5.3, 2.3);
    assert_eq!(openings(&sheet), [0, 0], "{:?}", sheet.found());
}

#[test]
fn panes_that_follow_each_other_are_windows_from_wall_to_wall() {
    let mut sheet = room(3.0);
    // Two panes with a post of 1 cm between them, which is no wall.
    for [from, to] in [[3.0, 4.495], [4.505, 6.0]] {
        for y in [0.0, 0.4, 0.2] {
            sheet.line(THIN, &[[from, y], [to, y]]);
        }
    }
    assert_eq!(openings(&sheet), [2, 0]);
    // A bench that ends in the open is none.
    let mut bench = room(3.0);
    bench.line(THIN, &[[3.0, 0.2], [4.495, 0.2]]);
    assert_eq!(openings(&bench), [0, 0]);
}

#[test]
fn a_door_ajar_is_a_door_though_its_arc_is_a_chain_and_its_threshold_is_drawn_as_walls_are() {
    let mut sheet = Sheet::default();
    let arc: Vec<SketchPoint> = (0..=8)
        .map(|i| {
            let (s, c) = (f64::from(i) * 30.0 / 8.0).to_radians().sin_cos();
            [4.0 - 0.9 * s, 2.0 + 0.9 * c]
        })
        .collect();
    sheet.flat(THICK).line(THICK, &arc).line(THICK, &[[4.0, 2.0], arc[8]]);
    sheet.line(THICK, &[[4.0, 2.0], [4.0, 2.9]]).line(THICK, &[[4.1, 2.0], [4.1, 2.9]]);
    // This one, and the way out, in which nothing is drawn.
    assert_eq!(openings(&sheet), [0, 2]);
    let plan = sheet.plan();
    assert_eq!([at(&plan, 4.0, 2.45), at(&plan, arc[4][0], arc[4][1]), at(&plan, 4.0, 1.0)], [Cell::Door, Cell::Free, Cell::Wall]);
}

#[test]
fn two_leaves_that_meet_are_one_door_as_wide_as_both() {
    let mut sheet = Sheet::default();
    // A corridor's end, the threshold drawn as the walls are.
    sheet.line(THICK, &[[2.0, 0.0], [0.0, 0.0], [0.0, 5.0], [8.0, 5.0], [8.0, 0.0], [3.8, 0.0]]).line(THICK, &[[2.0, 0.0], [3.8, 0.0]]);
    sheet.line(THICK, &[[4.0, 2.0], [4.0, 5.0]]);
    sheet.arc(THIN, [2.0, 0.0], 0.9, 0.0, 90.0).arc(THIN, [3.8, 0.0], 0.9, 90.0, 180.0);
    assert_eq!(openings(&sheet), [0, 1]);
    let plan = sheet.plan();
    assert!([2.2, 2.9, 3.6].iter().all(|x| at(&plan, *x, 0.0) == Cell::Door));
}

#[test]
fn openings_turn_with_the_drawing() {
    let mut sheet = room(2.0);
    for y in [0.0, 0.4, 0.18, 0.22] {
        sheet.line(THIN, &[[3.0, y], [5.0, y]]);
    }
    sheet.rectangle(PAPERY, 1.0, 4.6, 2.0, 5.0);
    let straight = openings(&sheet);
    let (s, c) = 0.4_f64.sin_cos();
    for path in &mut sheet.sketch.paths {
        path.points.iter_mut().for_each(|at| *at = [c * at[0] - s * at[1], s * at[0] + c * at[1]]);
    }
    assert_eq!((straight, openings(&sheet)), ([1, 1], [1, 1]));
}
