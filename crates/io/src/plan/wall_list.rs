//! What does a plain list of walls say? CSV `x0,y0,x1,y1[,kind]`: two ends, and wall, door or window.
//!
//! Columns stand apart by commas, semicolons, tabs or blanks; beside semicolons and tabs a comma may be a decimal one.
//! A header may stand on top and may call the ends 1 and 2; then columns are found by its names. Without one they are in this order.
//! Metres, unless the header's names end in another unit (`x0_ft`), or a number alone stands before the first wall: metres in a unit.

use planwalk_types::{Building, Element, ElementKind, Form, Pt2};

use super::PlanFileError;
use super::kind::{self, Meaning};
use crate::text;

/// Names of the columns, in the two ways of counting.
const NAMES: [[&str; 4]; 2] = [["x0", "y0", "x1", "y1"], ["x1", "y1", "x2", "y2"]];
/// Names of the column that says what it is.
const KIND: [&str; 3] = ["kind", "type", "category"];

/// Endings of a header's names, and metres in that unit.
const UNITS: [(&str, f64); 7] =
    [("_m", 1.0), ("_cm", 0.01), ("_mm", 0.001), ("_ft", FOOT_M), ("_feet", FOOT_M), ("_in", FOOT_M / 12.0), ("_inch", FOOT_M / 12.0)];
const FOOT_M: f64 = 0.3048;
/// No wall is longer, metres: times and places of a walk are, and millimetres that are taken for metres.
const LONGEST_M: f64 = 10_000.0;
/// What is shorter, metres, begins and ends at one place.
const SHORTEST_M: f64 = 1e-3;
/// A list is none of walls if so many of ten rows begin and end at one place.
const PLACES_OF_TEN: usize = 9;

/// Most walls: a campus has a tenth. Each takes some 700 bytes.
const MOST_WALLS: usize = 1_000_000;
/// Columns that are looked at: a row without an end is no table.
const MOST_COLUMNS: usize = 1000;

/// Where the columns are, and what their numbers are.
struct Columns {
    ends: [usize; 4],
    kind: Option<usize>,
    metres_per_unit: f64,
}

/// The columns of a row. What keeps them apart is told by the row itself: a header may be written by another hand than the rows.
fn cells(row: &str) -> Vec<&str> {
    if !row.contains([',', ';', '\t']) {
        return row.split_whitespace().take(MOST_COLUMNS).map(bare).collect();
    }
    // Commas are decimal where something else leaves four columns: 0,5;1,2;3,0;4,1 but not 0,0;4,0.
    let others: Vec<&str> = row.split([';', '\t']).take(MOST_COLUMNS).map(bare).collect();
    let parts = if others.len() >= 4 { others } else { row.split([',', ';', '\t']).take(MOST_COLUMNS).map(bare).collect() };
    if parts.len() >= 4 {
        return parts;
    }
    // Points of two numbers each: 0 0, 4 0.
    parts.into_iter().flat_map(points).take(MOST_COLUMNS).collect()
}

fn bare(cell: &str) -> &str {
    cell.trim().trim_matches('"')
}

/// A column's numbers if blanks keep several apart, else the column as it is.
fn points(cell: &str) -> Vec<&str> {
    let all_numbers = cell.contains(char::is_whitespace) && cell.split_whitespace().all(|word| number(word).is_some());
    if all_numbers { cell.split_whitespace().collect() } else { vec![cell] }
}

/// A column's number, with a point or a decimal comma.
fn number(cell: &str) -> Option<f64> {
    cell.parse().ok().or_else(|| cell.split_once(',').and_then(|(whole, part)| format!("{whole}.{part}").parse().ok()))
}

