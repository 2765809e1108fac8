use super::super::sketch::{SketchPath, SketchText};
use super::*;

/// Metres in a unit of the drawings here.
const METRES: f64 = 0.02;

fn path(points: &[SketchPoint], closed: bool, curved: bool) -> SketchPath {
    let points = points.iter().map(|at| at.map(|v| v / METRES)).collect();
    let (layer, stroke) = (String::new(), Some([0; 3]));
    SketchPath { points, closed, fill: None, stroke, width: 1.0, dashed: false, curved, group: 0, layer }
}

/// Rooms 5 m deep, side by side, of these widths in metres, each with its area written in it as `written` has it.
fn rooms(widths: &[f64], written: impl Fn(f64) -> String) -> Sketch {
    let mut sketch = Sketch::default();
    let mut left = 0.0;
    for width in widths {
        sketch.hidden.push(path(&[[left, 0.0], [left + width, 0.0], [left + width, 5.0], [left, 5.0]], true, false));
        let at = [left + 0.3, 2.5].map(|v| v / METRES);
        sketch.texts.push(SketchText { at, height: 10.0, text: written(5.0 * width), layer: String::new() });
        left += width;
    }
    sketch.paths.push(path(&[[0.0, 0.0], [left, 0.0], [left, 5.0], [0.0, 5.0]], true, false));
    sketch
}

/// Doors of these widths, metres, in a row, each with its leaf and its arc.
fn doors(widths: &[f64]) -> Sketch {
    let mut sketch = rooms(&[20.0, 20.0], |_| String::new());
    for (i, width) in widths.iter().enumerate() {
        let hinge = [1.0 + 1.5 * i as f64, 7.0];
        let arc: Vec<SketchPoint> = (0..=12)
            .map(|k| {
                let (s, c) = (f64::from(k) * 7.5).to_radians().sin_cos();
                [hinge[0] + width * c, hinge[1] + width * s]
            })
            .collect();
        sketch.paths.push(path(&arc, false, true));
        sketch.paths.push(path(&[hinge, [hinge[0], hinge[1] + width]], false, false));
    }
    sketch
}

fn noted(sketch: &Sketch, stated: Option<f64>, paper_m: Option<f64>) -> (Result<Scale, PlanFileError>, String) {
    let mut notes = Vec::new();
    let scale = Scale::of_drawing(stated, &PlanOptions::default(), sketch, paper_m, &mut notes);
    (scale, notes.join("\n"))
}

#[test]
fn areas_that_are_written_in_rooms_are_a_scale() {
    for written in [|m2: f64| format!("A: {m2:.3} m2"), |m2: f64| format!("Büro\n{m2:.1} m²").replace('.', ",")] {
        let (scale, notes) = noted(&rooms(&[4.0, 3.0, 7.3, 6.1], written), None, Some(1.0));
        let scale = scale.unwrap();
        // Areas are rounded to 0.05 m² of at least 15 m²: half of that share in length.
        assert!((scale.metres / METRES - 1.0).abs() < 0.002, "{}", scale.metres);
        assert!(scale.from == "areas written in rooms" && notes.contains("4 of 4 outlines"), "{notes}");
    }
}

#[test]
fn a_total_and_a_slip_among_the_areas_do_no_harm() {
    let mut sketch = rooms(&[4.0, 3.0, 7.3, 6.1, 5.0], |m2| format!("{m2:.1} m2"));
    sketch.texts[0].text = "all: 1234 m2".to_owned();
    sketch.texts[1].text = "51.0 m2".to_owned();
    let scale = noted(&sketch, None, None).0.unwrap();
    assert!((scale.metres / METRES - 1.0).abs() < 0.005, "{}", scale.metres);
    // Where the texts agree on nothing, they are no witness.
    let widths = [4.0, 3.0, 7.3, 6.1, 5.0];
    let mut odd = rooms(&widths, |_| String::new());
    for (text, m2) in odd.texts.iter_mut().zip([3.0, 40.0, 9.0, 100.0, 1.0]) {
        text.text = format!("{m2} m2");
    }
    assert!(matches!(noted(&odd, None, Some(1.0)).0, Err(PlanFileError::NoDrawingScale)));
    assert!(matches!(noted(&odd, None, None).0, Err(PlanFileError::NoScale)));
}

