//! What does a plain list of walls say? CSV `x0,y0,x1,y1[,kind]`: two ends in metres, and wall, door or window.
//!
//! A header may stand on top and may call the ends 1 and 2; then columns are found by its names. Without one they are in this order.

use super::kind::{self, Kind};
use super::vector::{self, Form, Shape};
use super::{PlanFile, PlanFileError};
use crate::text;

/// Names of the columns, in the two ways of counting.
const NAMES: [[&str; 4]; 2] = [["x0", "y0", "x1", "y1"], ["x1", "y1", "x2", "y2"]];
/// Names of the column that says what it is.
const KIND: [&str; 3] = ["kind", "type", "category"];

/// Where the columns are.
struct Columns {
    ends: [usize; 4],
    kind: Option<usize>,
}

fn cells(row: &str) -> Vec<&str> {
    row.split([',', ';', '\t']).map(|cell| cell.trim().trim_matches('"')).collect()
}

impl Columns {
    /// As a header names them.
    fn of(header: &str) -> Option<Self> {
        let bare = |name: &&str| name.trim_start_matches('#').trim().to_ascii_lowercase().trim_end_matches("_m").to_owned();
        let names: Vec<String> = cells(header).iter().map(bare).collect();
        let find = |name: &str| names.iter().position(|n| n == name);
        let ends = NAMES.iter().find_map(|wanted| {
            let found: Vec<usize> = wanted.iter().map_while(|name| find(name)).collect();
            found.try_into().ok()
        })?;
        Some(Self { ends, kind: KIND.iter().find_map(|name| find(name)) })
    }

    /// Without a header: four numbers, and perhaps a word.
    fn in_order(row: &str) -> Option<Self> {
        let cells = cells(row);
        let ends = cells.len() >= 4 && cells[..4].iter().all(|cell| cell.parse::<f64>().is_ok());
        ends.then_some(Self { ends: [0, 1, 2, 3], kind: Some(4) })
    }
}

/// Whether a text that begins like this is a list of walls.
pub(super) fn is_one(head: &str) -> bool {
    let first = head.lines().find(|line| !line.trim().is_empty() && !is_comment(line));
    first.is_some_and(|line| Columns::of(line).is_some() || Columns::in_order(line).is_some())
}

/// A comment; but a header may be one too.
fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with('#') && Columns::of(line).is_none()
}

/// Draws the walls of a list.
pub(super) fn read(text: &str) -> Result<PlanFile, PlanFileError> {
    let mut notes = Vec::new();
    let mut rows = (1..).zip(text.lines().map(str::trim)).filter(|(_, line)| !line.is_empty() && !is_comment(line)).peekable();
    let header = rows.peek().and_then(|(_, row)| Columns::of(row));
    let columns = match header {
        Some(columns) => {
            rows.next();
            columns
        }
        None => Columns { ends: [0, 1, 2, 3], kind: Some(4) },
    };
    let mut shapes = Vec::new();
    for (line, row) in rows {
        shapes.push(shape(line, &cells(row), &columns)?);
    }
    notes.push(format!("a list of {} walls, doors and windows in metres", shapes.len()));
    vector::draw(&shapes, notes)
}

fn shape(line: usize, cells: &[&str], columns: &Columns) -> Result<Shape, PlanFileError> {
    let number = |k: usize| {
        let cell = cells.get(columns.ends[k]).copied().unwrap_or("");
        let value = cell.parse().ok().filter(|v: &f64| v.is_finite());
        value.ok_or_else(|| PlanFileError::BadWall { line, why: format!("{} is \"{}\", no finite number", NAMES[0][k], text::short(cell)) })
    };
    let word = columns.kind.and_then(|at| cells.get(at)).copied().unwrap_or("");
    let kind = match kind::of(word) {
        None if word.is_empty() => Kind::Wall,
        Some(kind @ (Kind::Wall | Kind::Door | Kind::Window)) => kind,
        _ => return Err(PlanFileError::BadWall { line, why: format!("\"{}\" is no kind of wall", text::short(word)) }),
    };
    Ok(Shape { kind, form: Form::Line(vec![[number(0)?, number(1)?], [number(2)?, number(3)?]]) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Cell, Pt2};

    const ROOM: &str = "0,0,4,0\n4,0,4,3\n4,3,0,3\n0,3,0,0\n";

    #[test]
    fn walls_doors_and_windows_are_drawn_with_or_without_a_header() {
        let more = "1,0,2,0,door\n0,1,0,2,Window\n";
        for list in [
            format!("{ROOM}{more}"),
            format!("x0,y0,x1,y1,kind\n{ROOM}{more}"),
            format!("# a flat\nx1_m;y1_m;x2_m;y2_m;type\n{ROOM}{more}"),
        ] {
            assert!(is_one(&list), "{list}");
            let plan = read(&list).unwrap().plan;
            let at = |x, y| plan.at(Pt2::new(x, y));
            assert_eq!([at(3.0, 0.01), at(1.5, 0.01), at(0.01, 1.5), at(2.0, 1.5)], [Cell::Wall, Cell::Door, Cell::Window, Cell::Free]);
        }
    }

    #[test]
    fn columns_are_found_by_name() {
        let plan = read("name,y1,x1,y0,x0\na,0,4,0,0\nb,3,4,3,0\n").unwrap().plan;
        assert_eq!((plan.at(Pt2::new(3.9, 0.01)), plan.at(Pt2::new(3.9, 3.01))), (Cell::Wall, Cell::Wall));
    }

    #[test]
    fn broken_rows_are_named_with_their_line() {
        let line = |row: &str| match read(&format!("{ROOM}{row}\n")) {
            Err(PlanFileError::BadWall { line, .. }) => line,
            other => panic!("{row}: {other:?}"),
        };
        for row in ["1,2,3", "1,2,3,nan", "1,2,3,inf", "a,b,c,d", "1,2,3,4,cupboard", "1,2,3,4,room"] {
            assert_eq!(line(row), 5);
        }
        assert!(read("x0,y0,x1,y1\n").is_err());
        for other in ["", "P5 10 10 255", "t_s,x_m,y_m\n1,2,3", "1,2,3", "hello, world"] {
            assert!(!is_one(other), "{other}");
        }
    }
}