impl Columns {
    /// As a header names them.
    fn of(header: &str) -> Option<Self> {
        let bare = |name: &&str| name.trim_start_matches('#').trim().to_ascii_lowercase();
        let mut names: Vec<String> = cells(header).iter().map(bare).collect();
        let mut metres_per_unit = 1.0;
        for name in &mut names {
            if let Some((short, metres)) = UNITS.iter().find_map(|(ending, metres)| Some((name.strip_suffix(ending)?.to_owned(), *metres)))
            {
                (*name, metres_per_unit) = (short, metres);
            }
        }
        let find = |name: &str| names.iter().position(|n| n == name);
        let ends = NAMES.iter().find_map(|wanted| {
            let found: Vec<usize> = wanted.iter().map_while(|name| find(name)).collect();
            found.try_into().ok()
        })?;
        Some(Self { ends, kind: KIND.iter().find_map(|name| find(name)), metres_per_unit })
    }

    /// Without a header: four numbers, and perhaps a word.
    fn in_order(row: &str) -> Option<Self> {
        let cells = cells(row);
        let ends = cells.len() >= 4 && cells[..4].iter().all(|cell| number(cell).is_some());
        ends.then(Self::default)
    }
}

impl Default for Columns {
    fn default() -> Self {
        Self { ends: [0, 1, 2, 3], kind: Some(4), metres_per_unit: 1.0 }
    }
}

/// A number alone: metres in a unit.
fn unit_alone(row: &str) -> Option<f64> {
    row.trim().parse().ok().filter(|metres: &f64| *metres > 0.0 && metres.is_finite())
}

/// Whether a text that begins like this is a list of walls.
pub(super) fn is_one(head: &str) -> bool {
    let mut rows = head.lines().filter(|line| !line.trim().is_empty() && !is_comment(line)).peekable();
    rows.next_if(|row| unit_alone(row).is_some());
    rows.next().is_some_and(|line| Columns::of(line).is_some() || Columns::in_order(line).is_some())
}

/// A comment; but a header may be one too.
fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with('#') && Columns::of(line).is_none()
}

/// The walls of a list.
pub(super) fn read(text: &str, notes: &mut Vec<String>) -> Result<Building, PlanFileError> {
    let mut rows = (1..).zip(text.lines().map(str::trim)).filter(|(_, line)| !line.is_empty() && !is_comment(line)).peekable();
    let alone = rows.next_if(|(_, row)| unit_alone(row).is_some()).and_then(|(_, row)| unit_alone(row));
    let header = rows.peek().and_then(|(_, row)| Columns::of(row));
    if header.is_some() {
        rows.next();
    }
    let mut columns = header.unwrap_or_default();
    columns.metres_per_unit *= alone.unwrap_or(1.0);
    let (mut elements, mut places) = (Vec::new(), Vec::new());
    for (line, row) in rows {
        if elements.len() + places.len() == MOST_WALLS {
            return Err(PlanFileError::DrawingTooLarge { what: "walls", limit: MOST_WALLS });
        }
        match element(line, &cells(row), &columns)? {
            Some(element) => elements.push(element),
            None => places.push(line),
        }
    }
    if let Some(first) = places.first() {
        let (points, rows) = (places.len(), places.len() + elements.len());
        if 10 * points >= PLACES_OF_TEN * rows {
            return Err(PlanFileError::NoLengths { points, rows });
        }
        notes.push(format!("{points} of {rows} rows begin and end at one place, the first in line {first}: they are left out"));
    }
    notes.push(format!("a list of {} walls, doors and windows; their unit is {} m", elements.len(), columns.metres_per_unit));
    Ok(Building::of_one_level(elements))
}

