//! Which format is this? Told by the first lines with data.

use super::{PosesError, PosesFormat, table};
use crate::text;

/// Lines looked at: a robot's log may begin with parameters, a table with a title.
const LOOKED_AT: usize = 50;

pub(super) fn format_of(text: &str) -> Result<PosesFormat, PosesError> {
    let first_word = |(_, line): (usize, &str)| matches!(line.split_whitespace().next(), Some("ODOM" | "FLASER" | "PARAM" | "SYNC"));
    if text::data_lines(text).take(LOOKED_AT).any(first_word) {
        return Ok(PosesFormat::Carmen);
    }
    if table::find_header(text).is_some() {
        return Ok(PosesFormat::Csv);
    }
    let (line, first) = text::data_lines(text).next().ok_or(PosesError::Empty)?;
    let cells: Vec<&str> = first.split(|c: char| c == ',' || c.is_whitespace()).filter(|c| !c.is_empty()).collect();
    let all_numbers = cells.iter().all(|c| c.parse::<f64>().is_ok());
    let nanoseconds = cells.first().is_some_and(|c| c.len() >= 16 && c.bytes().all(|b| b.is_ascii_digit()));
    match cells.len() {
        n if n >= 8 && first.contains(',') && all_numbers && nanoseconds => Ok(PosesFormat::Euroc),
        12 | 13 if all_numbers && !first.contains(',') => Ok(PosesFormat::Kitti),
        n if n >= 8 && all_numbers && !first.contains(',') => Ok(PosesFormat::Tum),
        _ => Err(PosesError::UnknownFormat { line, text: first.chars().take(60).collect() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_their_first_lines() {
        let of = |text: &str| format_of(text).unwrap();
        assert_eq!(of("# t x y z\n1.0 0 0 0 0 0 0 1\n"), PosesFormat::Tum);
        assert_eq!(of("1.0\t0 0 0 0 0 0 1 9 9 9 9 9 9"), PosesFormat::Tum);
        assert_eq!(of("1 0 0 0 0 1 0 0 0 0 1 0"), PosesFormat::Kitti);
        assert_eq!(of("4 1 0 0 0 0 1 0 0 0 0 1 0"), PosesFormat::Kitti);
        assert_eq!(of("#timestamp, p_RS_R_x [m]\n1403636580838555648,4.6,-1.7,0.8,0.5,-0.1,-0.8,-0.1,-0.0"), PosesFormat::Euroc);
        assert_eq!(of("# x\nPARAM a 1\nODOM 0 0 0 0 0 0 1.5 host 0.1"), PosesFormat::Carmen);
        assert_eq!(of("t_s,x_m,y_m,yaw_rad\n0,0,0,0"), PosesFormat::Csv);
        assert_eq!(of("the ground truth of a walk\ntime,x,y\n0,0,0"), PosesFormat::Csv);
    }

    #[test]
    fn what_is_none_of_them_is_shown() {
        assert!(matches!(format_of("hello world"), Err(PosesError::UnknownFormat { line: 1, .. })));
        assert!(matches!(format_of("# only\n\n# comments\n"), Err(PosesError::Empty)));
        assert!(matches!(format_of(""), Err(PosesError::Empty)));
        assert!(matches!(format_of("1,2,3\n"), Err(PosesError::UnknownFormat { .. })));
        assert!(matches!(format_of(","), Err(PosesError::UnknownFormat { .. })));
    }
}
