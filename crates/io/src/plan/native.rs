//! What does Planwalk's own plan file say? A building's storeys as shapes in metres, with where they come from: `*.plan.json`.
//!
//! [`PlanDocument`] ─▶ [`write()`] ─▶ JSON, one element a line ─▶ `read` ─▶ [`PlanDocument`]
//!
//! `docs/plan-format.md` describes it for people who write such files. The same document always gives the same bytes; coordinates
//! are rounded to 0.1 mm. Members that are not known are passed over, so that later programs may add some; what changes the
//! meaning of known ones gets another number in [`SCHEMA`].
//! Pitfalls: JSON knows no order, but a file is known by its beginning, so `schema` stands first. JSON has no NaN, but `1e999` is JSON.

use planwalk_types::{Building, Element, ElementKind, Form, Georeference, Level, Plan, Pt2};
use serde::Deserialize;

use super::PlanFileError;
use super::notation::{self, METRE_DECIMALS, decimal, push_list, quoted};
use super::projection;
use crate::text;

/// What this program reads and writes.
pub const SCHEMA: &str = "planwalk-plan/1";
/// What every version's schema begins with.
const SCHEMA_FAMILY: &str = "planwalk-plan/";
/// Decimals of degrees and radians: 0.1 mm on the ground, and at 100 km.
const ANGLE_DECIMALS: usize = 9;

/// Most of each character in a file, strings included: they bound the memory before any of it is taken. A campus drawn to the
/// centimetre has a hundredth of each.
const LIMITS: [(char, usize, &str); 3] = [
    // `{`: each element, and a few more.
    ('{', 1_000_000, "elements"),
    // `[`: each point, ring and line.
    ('[', 10_000_000, "points"),
    // `"`: two for each word and for each text.
    ('"', 20_000_000, "texts"),
];

/// A building, and what a user should know about where it comes from.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanDocument {
    /// What is drawn.
    pub building: Building,
    /// The file that it was made from.
    pub source: Source,
    /// How its place on the globe is known, if somebody said it.
    pub placed: Option<Placed>,
    /// What was decided on the way, for people.
    pub notes: Vec<String>,
}

/// How a plan's place on the globe is known; for people, as [`Building::georeference`] has the place itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placed {
    /// Who says so: points, a world file, an anchor and a bearing, a grid.
    pub from: String,
    /// Points that are known on both, and how far the plan puts them from there.
    pub points: Vec<PlacedPoint>,
}

/// A point that is known on the plan and on the globe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedPoint {
    /// On the plan, metres.
    pub plan: Pt2<Plan>,
    /// On the globe, WGS 84.
    pub longitude_deg: f64,
    /// Likewise.
    pub latitude_deg: f64,
    /// Distance on the ground between there and where the plan puts it, metres.
    pub off_m: f64,
}

/// The file that a plan was made from; all of it for people, none of it needed.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Source {
    /// Its name.
    pub file: Option<String>,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: Option<String>,
    /// What it was read as: `dxf`, `svg`, `png` …
    pub format: Option<String>,
    /// Metres in one unit, or pixel, of it.
    pub metres_per_unit: Option<f64>,
    /// How that is known: the file's own unit, a dimension, a measured length …
    pub scale_from: Option<String>,
}

/// The document as a file's text.
///
/// Elements with a coordinate that is not finite, or is over 1e9 m, have no place in it: they are left out, and a note tells
/// their number. So is a georeference that is no place on the globe.
pub fn write(document: &PlanDocument) -> String {
    let mut out = String::new();
    let georeference = document.building.georeference.filter(projection::is_place);
    let notes: Vec<String> = document.notes.iter().cloned().chain(lost(&document.building)).collect();
    out.push_str("{\n");
    push_member(&mut out, "schema", &quoted(SCHEMA));
    push_member(&mut out, "units", &quoted("m"));
    push_member(&mut out, "y", &quoted("up"));
    if let Some(georeference) = georeference {
        push_member(&mut out, "georeference", &georeference_object(&georeference, document.placed.as_ref()));
    }
    push_member(&mut out, "source", &source_object(&document.source));
    out.push_str("  \"notes\": ");
    push_lines(&mut out, "  ", &notes, |out, note| out.push_str(&quoted(note)));
    out.push_str(",\n  \"levels\": ");
    push_lines(&mut out, "  ", &document.building.levels, push_level);
    out.push_str("\n}\n");
    out
}