/// What a row says; nothing if it has no length.
fn element(line: usize, cells: &[&str], columns: &Columns) -> Result<Option<Element>, PlanFileError> {
    let end = |k: usize| {
        let cell = cells.get(columns.ends[k]).copied().unwrap_or("");
        let value = number(cell).map(|v| v * columns.metres_per_unit).filter(|v| v.is_finite());
        value.ok_or_else(|| PlanFileError::BadWall { line, why: format!("{} is \"{}\", no finite number", NAMES[0][k], text::short(cell)) })
    };
    let word = columns.kind.and_then(|at| cells.get(at)).copied().unwrap_or("");
    let kind = match kind::of(word) {
        None if word.is_empty() => ElementKind::Wall,
        Some(Meaning::Part(kind)) if !kind.is_ground() => kind,
        _ if number(word).is_some() => {
            let why = format!("it has {} numbers, and a wall's two ends are four: is it a walk, or a table without a header?", cells.len());
            return Err(PlanFileError::BadWall { line, why });
        }
        _ => return Err(PlanFileError::BadWall { line, why: format!("\"{}\" is no kind of wall", text::short(word)) }),
    };
    let ends = [Pt2::new(end(0)?, end(1)?), Pt2::new(end(2)?, end(3)?)];
    let length_m = ends[0].distance(ends[1]);
    if length_m > LONGEST_M {
        let why =
            format!("it would be {length_m:.0} m long: are these times and places, or is the unit another (x0_mm,y0_mm,… in the header)?");
        return Err(PlanFileError::BadWall { line, why });
    }
    let wall = || Element { source: Some(format!("line {line}")), ..Element::new(kind, Form::Line(ends.to_vec())) };
    Ok((length_m >= SHORTEST_M).then(wall))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Cell, FloorPlan};

    const ROOM: &str = "0,0,4,0\n4,0,4,3\n4,3,0,3\n0,3,0,0\n";

    fn drawn(text: &str) -> FloorPlan {
        let building = read(text, &mut Vec::new()).unwrap();
        super::super::vector::draw(&building.levels[0].elements, &mut Vec::new()).unwrap()
    }

    #[test]
    fn walls_doors_and_windows_are_drawn_with_or_without_a_header() {
        let more = "1,0,2,0,door\n0,1,0,2,Window\n";
        for list in [
            format!("{ROOM}{more}"),
            format!("x0,y0,x1,y1,kind\n{ROOM}{more}"),
            format!("# a flat\nx1_m;y1_m;x2_m;y2_m;type\n{ROOM}{more}"),
        ] {
            assert!(is_one(&list), "{list}");
            let plan = drawn(&list);
            let at = |x, y| plan.at(Pt2::new(x, y));
            assert_eq!([at(3.0, 0.01), at(1.5, 0.01), at(0.01, 1.5), at(2.0, 1.5)], [Cell::Wall, Cell::Door, Cell::Window, Cell::Free]);
        }
    }

    #[test]
    fn columns_stand_apart_by_commas_semicolons_tabs_or_blanks() {
        let with = |between: &str| format!("{ROOM}1,0,2,0,door\n0,1,0,2,window\n").replace(',', between);
        let header = |between: &str| "x0,y0,x1,y1,kind\n".replace(',', between);
        for between in [",", ";", "\t", " ", "   ", " \t ", ", ", " ; "] {
            for list in [with(between), header(between) + &with(between), header(",") + &with(between), header(" ") + &with(between)] {
                assert!(is_one(&list), "{list}");
                let plan = drawn(&list);
                let at = |x, y| plan.at(Pt2::new(x, y));
                let found = [at(3.0, 0.01), at(1.5, 0.01), at(0.01, 1.5), at(2.0, 1.5)];
                assert_eq!(found, [Cell::Wall, Cell::Door, Cell::Window, Cell::Free], "{list}");
            }
        }
    }

    #[test]
    fn points_may_be_pairs_and_commas_decimal() {
        let walls = |text: &str| {
            assert!(is_one(text), "{text}");
            let building = read(text, &mut Vec::new()).unwrap();
            building.levels[0].elements[0].form.points().flat_map(|at| [at.x, at.y]).collect::<Vec<f64>>()
        };
        for pairs in
            ["0.5 1.25; 3 4\n", "0.5 1.25, 3 4\n", "0.5,1.25;3,4\n", "0,5;1,25;3,0;4\n", "0,5\t1,25\t3\t4\twall\n", "0.5 1.25\t3 4\n"]
        {
            assert_eq!(walls(pairs), [0.5, 1.25, 3.0, 4.0], "{pairs}");
        }
        // Blanks and decimal commas, or thousands, cannot be told from other lists: nothing is made up of them.
        for unclear in ["0,5 1,2 3,0 4,1\n", "1 000;2 000;3 000;4 000\n"] {
            assert!(!is_one(unclear) || read(unclear, &mut Vec::new()).is_err(), "{unclear}");
        }
    }

    #[test]
    fn a_walk_that_is_given_as_a_plan_is_refused_as_one() {
        for row in ["0.1 1.5 2.5 0 0 0 0 1", "0.1,1.5,2.5,0,0,0,0,1"] {
            assert!(is_one(row), "{row}");
            let error = read(row, &mut Vec::new()).unwrap_err().to_string();
            assert!(error.contains("8 numbers") && error.contains("walk"), "{error}");
        }
    }

    #[test]
    fn columns_are_found_by_name() {
        let plan = drawn("name,y1,x1,y0,x0\na,0,4,0,0\nb,3,4,3,0\n");
        assert_eq!((plan.at(Pt2::new(3.9, 0.01)), plan.at(Pt2::new(3.9, 3.01))), (Cell::Wall, Cell::Wall));
    }

    #[test]
    fn other_units_than_metres_are_put_up_with() {
        let room = "0,0,10,0\n10,0,10,10\n10,10,0,10\n0,10,0,0\n";
        for list in [format!("# one foot\n0.3048\n\n# x0, y0, x1, y1 of walls\n{room}"), format!("x0_ft,y0_ft,x1_ft,y1_ft\n{room}")] {
            assert!(is_one(&list), "{list}");
            let plan = drawn(&list);
            assert_eq!((plan.at(Pt2::new(3.05, 1.0)), plan.at(Pt2::new(10.0, 1.0))), (Cell::Wall, Cell::Unknown), "{list}");
        }
    }

    #[test]
    fn rows_of_no_length_are_left_out_and_lists_of_places_refused() {
        let mut notes = Vec::new();
        let building = read(&format!("{ROOM}2,2,2,2\n"), &mut notes).unwrap();
        assert_eq!(building.levels[0].elements.len(), 4);
        assert!(notes.iter().any(|note| note.contains("1 of 5 rows") && note.contains("line 5")), "{notes:?}");
        let walk: String = (0..10).map(|i| format!("{i},2,{i},2\n")).collect();
        assert!(matches!(read(&walk, &mut notes), Err(PlanFileError::NoLengths { points: 10, rows: 10 })));
        // Milliseconds, easting, northing, height.
        let error = read("1606391913755\t566578.064\t5932830.198\t19.6\n", &mut notes).unwrap_err().to_string();
        assert!(error.contains("line 1") && error.contains("times and places"), "{error}");
    }

    #[test]
    fn broken_rows_are_named_with_their_line() {
        let line = |row: &str| match read(&format!("{ROOM}{row}\n"), &mut Vec::new()) {
            Err(PlanFileError::BadWall { line, .. }) => line,
            other => panic!("{row}: {other:?}"),
        };
        for row in ["1,2,3", "1,2,3,nan", "1,2,3,inf", "a,b,c,d", "1,2,3,4,cupboard", "1,2,3,4,room"] {
            assert_eq!(line(row), 5);
        }
        assert!(read("x0,y0,x1,y1\n", &mut Vec::new()).unwrap().levels[0].elements.is_empty());
        for other in ["", "P5 10 10 255", "t_s,x_m,y_m\n1,2,3", "1,2,3", "hello, world"] {
            assert!(!is_one(other), "{other}");
        }
    }

    #[test]
    fn more_walls_than_any_plan_has_are_refused() {
        let walls = |count: usize| format!("x0,y0,x1,y1\n{}", "0,0,1,0\n".repeat(count));
        assert!(read(&walls(MOST_WALLS), &mut Vec::new()).is_ok());
        let error = read(&walls(MOST_WALLS + 1), &mut Vec::new()).unwrap_err().to_string();
        assert!(error.contains("1000000 walls"), "{error}");
        // A row that does not end is cut, not gathered.
        assert_eq!(cells(&",".repeat(1_000_000)).len(), MOST_COLUMNS);
    }
}
