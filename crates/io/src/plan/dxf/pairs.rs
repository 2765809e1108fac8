//! Which lines of the file make up one object? Code and value pairs, up to the next pair of code 0.
//!
//! ASCII (two lines a pair) or binary (a number and its value) ─▶ [`Pair`] ─▶ [`Record`]: what is drawn, without what programmes add
//!
//! Pitfall: a file that was cut off, or edited by hand, has a pair that is none. Then its record counts as broken, and reading goes on
//! at the next line that can begin one; binary files have no such place and end there.

use std::borrow::Cow;

/// How binary files begin.
pub(super) const SENTINEL: &[u8; 22] = b"AutoCAD Binary DXF\r\n\x1a\0";
/// Pairs kept of one record; one of more is broken. A polyline of 500,000 vertices or a large hatch has as many.
const PAIRS_LIMIT: usize = 2_000_000;

/// A code, which says what the value is, and the value as text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pair<'a> {
    pub code: i32,
    pub value: Cow<'a, [u8]>,
}

impl Pair<'_> {
    /// Its value as a number, if it is a finite one.
    pub(super) fn number(&self) -> Option<f64> {
        let text = std::str::from_utf8(&self.value).ok()?;
        text.trim().parse().ok().filter(|v: &f64| v.is_finite())
    }

    /// Whether the code says that the value is text; all other codes that records keep are numbers.
    pub(super) fn is_text(&self) -> bool {
        self.code < 10
    }
}

/// One object of the file.
#[derive(Debug)]
pub(super) struct Record<'a> {
    /// `LINE`, `SECTION`, `BLOCK` ...
    pub kind: String,
    /// What it says, in order: texts and finite numbers, without handles and what applications add for themselves.
    pub pairs: Vec<Pair<'a>>,
    /// A pair of it could not be read, a number is not finite, or there are too many.
    pub broken: bool,
}

impl Record<'_> {
    /// The first value of this code.
    pub(super) fn first(&self, code: i32) -> Option<&Pair<'_>> {
        self.pairs.iter().find(|pair| pair.code == code)
    }

    pub(super) fn number(&self, code: i32) -> Option<f64> {
        self.first(code)?.number()
    }

    /// A whole number; of one too large for that, the nearest.
    pub(super) fn whole(&self, code: i32) -> Option<i32> {
        self.number(code).map(|v| v as i32)
    }
}

/// All records of a file, in order.
pub(super) struct Records<'a> {
    source: Source<'a>,
    next_kind: Option<String>,
    /// Whether the file said that it ends here; else it was cut off.
    pub ended: bool,
}

enum Source<'a> {
    Ascii(Lines<'a>),
    Binary(Bytes<'a>),
}

/// A pair that is none.
struct Broken;

impl<'a> Records<'a> {
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        let source = match bytes.strip_prefix(SENTINEL) {
            Some(rest) => Source::Binary(Bytes { rest, two_bytes: rest.starts_with(&[0, 0]) }),
            None => Source::Ascii(Lines { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes) }),
        };
        Self { source, next_kind: None, ended: false }
    }

    fn pair(&mut self) -> Option<Result<Pair<'a>, Broken>> {
        match &mut self.source {
            Source::Ascii(lines) => lines.pair(),
            Source::Binary(bytes) => bytes.pair(),
        }
    }

    /// The kind of the first record: whatever comes before a pair of code 0 is nobody's.
    fn first_kind(&mut self) -> Option<String> {
        loop {
            if let Ok(pair) = self.pair()?
                && pair.code == 0
            {
                return Some(word(&pair.value));
            }
        }
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Record<'a>;

    /// The next record that is there as a whole.
    fn next(&mut self) -> Option<Record<'a>> {
        let kind = match self.next_kind.take() {
            Some(kind) => kind,
            None => self.first_kind()?,
        };
        if kind == "EOF" {
            self.ended = true;
            return None;
        }
        let mut record = Record { kind, pairs: Vec::new(), broken: false };
        let mut filter = Filter::default();
        loop {
            match self.pair()? {
                Ok(pair) if pair.code == 0 => {
                    self.next_kind = Some(word(&pair.value));
                    return Some(record);
                }
                Ok(pair) if filter.keeps(&pair) => {
                    let sound = record.pairs.len() < PAIRS_LIMIT && (pair.is_text() || pair.number().is_some());
                    if sound {
                        record.pairs.push(pair);
                    } else {
                        record.broken = true;
                    }
                }
                Ok(_) => {}
                Err(Broken) => record.broken = true,
            }
        }
    }
}

fn word(value: &[u8]) -> String {
    String::from_utf8_lossy(value.trim_ascii()).to_ascii_uppercase()
}

/// What of a record is the drawing's.
#[derive(Default)]
struct Filter {
    /// Groups `102 {NAME ... 102 }` around this pair, in which applications keep their own.
    groups: usize,
    /// What follows is a second object inside of this one, whose codes mean other things.
    over: bool,
}

impl Filter {
    fn keeps(&mut self, pair: &Pair) -> bool {
        match pair.code {
            101 => self.over = true,
            100 if pair.value.trim_ascii() == b"AcDbXrecord" => self.over = true,
            102 if pair.value.trim_ascii() == b"}" => self.groups = self.groups.saturating_sub(1),
            102 => self.groups += 1,
            _ => {}
        }
        let known = matches!(pair.code, 1..=4 | 6..=79 | 90..=98 | 210 | 220 | 230 | 420);
        known && self.groups == 0 && !self.over
    }
}

/// The lines of a file that is text.
struct Lines<'a> {
    rest: &'a [u8],
}

