//! How is text drawn where no font can be relied on? With strokes of our own, so that a picture is the same on every machine.
//!
//! Letters are drawn in units with the baseline at 0, capitals 14 high, small letters 10, tails down to −4; y up.
//! A stroke is a polyline, or with `~` an open and with `o` a closed quadratic B-spline over its points.

use super::svg::number;

/// Height of a capital, in font units.
const CAPITAL: f64 = 14.0;
/// Space between letters, font units.
const GAP: f64 = 3.4;
/// Width of a blank, font units (without the gaps at its sides).
const BLANK: f64 = 3.0;

/// Every letter that can be drawn: (letter, width, strokes).
const GLYPHS: &[(char, f64, &str)] = &[
    ('0', 8.0, "o0,0 8,0 8,14 0,14"),
    ('1', 6.0, "1,11 4,14 4,0"),
    ('2', 8.0, "~0.3,11 1,14.3 8,14.5 8,9 4,5 0,0;0,0 8,0"),
    ('3', 8.0, "~0.5,12 1.5,14.3 7.8,14.5 7.8,7.8 3,7.5;~3,7.5 8.5,7.5 8.5,-0.4 1.5,-0.4 0,2.5"),
    ('4', 8.5, "6,0 6,14 0,4 8.5,4"),
    ('5', 8.0, "7.5,14 1.5,14 1,8;~1,8 3,9.5 8.5,9.5 8.5,-0.4 1.5,-0.4 0,2.2"),
    ('6', 8.0, "~7,13 3,15 0,9 0,4.5;o0,0 8,0 8,9 0,9"),
    ('7', 8.0, "0,14 8,14 3,0"),
    ('8', 8.0, "o0.7,7.5 7.3,7.5 7.3,14 0.7,14;o0,0 8,0 8,7.5 0,7.5"),
    ('9', 8.0, "o0,5 8,5 8,14 0,14;~8,9.5 8,5 5,-1 1,1"),
    ('A', 10.0, "0,0 5,14 10,0;1.8,5 8.2,5"),
    ('B', 9.0, "0,0 0,14;~0,14 4,14 8,14 8,7.5 4,7.5 0,7.5;~0,7.5 5,7.5 9,7.5 9,0 5,0 0,0"),
    ('C', 10.0, "~10,11.5 9,14.3 0,14.5 0,-0.5 9,-0.3 10,2.5"),
    ('D', 10.0, "0,0 0,14;~0,14 4,14 10,14 10,0 4,0 0,0"),
    ('E', 8.0, "8,14 0,14 0,0 8,0;0,7.5 6.5,7.5"),
    ('F', 8.0, "8,14 0,14 0,0;0,7.5 6.5,7.5"),
    ('G', 10.0, "~10,11.5 9,14.3 0,14.5 0,-0.5 9,-0.5 10,3 10,6.5;10,6.5 6,6.5"),
    ('H', 9.0, "0,0 0,14;9,0 9,14;0,7.5 9,7.5"),
    ('I', 1.0, "0.5,0 0.5,14"),
    ('J', 6.0, "~6,14 6,3 5.5,-0.5 0.5,-0.5 0,3"),
    ('K', 9.0, "0,0 0,14;8.5,14 0,6;3,8.7 9,0"),
    ('L', 7.5, "0,14 0,0 7.5,0"),
    ('M', 11.0, "0,0 0,14 5.5,4 11,14 11,0"),
    ('N', 9.0, "0,0 0,14 9,0 9,14"),
    ('O', 10.0, "o0,0 10,0 10,14 0,14"),
    ('P', 9.0, "0,0 0,14;~0,14 5,14 9,14 9,6.5 5,6.5 0,6.5"),
    ('Q', 10.0, "o0,0 10,0 10,14 0,14;6,4 10,-1"),
    ('R', 9.0, "0,0 0,14;~0,14 5,14 9,14 9,6.5 5,6.5 0,6.5;5,6.5 9,0"),
    ('S', 9.0, "~8.5,11.5 7.5,14.5 0.5,14.5 0,7.5 9,7 9,-0.5 1,-0.5 0,2.5"),
    ('T', 10.0, "0,14 10,14;5,14 5,0"),
    ('U', 9.0, "~0,14 0,4 0.5,-0.5 8.5,-0.5 9,4 9,14"),
    ('V', 10.0, "0,14 5,0 10,14"),
    ('W', 13.0, "0,14 3.5,0 6.5,12 9.5,0 13,14"),
    ('X', 9.0, "0,0 9,14;0,14 9,0"),
    ('Y', 10.0, "0,14 5,7 10,14;5,7 5,0"),
    ('Z', 9.0, "0,14 9,14 0,0 9,0"),
    ('a', 7.0, "o0,0 7,0 7,10 0,10;7,10 7,0"),
    ('b', 7.0, "0,14 0,0;o0,0 7,0 7,10 0,10"),
    ('c', 7.0, "~7,8.3 6,10.3 0,10.5 0,-0.5 6,-0.3 7,1.7"),
    ('d', 7.0, "7,14 7,0;o0,0 7,0 7,10 0,10"),
    ('e', 7.0, "0,5.3 7,5.3;~7,5.3 7,10 0,10.5 0,-0.5 5.5,-0.3 6.8,1.8"),
    ('f', 5.0, "~5,13.7 2,14.8 2,10 2,0;0,9.5 4.6,9.5"),
    ('g', 7.0, "o0,0 7,0 7,10 0,10;~7,10 7,0 7,-4.5 1.5,-4.5 0.5,-2.5"),
    ('h', 7.0, "0,14 0,0;~0,5 0,10.3 7,10.8 7,5 7,0"),
    ('i', 1.0, "0.5,10 0.5,0;0.5,13.4 0.5,13.8"),
    ('j', 3.0, "~2.5,10 2.5,-2 2.5,-4.5 0,-4;2.5,13.4 2.5,13.8"),
    ('k', 7.0, "0,14 0,0;6.3,10 0,4;2.4,6.3 7,0"),
    ('l', 1.0, "0.5,14 0.5,0"),
    ('m', 11.0, "0,10 0,0;~0,6 0,10.5 5.5,10.8 5.5,5 5.5,0;~5.5,6 5.5,10.5 11,10.8 11,5 11,0"),
    ('n', 7.0, "0,10 0,0;~0,6 0,10.5 7,10.8 7,5 7,0"),
    ('o', 7.0, "o0,0 7,0 7,10 0,10"),
    ('p', 7.0, "0,10 0,-4;o0,0 7,0 7,10 0,10"),
    ('q', 7.0, "7,10 7,-4;o0,0 7,0 7,10 0,10"),
    ('r', 5.0, "0,10 0,0;~0,6 0.5,10.3 3,10.3 5,9.7"),
    ('s', 6.5, "~6,8.3 5.5,10.4 0.5,10.4 0,5.3 6.5,5 6.5,-0.4 0.8,-0.4 0,1.8"),
    ('t', 5.0, "2,13 2,3;~2,3 2,-0.3 5,0.2;0,9.8 4.6,9.8"),
    ('u', 7.0, "~0,10 0,3 0,-0.8 7,-0.5 7,4;7,10 7,0"),
    ('v', 7.0, "0,10 3.5,0 7,10"),
    ('w', 10.0, "0,10 2.5,0 5,9 7.5,0 10,10"),
    ('x', 7.0, "0,0 7,10;0,10 7,0"),
    ('y', 7.0, "0,10 3.6,0.4;7,10 3.2,-1;~3.2,-1 2,-4.3 0,-4"),
    ('z', 7.0, "0,10 7,10 0,0 7,0"),
    ('.', 1.0, "0.5,0 0.5,0.4"),
    (',', 1.5, "1,0.6 0,-2.4"),
    (':', 1.0, "0.5,0 0.5,0.4;0.5,8 0.5,8.4"),
    (';', 1.5, "1,0.6 0,-2.4;1,8 1,8.4"),
    ('-', 5.0, "0,5.5 5,5.5"),
    ('–', 7.0, "0,5.5 7,5.5"),
    ('—', 12.0, "0,5.5 12,5.5"),
    ('−', 8.0, "0,5.5 8,5.5"),
    ('+', 8.0, "0,5.5 8,5.5;4,1.5 4,9.5"),
    ('±', 8.0, "0,7.5 8,7.5;4,3.5 4,11.5;0,0.5 8,0.5"),
    ('×', 7.0, "0.5,2.5 6.5,8.5;0.5,8.5 6.5,2.5"),
    ('%', 11.0, "0.5,0 10.5,14;o0,7.5 4.5,7.5 4.5,14 0,14;o6.5,0 11,0 11,6.5 6.5,6.5"),
    ('(', 3.5, "~3.5,15 0,12 0,0 3.5,-3"),
    (')', 3.5, "~0,15 3.5,12 3.5,0 0,-3"),
    ('[', 3.0, "3,15 0,15 0,-3 3,-3"),
    (']', 3.0, "0,15 3,15 3,-3 0,-3"),
    ('/', 6.0, "0,-1 6,15"),
    ('=', 8.0, "0,7.5 8,7.5;0,3.5 8,3.5"),
    ('°', 4.0, "o0,9.8 4,9.8 4,14 0,14"),
    ('²', 4.5, "~0,12.8 0.5,14.6 4.3,14.6 4.3,11 0,8;0,8 4.5,8"),
    ('\'', 1.0, "0.5,14 0.5,11"),
    ('"', 4.0, "0.5,14 0.5,11;3.5,14 3.5,11"),
    ('!', 1.0, "0.5,14 0.5,4;0.5,0 0.5,0.4"),
    ('?', 7.0, "~0,11.5 0.5,14.5 7,14.5 7,9 3.5,8 3.5,3.8;3.5,0 3.5,0.4"),
    ('_', 8.0, "0,-2 8,-2"),
    ('<', 7.0, "7,10 0,5.5 7,1"),
    ('>', 7.0, "0,10 7,5.5 0,1"),
    ('#', 9.0, "2,0 4,14;5.5,0 7.5,14;0,4.5 8.5,4.5;0.5,9.5 9,9.5"),
    ('&', 10.0, "~10,6 8,0 0,-1 0,5 7,9 6.5,14.3 1.5,14.3 1.5,9 10,0"),
    ('~', 8.0, "~0,4.5 2,8 6,3 8,6.5"),
    ('·', 1.0, "0.5,5.3 0.5,5.7"),
    ('…', 9.0, "0.5,0 0.5,0.4;4.5,0 4.5,0.4;8.5,0 8.5,0.4"),
    ('ä', 7.0, "o0,0 7,0 7,10 0,10;7,10 7,0;2.0,13.4 2.0,13.8;5.0,13.4 5.0,13.8"),
    ('ö', 7.0, "o0,0 7,0 7,10 0,10;2.0,13.4 2.0,13.8;5.0,13.4 5.0,13.8"),
    ('ü', 7.0, "~0,10 0,3 0,-0.8 7,-0.5 7,4;7,10 7,0;2.0,13.4 2.0,13.8;5.0,13.4 5.0,13.8"),
    ('Ä', 10.0, "0,0 5,14 10,0;1.8,5 8.2,5;2.8,15.1 2.8,15.5;7.2,15.1 7.2,15.5"),
    ('Ö', 10.0, "o0,0 10,0 10,14 0,14;2.8,15.1 2.8,15.5;7.2,15.1 7.2,15.5"),
    ('Ü', 9.0, "~0,14 0,4 0.5,-0.5 8.5,-0.5 9,4 9,14;2.5,15.1 2.5,15.5;6.5,15.1 6.5,15.5"),
    ('é', 7.0, "0,5.3 7,5.3;~7,5.3 7,10 0,10.5 0,-0.5 5.5,-0.3 6.8,1.8;3,12.4 5,14.6"),
    ('ß', 7.0, "0,0 0,10;~0,9 0,14.3 6,14.3 6,8.5 2.5,8;~2.5,8 7.5,8 7.5,-0.4 2,0"),
    ('→', 11.0, "0,5.5 11,5.5;7,9 11,5.5 7,2"),
    ('≤', 7.0, "7,11 0,7 7,3;0,0 7,0"),
    ('≥', 7.0, "0,11 7,7 0,3;0,0 7,0"),
];