fn push_member(out: &mut String, key: &str, value: &str) {
    for part in ["  \"", key, "\": ", value, ",\n"] {
        out.push_str(part);
    }
}

/// A list with each item on its own line, two spaces deeper than `indent`.
fn push_lines<T>(out: &mut String, indent: &str, items: impl IntoIterator<Item = T>, mut push: impl FnMut(&mut String, T)) {
    out.push('[');
    let mut any = false;
    for item in items {
        out.push_str(if any { ",\n" } else { "\n" });
        out.push_str(indent);
        out.push_str("  ");
        push(out, item);
        any = true;
    }
    if any {
        out.push('\n');
        out.push_str(indent);
    }
    out.push(']');
}

fn georeference_object(georeference: &Georeference, placed: Option<&Placed>) -> String {
    let angle = |value| Some(decimal(value, ANGLE_DECIMALS));
    let anchor = georeference.anchor;
    let placed = placed.filter(|placed| placed.points.iter().all(can_be_kept));
    notation::object([
        ("longitude_deg", angle(georeference.longitude_deg)),
        ("latitude_deg", angle(georeference.latitude_deg)),
        ("bearing_rad", angle(georeference.bearing_rad)),
        ("anchor", (anchor != Pt2::new(0.0, 0.0)).then(|| position(anchor))),
        ("scale", (georeference.scale != 1.0).then(|| decimal(georeference.scale, ANGLE_DECIMALS))),
        ("from", placed.map(|placed| quoted(&placed.from))),
        ("points", placed.filter(|placed| !placed.points.is_empty()).map(|placed| points_list(&placed.points))),
    ])
}

fn can_be_kept(point: &PlacedPoint) -> bool {
    let numbers = [point.longitude_deg, point.latitude_deg, point.off_m];
    notation::is_near(point.plan) && numbers.iter().all(|number| number.abs() <= notation::FARTHEST_M)
}

fn points_list(points: &[PlacedPoint]) -> String {
    let mut out = String::new();
    push_list(&mut out, points, |out, point| {
        out.push_str(&notation::object([
            ("plan", Some(position(point.plan))),
            ("longitude_deg", Some(decimal(point.longitude_deg, ANGLE_DECIMALS))),
            ("latitude_deg", Some(decimal(point.latitude_deg, ANGLE_DECIMALS))),
            ("off_m", Some(decimal(point.off_m, METRE_DECIMALS))),
        ]));
    });
    out
}

fn position(at: Pt2<Plan>) -> String {
    let mut out = String::new();
    notation::push_position(&mut out, [at.x, at.y], METRE_DECIMALS);
    out
}

fn source_object(source: &Source) -> String {
    let text = |value: &Option<String>| value.as_deref().map(quoted);
    notation::object([
        ("file", text(&source.file)),
        ("sha256", text(&source.sha256)),
        ("format", text(&source.format)),
        // All digits: a foot is 0.3048 m, a scan's pixel is anything.
        ("metres_per_unit", source.metres_per_unit.filter(|m| m.is_finite()).map(|m| serde_json::Value::from(m).to_string())),
        ("scale_from", text(&source.scale_from)),
    ])
}

fn push_level(out: &mut String, level: &Level) {
    out.push_str(&format!("{{\"ordinal\": {}, \"name\": {}, \"elements\": ", level.ordinal, quoted(&level.name)));
    push_lines(out, "    ", level.elements.iter().filter(|e| notation::can_be_written(e)), push_element);
    out.push('}');
}

