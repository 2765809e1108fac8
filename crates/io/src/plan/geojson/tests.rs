//! Features are known by their words; what is none is refused.

use super::*;
use planwalk_types::{Cell, FloorPlan, Pt2};

/// The ground floor, drawn, and what was told.
fn drawn(text: &str) -> (FloorPlan, Vec<String>) {
    let mut notes = Vec::new();
    let building = read(text, &mut notes).unwrap();
    let level = storeys::choose(&building, None, &mut notes).unwrap();
    (super::super::vector::draw(&level.elements, &mut notes).unwrap(), notes)
}

fn collection(head: &str, features: &[String]) -> String {
    format!("{{\"type\":\"FeatureCollection\",{head}\"features\":[{}]}}", features.join(","))
}

fn feature(properties: &str, geometry: &str, coordinates: &str) -> String {
    format!("{{\"type\":\"Feature\",\"properties\":{properties},\"geometry\":{{\"type\":\"{geometry}\",\"coordinates\":{coordinates}}}}}")
}

fn flat() -> Vec<String> {
    vec![
        feature("{\"Type\":\"Wa\"}", "Polygon", "[[[0,0],[5,0],[5,4],[0,4],[0,0]],[[0.2,0.2],[0.2,3.8],[4.8,3.8],[4.8,0.2],[0.2,0.2]]]"),
        feature("{\"Type\":\"B_Door\"}", "Polygon", "[[[2,0],[3,0],[3,0.2],[2,0.2],[2,0]]]"),
        feature("{\"category\":\"window\"}", "LineString", "[[0.1,1,0],[0.1,2,0]]"),
        "{\"type\":\"Feature\",\"properties\":{\"Type\":\"Wall\"},\"geometry\":null}".to_owned(),
        feature("{\"Type\":\"furniture\"}", "Polygon", "[[[2,2],[3,2],[3,3],[2,2]]]"),
        feature("{\"Type\":\"NaNs\"}", "Polygon", "[[[2,2],[3,2],[3,3],[2,2]]]"),
        feature("null", "LineString", "[[4,0],[4,4]]"),
    ]
}

#[test]
fn features_are_known_by_their_words_and_what_is_left_out_is_told() {
    let (plan, notes) = drawn(&collection("", &flat()));
    let at = |x, y| plan.at(Pt2::new(x, y));
    assert_eq!([at(1.0, 0.1), at(2.5, 0.1), at(0.1, 1.5), at(2.5, 2.4)], [Cell::Wall, Cell::Door, Cell::Window, Cell::Free]);
    assert_eq!(at(4.01, 2.0), Cell::Wall, "a bare line");
    for told in ["1 of 7 features have no geometry", "1 of \"NaNs\"", "1 lines say nothing", "1 shapes of furniture", "metres"] {
        assert!(notes.iter().any(|note| note.contains(told)), "{told}: {notes:?}");
    }
}

#[test]
fn units_and_openings_make_rooms_with_doors() {
    let unit = |x: f64| {
        let ring = format!("[[[{x},0],[{},0],[{},3],[{x},3],[{x},0]]]", x + 4.0, x + 4.0);
        feature("{\"category\":\"room\",\"level_id\":\"a\"}", "Polygon", &ring).replacen('{', "{\"feature_type\":\"unit\",", 1)
    };
    let opening = feature("{\"level_id\":\"a\"}", "LineString", "[[4,1],[4,2]]").replacen('{', "{\"feature_type\":\"opening\",", 1);
    let (plan, _) = drawn(&collection("\"units\":\"m\",", &[unit(0.0), unit(4.0), opening]));
    assert_eq!(plan.at(Pt2::new(4.01, 1.5)), Cell::Door);
    assert_eq!(plan.at(Pt2::new(4.01, 0.5)), Cell::Wall);
    // What is on another storey is not drawn on this one.
    let upstairs = feature("{\"level_id\":\"b\",\"type\":\"wall\"}", "LineString", "[[2,0],[2,3]]");
    let level = |id: &str, name: &str, ordinal: i32| {
        let properties = format!("{{\"ordinal\":{ordinal},\"short_name\":{{\"en\":\"{name}\"}}}}");
        feature(&properties, "Polygon", "[]").replacen('{', &format!("{{\"id\":\"{id}\",\"feature_type\":\"level\","), 1)
    };
    let storeys = collection("\"units\":\"m\",", &[unit(0.0), upstairs, level("b", "Up", 3), level("a", "Down", 2)]);
    let (plan, notes) = drawn(&storeys);
    assert_eq!(plan.at(Pt2::new(2.0, 1.5)), Cell::Free);
    assert!(notes.iter().any(|n| n.contains("2 storeys (Down, Up): Down is taken")), "{notes:?}");
}

#[test]
fn elements_tell_their_feature_and_stairs_the_storeys_that_they_are_on() {
    let text = collection(
        "\"units\":\"m\",",
        &[
            feature("{\"type\":\"wall\",\"level\":0}", "LineString", "[[0,0],[4,0]]"),
            feature("{\"type\":\"stairs\",\"level\":\"0;1\",\"id\":\"s1\"}", "Polygon", "[[[0,0],[1,0],[1,1]]]"),
            feature("{\"type\":\"lift\",\"level\":0,\"joins\":\"0-2\"}", "Point", "[3,1]"),
        ],
    );
    let levels = read(&text, &mut Vec::new()).unwrap().levels;
    let short: Vec<Vec<(Option<&str>, &[i32])>> =
        levels.iter().map(|l| l.elements.iter().map(|e| (e.source.as_deref(), e.joins.as_slice())).collect()).collect();
    let stairs = (Some("feature s1, stairs"), &[0, 1][..]);
    let lift = (Some("feature 3, lift"), &[0, 1, 2][..]);
    assert_eq!(short, [vec![(Some("feature 1, wall"), &[][..]), stairs, lift], vec![stairs]]);
}