/// What stands for a letter that cannot be drawn.
const MISSING: (f64, &str) = (7.0, "0,0 7,0 7,14 0,14 0,0");

/// Width and strokes of one letter.
fn glyph(letter: char) -> (f64, &'static str) {
    if letter.is_whitespace() {
        return (BLANK, "");
    }
    GLYPHS.iter().find(|g| g.0 == letter).map_or(MISSING, |g| (g.1, g.2))
}

/// Width of `text` whose capitals are `size_px` high.
pub(super) fn width_px(text: &str, size_px: f64) -> f64 {
    let units: f64 = text.chars().map(|c| glyph(c).0 + GAP).sum();
    (units - GAP).max(0.0) * size_px / CAPITAL
}

/// SVG path data of `text`, capitals `size_px` high, that begins at (`x`, `y`) on the baseline (y down).
pub(super) fn path_data(text: &str, x: f64, y: f64, size_px: f64) -> String {
    let scale = size_px / CAPITAL;
    let mut data = String::new();
    let mut pen = 0.0;
    for letter in text.chars() {
        let (width, strokes) = glyph(letter);
        let place = |(px, py): (f64, f64)| (x + (pen + px) * scale, y - py * scale);
        for stroke in strokes.split(';').filter(|s| !s.is_empty()) {
            draw_stroke(&mut data, stroke, &place);
        }
        pen += width + GAP;
    }
    data
}