fn push_element(out: &mut String, element: &Element) {
    let mut form = String::new();
    let push_point = |out: &mut String, at: &Pt2<Plan>| notation::push_position(out, [at.x, at.y], METRE_DECIMALS);
    let key = match &element.form {
        Form::Area(rings) => {
            push_list(&mut form, rings, |out, ring| push_list(out, ring, push_point));
            "area"
        }
        Form::Line(line) => {
            push_list(&mut form, line, push_point);
            "line"
        }
        Form::Spot(spot) => {
            push_point(&mut form, spot);
            "spot"
        }
    };
    out.push_str(&notation::object([
        ("kind", Some(quoted(element.kind.word()))),
        ("name", element.name.as_deref().map(quoted)),
        ("source", element.source.as_deref().map(quoted)),
        ("joins", (!element.joins.is_empty()).then(|| format!("{:?}", element.joins))),
        (key, Some(form)),
    ]));
}

/// What the file cannot hold.
fn lost(building: &Building) -> impl Iterator<Item = String> {
    let count = building.levels.iter().flat_map(|l| &l.elements).filter(|e| !notation::can_be_written(e)).count();
    let elements = (count > 0).then(|| format!("{count} elements with coordinates that are not finite or over 1e9 m are left out"));
    let place = building.georeference.filter(|g| !projection::is_place(g));
    let place =
        place.map(|g| format!("longitude {}°, latitude {}° is no place for a plan, and is left out", g.longitude_deg, g.latitude_deg));
    elements.into_iter().chain(place)
}

/// Whether a text that begins like this is such a file, of whatever version.
pub(super) fn is_one(head: &str) -> bool {
    let schemas = || head.split("\"schema\"").skip(1).filter_map(|rest| rest.trim_start().strip_prefix(':')).map(str::trim_start);
    head.trim_start().starts_with('{')
        && schemas().any(|value| value.strip_prefix('"').is_some_and(|value| value.starts_with(SCHEMA_FAMILY)))
}

/// What every version of the file says of itself.
#[derive(Deserialize)]
struct Head {
    schema: String,
}

/// The file as JSON; what it may leave out is an option.
#[derive(Deserialize)]
struct Body {
    units: Option<String>,
    y: Option<String>,
    georeference: Option<Place>,
    source: Option<Source>,
    notes: Option<Vec<String>>,
    levels: Vec<Storey>,
}

#[derive(Deserialize)]
struct Place {
    longitude_deg: f64,
    latitude_deg: f64,
    bearing_rad: Option<f64>,
    anchor: Option<[f64; 2]>,
    scale: Option<f64>,
    from: Option<String>,
    points: Option<Vec<PointRecord>>,
}

#[derive(Deserialize)]
struct PointRecord {
    plan: [f64; 2],
    longitude_deg: f64,
    latitude_deg: f64,
    off_m: Option<f64>,
}

#[derive(Deserialize)]
struct Storey {
    ordinal: i32,
    name: Option<String>,
    elements: Vec<Record>,
}

#[derive(Deserialize)]
struct Record {
    kind: String,
    name: Option<String>,
    source: Option<String>,
    joins: Option<Vec<i32>>,
    area: Option<Vec<Vec<[f64; 2]>>>,
    line: Option<Vec<[f64; 2]>>,
    spot: Option<[f64; 2]>,
}

/// Reads a document. Storeys come back in their order from below.
pub(super) fn read(text: &str) -> Result<PlanDocument, PlanFileError> {
    for (mark, limit, what) in LIMITS {
        let count = text.bytes().filter(|byte| u32::from(*byte) == u32::from(mark)).count();
        if count > limit {
            return Err(refused(format!("{count} times \"{mark}\" are more than {limit}, enough for any plan's {what}")));
        }
    }
    let syntax = |why: serde_json::Error| refused(why.to_string());
    let Head { schema } = serde_json::from_str(text).map_err(syntax)?;
    if schema != SCHEMA {
        return Err(PlanFileError::OtherSchema { found: text::short(&schema), read: SCHEMA });
    }
    let body: Body = serde_json::from_str(text).map_err(syntax)?;
    for (key, value, meant) in [("units", &body.units, "m"), ("y", &body.y, "up")] {
        if let Some(value) = value.as_deref().filter(|value| *value != meant) {
            return Err(refused(format!("\"{key}\" is \"{}\", and can only be \"{meant}\"", text::short(value))));
        }
    }
    let (georeference, placed) = match body.georeference {
        Some(place) => (Some(place.georeference()?), place.placed()),
        None => (None, None),
    };
    let mut levels = body.levels.into_iter().map(Storey::level).collect::<Result<Vec<_>, _>>()?;
    // Stable: storeys of one ordinal stay in the file's order.
    levels.sort_by_key(|level| level.ordinal);
    let building = Building { levels, georeference };
    Ok(PlanDocument { building, placed, source: body.source.unwrap_or_default(), notes: body.notes.unwrap_or_default() })
}

