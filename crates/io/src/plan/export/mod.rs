//! How does a storey leave for other programs? As a drawing, as features of a map, as a list of walls, or as a robot's map.
//!
//! | function | file | who reads it |
//! |---|---|---|
//! | [`svg`] | SVG, 1 unit = 1 mm | browsers, Inkscape, CAD |
//! | [`geojson`] | GeoJSON in metres | this program, scripts |
//! | [`geojson_on_globe`] | GeoJSON (RFC 7946), degrees | map programs |
//! | [`picture`] | SVG with rooms in colours, findings, a legend | people |
//! | [`csv`] | `x0,y0,x1,y1,kind` | this program, spreadsheets, scripts |
//! | [`ros_map_image`], [`ros_map_yaml`] | PGM, `map.yaml` | robots |
//!
//! All but the last are of one [`Level`]. What no file of a format can hold is left out: a coordinate that is not finite or over
//! 1e9 m, a ring of fewer than three corners, a line of fewer than two. The whole of a building is kept by [`super::native`].

mod csv;
mod geojson;
mod picture;
mod ros;
mod svg;

use planwalk_types::{Element, Level, Plan, Pt2};

use super::notation;
pub use super::projection::NoPlace;
pub use csv::csv;
pub use geojson::{geojson, geojson_on_globe};
pub use picture::picture;
pub use ros::{ros_map_image, ros_map_yaml};
pub use svg::svg;

/// Fewest corners of a ring that encloses something.
const FEWEST_CORNERS: usize = 3;

/// A door given as a point opens walls this near to it, metres: as much as drawing makes of it.
const SPOT_RADIUS_M: f64 = 0.5 * super::vector::POINT_DOOR_M;

/// Elements that can be written.
fn elements(level: &Level) -> impl Iterator<Item = &Element> {
    level.elements.iter().filter(|element| notation::can_be_written(element))
}

/// A ring's corners, none twice in a row, the first not repeated at the end; `None` where they enclose nothing.
fn corners(ring: &[Pt2<Plan>]) -> Option<Vec<Pt2<Plan>>> {
    let mut corners = ring.to_vec();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    (corners.len() >= FEWEST_CORNERS).then_some(corners)
}

/// The outline and the holes of an area, in that order; `None` where the outline encloses nothing.
fn rings(rings: &[Vec<Pt2<Plan>>]) -> Option<Vec<Vec<Pt2<Plan>>>> {
    let (outline, holes) = rings.split_first()?;
    let outline = corners(outline)?;
    Some(std::iter::once(outline).chain(holes.iter().filter_map(|hole| corners(hole))).collect())
}

#[cfg(test)]
mod tests {
    //! Two rooms with walls 20 cm thick, for the tests of every format.

    use super::*;
    use planwalk_types::{ElementKind, FloorPlan, Form};

    pub(super) fn ring(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<Pt2<Plan>> {
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Pt2::new(x, y)).to_vec()
    }

    fn named(kind: ElementKind, name: &str, form: Form) -> Element {
        Element { name: Some(name.to_owned()), source: Some("layer \"0\" & <more>".to_owned()), ..Element::new(kind, form) }
    }

    pub(super) fn flat() -> Level {
        let line = |ends: [(f64, f64); 2]| Form::Line(ends.map(|(x, y)| Pt2::new(x, y)).to_vec());
        let elements = vec![
            Element::new(ElementKind::Wall, Form::Area(vec![ring(-0.2, -0.2, 8.2, 4.2), ring(0.0, 0.0, 8.0, 4.0)])),
            Element::new(ElementKind::Wall, line([(5.0, 0.0), (5.0, 4.0)])),
            named(ElementKind::Door, "front", Form::Area(vec![ring(1.0, -0.2, 1.9, 0.0)])),
            Element::new(ElementKind::Door, Form::Spot(Pt2::new(5.0, 2.0))),
            Element::new(ElementKind::Door, line([(0.0, 1.0), (0.0, 1.9)])),
            Element::new(ElementKind::Window, Form::Area(vec![ring(6.0, -0.2, 7.5, 0.0)])),
            named(ElementKind::Room, "Küche <1> & \"2\"", Form::Area(vec![ring(0.0, 0.0, 5.0, 4.0)])),
            named(ElementKind::Room, "3", Form::Area(vec![ring(5.0, 0.0, 8.0, 4.0)])),
        ];
        Level { ordinal: 1, name: "first floor".to_owned(), elements }
    }

    /// What the crate's reader makes of a file with this text.
    pub(super) fn read(text: &str) -> FloorPlan {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        crate::plan::read(file.path(), &crate::plan::PlanOptions::default()).unwrap().plan
    }

    #[test]
    fn rings_are_opened_and_those_that_enclose_nothing_are_left_out() {
        let square = ring(0.0, 0.0, 1.0, 1.0);
        let closed = [square.clone(), vec![square[0], square[0]]].concat();
        assert_eq!(corners(&closed), Some(square.clone()));
        let edge = vec![square[0], square[1], square[1], square[0]];
        assert_eq!((corners(&edge), corners(&[])), (None, None));
        assert_eq!(rings(&[closed.clone(), edge.clone()]), Some(vec![square]));
        assert_eq!((rings(&[edge, closed]), rings(&[])), (None, None));
    }

    #[test]
    fn what_cannot_be_written_leaves_the_rest_alone() {
        let mut level = flat();
        let whole = (svg(&level), geojson(&level), csv(&level));
        for far in [f64::NAN, f64::INFINITY, -1e300] {
            for form in [Form::Spot(Pt2::new(far, 0.0)), Form::Line(vec![Pt2::new(0.0, 0.0), Pt2::new(0.0, far)])] {
                level.elements.push(Element::new(ElementKind::Wall, form));
            }
        }
        for form in [Form::Area(vec![]), Form::Area(vec![vec![Pt2::new(0.0, 0.0)]]), Form::Line(vec![Pt2::new(0.0, 0.0)])] {
            level.elements.push(Element::new(ElementKind::Room, form));
        }
        assert_eq!((svg(&level), geojson(&level), csv(&level)), whole);
    }
}