fn draw_stroke(data: &mut String, stroke: &str, place: &dyn Fn((f64, f64)) -> (f64, f64)) {
    let list = stroke.trim_start_matches(['~', 'o']);
    let points: Vec<(f64, f64)> = list.split(' ').filter_map(point).map(place).collect();
    match stroke.chars().next() {
        Some('~') => open_spline(data, &points),
        Some('o') => closed_spline(data, &points),
        _ => polyline(data, &points),
    }
}

fn point(text: &str) -> Option<(f64, f64)> {
    let (x, y) = text.split_once(',')?;
    Some((x.parse().ok()?, y.parse().ok()?))
}

fn push(data: &mut String, command: char, points: &[(f64, f64)]) {
    data.push(command);
    for (i, (x, y)) in points.iter().enumerate() {
        if i > 0 {
            data.push(' ');
        }
        data.push_str(&number(*x));
        data.push(' ');
        data.push_str(&number(*y));
    }
}

fn polyline(data: &mut String, points: &[(f64, f64)]) {
    for (i, p) in points.iter().enumerate() {
        push(data, if i == 0 { 'M' } else { 'L' }, &[*p]);
    }
}

fn middle(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1))
}

/// From the first to the last point; those between pull.
fn open_spline(data: &mut String, points: &[(f64, f64)]) {
    let [first, pulls @ .., last] = points else { return };
    push(data, 'M', &[*first]);
    for (i, pull) in pulls.iter().enumerate() {
        let to = pulls.get(i + 1).map_or(*last, |next| middle(*pull, *next));
        push(data, 'Q', &[*pull, to]);
    }
}