#[test]
fn areas_of_no_known_kind_are_rooms_where_nothing_else_divides_the_floor() {
    let floor = feature("{\"type\":\"floor\"}", "Polygon", "[[[0,0],[20,0],[20,10],[0,10],[0,0]]]");
    let shop = feature("{\"category\":\"5d35\"}", "Polygon", "[[[2,2],[8,2],[8,8],[2,8],[2,2]]]");
    let (plan, notes) = drawn(&collection("\"units\":\"m\",", &[floor.clone(), shop.clone()]));
    assert_eq!([plan.at(Pt2::new(2.01, 5.0)), plan.at(Pt2::new(5.0, 5.0))], [Cell::Wall, Cell::Free]);
    assert!(notes.iter().any(|note| note.contains("1 areas of no known kind are taken as rooms")), "{notes:?}");
    let wall = feature("{\"type\":\"wall\"}", "LineString", "[[0,0],[20,0]]");
    let (plan, notes) = drawn(&collection("\"units\":\"m\",", &[floor, shop, wall]));
    assert_eq!(plan.at(Pt2::new(2.01, 5.0)), Cell::Free);
    assert!(notes.iter().any(|note| note.contains("left out: 1 of \"5d35\"")), "{notes:?}");
}

#[test]
fn a_plan_on_the_globe_becomes_metres() {
    // 0.0001° are 11 m northwards and 6.6 m eastwards at Hamburg.
    let walls = feature("{\"type\":\"wall\"}", "LineString", "[[10,53.54],[10.0001,53.54],[10.0001,53.5401],[10,53.5401],[10,53.54]]");
    let (plan, notes) = drawn(&collection("", &[walls]));
    let (width, height) = plan.size_m();
    assert!((width - 2.0 - 6.63).abs() < 0.2 && (height - 2.0 - 11.13).abs() < 0.2, "{width} × {height}");
    assert!(notes.iter().any(|n| n.contains("10.0000000, 53.5400000")), "{notes:?}");
}

#[test]
fn doors_as_points_open_their_wall() {
    let mut features = flat();
    features.push(feature("{\"door\":\"hinged\"}", "Point", "[4,1]"));
    assert_eq!(drawn(&collection("", &features)).0.at(Pt2::new(4.01, 1.0)), Cell::Door);
}

#[test]
fn bare_lines_of_a_layer_of_routes_are_no_walls() {
    // As a routing graph is handed on beside the plan: lines that say nothing, and a name of the whole.
    let graph = collection("\"name\":\"UTM_Routing4OG\",", &[feature("{\"name\":null}", "LineString", "[[0,0],[3,0]]")]);
    let error = read(&graph, &mut Vec::new()).unwrap_err().to_string();
    assert!(error.contains("1 lines that \"UTM_Routing4OG\" calls routes"), "{error}");
    // What says that it is a wall is one.
    let (plan, notes) = drawn(&collection("\"name\":\"route_1OG\",", &flat()));
    assert_eq!([plan.at(Pt2::new(1.0, 0.1)), plan.at(Pt2::new(4.01, 2.0))], [Cell::Wall, Cell::Free]);
    assert!(notes.iter().any(|note| note.contains("1 lines say nothing of what they are, and are left out")), "{notes:?}");
}

#[test]
fn what_is_no_plan_is_refused_with_a_remedy() {
    let error = |text: &str| read(text, &mut Vec::new()).unwrap_err().to_string();
    let nested =
        format!("{{\"type\":\"GeometryCollection\",\"geometries\":{}", "[{\"type\":\"GeometryCollection\",\"geometries\":".repeat(50_000));
    for text in ["{", "{}", "{\"type\":\"Topology\"}", "{\"walls\":[]}", &nested, &"[".repeat(100_000)] {
        assert!(error(text).contains("no GeoJSON"), "{}", error(text));
    }
    let huge = collection("", &[feature("{\"type\":\"wall\"}", "LineString", "[[0,0],[1e999,0]]")]);
    assert!(error(&huge).contains("no GeoJSON"), "{}", error(&huge));
    let unknown = collection("", &[feature("{\"type\":\"tree\"}", "Polygon", "[[[0,0],[1,0],[1,1],[0,0]]]")]);
    assert!(error(&unknown).contains("1 of \"tree\""), "{}", error(&unknown));
    assert!(error(&collection("", &[])).contains("none of the 0 features"));
    for coordinates in ["[]", "[[]]", "[[[]]]", "[[[1]]]"] {
        let odd = collection("", &[feature("{\"type\":\"wall\"}", "Polygon", coordinates)]);
        let level = read(&odd, &mut Vec::new()).map(|building| building.levels[0].elements.clone());
        assert!(level.is_err() || super::super::vector::draw(&level.unwrap(), &mut Vec::new()).is_err(), "{coordinates}");
    }
}

#[test]
fn more_than_any_plan_is_refused_before_memory_is_taken() {
    // Ten million lists in lists would be gigabytes, and numbers without end as well.
    for (text, what) in [("[".repeat(10_000_001), "points"), ("1,".repeat(50_000_001), "numbers"), ("{".repeat(3_000_001), "objects")] {
        let error = read(&format!("{{\"type\":{text}"), &mut Vec::new()).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
    }
}
