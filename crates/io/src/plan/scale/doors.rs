//! Which scale do the doors say? Leaves are 0.6 m to 1.2 m wide, most of them 0.8 m or 0.9 m.
//!
//! arcs ─▶ those in which a leaf swings ─▶ a few widths in units ─▶ for each scale, how usual all widths are by it ─▶ mean and spread
//!
//! One width alone says little (it may be 0.8 m or 0.9 m: ± 13 %); two or three in the right ratio say more.

use std::f64::consts::TAU;

use super::super::interpret::Piece;
use super::super::interpret::nearby::Nearby;
use super::super::interpret::swings::Swing;
use super::super::sketch::Sketch;
use super::{Witness, extent, median};

/// Widths of leaves, metres, and how usual each is: those of standards (DIN 18101, NS 3140, ANSI A250), all that there are.
const USUAL_M: [(f64, f64); 8] = [(0.6, 0.04), (0.7, 0.12), (0.76, 0.06), (0.8, 0.24), (0.9, 0.36), (1.0, 0.12), (1.1, 0.03), (1.2, 0.03)];
/// Drawn widths are off by this share: leaves are narrower than their openings, and some are drawn to their frames.
const OFF: f64 = 0.03;
/// A width may be none of these: as a share, and how such ones are spread about 0.85 m, as a share of it.
const UNUSUAL: f64 = 0.1;
const UNUSUAL_M: f64 = 0.85;
const UNUSUAL_SPREAD: f64 = 0.35;
/// Doors differ by more than this in width, or are of one width.
const SAME_WIDTH: f64 = 0.015;
/// A width counts if so many doors, and this share of all, have it.
const DOORS_OF_WIDTH: usize = 2;
const SHARE_OF_WIDTH: f64 = 0.08;
/// Doors there must be, with a leaf drawn or without.
const WITH_LEAF: usize = 3;
const WITHOUT_LEAF: usize = 6;
/// A drawing is so many door widths across.
const ACROSS: std::ops::RangeInclusive<f64> = 4.0..=1000.0;
/// A leaf ends this near to where its arc does, as a share of its width.
const LEAF_OFF: f64 = 0.12;
/// Scales are tried in steps of this share.
const STEP: f64 = 0.0025;

pub(super) fn witness(sketch: &Sketch) -> Option<Witness> {
    let size = extent(sketch).into_iter().fold(0.0, f64::max);
    let is_door = |swing: &Swing| ACROSS.contains(&(size / swing.radius));
    let swings: Vec<Swing> = sketch.paths.iter().filter_map(|path| Swing::of_any_size(path, &path.points)).filter(is_door).collect();
    if swings.len() < WITH_LEAF {
        return None;
    }
    let leaved = with_leaf(&swings, sketch);
    let radii = |chosen: &[usize]| -> Vec<f64> { chosen.iter().map(|i| swings[*i].radius).collect() };
    let (mut radii, how) = match leaved.len() {
        WITH_LEAF.. => (radii(&leaved), "door leaves"),
        _ if swings.len() >= WITHOUT_LEAF => (swings.iter().map(|swing| swing.radius).collect(), "arcs like those of doors"),
        _ => return None,
    };
    let widths = widths(&mut radii);
    let (metres, sigma) = usual_scale(&widths)?;
    let told: Vec<String> = widths.iter().map(|width| format!("{:.2} m", width * metres)).collect();
    Some(Witness {
        metres,
        sigma,
        from: "widths of doors",
        says: format!("{} {how}, most of them {} wide by it, say", radii.len(), told.join(", ")),
        remark: "; doors alone are no good measure: give --measure, or --drawing-scale of a drawing on paper",
    })
}