#[test]
fn areas_are_read_as_people_write_them() {
    for (text, area) in [
        ("A: 65.948 m2", Some(65.948)),
        ("12,5 m²", Some(12.5)),
        ("Room 101\n18.7m2", Some(18.7)),
        ("NRF 1.234,5 qm", Some(1234.5)),
        ("100 sq ft", Some(9.290_304)),
        ("7 SQM", Some(7.0)),
        ("m2", None),
        ("3 m", None),
        ("4 m2x", None),
        ("0 m2", None),
        ("1:100", None),
        ("", None),
        ("٣ m2", None),
    ] {
        assert_eq!(areas::area_m2(text), area, "{text}");
    }
}

#[test]
fn a_scale_that_disagrees_with_the_drawing_is_warned_of_with_both_figures() {
    let sketch = rooms(&[4.0, 3.0, 7.3, 6.1], |m2| format!("{m2:.2} m2"));
    let (scale, notes) = noted(&sketch, Some(0.021), None);
    assert_eq!(scale.unwrap().metres, 0.021);
    assert!(notes.starts_with("warning: ") && notes.contains("0.02100 m") && notes.contains("0.02000 m"), "{notes}");
    let (_, notes) = noted(&sketch, Some(0.0202), None);
    assert!(notes.starts_with("the scale of 0.02020 m a unit is right as far as"), "{notes}");
    // A file's own unit that is no building's is not believed where there is something better.
    let slip = Sketch { metres_per_unit: Some(1e-6), ..sketch };
    let (scale, notes) = noted(&slip, None, None);
    assert!((scale.unwrap().metres / METRES - 1.0).abs() < 0.002);
    assert!(notes.contains("is not believed"), "{notes}");
}

#[test]
fn doors_are_a_scale_where_there_is_nothing_else() {
    let one = doors::witness(&doors(&[0.9; 8])).unwrap();
    let three = doors::witness(&doors(&[0.7, 0.7, 0.9, 0.9, 0.9, 0.9, 1.0, 1.0])).unwrap();
    for (name, witness) in [("one width", &one), ("three widths", &three)] {
        let off = (witness.metres / METRES).ln();
        assert!(off.abs() < 2.0 * witness.sigma, "{name}: off by {off}, {witness:?}");
    }
    // One width may be any standard's; several in their ratio say more.
    assert!(one.sigma > 0.08 && three.sigma < one.sigma, "{} {}", one.sigma, three.sigma);
    let (scale, notes) = noted(&doors(&[0.9; 8]), None, None);
    assert_eq!(scale.unwrap().from, "widths of doors");
    assert!(notes.contains('±') && notes.contains("--measure"), "{notes}");
}

#[test]
fn few_arcs_or_arcs_without_leaves_are_no_doors() {
    assert_eq!(doors::witness(&doors(&[0.9, 0.9])), None);
    let mut round = doors(&[0.9; 5]);
    round.paths.retain(|path| path.curved || path.closed);
    assert_eq!(doors::witness(&round), None);
}

#[test]
fn the_truth_is_within_what_doors_say() {
    // Buildings with one to three of the usual widths, in the shares in which they are usual; a fixed sequence stands for chance.
    let usual = [0.7, 0.8, 0.8, 0.8, 0.9, 0.9, 0.9, 0.9, 0.9, 1.0];
    let (mut within, mut all) = (0, 0);
    for a in usual {
        for b in usual {
            let c = usual[(all * 7) % usual.len()];
            let widths = [a, a, a, b, b, b, c, c];
            let witness = doors::witness(&doors(&widths)).unwrap();
            within += usize::from((witness.metres / METRES).ln().abs() <= 2.0 * witness.sigma);
            all += 1;
        }
    }
    // 95 % of a normal distribution; by three standard errors less, of 100: 88 %.
    assert!(within * 100 >= all * 88, "{within} of {all}");
}
