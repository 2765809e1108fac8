//! What shape is an entity? Lines, polylines, splines and insertions, as [`Shape`]s in their own planes.

use dxf::entities::{Insert, LwPolyline, Polyline, Spline as SplineEntity};

use super::curves::{Affine, Curve, Point, Space, Spline, Vertex, cross, rad};
use super::look;
use super::objects::{Insertion, Object, Shape};

pub(super) fn vector(v: &dxf::Vector) -> Space {
    [v.x, v.y, v.z]
}

pub(super) fn plane(normal: &dxf::Vector, height: f64) -> Affine {
    Affine::of_plane(vector(normal), height)
}

pub(super) fn line(curve: Curve, closed: bool) -> Shape {
    Shape::Line { curve: Box::new(curve), closed }
}

pub(super) fn straight(at: Point) -> Vertex {
    Vertex { at, bulge: 0.0, width: 0.0 }
}

pub(super) fn chain(points: &[&dxf::Point], closed: bool) -> Shape {
    line(Curve::Chain(points.iter().map(|p| straight([p.x, p.y])).collect()), closed)
}

/// The corners in order around; files have the last two crossed.
pub(super) fn area(corners: [&dxf::Point; 4]) -> Shape {
    let mut ring: Vec<Vertex> = corners.iter().map(|p| straight([p.x, p.y])).collect();
    ring.dedup();
    Shape::Area(vec![vec![Curve::Chain(ring)]])
}

/// Half axes of an ellipse in space, seen from above.
pub(super) fn axes(major: Space, normal: Space, ratio: f64) -> [Point; 2] {
    let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
    let unit = if length > 0.0 { normal.map(|v| v / length) } else { [0.0, 0.0, 1.0] };
    let minor = cross(unit, major);
    [[major[0], major[1]], [minor[0] * ratio, minor[1] * ratio]]
}

pub(super) fn light_polyline(polyline: &LwPolyline) -> Shape {
    let width = |v: &dxf::LwPolylineVertex| {
        let own = 0.5 * (v.starting_width + v.ending_width);
        if own > 0.0 { own } else { polyline.constant_width }
    };
    let vertices = polyline.vertices.iter().map(|v| Vertex { at: [v.x, v.y], bulge: v.bulge, width: width(v) });
    line(Curve::Chain(vertices.collect()), polyline.is_closed())
}

pub(super) fn heavy_polyline(polyline: &Polyline) -> (Affine, Shape) {
    let default = 0.5 * (polyline.default_starting_width + polyline.default_ending_width);
    // The frame that a spline was fitted to is not drawn.
    let drawn = polyline.vertices().filter(|v| !v.is_spline_frame_control_point());
    let vertices = drawn.map(|v| {
        let own = 0.5 * (v.starting_width + v.ending_width);
        Vertex { at: [v.location.x, v.location.y], bulge: v.bulge, width: if own > 0.0 { own } else { default } }
    });
    let shape = line(Curve::Chain(vertices.collect()), polyline.is_closed());
    let in_space = polyline.is_3d_polyline();
    (if in_space { Affine::IDENTITY } else { plane(&polyline.normal, polyline.location.z) }, shape)
}

pub(super) fn spline(spline: &SplineEntity) -> Shape {
    if spline.control_points.is_empty() {
        let through: Vec<Point> = spline.fit_points.iter().map(|p| [p.x, p.y]).collect();
        return line(Curve::Spline(Spline::through(&through)), spline.is_closed());
    }
    let weights = spline.weight_values.iter().copied().chain(std::iter::repeat(1.0));
    let controls = spline.control_points.iter().zip(weights).map(|(p, w)| [p.x * w, p.y * w, w]).collect();
    let degree = usize::try_from(spline.degree_of_curve).unwrap_or(0);
    line(Curve::Spline(Spline { degree, knots: spline.knot_values.clone(), controls }), spline.is_closed())
}

pub(super) fn insertion(insert: &Insert, labels: Vec<Object>) -> Shape {
    let count = |n: i16| u16::try_from(n).unwrap_or(1).max(1);
    Shape::Insert(Box::new(Insertion {
        block: look::short(&insert.name).to_owned(),
        at: [insert.location.x, insert.location.y],
        scale: [insert.x_scale_factor, insert.y_scale_factor],
        turn_rad: rad(insert.rotation),
        columns: count(insert.column_count),
        rows: count(insert.row_count),
        spacing: [insert.column_spacing, insert.row_spacing],
        labels,
    }))
}