impl<'a> Lines<'a> {
    fn line(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|b| *b == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn pair(&mut self) -> Option<Result<Pair<'a>, Broken>> {
        let code = self.line()?;
        let code = std::str::from_utf8(code).ok().and_then(|code| code.trim().parse().ok());
        let Some(code) = code else {
            self.find_record();
            return Some(Err(Broken));
        };
        let value = self.line()?;
        Some(Ok(Pair { code, value: Cow::Borrowed(value) }))
    }

    /// Goes on to the next line that can begin a record: a 0 above a word.
    fn find_record(&mut self) {
        loop {
            let before = self.rest;
            let Some(line) = self.line() else { return };
            let mut ahead = Lines { rest: self.rest };
            let begins = || ahead.line().is_some_and(|l| l.trim_ascii().first().is_some_and(u8::is_ascii_uppercase));
            if line.trim_ascii() == b"0" && { begins }() {
                self.rest = before;
                return;
            }
        }
    }
}

/// The pairs of a binary file.
struct Bytes<'a> {
    rest: &'a [u8],
    /// Codes are two bytes since release 13; before, one.
    two_bytes: bool,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn pair(&mut self) -> Option<Result<Pair<'a>, Broken>> {
        let code = self.code()?;
        let value = match code {
            10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => written(f64::from_le_bytes(self.array()?)),
            60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => written(i16::from_le_bytes(self.array()?)),
            90..=99 | 420..=429 | 440..=459 | 1071 => written(i32::from_le_bytes(self.array()?)),
            160..=169 => written(i64::from_le_bytes(self.array()?)),
            290..=299 => written(u8::from_le_bytes(self.array()?)),
            310..=319 | 1004 => {
                let [length] = self.array()?;
                Cow::Borrowed(self.take(usize::from(length))?)
            }
            0..=9 | 100..=109 | 300..=309 | 320..=369 | 390..=399 | 410..=419 | 430..=439 | 470..=481 | 999..=1009 => self.text()?,
            _ => {
                // How long the value of such a code is, nobody knows: there is no going on.
                self.rest = &[];
                return Some(Err(Broken));
            }
        };
        Some(Ok(Pair { code, value }))
    }

    fn code(&mut self) -> Option<i32> {
        if self.two_bytes {
            return self.array().map(|code| i32::from(u16::from_le_bytes(code)));
        }
        match self.array()? {
            [255] => self.array().map(|code| i32::from(u16::from_le_bytes(code))),
            [code] => Some(i32::from(code)),
        }
    }

    /// Up to the next zero.
    fn text(&mut self) -> Option<Cow<'a, [u8]>> {
        let end = self.rest.iter().position(|b| *b == 0)?;
        let text = self.take(end)?;
        self.take(1)?;
        Some(Cow::Borrowed(text))
    }
}

fn written<'a>(number: impl ToString) -> Cow<'a, [u8]> {
    Cow::Owned(number.to_string().into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(bytes: &[u8]) -> (Vec<(String, usize, bool)>, bool) {
        let mut records = Records::of(bytes);
        let kinds = records.by_ref().map(|r| (r.kind, r.pairs.len(), r.broken)).collect();
        (kinds, records.ended)
    }

    #[test]
    fn records_end_where_the_next_begins() {
        let (found, ended) = kinds(b"999\r\nby hand\r\n  0\r\nSECTION\r\n  2\r\nENTITIES\r\n0\nLINE\n10\n1.5\n11\n2\n0\nENDSEC\n0\nEOF\n");
        assert_eq!(found, [("SECTION".into(), 1, false), ("LINE".into(), 2, false), ("ENDSEC".into(), 0, false)]);
        assert!(ended);
    }

    #[test]
    fn what_applications_add_is_left_out_however_deep_it_is_nested() {
        let deep = "102\n{A\n".repeat(100_000) + &"102\n}\n".repeat(100_000);
        let file = format!("0\nLINE\n5\nxyz\n{deep}10\n1\n1001\nACAD\n1002\n{{\n1040\n2.0\n101\nEmbedded Object\n10\n7\n0\nENDSEC\n");
        let mut records = Records::of(file.as_bytes());
        let line = records.next().unwrap();
        assert_eq!((line.pairs.len(), line.number(10), line.broken), (1, Some(1.0), false));
    }

    #[test]
    fn a_broken_pair_costs_its_record_only() {
        let (found, ended) = kinds(b"0\nLINE\n10\n1\noops\n0\n0\nARC\n40\n1\n0\nCIRCLE\n40\n1.#QNAN\n0\nTEXT\n10\n3");
        assert_eq!(found, [("LINE".into(), 1, true), ("ARC".into(), 1, false), ("CIRCLE".into(), 0, true)]);
        assert!(!ended, "the text has no end");
        assert!(kinds(b"").0.is_empty() && kinds(b"0").0.is_empty() && kinds(b"\n\n\n").0.is_empty());
    }

    #[test]
    fn binary_files_have_codes_of_one_or_two_bytes() {
        let one = |code: u8| vec![code];
        let two = |code: u8| vec![code, 0];
        for code in [&one as &dyn Fn(u8) -> Vec<u8>, &two] {
            let mut file = SENTINEL.to_vec();
            let mut add = |c, value: &[u8]| file.extend(code(c).iter().chain(value));
            add(0, b"LINE\0");
            add(10, &(-2.5f64).to_le_bytes());
            add(62, &7i16.to_le_bytes());
            add(0, b"EOF\0");
            let mut records = Records::of(&file);
            let line = records.next().unwrap();
            assert_eq!((line.kind.as_str(), line.number(10), line.whole(62)), ("LINE", Some(-2.5), Some(7)));
            assert!(records.next().is_none() && records.ended);
            let mut cut = Records::of(&file[..file.len() - 6]);
            assert!(cut.next().is_none() && !cut.ended);
        }
    }
}
