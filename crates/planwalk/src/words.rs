//! How is a result said in a sentence? The same words on the terminal, in pictures and in the report.

use planwalk_types::{Estimate, ScaleEstimate, Status};

use crate::result::{ApartEntry, ContradictedEntry, ContradictedKindEntry, CueEntry, EvidenceEntry, OdometryEntry};

/// The verdict as a sentence; `probability` is that of the likeliest place.
pub fn verdict(status: Status, probability: f64) -> String {
    let share = percent(probability);
    match status {
        Status::Tracking => "One place on the plan explains the walk.".to_owned(),
        // Mass alone is no proof: the place must also explain what was seen.
        Status::Ambiguous if probability >= 0.9 => format!("The likeliest place holds {share}, but the evidence for it is thin."),
        Status::Ambiguous => format!("The walk is not pinned to one place yet: the likeliest holds {share}."),
        Status::Lost => "No place on the plan explains the walk; the likeliest is drawn.".to_owned(),
    }
}

/// Where the walk ended, how sure that is, and which way the walker faced.
pub fn end_pose(end: &Estimate) -> String {
    let heading_deg = signed(end.pose.heading_rad.to_degrees(), 0);
    format!("({}, {}) m ± {:.2} m (95 %), facing {heading_deg}°", signed(end.pose.x, 2), signed(end.pose.y, 2), end.radius95_m)
}

/// The scale, e.g. `1 unit of odometry = 0.84 m ± 5 %`.
pub fn scale(scale: &ScaleEstimate) -> String {
    format!("1 unit of odometry = {} m ± {:.0} %", significant(scale.metres_per_unit), 100.0 * scale.relative_sigma)
}

/// What the walking body says of the unit before the plan is looked at: `1 unit ≈ 1 m ± 14 %: camera 1.36 up, 1.85 steps a second`.
pub fn unit(odometry: &OdometryEntry) -> String {
    let cue = |e: &EvidenceEntry| match e.cue {
        CueEntry::CameraHeight => format!("camera {} up", significant(e.measured)),
        CueEntry::Gait => format!("{} steps a second", significant(e.measured)),
        CueEntry::WalkingSpeed => format!("{} units a second", significant(e.measured)),
    };
    let cues: Vec<String> = odometry.unit_evidence.iter().map(cue).collect();
    let why = if cues.is_empty() { "nothing moved".to_owned() } else { cues.join(", ") };
    format!("1 unit ≈ 1 m ± {:.0} %: {why}", 100.0 * odometry.unit_sigma)
}

/// Which drawn walls the walk contradicts; `None` where none is.
pub fn contradicted(walls: &[ContradictedEntry]) -> Option<String> {
    /// More are told by the list, not by a sentence.
    const NAMED: usize = 4;
    let all = |kind: ContradictedKindEntry| walls.iter().filter(move |w| w.kind == kind);
    let places = |kind: ContradictedKindEntry| {
        let place = |w: &ContradictedEntry| {
            let times = if w.times_crossed > 1 { format!(" ({} times)", w.times_crossed) } else { String::new() };
            format!("({}, {}){times}", signed(w.x_m, 1), signed(w.y_m, 1))
        };
        let named: Vec<String> = all(kind).take(NAMED).map(place).collect();
        let more = all(kind).count().saturating_sub(NAMED);
        named.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
    };
    let (crossed, seen) = (places(ContradictedKindEntry::Crossed), places(ContradictedKindEntry::SeenThrough));
    let how = match (crossed.is_empty(), seen.is_empty()) {
        (true, true) => return None,
        (false, true) => format!("crossed near {crossed}"),
        (true, false) => format!("seen through near {seen}"),
        (false, false) => format!("crossed near {crossed}; seen through near {seen}"),
    };
    let count = walls.len();
    Some(if count == 1 { format!("1 drawn wall is contradicted: {how}") } else { format!("{count} drawn walls are contradicted: {how}") })
}

/// What would tell two places apart, e.g. `they differ in 6 m: a door on the left at the first, a wall 1.5 m off at the second`.
pub fn apart(apart: &ApartEntry) -> String {
    let places = |i: usize| match apart.hypotheses[i] {
        0 => "the likeliest place".to_owned(),
        other => format!("place {}", other + 1),
    };
    let (first, second) = (places(0), places(1));
    let Some(go) = &apart.go else {
        return format!("{first} and {second}: nothing within {:.0} m tells them apart", apart.distance_m);
    };
    let way = match (go.as_str(), apart.distance_m) {
        ("straight", d) if d < 0.5 => "they differ here".to_owned(),
        ("straight", d) => format!("they differ in {d:.0} m straight on"),
        (turn, d) if d < 0.5 => format!("they differ to the {turn}"),
        (turn, d) => format!("they differ in {d:.0} m after a turn to the {turn}"),
    };
    let look = match apart.direction_rad {
        r if r > 0.1 => "on the left",
        r if r < -0.1 => "on the right",
        _ => "ahead",
    };
    format!("{first} and {second}: {way}: {look}, {} at the first, {} at the second", apart.at_first, apart.at_second)
}

