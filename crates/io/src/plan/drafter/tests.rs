use super::*;
use letters::Letters;
use proptest::prelude::*;

const BOX: Bounds = Bounds { low: [0.0, 0.0], high: [10.0, 10.0] };

fn black() -> Look {
    Look { stroke: Some([0; 3]), ..Look::default() }
}

fn drawn(steps: &[Step], clip: Bounds, look: &Look) -> Vec<SketchPath> {
    let mut drafter = Drafter::new(100.0);
    drafter.draw(steps.iter().copied(), clip, look).unwrap();
    drafter.sketch.paths
}

#[test]
fn a_quarter_circle_becomes_chords_that_keep_to_it() {
    // The usual approximation of a quarter of radius 50.
    let k = 50.0 * 0.552_284_75;
    let paths = drawn(&[Step::Move([50.0, 0.0]), Step::Cubic([50.0, k], [k, 50.0], [0.0, 50.0])], Bounds::ALL, &black());
    let points = &paths[0].points;
    assert!(paths[0].curved && !paths[0].closed);
    for pair in points.windows(2) {
        let middle = [0, 1].map(|i| (pair[0][i] + pair[1][i]) / 2.0);
        let sag = 50.0 - middle[0].hypot(middle[1]);
        assert!(sag < 100.0 * CHORD_ERROR + 0.02, "{sag} in {} chords", points.len() - 1);
    }
    assert!((4..MOST_CHORDS).contains(&points.len()), "{}", points.len());
}

#[test]
fn chains_close_where_they_end_at_their_start() {
    let square = [Step::Move([0.0, 0.0]), Step::Line([4.0, 0.0]), Step::Line([4.0, 3.0]), Step::Line([0.0, 0.0])];
    let paths = drawn(&square, Bounds::ALL, &black());
    assert_eq!((paths[0].closed, paths[0].points.len()), (true, 3));
    // There and back is no ring, and a dot is no line.
    let line = [Step::Move([0.0, 0.0]), Step::Line([4.0, 0.0]), Step::Close, Step::Line([0.0, 0.0])];
    let paths = drawn(&line, Bounds::ALL, &black());
    assert_eq!((paths.len(), paths[0].closed), (1, false));
    // After a close the pen is at the start again.
    let after = [Step::Move([1.0, 1.0]), Step::Line([4.0, 1.0]), Step::Line([4.0, 3.0]), Step::Close, Step::Line([0.0, 0.0])];
    assert_eq!(drawn(&after, Bounds::ALL, &black())[1].points, [[1.0, 1.0], [0.0, 0.0]]);
}

#[test]
fn a_line_leaves_its_clip_and_comes_back_as_two() {
    let line = [Step::Move([5.0, 5.0]), Step::Line([15.0, 5.0]), Step::Line([15.0, 8.0]), Step::Line([5.0, 8.0])];
    let points: Vec<_> = drawn(&line, BOX, &black()).into_iter().map(|p| p.points).collect();
    assert_eq!(points, [[[5.0, 5.0], [10.0, 5.0]], [[10.0, 8.0], [5.0, 8.0]]]);
}

#[test]
fn an_area_is_cut_but_the_cut_is_no_line() {
    let square = [[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]];
    let steps: Vec<Step> =
        std::iter::once(Step::Move(square[0])).chain(square[1..].iter().map(|p| Step::Line(*p))).chain([Step::Close]).collect();
    let paths = drawn(&steps, BOX, &Look { fill: Some([9; 3]), ..black() });
    let (area, lines): (Vec<_>, Vec<_>) = paths.iter().partition(|p| p.fill.is_some());
    assert_eq!(Bounds::of(&area[0].points), Some(Bounds { low: [5.0, 5.0], high: [10.0, 10.0] }));
    assert_eq!((area.len(), area[0].stroke, lines.len()), (1, None, 2));
    assert!(paths.iter().all(|p| p.group == 0));
    assert!(drawn(&steps, Bounds { low: [20.0, 0.0], high: [30.0, 4.0] }, &black()).is_empty());
}