/// Those arcs of which a straight line goes from the hinge to an end.
fn with_leaf(swings: &[Swing], sketch: &Sketch) -> Vec<usize> {
    // As if the typical door were a metre wide, for the grid in which pieces are looked up.
    let Some(typical) = median(&mut swings.iter().map(|swing| swing.radius).collect::<Vec<_>>()) else { return Vec::new() };
    let scaled = |at: [f64; 2]| at.map(|v| v / typical);
    let mut longest = 0.0_f64;
    swings.iter().for_each(|swing| longest = longest.max(swing.radius / typical));
    let straight = sketch.paths.iter().filter(|path| !path.curved);
    let pieces: Vec<Piece> = straight
        .flat_map(|path| {
            let ends = path.points.iter().zip(path.points.iter().skip(1).chain(path.points.first().filter(|_| path.closed)));
            ends.map(|(from, to)| Piece { from: scaled(*from), to: scaled(*to) })
        })
        .filter(|piece| piece.length() < 2.0 * longest)
        .collect();
    let nearby = Nearby::of(pieces.iter().enumerate());
    let is_near = |a: [f64; 2], b: [f64; 2], within: f64| (a[0] - b[0]).hypot(a[1] - b[1]) <= within;
    let has_leaf = |swing: &Swing| {
        let (hinge, within) = (scaled(swing.hinge), LEAF_OFF * swing.radius / typical);
        nearby.to_point(hinge).into_iter().filter_map(|i| pieces.get(i)).any(|piece| {
            let [from, to] = [piece.from, piece.to].map(|at| is_near(at, hinge, within));
            let other = if from { piece.to } else { piece.from };
            (from || to) && swing.ends.iter().any(|end| is_near(other, scaled(*end), within))
        })
    };
    (0..swings.len()).filter(|i| has_leaf(&swings[*i])).collect()
}

/// The widths that several doors have, units.
fn widths(radii: &mut [f64]) -> Vec<f64> {
    radii.sort_by(f64::total_cmp);
    let least = DOORS_OF_WIDTH.max((SHARE_OF_WIDTH * radii.len() as f64).ceil() as usize);
    let alike = radii.chunk_by(|a, b| b / a < 1.0 + SAME_WIDTH).filter(|alike| alike.len() >= least);
    let widths: Vec<f64> = alike.map(|alike| alike[alike.len() / 2]).collect();
    // Where all are different, the middle one stands for all.
    if widths.is_empty() { radii.get(radii.len() / 2).copied().into_iter().collect() } else { widths }
}

/// Mean and spread of the scales by which these widths are usual ones.
fn usual_scale(widths: &[f64]) -> Option<(f64, f64)> {
    let (narrowest, widest) = (widths.first()?, widths.last()?);
    let (low, high) = ((0.4 / widest).ln(), (1.6 / narrowest).ln());
    let count = ((high - low) / STEP).ceil().clamp(1.0, 10_000.0) as usize;
    let mut sums = [0.0; 3];
    for i in 0..=count {
        let scale = low + (high - low) * i as f64 / count as f64;
        let likelihood: f64 = widths.iter().map(|width| usual(scale + width.ln())).product();
        for (power, sum) in sums.iter_mut().enumerate() {
            *sum += likelihood * scale.powi(power as i32);
        }
    }
    let mean = sums[1] / sums[0];
    let sigma = (sums[2] / sums[0] - mean * mean).max(0.0).sqrt();
    (mean.is_finite() && sigma.is_finite()).then_some((mean.exp(), sigma.max(OFF)))
}

/// How usual a leaf of this logarithm of a width is: a density.
fn usual(log_m: f64) -> f64 {
    let normal = |off: f64, sigma: f64| (-0.5 * (off / sigma).powi(2)).exp() / (sigma * TAU.sqrt());
    let known: f64 = USUAL_M.iter().map(|(metres, share)| share * normal(log_m - metres.ln(), OFF)).sum();
    (1.0 - UNUSUAL) * known + UNUSUAL * normal(log_m - UNUSUAL_M.ln(), UNUSUAL_SPREAD)
}
