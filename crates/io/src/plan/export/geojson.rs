//! How does a storey become features of a map? Areas, lines and places with properties that say what they are.
//!
//! In the plan's own metres it is GeoJSON in form only, and says so by `"frame": "plan", "units": "m"`; this program's reader goes
//! by that. On the globe it is RFC 7946: WGS 84, outlines anticlockwise, holes clockwise, 7 decimals (1 cm).
//! Properties: `type` (wall, window, door, floor, room, stairs, lift), `name`, `level`, `ordinal`, `joins`
//! (ordinals, `0;1`), `source`.

use planwalk_types::{Element, Form, Georeference, Level, Plan, Pt2};

use super::super::notation::{METRE_DECIMALS, object, push_list, push_position, quoted};
use super::super::projection::{self, NoPlace};

/// Decimals of degrees: what RFC 7946 advises at most; a step is 11 mm of meridian.
const DEGREE_DECIMALS: usize = 7;
/// What says that the numbers are the plan's metres.
const PLAN_MEMBERS: &str = "\"frame\": \"plan\", \"units\": \"m\", ";

/// The storey in the plan's metres, x right, y up.
pub fn geojson(level: &Level) -> String {
    collection(level, PLAN_MEMBERS, METRE_DECIMALS, |point| [point.x, point.y])
}

/// The storey where it is on the globe: longitude and latitude.
///
/// # Errors
/// [`NoPlace`] if the georeference is none.
pub fn geojson_on_globe(level: &Level, georeference: &Georeference) -> Result<String, NoPlace> {
    if !projection::is_place(georeference) {
        return Err(NoPlace(*georeference));
    }
    Ok(collection(level, "", DEGREE_DECIMALS, |point| projection::degrees(georeference, point)))
}

fn collection(level: &Level, members: &str, decimals: usize, position: impl Fn(Pt2<Plan>) -> [f64; 2]) -> String {
    let mut out = format!("{{\"type\": \"FeatureCollection\", {members}\"features\": [");
    let mut separator = "\n";
    for element in super::elements(level) {
        let push = |out: &mut String, point: &Pt2<Plan>| push_position(out, position(*point), decimals);
        let Some((geometry, coordinates)) = geometry(&element.form, push) else { continue };
        out.push_str(separator);
        out.push_str(&object([
            ("type", Some(quoted("Feature"))),
            ("properties", Some(properties(element, level))),
            ("geometry", Some(object([("type", Some(quoted(geometry))), ("coordinates", Some(coordinates))]))),
        ]));
        separator = ",\n";
    }
    out.push_str("\n]}\n");
    out
}

fn properties(element: &Element, level: &Level) -> String {
    object([
        ("type", Some(quoted(element.kind.word()))),
        ("name", element.name.as_deref().map(quoted)),
        ("level", Some(quoted(&level.name))),
        ("ordinal", Some(level.ordinal.to_string())),
        ("joins", (!element.joins.is_empty()).then(|| quoted(&joins(element)))),
        ("source", element.source.as_deref().map(quoted)),
    ])
}

/// Ordinals of the storeys that stairs or a lift join: `0;1`.
fn joins(element: &Element) -> String {
    element.joins.iter().map(i32::to_string).collect::<Vec<_>>().join(";")
}

/// Type and coordinates.
fn geometry(form: &Form, push: impl Fn(&mut String, &Pt2<Plan>)) -> Option<(&'static str, String)> {
    let mut out = String::new();
    let name = match form {
        Form::Area(rings) => {
            let mut rings = super::rings(rings)?;
            for (i, ring) in rings.iter_mut().enumerate() {
                if (signed_area(ring) > 0.0) != (i == 0) {
                    ring.reverse();
                }
                ring.extend(ring.first().copied());
            }
            push_list(&mut out, &rings, |out, ring| push_list(out, ring, &push));
            "Polygon"
        }
        Form::Line(line) if line.len() < 2 => return None,
        Form::Line(line) => {
            push_list(&mut out, line, push);
            "LineString"
        }
        Form::Spot(spot) => {
            push(&mut out, spot);
            "Point"
        }
    };
    Some((name, out))
}

