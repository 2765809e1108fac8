//! What goes into the tables that other programs read? `track.csv`, `filter.csv` and TUM lines.

use std::fmt::Write;

use planwalk_types::{Estimate, PlanPose, Rigid3, Stamp, Status};

/// Columns of `track.csv` and `filter.csv`.
pub const COLUMNS: &str = "t_s,x_m,y_m,yaw_rad,sxx_m2,sxy_m2,syy_m2,syaw_rad2,radius95_m,probability,status";

/// The estimates as CSV with [`COLUMNS`]; times with nine decimals, so that nanoseconds survive.
pub fn estimates_csv(estimates: &[Estimate]) -> String {
    let mut text = String::with_capacity(120 * (estimates.len() + 1));
    text.push_str(COLUMNS);
    text.push('\n');
    for e in estimates {
        let c = &e.covariance;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{:.9},{:.6},{:.6},{:.6},{:.9},{:.9},{:.9},{:.9},{:.4},{:.6},{}",
            e.stamp.as_secs(),
            e.pose.x,
            e.pose.y,
            e.pose.heading_rad,
            c[(0, 0)],
            c[(0, 1)],
            c[(1, 1)],
            c[(2, 2)],
            e.radius95_m,
            e.probability,
            e.status
        );
    }
    text
}

/// Why a table is not what [`estimates_csv`] writes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TableError {
    /// Other columns.
    #[error("the first line is {got:?}, not {COLUMNS}: is this a track.csv or filter.csv of planwalk?")]
    Columns {
        /// How the first line begins.
        got: String,
    },
    /// A value missing, or one that is no number, no time or no status.
    #[error("line {line}: {column} is {value:?}, not {must}")]
    BadValue {
        /// Line, counted from 1.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// What stands there.
        value: String,
        /// What should.
        must: &'static str,
    },
}

/// Reads back what [`estimates_csv`] wrote. Covariances between place and heading are not in the table: they are 0.
///
/// # Errors
/// [`TableError`], with the line.
pub fn estimates_of_csv(text: &str) -> Result<Vec<Estimate>, TableError> {
    let mut lines = (1..).zip(text.lines());
    match lines.next() {
        Some((_, head)) if head.trim() == COLUMNS => (),
        head => return Err(TableError::Columns { got: head.map_or("", |(_, text)| text).chars().take(60).collect() }),
    }
    lines.filter(|(_, row)| !row.trim().is_empty()).map(|(line, row)| estimate(line, row)).collect()
}

fn estimate(line: usize, row: &str) -> Result<Estimate, TableError> {
    let cells: Vec<&str> = row.split(',').map(str::trim).collect();
    let names: Vec<&'static str> = COLUMNS.split(',').collect();
    let cell = |i: usize| cells.get(i).copied().unwrap_or("");
    let bad = |i: usize, must| TableError::BadValue { line, column: names[i], value: cell(i).to_owned(), must };
    let number = |i: usize| cell(i).parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| bad(i, "a finite number"));
    let status = match cell(10) {
        "tracking" => Status::Tracking,
        "ambiguous" => Status::Ambiguous,
        "lost" => Status::Lost,
        _ => return Err(bad(10, "tracking, ambiguous or lost")),
    };
    let (sxx, sxy, syy, syaw) = (number(4)?, number(5)?, number(6)?, number(7)?);
    Ok(Estimate {
        stamp: Stamp::from_secs(number(0)?).ok_or_else(|| bad(0, "a time in seconds"))?,
        pose: PlanPose::new(number(1)?, number(2)?, number(3)?),
        covariance: nalgebra::Matrix3::new(sxx, sxy, 0.0, sxy, syy, 0.0, 0.0, 0.0, syaw),
        radius95_m: number(8)?,
        probability: number(9)?,
        status,
        scale: None,
    })
}

/// A pose on the floor as one in space, at height 0.
pub fn upright<A, B>(pose: &planwalk_types::Rigid2<A, B>) -> Rigid3<A, B> {
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), pose.heading_rad);
    Rigid3::from_parts(nalgebra::Vector3::new(pose.x, pose.y, 0.0), turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{PlanPose, Stamp, Status};

    #[test]
    fn a_row_has_the_columns_of_its_header() {
        let estimate = Estimate {
            stamp: Stamp(1_500_000_001),
            pose: PlanPose::new(1.0, -2.0, 0.5),
            covariance: nalgebra::Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.002),
            radius95_m: 0.61,
            probability: 0.97,
            status: Status::Tracking,
            scale: None,
        };
        let text = estimates_csv(&[estimate]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "t_s,x_m,y_m,yaw_rad,sxx_m2,sxy_m2,syy_m2,syaw_rad2,radius95_m,probability,status");
        assert_eq!(
            lines[1],
            "1.500000001,1.000000,-2.000000,0.500000,0.040000000,0.010000000,0.090000000,0.002000000,0.6100,0.970000,tracking"
        );
    }

    #[test]
    fn a_table_reads_back_as_it_was_written() {
        let of = |i: i64, status: Status| Estimate {
            stamp: Stamp(i * 33_333_333),
            pose: PlanPose::new(1.5, -2.25, 0.5),
            covariance: nalgebra::Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.002),
            radius95_m: 0.61,
            probability: 0.97,
            status,
            scale: None,
        };
        let text = estimates_csv(&[of(0, Status::Lost), of(1, Status::Ambiguous), of(2, Status::Tracking)]);
        let back = estimates_of_csv(&text).unwrap();
        assert_eq!(estimates_csv(&back), text);
        assert_eq!(back[1].stamp, Stamp(33_333_333));
    }

    #[test]
    fn what_is_no_table_of_ours_is_named_with_its_line() {
        assert!(matches!(estimates_of_csv(""), Err(TableError::Columns { .. })));
        assert!(matches!(estimates_of_csv("t,x,y\n0,0,0\n"), Err(TableError::Columns { .. })));
        for (row, column) in [("0,nan,0,0,0,0,0,0,0,0,lost", "x_m"), ("0,0", "status"), ("0,0,0,0,0,0,0,0,0,0,sure", "status")] {
            let why = estimates_of_csv(&format!("{COLUMNS}\n{row}\n")).unwrap_err().to_string();
            assert!(why.contains("line 2") && why.contains(column), "{why}");
        }
    }
}