#[test]
fn a_stroke_after_its_filling_is_the_same_path() {
    let steps = [Step::Move([0.0, 0.0]), Step::Line([4.0, 0.0]), Step::Line([4.0, 3.0]), Step::Close];
    let mut drafter = Drafter::new(10.0);
    drafter.draw(steps, Bounds::ALL, &Look { fill: Some([200; 3]), ..Look::default() }).unwrap();
    drafter.draw(steps, Bounds::ALL, &Look { width: 0.5, ..black() }).unwrap();
    drafter.draw(steps, Bounds::ALL, &black()).unwrap();
    let paths = drafter.sketch.paths;
    assert_eq!((paths.len(), paths[0].fill, paths[0].stroke, paths[0].width), (2, Some([200; 3]), Some([0; 3]), 0.5));
    assert_eq!((paths[0].group, paths[1].group), (0, 1));
}

#[test]
fn what_is_no_number_is_left_out_and_too_much_is_refused() {
    let mut drafter = Drafter::new(10.0);
    for bad in [f64::NAN, f64::INFINITY] {
        drafter.draw([Step::Move([0.0, 0.0]), Step::Cubic([1.0, bad], [2.0, 0.0], [3.0, 0.0])], Bounds::ALL, &black()).unwrap();
    }
    assert_eq!((drafter.sketch.paths.len(), drafter.broken), (0, 2));
    let endless = (0..).map(|i| Step::Line([f64::from(i % 7), 0.0]));
    assert!(matches!(drafter.draw(endless, Bounds::ALL, &black()), Err(PlanFileError::DrawingTooIntricate { .. })));
}

#[test]
fn letters_become_words_and_words_become_lines() {
    let mut drafter = Drafter::new(100.0);
    let mut write = |x: f64, y: f64, size: f64, width_em: f64, text: &str| {
        drafter.write(Letters { at: [x, y], em: [size, 0.0], width_em, text: text.to_owned(), layer: String::new() }).unwrap();
    };
    write(0.0, 0.0, 10.0, 0.6, "A");
    write(6.1, 0.0, 10.0, 0.3, ":");
    write(12.0, 0.0, 10.0, 1.1, "65");
    write(23.0, 0.0, 10.0, 0.3, " ");
    write(25.0, 0.0, 10.0, 0.8, "m");
    write(33.0, 3.0, 6.0, 0.5, "2");
    // A column of a table, the next line, and a text that stands upright.
    write(60.0, 0.0, 10.0, 1.0, "17");
    write(0.0, -12.0, 10.0, 1.0, " Flur \n EG ");
    drafter.write(Letters { at: [10.0, -12.0], em: [0.0, 10.0], width_em: 1.0, text: "Lift".into(), layer: String::new() }).unwrap();
    let texts: Vec<&str> = drafter.sketch.texts.iter().map(|t| t.text.as_str()).collect();
    assert_eq!(texts, ["A: 65 m2", "17", "Flur EG", "Lift"]);
    assert_eq!(drafter.sketch.texts[0].height, 10.0 * CAPITALS);
}

#[test]
fn layers_have_a_longest_name() {
    assert_eq!(layer_within("plan", ["", " Walls ", "st1"]), "plan/Walls/st1");
    let long = "x".repeat(1_000_000);
    let layer = (0..100).fold(String::new(), |layer, _| layer_within(&layer, [long.as_str()]));
    assert!(layer.chars().count() <= LONGEST_LAYER + LONGEST_NAME + 1);
}

proptest! {
    #[test]
    fn chords_begin_and_end_where_their_curve_does(c in prop::collection::vec(prop::array::uniform2(-1e3..1e3f64), 4)) {
        let paths = drawn(&[Step::Move(c[0]), Step::Cubic(c[1], c[2], c[3])], Bounds::ALL, &black());
        prop_assert_eq!(paths[0].points[0], c[0]);
        prop_assert!(paths[0].closed || paths[0].points.last() == Some(&c[3]));
        prop_assert!(paths[0].points.len() <= MOST_CHORDS + 1);
    }

    #[test]
    fn nothing_is_left_outside_of_the_clip(points in prop::collection::vec(prop::array::uniform2(-20.0..30.0f64), 3..12), fill: bool) {
        let steps = std::iter::once(Step::Move(points[0])).chain(points[1..].iter().map(|p| Step::Line(*p)));
        let look = Look { fill: fill.then_some([1; 3]), ..black() };
        for path in drawn(&steps.collect::<Vec<_>>(), BOX, &look) {
            let bounds = Bounds::of(&path.points).unwrap();
            // Round-off of a crossing 50 units away.
            prop_assert!(bounds.low.iter().all(|v| *v > -1e-12) && bounds.high.iter().all(|v| *v < 10.0 + 1e-12), "{:?}", bounds);
        }
    }
}