/// Twice a ring's area, above 0 where it runs anticlockwise; seen from its first corner, for sites far from the origin.
fn signed_area(ring: &[Pt2<Plan>]) -> f64 {
    let Some(first) = ring.first() else { return 0.0 };
    let cross = |a: &Pt2<Plan>, b: &Pt2<Plan>| (a.x - first.x) * (b.y - first.y) - (b.x - first.x) * (a.y - first.y);
    ring.iter().zip(ring.iter().skip(1)).map(|(a, b)| cross(a, b)).sum()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{flat, read, ring};
    use super::*;
    use crate::plan::projection::Projection;
    use ::geojson::{FeatureCollection, GeometryValue};
    use planwalk_types::{Cell, ElementKind, FloorPlan};
    use proptest::prelude::*;

    fn features(text: &str) -> FeatureCollection {
        text.parse().unwrap()
    }

    /// All positions, in the file's order; rings with their repeated first.
    fn positions(text: &str) -> Vec<[f64; 2]> {
        let of = |feature: ::geojson::Feature| match feature.geometry.unwrap().value {
            GeometryValue::Point { coordinates } => vec![coordinates],
            GeometryValue::LineString { coordinates } => coordinates,
            GeometryValue::Polygon { coordinates } => coordinates.concat(),
            other => panic!("{other:?}"),
        };
        features(text).features.into_iter().flat_map(of).map(|p| [p[0], p[1]]).collect()
    }

    #[test]
    fn features_say_what_they_are() {
        let features = features(&geojson(&flat())).features;
        assert_eq!(features.len(), flat().elements.len());
        let room = features[6].properties.as_ref().unwrap();
        for (key, value) in [("type", "room"), ("name", "Küche <1> & \"2\""), ("level", "first floor"), ("source", "layer \"0\" & <more>")]
        {
            assert_eq!(room.get(key).and_then(|v| v.as_str()), Some(value), "{key}");
        }
        assert_eq!(room.get("ordinal").and_then(serde_json::Value::as_i64), Some(1));
        assert_eq!(features[0].properties.as_ref().unwrap().get("name"), None);
    }

    #[test]
    fn outlines_run_anticlockwise_and_holes_clockwise_however_they_were_drawn() {
        let turned = |mut ring: Vec<Pt2<Plan>>| {
            ring.reverse();
            ring
        };
        let text = |outline: Vec<Pt2<Plan>>, hole: Vec<Pt2<Plan>>| {
            let walls = Element::new(ElementKind::Wall, Form::Area(vec![outline, hole]));
            geojson(&Level { elements: vec![walls], ..Level::default() })
        };
        let (outline, hole) = (ring(0.0, 0.0, 4.0, 3.0), ring(1.0, 1.0, 2.0, 2.0));
        let right = text(outline.clone(), turned(hole.clone()));
        assert!(right.contains("[[0,0],[4,0],[4,3],[0,3],[0,0]]"), "{right}");
        for (outline, hole) in [(outline.clone(), hole.clone()), (turned(outline), hole)] {
            for ring in positions(&text(outline, hole)).chunks(5).enumerate() {
                let points: Vec<Pt2<Plan>> = ring.1.iter().map(|[x, y]| Pt2::new(*x, *y)).collect();
                assert_eq!(signed_area(&points) > 0.0, ring.0 == 0);
                assert_eq!(ring.1.first(), ring.1.last());
            }
        }
    }

    /// The flat as somebody else would write it: other words, no names, rings either way round, closed or not.
    const FLAT_BY_HAND: &str = r#"{"type": "FeatureCollection", "units": "m", "features": [
        {"type": "Feature", "properties": {"class": "mur"}, "geometry": {"type": "Polygon", "coordinates": [
            [[-0.2,-0.2],[-0.2,4.2],[8.2,4.2],[8.2,-0.2],[-0.2,-0.2]], [[0,0],[8,0],[8,4],[0,4]]]}},
        {"type": "Feature", "properties": {"class": "mur"}, "geometry": {"type": "LineString", "coordinates": [[5,4],[5,0]]}},
        {"type": "Feature", "properties": {"class": "porte"}, "geometry": {"type": "Polygon", "coordinates": [
            [[1.9,-0.2],[1,-0.2],[1,0],[1.9,0]]]}},
        {"type": "Feature", "properties": {"door": "yes"}, "geometry": {"type": "Point", "coordinates": [5,2]}},
        {"type": "Feature", "properties": {"class": "porte"}, "geometry": {"type": "LineString", "coordinates": [[0,1],[0,1.9]]}},
        {"type": "Feature", "properties": {"class": "Fenster"}, "geometry": {"type": "Polygon", "coordinates": [
            [[6,-0.2],[7.5,-0.2],[7.5,0],[6,0]]]}},
        {"type": "Feature", "properties": {"class": "Raum"}, "geometry": {"type": "MultiPolygon", "coordinates": [
            [[[0,0],[5,0],[5,4],[0,4]]], [[[5,0],[8,0],[8,4],[5,4]]]]}}]}"#;

    #[test]
    fn a_storey_in_metres_is_read_as_it_was_meant() {
        let plan = read(&geojson(&flat()));
        assert_eq!(plan, read(FLAT_BY_HAND));
        let at = |x, y| plan.at(Pt2::new(x, y));
        let walls = [at(3.0, -0.1), at(5.0, 1.0), at(8.1, 2.0)];
        assert_eq!(walls, [Cell::Wall; 3]);
        assert_eq!([at(1.5, -0.1), at(5.01, 2.0), at(-0.1, 1.5)], [Cell::Door; 3]);
        assert_eq!([at(7.0, -0.1), at(2.0, 2.0), at(-0.5, -0.5)], [Cell::Window, Cell::Free, Cell::Unknown]);
    }

    #[test]
    fn a_storey_on_the_globe_is_read_with_the_same_rooms() {
        let place = Georeference::at_origin(10.0, 53.5, 0.0);
        let text = geojson_on_globe(&flat(), &place).unwrap();
        assert!(!text.contains("units"));
        let globe = read(&text);
        let plan = read(&geojson(&flat()));
        let area = FloorPlan::inside_area_m2;
        // Cells of 5 cm fall differently: half a cell along 40 m of walls.
        assert!((area(&globe) - area(&plan)).abs() < 1.0, "{} m² for {} m²", area(&globe), area(&plan));
        let doors = |plan: &FloorPlan| plan.cells().iter().filter(|c| **c == Cell::Door).count() as f64;
        assert!((doors(&globe) / doors(&plan) - 1.0).abs() < 0.2, "{} cells for {}", doors(&globe), doors(&plan));
    }

    #[test]
    fn what_is_no_place_is_refused() {
        let place = Georeference::at_origin(10.0, -90.0, 0.0);
        let error = geojson_on_globe(&flat(), &place).unwrap_err().to_string();
        assert!(error.contains("latitude -90°"), "{error}");
    }

    #[test]
    fn an_empty_storey_is_an_empty_collection() {
        assert!(features(&geojson(&Level::default())).features.is_empty());
    }

    proptest! {
        #[test]
        fn a_walk_to_the_globe_and_back_costs_less_than_five_centimetres(
            (longitude_deg, latitude_deg) in (-180.0..180.0, -65.0..65.0),
            bearing_rad in -3.0..3.0,
            points in prop::collection::vec((-120.0..120.0, -120.0..120.0), 3..20),
        ) {
            let line: Vec<Pt2<Plan>> = points.iter().map(|(x, y)| Pt2::new(*x, *y)).collect();
            let walls = Element::new(ElementKind::Wall, Form::Line(line.clone()));
            let place = Georeference::at_origin(longitude_deg, latitude_deg, bearing_rad);
            let text = geojson_on_globe(&Level { elements: vec![walls], ..Level::default() }, &place).unwrap();
            let globe = positions(&text);
            for degree in globe.iter().flatten() {
                prop_assert!((degree * 1e7 - (degree * 1e7).round()).abs() < 1e-6);
            }
            // The reader's map has north up at the first point. 170 m from the writer's, at 65°, its north differs by 6e-5: 2 cm over
            // 340 m. Rounding adds 8 mm at either point.
            let projection = Projection::of(Some("urn:ogc:def:crs:OGC:1.3:CRS84"), false, &globe, &mut Vec::new());
            let (s, c) = bearing_rad.sin_cos();
            for (at, meant) in globe.iter().zip(&line) {
                let [east, north] = projection.metres(*at);
                let (x, y) = (line[0].x + east * c - north * s, line[0].y + east * s + north * c);
                let error = (x - meant.x).hypot(y - meant.y);
                prop_assert!(error < 0.05, "{error} m");
            }
        }
    }
}