/// A share as per cent; what is neither none nor all is not rounded to it.
pub fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p > 0.0 && p < 1.0 => "< 1 %".to_owned(),
        p if p > 99.0 && p < 100.0 => "> 99 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

/// A count with its thousands apart.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A number with a true minus sign and no negative zero.
fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let digits = text.trim_start_matches('-');
    let zero = digits.chars().all(|c| c == '0' || c == '.');
    if text.starts_with('-') && !zero { format!("−{digits}") } else { digits.to_owned() }
}

/// Three significant digits, for figures whose size is not known beforehand.
pub(crate) fn significant(value: f64) -> String {
    let size = value.abs();
    let decimals = if size > 0.0 && size.is_finite() { (2.0 - size.log10().floor()).clamp(0.0, 9.0) as usize } else { 2 };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{PlanPose, Stamp};

    #[test]
    fn an_end_reads_like_this() {
        let pose = PlanPose::new(-1.204, 0.0, 1.6);
        let end = Estimate {
            stamp: Stamp(0),
            pose,
            covariance: nalgebra::Matrix3::zeros(),
            radius95_m: 0.5,
            probability: 1.0,
            status: Status::Tracking,
            scale: None,
        };
        assert_eq!(end_pose(&end), "(−1.20, 0.00) m ± 0.50 m (95 %), facing 92°");
    }

    #[test]
    fn contradicted_walls_are_named_with_their_places() {
        let wall = |kind, x_m: f64, times_crossed| ContradictedEntry {
            kind,
            x_m,
            y_m: 4.5,
            length_m: 0.0,
            times_crossed,
            confidence: 1.0,
            rays_through: 0,
            rays_ending: 0,
        };
        assert_eq!(contradicted(&[]), None);
        let crossed = wall(ContradictedKindEntry::Crossed, 12.3, 1);
        assert_eq!(contradicted(&[crossed]).unwrap(), "1 drawn wall is contradicted: crossed near (12.3, 4.5)");
        let all = [crossed, wall(ContradictedKindEntry::Crossed, 2.0, 2), wall(ContradictedKindEntry::SeenThrough, -7.0, 0)];
        let said = "3 drawn walls are contradicted: crossed near (12.3, 4.5), (2.0, 4.5) (2 times); seen through near (−7.0, 4.5)";
        assert_eq!(contradicted(&all).unwrap(), said);
    }

    #[test]
    fn what_tells_places_apart_reads_like_this() {
        let mut entry = ApartEntry {
            hypotheses: [0, 1],
            go: Some("straight".to_owned()),
            distance_m: 6.0,
            direction_rad: 1.57,
            at_first: "a door".to_owned(),
            at_second: "a wall 1.5 m off".to_owned(),
        };
        let said = "the likeliest place and place 2: they differ in 6 m straight on: on the left, a door at the first, a wall 1.5 m off at the second";
        assert_eq!(apart(&entry), said);
        (entry.distance_m, entry.direction_rad) = (0.0, 0.0);
        assert!(apart(&entry).contains("they differ here: ahead"), "{}", apart(&entry));
        (entry.go, entry.distance_m) = (None, 30.0);
        assert_eq!(apart(&entry), "the likeliest place and place 2: nothing within 30 m tells them apart");
    }

    #[test]
    fn small_and_large_scales_keep_their_digits() {
        let of = |metres_per_unit: f64| scale(&ScaleEstimate { metres_per_unit, relative_sigma: 0.051 });
        assert_eq!(of(0.00834), "1 unit of odometry = 0.00834 m ± 5 %");
        assert_eq!(of(12.34), "1 unit of odometry = 12.3 m ± 5 %");
    }

    #[test]
    fn the_unit_is_said_with_what_speaks_for_it() {
        let cue = |cue, measured| EvidenceEntry { cue, measured, metres_per_unit: 1.0, relative_sigma: 0.15 };
        let unit_evidence = vec![cue(CueEntry::CameraHeight, 1.364), cue(CueEntry::Gait, 1.85)];
        let mut entry = OdometryEntry {
            frames: 100,
            seconds: 10.0,
            length: 8.0,
            sightings: 50,
            solver: crate::result::SolverEntry::FivePoint,
            unit_sigma: 0.141,
            unit_evidence,
            quality: Vec::new(),
        };
        assert_eq!(unit(&entry), "1 unit ≈ 1 m ± 14 %: camera 1.36 up, 1.85 steps a second");
        entry.unit_evidence.clear();
        assert!(unit(&entry).ends_with("nothing moved"));
    }

    #[test]
    fn thousands_stand_apart() {
        assert_eq!([0, 999, 1000, 864_214, 1_000_000].map(grouped), ["0", "999", "1,000", "864,214", "1,000,000"]);
    }

    #[test]
    fn an_ambiguous_verdict_never_sounds_sure() {
        assert!(verdict(Status::Ambiguous, 0.99).contains("evidence for it is thin"));
        assert!(verdict(Status::Ambiguous, 0.5).contains("holds 50 %"));
    }

    #[test]
    fn shares_are_not_rounded_to_certainty() {
        assert_eq!([percent(0.999), percent(0.001), percent(0.5), percent(1.0), percent(0.0)], ["> 99 %", "< 1 %", "50 %", "100 %", "0 %"]);
    }
}