fn refused(why: String) -> PlanFileError {
    PlanFileError::Native { why }
}

impl Place {
    fn georeference(&self) -> Result<Georeference, PlanFileError> {
        let [x, y] = self.anchor.unwrap_or_default();
        let georeference = Georeference {
            longitude_deg: self.longitude_deg,
            latitude_deg: self.latitude_deg,
            bearing_rad: self.bearing_rad.unwrap_or(0.0),
            anchor: Pt2::new(x, y),
            scale: self.scale.unwrap_or(1.0),
        };
        let place = projection::is_place(&georeference).then_some(georeference);
        place.ok_or_else(|| refused(projection::NoPlace(georeference).to_string()))
    }

    fn placed(self) -> Option<Placed> {
        let point = |point: PointRecord| PlacedPoint {
            plan: Pt2::new(point.plan[0], point.plan[1]),
            longitude_deg: point.longitude_deg,
            latitude_deg: point.latitude_deg,
            off_m: point.off_m.unwrap_or(0.0),
        };
        let points: Vec<PlacedPoint> = self.points.unwrap_or_default().into_iter().map(point).collect();
        let from = self.from.or((!points.is_empty()).then(|| "points".to_owned()))?;
        Some(Placed { from, points })
    }
}

impl Storey {
    fn level(self) -> Result<Level, PlanFileError> {
        let name = self.name.unwrap_or_else(|| self.ordinal.to_string());
        let mut elements = Vec::with_capacity(self.elements.len());
        for (i, record) in self.elements.into_iter().enumerate() {
            let refuse = |why| PlanFileError::BadElement { level: text::short(&name), element: i, why };
            elements.push(record.element().map_err(refuse)?);
        }
        Ok(Level { ordinal: self.ordinal, name, elements })
    }
}

impl Record {
    fn element(self) -> Result<Element, String> {
        let kind = ElementKind::ALL.into_iter().find(|kind| kind.word() == self.kind).ok_or_else(|| {
            format!(
                "\"{}\" is no kind of element; known are {}",
                text::short(&self.kind),
                ElementKind::ALL.map(ElementKind::word).join(", ")
            )
        })?;
        let chain = |points: Vec<[f64; 2]>| points.into_iter().map(|[x, y]| Pt2::new(x, y)).collect::<Vec<_>>();
        let form = match (self.area, self.line, self.spot) {
            (Some(rings), None, None) => Form::Area(rings.into_iter().map(chain).collect()),
            (None, Some(line), None) => Form::Line(chain(line)),
            (None, None, Some([x, y])) => Form::Spot(Pt2::new(x, y)),
            (None, None, None) => return Err("it has no \"area\", \"line\" or \"spot\"".to_owned()),
            _ => return Err("it has more than one of \"area\", \"line\" and \"spot\"".to_owned()),
        };
        let far = form.points().find(|point| !notation::is_near(*point));
        if let Some(far) = far {
            return Err(format!("the point {far:?} is over 1e9 m away"));
        }
        let mut joins = self.joins.unwrap_or_default();
        joins.sort_unstable();
        joins.dedup();
        Ok(Element { kind, form, name: self.name, source: self.source, joins })
    }
}

#[cfg(test)]
mod tests;