/// Round the middles of the polygon's sides.
fn closed_spline(data: &mut String, points: &[(f64, f64)]) {
    let [first, .., last] = points else { return };
    push(data, 'M', &[middle(*last, *first)]);
    for (i, pull) in points.iter().enumerate() {
        push(data, 'Q', &[*pull, middle(*pull, points[(i + 1) % points.len()])]);
    }
    data.push('Z');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_is_drawn_inside_its_box() {
        for (letter, width, strokes) in GLYPHS {
            for stroke in strokes.split(';') {
                let points: Vec<_> = stroke.trim_start_matches(['~', 'o']).split(' ').map(|p| point(p).unwrap()).collect();
                assert!(points.len() >= 2, "{letter} has a stroke of one point");
                // Control points may stand out by half a unit: the curve does not reach them.
                let held = points.iter().all(|(x, y)| (-0.6..=width + 0.6).contains(x) && (-4.6..=15.6).contains(y));
                assert!(held, "{letter}: {stroke}");
            }
        }
    }

    #[test]
    fn all_that_is_printed_can_be_drawn() {
        let printed = (' '..='~').filter(|c| !"$*@\\^`{|}".contains(*c)).chain("–—−±×°²·…→≤≥".chars());
        for letter in printed {
            assert!(letter == ' ' || GLYPHS.iter().any(|g| g.0 == letter), "{letter:?} has no glyph");
        }
    }

    #[test]
    fn longer_text_is_wider_and_empty_text_has_no_width() {
        assert_eq!(width_px("", 10.0), 0.0);
        assert!(width_px("ab", 10.0) > width_px("a", 10.0));
        assert_eq!(width_px("ab", 20.0), 2.0 * width_px("ab", 10.0));
    }
}
