//! What is written is read back; what is damaged is refused with its place.

use super::*;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// A document of one storey with these elements.
fn document(elements: &str) -> String {
    format!("{{\"schema\": \"planwalk-plan/1\", \"levels\": [{{\"ordinal\": 2, \"elements\": [{elements}]}}]}}")
}

fn error(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

#[test]
fn the_example_of_the_docs_is_read_and_written_back_the_same() {
    let page = include_str!("../../../../../docs/plan-format.md");
    let example = page.split("```json\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    assert!(is_one(example));
    let document = read(example).unwrap();
    assert_eq!(write(&document), example);
    // The page shows all that there is.
    let kinds: Vec<&str> =
        ElementKind::ALL.into_iter().map(ElementKind::word).filter(|word| !page.contains(&format!("`{word}`"))).collect();
    assert!(kinds.is_empty(), "the page does not say what these are: {kinds:?}");
    let forms: Vec<&Form> = document.building.levels.iter().flat_map(|l| &l.elements).map(|e| &e.form).collect();
    assert!(forms.iter().any(|f| matches!(f, Form::Area(rings) if rings.len() == 2)));
    assert!(forms.iter().any(|f| matches!(f, Form::Line(_))) && forms.iter().any(|f| matches!(f, Form::Spot(_))));
}

#[test]
fn what_is_usual_may_be_left_out_and_what_is_not_known_is_passed_over() {
    let read = read(&document("{\"kind\": \"wall\", \"line\": [[0, 0], [4, 0]], \"height_m\": {\"top\": [2.5]}}")).unwrap();
    assert_eq!((read.source, read.notes, read.building.georeference), (Source::default(), Vec::new(), None));
    let level = Level {
        ordinal: 2,
        name: "2".to_owned(),
        elements: vec![Element::new(ElementKind::Wall, Form::Line(vec![Pt2::new(0.0, 0.0), Pt2::new(4.0, 0.0)]))],
    };
    assert_eq!(read.building.levels, [level]);
}

#[test]
fn an_element_is_a_line_so_that_versions_can_be_compared() {
    let mut one = PlanDocument { building: Building::of_one_level(Vec::new()), ..PlanDocument::default() };
    for x in 0..4 {
        one.building.levels[0].elements.push(Element::new(ElementKind::Door, Form::Spot(Pt2::new(f64::from(x), 0.123_456))));
    }
    let mut other = one.clone();
    other.building.levels[0].elements[2].name = Some("main \"entrance\"\n".to_owned());
    let (one, other) = (write(&one), write(&other));
    assert_eq!(one.lines().count(), other.lines().count());
    let changed: Vec<_> = one.lines().zip(other.lines()).filter(|(a, b)| a != b).collect();
    let line = r#"      {"kind": "door", "name": "main \"entrance\"\n", "spot": [2,0.1235]},"#;
    assert_eq!(changed, [(r#"      {"kind": "door", "spot": [2,0.1235]},"#, line)]);
}

#[test]
fn stairs_keep_the_storeys_that_they_join_and_a_place_says_how_it_is_known() {
    let text = document("{\"kind\": \"stairs\", \"joins\": [3, 2, 3], \"spot\": [1, 2]}").replacen(
        '{',
        "{\"georeference\": {\"longitude_deg\": 10, \"latitude_deg\": 53.5, \"anchor\": [566600, 5932800], \"scale\": 0.9996, \
         \"from\": \"points\", \"points\": [{\"plan\": [1, 2], \"longitude_deg\": 10.00001, \"latitude_deg\": 53.5, \"off_m\": 0.12}]}, ",
        1,
    );
    let read = read(&text).unwrap();
    assert_eq!(read.building.levels[0].elements[0].joins, [2, 3]);
    let place = read.building.georeference.unwrap();
    assert_eq!((place.anchor, place.scale, place.bearing_rad), (Pt2::new(566_600.0, 5_932_800.0), 0.9996, 0.0));
    assert_eq!(read.placed.as_ref().unwrap().points[0].off_m, 0.12);
    assert_eq!(super::read(&write(&read)).unwrap(), read);
}

#[test]
fn storeys_come_back_from_below() {
    let level = |ordinal: i32| format!("{{\"ordinal\": {ordinal}, \"elements\": []}}");
    let text = format!("{{\"schema\": \"planwalk-plan/1\", \"levels\": [{}, {}]}}", level(1), level(-1));
    let ordinals: Vec<i32> = read(&text).unwrap().building.levels.iter().map(|l| l.ordinal).collect();
    assert_eq!(ordinals, [-1, 1]);
}

#[test]
fn a_file_is_known_by_its_schema() {
    for head in ["{\"schema\":\"planwalk-plan/1\"", " {\n\"about\": 1, \"schema\" : \"planwalk-plan/27\", \"le", &document("")] {
        assert!(is_one(head), "{head}");
    }
    for head in [
        "",
        "{",
        "{\"type\": \"FeatureCollection\"",
        "{\"schema\": \"other\"",
        "\"schema\": \"planwalk-plan/1\"",
        "{\"a\": \"planwalk-plan/1\"}",
    ] {
        assert!(!is_one(head), "{head}");
    }
}

#[test]
fn another_version_is_refused_with_both_numbers() {
    let text = document("{\"kind\": \"wall\", \"mesh\": 0}").replace("plan/1", "plan/2");
    assert!(error(&text).contains("\"planwalk-plan/2\", and this program reads \"planwalk-plan/1\""), "{}", error(&text));
}

#[test]
fn a_bad_element_is_named() {
    let wall = "{\"kind\": \"wall\", \"line\": [[0, 0], [4, 0]]}";
    for (bad, told) in [
        (
            "{\"kind\": \"tree\", \"spot\": [0, 0]}",
            "\"tree\" is no kind of element; known are wall, window, door, floor, room, stairs, lift",
        ),
        ("{\"kind\": \"door\"}", "no \"area\", \"line\" or \"spot\""),
        ("{\"kind\": \"door\", \"spot\": [0, 0], \"line\": []}", "more than one of"),
        ("{\"kind\": \"door\", \"spot\": [0, 1e300]}", "over 1e9 m away"),
    ] {
        let error = error(&document(&format!("{wall}, {bad}")));
        assert!(error.contains("element 1 (counted from 0) of the storey \"2\"") && error.contains(told), "{error}");
    }
}

#[test]
fn damaged_files_are_refused_with_the_place() {
    let whole = document("{\"kind\": \"wall\", \"area\": [[[0, 0], [4, 0], [4, 3]]]}");
    for cut in 0..whole.len() {
        assert!(read(&whole[..cut]).is_err(), "{cut}");
    }
    for (from, to) in
        [("[4, 3]", "[4, 1e999]"), ("[4, 3]", "[4, NaN]"), ("[4, 3]", "[4]"), ("[4, 3]", "[4, 3, 0]"), ("2,", "2.5,"), ("[[[", "[[[[")]
    {
        let error = error(&whole.replace(from, to));
        assert!(error.contains("docs/plan-format.md") && error.contains("line 1 column"), "{to}: {error}");
    }
    for (member, told) in [
        ("\"units\": \"mm\"", "\"mm\", and can only be \"m\""),
        ("\"y\": \"down\"", "can only be \"up\""),
        ("\"georeference\": {\"longitude_deg\": 10, \"latitude_deg\": 99}", "latitude 99°"),
    ] {
        let error = error(&whole.replacen('{', &format!("{{{member}, "), 1));
        assert!(error.contains(told), "{error}");
    }
}

#[test]
fn hostile_files_are_refused_before_they_take_memory() {
    let notes = |inner: String| document("").replacen('{', &format!("{{\"notes\": [{inner}], "), 1);
    assert!(error(&notes("\"\",".repeat(10_000_001))).contains("texts"));
    assert!(error(&document(&format!("{{\"kind\": \"wall\", \"area\": [{}]}}", "[],".repeat(10_000_001)))).contains("points"));
    assert!(error(&document(&"{},".repeat(1_000_001))).contains("elements"));
    for mark in ["[", "{\"a\":"] {
        let deep = document("").replacen('{', &format!("{{\"more\": {}", mark.repeat(900_000)), 1);
        assert!(read(&deep).is_err());
    }
}

#[test]
fn what_has_no_place_in_json_is_left_out_and_told() {
    let spot = |x: f64| Element::new(ElementKind::Door, Form::Spot(Pt2::new(x, 0.0)));
    let building = Building {
        georeference: Some(Georeference::at_origin(f64::NAN, 0.0, 0.0)),
        ..Building::of_one_level(vec![spot(f64::NAN), spot(1.0), spot(f64::INFINITY), spot(-1e300)])
    };
    let document = read(&write(&PlanDocument { building, ..PlanDocument::default() })).unwrap();
    assert_eq!(document.building, Building::of_one_level(vec![spot(1.0)]));
    assert!(document.notes[0].starts_with("3 elements") && document.notes[1].contains("NaN"), "{:?}", document.notes);
}

fn point() -> impl Strategy<Value = Pt2<Plan>> {
    // Sites near their origin and on a map's grid.
    prop_oneof![(-100.0..100.0, -100.0..100.0), (4e5..8e5, 5e6..6e6)].prop_map(|(x, y): (f64, f64)| Pt2::new(x, y))
}

fn form() -> impl Strategy<Value = Form> {
    let chain = || prop::collection::vec(point(), 0..5);
    prop_oneof![prop::collection::vec(chain(), 0..3).prop_map(Form::Area), chain().prop_map(Form::Line), point().prop_map(Form::Spot),]
}

fn element() -> impl Strategy<Value = Element> {
    let word = || prop::option::of(".{0,12}");
    let joins = prop::collection::btree_set(-3..9, 0..3).prop_map(|joins| joins.into_iter().collect());
    (prop::sample::select(&ElementKind::ALL[..]), form(), word(), word(), joins).prop_map(|(kind, form, name, source, joins)| Element {
        kind,
        form,
        name,
        source,
        joins,
    })
}

fn documents() -> impl Strategy<Value = PlanDocument> {
    let level = ("\\PC{0,12}", prop::collection::vec(element(), 0..6));
    let levels = prop::collection::vec(level, 0..4).prop_map(|levels| {
        let level = |(ordinal, (name, elements))| Level { ordinal, name, elements };
        (-1..).zip(levels).map(level).collect::<Vec<_>>()
    });
    let place =
        (-180.0..180.0, -85.0..85.0, -TAU..TAU, point(), 0.9..1.1).prop_map(|(longitude_deg, latitude_deg, bearing_rad, anchor, scale)| {
            Georeference { longitude_deg, latitude_deg, bearing_rad, anchor, scale }
        });
    let control = (point(), -180.0..180.0, -85.0..85.0, 0.0..9.0).prop_map(|(plan, longitude_deg, latitude_deg, off_m)| PlacedPoint {
        plan,
        longitude_deg,
        latitude_deg,
        off_m,
    });
    let placed = (".{0,9}", prop::collection::vec(control, 0..3)).prop_map(|(from, points)| Placed { from, points });
    let source = (prop::option::of(".*"), prop::option::of(1e-6..1e3)).prop_map(|(file, metres_per_unit)| Source {
        file,
        metres_per_unit,
        format: Some("dxf".to_owned()),
        ..Source::default()
    });
    (levels, prop::option::of((place, prop::option::of(placed))), source, prop::collection::vec(".*", 0..3)).prop_map(
        |(levels, place, source, notes)| {
            let (georeference, placed) = place.unzip();
            PlanDocument { building: Building { levels, georeference }, source, placed: placed.flatten(), notes }
        },
    )
}

/// The same with all numbers at zero, to compare the rest.
fn without_numbers(document: &PlanDocument) -> PlanDocument {
    let mut bare = document.clone();
    bare.building.georeference = None;
    for point in bare.placed.iter_mut().flat_map(|placed| &mut placed.points) {
        *point = PlacedPoint { plan: Pt2::new(0.0, 0.0), longitude_deg: 0.0, latitude_deg: 0.0, off_m: 0.0 };
    }
    for element in bare.building.levels.iter_mut().flat_map(|l| &mut l.elements) {
        let zeros = |chain: &mut Vec<Pt2<Plan>>| chain.fill(Pt2::new(0.0, 0.0));
        match &mut element.form {
            Form::Area(rings) => rings.iter_mut().for_each(zeros),
            Form::Line(line) => zeros(line),
            Form::Spot(spot) => *spot = Pt2::new(0.0, 0.0),
        }
    }
    bare
}

proptest! {
    #[test]
    fn what_is_written_is_read_to_half_a_tenth_of_a_millimetre(document in documents()) {
        let text = write(&document);
        prop_assert!(is_one(&text));
        let read = read(&text).unwrap();
        prop_assert_eq!(without_numbers(&read), without_numbers(&document));
        let points = |d: &PlanDocument| d.building.levels.iter().flat_map(|l| &l.elements).flat_map(|e| e.form.points().collect::<Vec<_>>()).collect::<Vec<_>>();
        for (read, meant) in points(&read).into_iter().zip(points(&document)) {
            // And the doubles' own spacing at 6e6.
            let error = (read.x - meant.x).abs().max((read.y - meant.y).abs());
            prop_assert!(error < 0.5e-4 + 1e-8, "{error} m");
        }
        if let (Some(read), Some(meant)) = (read.building.georeference, document.building.georeference) {
            let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
            prop_assert!(near(read.longitude_deg, meant.longitude_deg) && near(read.latitude_deg, meant.latitude_deg));
            prop_assert!(near(read.bearing_rad, meant.bearing_rad) && near(read.scale, meant.scale));
            prop_assert!(read.anchor.distance(meant.anchor) < 1e-4);
        }
        prop_assert_eq!(read.building.georeference.is_some(), document.building.georeference.is_some());
        // Once rounded, bytes stay.
        prop_assert_eq!(write(&read), text);
    }
}
