//! Which scale do the areas say that are written in rooms? The one by which most outlines around such texts have the area written.
//!
//! texts "12,5 m²" × rings that hold them ─▶ metres in a unit, of each pair ─▶ those that most texts agree on ─▶ median and spread

use super::super::bounds::Bounds;
use super::super::sketch::{Sketch, SketchPoint};
use super::{Witness, median, twice_area};

/// Pairs agree within this share: areas are rounded, and taken to the faces of walls or to their middle.
const AGREE: f64 = 0.02;
/// Fewest texts that agree, and the share of all of them that must.
const FEWEST: usize = 2;
const SHARE: f64 = 0.5;
/// Of rings around a text, this many are tried, from the smallest: a frame around the label, the room, the flat.
const RINGS_TRIED: usize = 4;
/// Most tests of a text against a ring and its corners: some seconds. An office floor has a thousandth of it.
const TESTS_MOST: usize = 1_000_000_000;
/// No spread is smaller: outlines are drawn to a finger's breadth.
const LEAST_SIGMA: f64 = 0.001;
/// From a median deviation to a standard one, of a normal distribution.
const SIGMA_PER_MAD: f64 = 1.4826;

/// Units of area, as they begin after the number, in square metres; longer ones first where one begins like another.
const UNITS: [(&str, f64); 13] = [
    ("m2", 1.0),
    ("m²", 1.0),
    ("m^2", 1.0),
    ("m 2", 1.0),
    ("sqm", 1.0),
    ("sq m", 1.0),
    ("sq.m", 1.0),
    ("qm", 1.0),
    ("kvm", 1.0),
    ("sqft", 0.092_903_04),
    ("sq ft", 0.092_903_04),
    ("sq. ft", 0.092_903_04),
    ("ft²", 0.092_903_04),
];

pub(super) fn witness(sketch: &Sketch) -> Option<Witness> {
    let written: Vec<(SketchPoint, f64)> =
        sketch.texts.iter().filter_map(|text| Some((inside(text.at, text.height), area_m2(&text.text)?))).collect();
    let rings: Vec<Ring<'_>> =
        sketch.hidden.iter().chain(&sketch.paths).filter(|path| path.closed).filter_map(|path| Ring::of(&path.points)).collect();
    let corners: usize = rings.iter().map(|ring| 1 + ring.points.len()).sum();
    if written.len() < FEWEST || written.len().saturating_mul(corners) > TESTS_MOST {
        return None;
    }
    // Of each text, what each ring around it says, as a logarithm.
    let said: Vec<Vec<f64>> = written
        .iter()
        .map(|(at, area_m2)| {
            let mut around: Vec<f64> = rings.iter().filter(|ring| ring.holds(*at)).map(|ring| ring.area).collect();
            around.sort_by(f64::total_cmp);
            around.dedup();
            around.iter().take(RINGS_TRIED).map(|area| 0.5 * (area_m2 / area).ln()).collect()
        })
        .collect();
    let asked = said.iter().filter(|of_text| !of_text.is_empty()).count();
    let agreeing = most_agree(&said)?;
    if agreeing.len() < FEWEST || (agreeing.len() as f64) < SHARE * asked as f64 {
        return None;
    }
    let middle = median(&mut agreeing.clone())?;
    let spread = SIGMA_PER_MAD * median(&mut agreeing.iter().map(|v| (v - middle).abs()).collect::<Vec<_>>())?;
    Some(Witness {
        metres: middle.exp(),
        sigma: (spread / (agreeing.len() as f64).sqrt()).max(LEAST_SIGMA),
        from: "areas written in rooms",
        says: format!("areas written in {} of {asked} outlines say", agreeing.len()),
        remark: "",
    })
}

/// A little up and to the right of a text's beginning: on the first letter.
fn inside(at: SketchPoint, height: f64) -> SketchPoint {
    at.map(|v| v + 0.3 * height)
}

/// One value of each text that has one near to the value that most texts are near to.
fn most_agree(said: &[Vec<f64>]) -> Option<Vec<f64>> {
    let mut all: Vec<(f64, usize)> = said.iter().enumerate().flat_map(|(i, of_text)| of_text.iter().map(move |v| (*v, i))).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // A window that slides over the sorted values, and counts how many texts are in it.
    let (mut counts, mut texts, mut first) = (vec![0usize; said.len()], 0, 0);
    let mut best: Option<(usize, std::ops::RangeInclusive<usize>)> = None;
    for last in 0..all.len() {
        texts += usize::from(counts[all[last].1] == 0);
        counts[all[last].1] += 1;
        while all[last].0 - all[first].0 > 2.0 * AGREE {
            counts[all[first].1] -= 1;
            texts -= usize::from(counts[all[first].1] == 0);
            first += 1;
        }
        if best.as_ref().is_none_or(|(most, _)| texts > *most) {
            best = Some((texts, first..=last));
        }
    }
    let (_, window) = best?;
    let mut seen = vec![false; said.len()];
    let mut values = Vec::new();
    for (value, text) in &all[window] {
        if !std::mem::replace(&mut seen[*text], true) {
            values.push(*value);
        }
    }
    Some(values)
}

/// A ring, and its box.
struct Ring<'a> {
    points: &'a [SketchPoint],
    bounds: Bounds,
    area: f64,
}

impl<'a> Ring<'a> {
    fn of(points: &'a [SketchPoint]) -> Option<Self> {
        let area = 0.5 * twice_area(points).abs();
        let bounds = Bounds::of(points)?;
        (points.len() > 2 && area > 0.0 && area.is_finite()).then_some(Self { points, bounds, area })
    }

    /// Even-odd rule.
    fn holds(&self, at: SketchPoint) -> bool {
        if !self.bounds.holds(at) {
            return false;
        }
        let ends = self.points.iter().zip(self.points.iter().cycle().skip(1));
        let crossings =
            ends.filter(|(a, b)| (a[1] > at[1]) != (b[1] > at[1]) && at[0] < a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
        crossings.count() % 2 == 1
    }
}

/// The first area that a text says, square metres: 65.948 of "A: 65.948 m2".
pub(in crate::plan) fn area_m2(text: &str) -> Option<f64> {
    let text = text.to_lowercase();
    let mut rest = text.as_str();
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let tail = &rest[start..];
        let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',');
        let end = tail.find(|c: char| !is_part(c)).unwrap_or(tail.len());
        let (digits, after) = tail.split_at(end);
        let unit = after.trim_start();
        let factor = UNITS
            .iter()
            .find(|(unit_text, _)| unit.strip_prefix(unit_text).is_some_and(|left| !left.starts_with(|c: char| c.is_alphanumeric())));
        if let Some((_, factor)) = factor {
            return number(digits).map(|v| v * factor).filter(|v| *v > 0.0);
        }
        rest = after;
    }
    None
}

/// With a point or a comma before the decimals; where both are there, the last one is before them.
fn number(digits: &str) -> Option<f64> {
    let (whole, decimals) = digits.rsplit_once(['.', ',']).unwrap_or((digits, ""));
    let whole: String = whole.chars().filter(char::is_ascii_digit).collect();
    format!("{whole}.{decimals}0").parse().ok().filter(|v: &f64| v.is_finite())
}
