//! How are scores said in a table? For the terminal, and as rows of markdown.

use std::fmt::Write as _;

use super::causal::Convergence;
use super::curves::Curves;
use super::place::AnswerScores;
use super::{Alignment, Evaluation, OdometryScores, PlaceScores};
use crate::words::percent;

/// The scores as a few aligned lines for a terminal.
pub fn text(evaluation: &Evaluation) -> String {
    let mut out = String::new();
    if let Some(place) = &evaluation.place {
        place_text(&mut out, place);
    }
    if let Some(odometry) = &evaluation.odometry {
        odometry_text(&mut out, odometry);
    }
    if let Some(pace) = &evaluation.pace {
        let part = |name: &str, pace: Option<f64>| pace.map(|p| format!("{name} {p:.2} s")).into_iter();
        let parts: Vec<String> = part("odometry", pace.odometry).chain(part("localisation", pace.locate)).collect();
        let _ = writeln!(out, "work in a second of walk: {}, on {} threads", parts.join(", "), pace.threads);
    }
    out
}

// Writing to a String cannot fail, here and below.
fn line(out: &mut String, cells: [&str; 3]) {
    let row = format!("  {:<30}{:>12}{:>12}", cells[0], cells[1], cells[2]);
    let _ = writeln!(out, "{}", row.trim_end());
}

fn place_text(out: &mut String, scores: &PlaceScores) {
    let (track, filter) = (&scores.track, scores.filter.as_ref());
    let _ = writeln!(out, "place on the plan: {} moments, {:.1} s, {:.1} m walked", track.compared, scores.duration_s, scores.length_m);
    line(out, ["", "whole walk", if filter.is_some() { "as it went" } else { "" }]);
    let causal = filter.map(|f| &f.errors);
    let mut row = |name: &str, of: &dyn Fn(&AnswerScores) -> String| {
        line(out, [name, &of(track), &causal.map(of).unwrap_or_default()]);
    };
    row("error, median (CE50)", &|s| metres(s.median_m));
    row("error, 95 % (CE95)", &|s| metres(s.ce95_m));
    row("error, RMS", &|s| metres(s.rmse_m));
    row("error, largest", &|s| metres(s.max_m));
    row("error at the end", &|s| metres(s.end_m));
    row("heading, median", &|s| s.heading_median_rad.map_or_else(|| "–".to_owned(), |h| format!("{:.1}°", h.to_degrees())));
    for (i, within) in track.recall.iter().enumerate() {
        row(&format!("within {} m, of the way", within.within_m), &|s| {
            s.recall.get(i).map_or_else(String::new, |r| percent(r.of_distance))
        });
    }
    if track.calibration.is_some() {
        let of = |s: &AnswerScores, i: usize| s.calibration.as_ref().and_then(|c| c.regions.get(i)).map(|r| percent(r.empirical));
        for (i, name) in ["truth in 50 % region", "truth in 90 % region", "truth in 95 % region"].into_iter().enumerate() {
            row(name, &|s| of(s, i).unwrap_or_default());
        }
        row("truth in radius95", &|s| s.calibration.as_ref().map_or_else(String::new, |c| percent(c.radius95)));
        let nees = |s: &AnswerScores| s.calibration.as_ref().and_then(|c| c.nees_position);
        row("NEES of position (honest: 2)", &|s| nees(s).map_or_else(|| "–".to_owned(), |n| format!("{n:.1}")));
    }
    let Some(filter) = filter else { return };
    for (name, converged) in [("stays right from", &filter.converged_right), ("stays near from", &filter.converged_near)] {
        line(out, [name, "", &convergence(converged)]);
    }
    for stay in filter.stays.iter().filter(|stay| stay.from_m < scores.length_m && stay.from_m >= 30.0) {
        let held = if stay.holds { "yes" } else { "no" };
        line(out, [&format!("within {} m from {} m on", stay.within_m, stay.from_m), "", held]);
    }
    let shares = format!("{} / {} / {}", percent(filter.tracking), percent(filter.ambiguous), percent(filter.lost));
    let _ = writeln!(out, "  tracking / ambiguous / lost: {shares}; at the end: {}", filter.end_status);
    let (falsely, longest_s) = (percent(filter.false_confidence), filter.false_confidence_longest_s);
    let _ = writeln!(out, "  sure and wrong: {falsely} of the moments, {longest_s:.1} s at a stretch");
    if let Some(places) = &scores.hypotheses {
        let right = if places.any_right { format!("with {}", percent(places.probability_right)) } else { "not among them".to_owned() };
        let _ = writeln!(out, "  places listed: {}; the true end: {right} (nearest {:.2} m)", places.listed, places.nearest_m);
    }
}

fn odometry_text(out: &mut String, s: &OdometryScores) {
    let posed = percent(s.posed_share);
    let _ = writeln!(
        out,
        "odometry, {}: {} poses, {:.1} s, {:.1} m, {posed} of the time posed",
        alignment(s.alignment),
        s.compared,
        s.duration_s,
        s.length_m
    );
    let share = s.ate_percent.map_or_else(String::new, |p| format!(" = {p:.2} % of the path"));
    let _ = writeln!(out, "  ATE RMS {:.3} m{share}; median {:.3} m, largest {:.3} m", s.ate_m.rmse, s.ate_m.median, s.ate_m.max);
    if s.scale != 1.0 {
        let _ = writeln!(out, "  scale {} m a unit", crate::words::significant(s.scale));
    }
    if let Some(rotation) = &s.rotation_deg {
        let _ = writeln!(out, "  rotation RMS {:.2}°, mean {:.2}°", rotation.rmse, rotation.mean);
    }
    for (name, rpe) in [("frame", &s.rpe_frame), ("metre", &s.rpe_metre)] {
        if let Some(rpe) = rpe {
            let _ = writeln!(out, "  RPE a {name}: {:.4} m, {:.3}° (RMS)", rpe.translation_m.rmse, rpe.rotation_deg.rmse);
        }
    }
    for drift in &s.drift {
        let (percent, deg) = (drift.translation_percent, drift.rotation_deg_per_m);
        let _ = writeln!(out, "  drift over {:>3.0} m: {percent:.2} %, {deg:.3}°/m", drift.length_m);
    }
}

/// What was free, e.g. `sim3 alignment`.
pub fn alignment(alignment: Alignment) -> String {
    if alignment == Alignment::None { "not aligned".to_owned() } else { format!("{alignment} alignment") }
}

fn metres(value: f64) -> String {
    format!("{value:.2} m")
}

fn convergence(converged: &Option<Convergence>) -> String {
    converged.map_or_else(|| "never".to_owned(), |c| format!("{:.1} m", c.distance_m))
}

/// The curves as CSV: `answer` is `track` (smoothed) or `filter` (causal); the heading's error is empty where it is not known.
pub fn curves_csv(curves: &Curves) -> String {
    let mut out = "answer,t_s,distance_m,error_m,heading_error_rad,radius95_m,status\n".to_owned();
    for (name, moments) in [("track", &curves.track), ("filter", &curves.filter)] {
        for m in moments {
            let heading = m.heading_error_rad.map_or_else(String::new, |h| format!("{h:.6}"));
            let (t_s, status) = (m.stamp.as_secs(), m.status);
            let _ = writeln!(out, "{name},{t_s:.9},{:.4},{:.4},{heading},{:.4},{status}", m.distance_m, m.error_m, m.radius95_m);
        }
    }
    out
}
