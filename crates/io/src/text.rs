//! What do text files share? Decompression by content, numbered lines, and stamps that keep their nanoseconds.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use planwalk_types::Stamp;

/// Longest text taken, bytes: a day of 1 kHz poses. A bomb of zeros ends here instead of in memory.
const TEXT_LIMIT: u64 = 1 << 30;

/// The text of a file; gzip and bzip2 are unpacked, told by their first bytes and not by the name.
pub(crate) fn read(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut head = Vec::with_capacity(3);
    file.by_ref().take(3).read_to_end(&mut head)?;
    let whole = io::Cursor::new(head.clone()).chain(file);
    let mut bytes = Vec::new();
    let read = match head.as_slice() {
        [0x1f, 0x8b, ..] => flate2::read::MultiGzDecoder::new(whole).take(TEXT_LIMIT + 1).read_to_end(&mut bytes),
        b"BZh" => bzip2::read::MultiBzDecoder::new(whole).take(TEXT_LIMIT + 1).read_to_end(&mut bytes),
        _ => { whole }.take(TEXT_LIMIT + 1).read_to_end(&mut bytes),
    }?;
    if read as u64 > TEXT_LIMIT {
        let message = format!("the text is over {} MB when unpacked: is this the right file?", TEXT_LIMIT >> 20);
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    // Lossy: a degree sign in another encoding, in a comment, is no reason to refuse the numbers.
    let text = String::from_utf8_lossy(&bytes);
    Ok(text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned())
}

/// Line numbers (from 1) and trimmed text of the lines that are neither blank nor `#` comments.
pub(crate) fn data_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    (1..).zip(text.lines().map(str::trim)).filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// The beginning of a text that is shown in a message.
pub(crate) fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Seconds as a stamp, exact to the nanosecond where the text is a plain decimal (f64 holds unix time to 240 ns only).
pub(crate) fn seconds(token: &str) -> Option<Stamp> {
    exact_seconds(token).or_else(|| token.parse().ok().and_then(Stamp::from_secs))
}

fn exact_seconds(token: &str) -> Option<Stamp> {
    let (sign, digits) = token.strip_prefix('-').map_or((1, token), |rest| (-1, rest));
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let plain = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if !plain(whole) || !plain(fraction) || (whole.is_empty() && fraction.is_empty()) {
        return None;
    }
    let whole: i64 = if whole.is_empty() { 0 } else { whole.parse().ok()? };
    let digit = |i: usize| fraction.as_bytes().get(i).map_or(0, |b| i64::from(b - b'0'));
    let nanos = (0..9).fold(0, |sum, i| 10 * sum + digit(i)) + i64::from(digit(9) >= 5);
    Some(Stamp(sign * whole.checked_mul(1_000_000_000)?.checked_add(nanos)?))
}

/// A stamp as decimal seconds with nine decimals, exactly.
pub(crate) fn decimal_seconds(stamp: Stamp) -> String {
    let sign = if stamp.0 < 0 { "-" } else { "" };
    let nanos = stamp.0.unsigned_abs();
    format!("{sign}{}.{:09}", nanos / 1_000_000_000, nanos % 1_000_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Write;

    proptest! {
        #[test]
        fn a_stamp_survives_the_trip_through_text(ns in any::<i64>()) {
            // i64::MIN has no positive twin; no clock is there.
            let stamp = Stamp(ns.max(-i64::MAX));
            prop_assert_eq!(seconds(&decimal_seconds(stamp)), Some(stamp));
        }
    }

    #[test]
    fn unix_time_keeps_its_nanoseconds() {
        assert_eq!(seconds("1520531829.301144123"), Some(Stamp(1_520_531_829_301_144_123)));
        assert_eq!(seconds("-0.5"), Some(Stamp(-500_000_000)));
        assert_eq!(seconds("1.037359e-01"), Some(Stamp(103_735_900)));
        assert_eq!(seconds("0.0000000006"), Some(Stamp(1)));
    }

    #[test]
    fn what_is_no_time_is_none() {
        for token in ["", ".", "-", "nan", "inf", "1e30", "99999999999999999999", "1.5.2", "t"] {
            assert_eq!(seconds(token), None, "{token}");
        }
    }

    #[test]
    fn packed_text_is_unpacked_whatever_its_name() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("poses.txt");
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(b"0 1 2\n").unwrap();
        std::fs::write(&path, gz.finish().unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), "0 1 2\n");
        let mut bz = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        bz.write_all(b"3 4 5\n").unwrap();
        std::fs::write(&path, bz.finish().unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), "3 4 5\n");
        std::fs::write(&path, [0x1f, 0x8b, 8]).unwrap();
        assert!(read(&path).is_err(), "a cut-off gzip is an error");
    }
}
