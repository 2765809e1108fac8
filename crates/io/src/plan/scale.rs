//! How long is a unit of a drawing? What a person says, else what the file says, else what the drawing itself gives away.
//!
//! given ─▶ the file's own unit ─▶ areas written in rooms ─▶ "1:100" in words ─▶ widths of doors
//!
//! The first that there is counts; the drawing's own witnesses are compared with it, and a note tells how well they agree. The
//! areas go before the words: they hold on paper of any size, and "1:100" does not.

pub(super) mod areas;
mod doors;
mod words;

use super::PlanFileError;
use super::PlanOptions;
use super::bounds::Bounds;
use super::sketch::{Sketch, SketchPoint};

/// A floor by a drawing's own unit is neither smaller nor larger than this, metres across.
const PLAUSIBLE_M: std::ops::RangeInclusive<f64> = 2.0..=5000.0;
/// Two scales that differ by less say the same, as a share: what --measure is warned by, too.
const SAME_SHARE: f64 = 0.03;

/// Metres in a unit, and who says so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    pub metres: f64,
    pub from: &'static str,
    /// The file's own unit may be a slip.
    pub is_files: bool,
}

/// What a drawing gives away of its scale.
#[derive(Debug, Clone, PartialEq)]
struct Witness {
    /// Metres in a unit.
    metres: f64,
    /// Standard deviation, as a share of it.
    sigma: f64,
    /// As `source.scale_from` has it.
    from: &'static str,
    /// What it is based on, for people, with a verb: "areas written in 61 rooms say".
    says: String,
    /// What a person should know who has nothing better.
    remark: &'static str,
}

impl Witness {
    fn figure(&self) -> String {
        format!("{} ± {}", metres_text(self.metres), percent(self.sigma))
    }
}

impl Scale {
    /// Of a drawing, one unit of which is so long on paper, if it was ever on paper. What is decided, and what speaks against it, is
    /// noted.
    ///
    /// # Errors
    /// [`PlanFileError::NoScale`] and [`PlanFileError::NoDrawingScale`] where nothing tells, [`PlanFileError::ImplausibleUnit`] where
    /// only an implausible unit does, and errors of what was given.
    pub(super) fn of_drawing(
        stated: Option<f64>,
        options: &PlanOptions,
        sketch: &Sketch,
        paper_m: Option<f64>,
        notes: &mut Vec<String>,
    ) -> Result<Self, PlanFileError> {
        let scale = Self::of(stated, options, sketch.metres_per_unit, paper_m).and_then(|scale| scale.checked(sketch));
        if sketch.exported_from.is_some() {
            return scale;
        }
        let witnesses = witnesses(sketch, paper_m);
        match scale {
            Ok(scale) => {
                notes.extend(witnesses.iter().map(|witness| scale.compared(witness)));
                Ok(scale)
            }
            Err(why @ (PlanFileError::NoScale | PlanFileError::NoDrawingScale | PlanFileError::ImplausibleUnit { .. })) => {
                let Some((best, others)) = witnesses.split_first() else { return Err(why) };
                if matches!(why, PlanFileError::ImplausibleUnit { .. }) {
                    notes.push(format!("warning: the file's own unit is not believed: {why}"));
                }
                notes.push(format!("the scale is taken from the drawing itself: {} {} a unit{}", best.says, best.figure(), best.remark));
                let scale = Self { metres: best.metres, from: best.from, is_files: false };
                notes.extend(others.iter().map(|other| scale.compared(other)));
                Ok(scale)
            }
            Err(why) => Err(why),
        }
    }

    /// What a person says goes before what the file says; `paper_m` is the unit's size on paper.
    pub(super) fn of(stated: Option<f64>, options: &PlanOptions, files: Option<f64>, paper_m: Option<f64>) -> Result<Self, PlanFileError> {
        if let Some(metres) = stated {
            let from = if !options.measures.is_empty() { "a measured length" } else { "given" };
            return Ok(Self { metres, from, is_files: false });
        }
        match (options.drawing_scale, paper_m, files) {
            (Some(scale), _, _) if !(1.0..=100_000.0).contains(&scale) => Err(PlanFileError::BadDrawingScale { scale }),
            (Some(_), None, _) => Err(PlanFileError::NotOnPaper),
            (Some(scale), Some(paper_m), _) => Ok(Self { metres: scale * paper_m, from: "the drawing's scale, given", is_files: false }),
            (_, _, Some(metres)) => Ok(Self { metres, from: "the file's own unit", is_files: true }),
            (_, Some(_), None) => Err(PlanFileError::NoDrawingScale),
            (_, None, None) => Err(PlanFileError::NoScale),
        }
    }

    /// A unit that makes the drawing no building is a slip.
    fn checked(self, sketch: &Sketch) -> Result<Self, PlanFileError> {
        let [width_m, height_m] = extent(sketch).map(|side| side * self.metres);
        if self.is_files && !PLAUSIBLE_M.contains(&width_m.max(height_m)) {
            return Err(PlanFileError::ImplausibleUnit { metres_per_unit: self.metres, width_m, height_m });
        }
        Ok(self)
    }

    /// How a witness agrees, in words.
    fn compared(&self, witness: &Witness) -> String {
        let off = witness.metres / self.metres - 1.0;
        let (says, figure) = (&witness.says, witness.figure());
        if off.abs() <= SAME_SHARE.max(2.0 * witness.sigma) {
            format!("the scale of {} a unit is right as far as the drawing tells: {says} {figure}", metres_text(self.metres))
        } else {
            format!(
                "warning: the scale is {} a unit ({}), but {says} {figure}, which is {:+.1} %: one of the two is wrong",
                metres_text(self.metres),
                self.from,
                100.0 * off
            )
        }
    }
}

/// All that the drawing gives away, the most trusted first.
fn witnesses(sketch: &Sketch, paper_m: Option<f64>) -> Vec<Witness> {
    let of_sane_size = |witness: &Witness| {
        let side = extent(sketch).into_iter().fold(0.0, f64::max) * witness.metres;
        witness.metres.is_finite() && witness.metres > 0.0 && PLAUSIBLE_M.contains(&side)
    };
    [areas::witness(sketch), paper_m.and_then(|paper_m| words::witness(sketch, paper_m)), doors::witness(sketch)]
        .into_iter()
        .flatten()
        .filter(of_sane_size)
        .collect()
}

/// Width and height of all that is drawn, units.
fn extent(sketch: &Sketch) -> [f64; 2] {
    Bounds::of(sketch.paths.iter().flat_map(|path| &path.points)).map_or([0.0; 2], Bounds::size)
}

/// Four digits that count.
fn metres_text(metres: f64) -> String {
    let decimals = (3.0 - metres.abs().max(1e-300).log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{metres:.decimals$} m")
}

fn percent(share: f64) -> String {
    if share < 0.0995 { format!("{:.1} %", 100.0 * share) } else { format!("{:.0} %", 100.0 * share) }
}

/// The middle one; `None` of none.
fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Twice the area of a ring, signed, units².
fn twice_area(ring: &[SketchPoint]) -> f64 {
    let from = ring.first().copied().unwrap_or_default();
    // From one of its points: far from the origin, products of coordinates lose all digits.
    let way = |at: &SketchPoint| [at[0] - from[0], at[1] - from[1]];
    ring.windows(2).map(|ends| (way(&ends[0]), way(&ends[1]))).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
}

#[cfg(test)]
mod tests;
