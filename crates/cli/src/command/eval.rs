//! `planwalk eval`: how far is it from the truth, and was its doubt honest?

use std::path::Path;

use clap::ValueEnum;
use nalgebra::{Matrix3, Vector3};
use planwalk::evaluate::{
    Alignment, AssociateOptions, Curves, EvaluateError, Evaluation, OdometryScoreOptions, PlaceOptions, Timing, curves, odometry, place,
    words,
};
use planwalk::figure::{CalibrationPicture, ErrorPicture, OverlayPicture, png_of};
use planwalk::result::{OptionEntry, ResultFile};
use planwalk::types::{Body, Estimate, Odom, Plan, PlanPose, Rigid3, Stamp, Status};
use planwalk_io::trajectory::{self, PosesFile, PosesFormat, PosesFrame, PosesOptions};

use serde::de::DeserializeOwned;

use super::name_of;
use crate::args::EvalArgs;
use crate::failure::Failure;
use crate::inputs;
use crate::output::Output;
use crate::say::{self, Voice};

/// Poses as files hold them.
type Poses = [(Stamp, Rigid3<Odom, Body>)];

/// What is to be scored.
#[derive(Default)]
struct Answer {
    /// The smoothed track, where there is one.
    track: Option<Vec<Estimate>>,
    /// The causal answer; may be empty.
    filter: Vec<Estimate>,
    /// Probability and end of each listed place.
    places: Vec<(f64, PlanPose)>,
    /// The odometry, where there is one.
    odometry: Option<Odometry>,
    /// How long the run took, where it said so.
    timing: Option<Timing>,
}

/// An odometry, and what is free when nothing was said.
struct Odometry {
    poses: PosesFile,
    usual: Alignment,
    /// Whether it stands in a body's frame; else in whatever frame the file has, which the truth must share.
    body: bool,
}

/// Scores a folder of results, or a trajectory, against the truth.
pub fn run(args: &EvalArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.quiet };
    let mut evaluation = Evaluation::new(&name_of(&args.result));
    note_options(&mut evaluation, args);
    let truth = read_truth(args)?;
    let answer = if args.result.is_dir() { of_folder(args, &mut evaluation.notes)? } else { of_file(args, &mut evaluation.notes)? };
    evaluation.notes.extend(truth.notes.iter().map(|note| format!("truth: {}", note.replace("--poses-frame", "--truth-frame"))));
    evaluation.inputs.push(inputs::entry("truth", &args.truth)?);
    check_frames(&truth, &answer, args)?;
    let curves = score_place(&mut evaluation, &answer, &truth, args)?;
    let aligned = score_odometry(&mut evaluation, &answer, &truth, args)?;
    evaluation.pace = answer.timing.and_then(|timing| timing.pace());
    for note in &evaluation.notes {
        voice.say(&format!("note: {note}"));
    }
    let output = Output::beside(args.output.as_deref().unwrap_or_else(|| folder_of(&args.result)))?;
    draw(&output, &evaluation, curves.as_ref(), aligned.as_ref(), args)?;
    output.write("eval.json", evaluation.to_json())?;
    voice.say(words::text(&evaluation).trim_end());
    voice.say(&format!("scores: {}", output.path("eval.json").display()));
    if args.json {
        say::stdout_text(&evaluation.to_json());
    }
    Ok(())
}

/// Where results lie that are not a folder.
fn folder_of(file: &Path) -> &Path {
    if file.is_dir() { file } else { file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")) }
}

fn note_options(evaluation: &mut Evaluation, args: &EvalArgs) {
    let mut option = |name: &str, value: Option<String>| {
        evaluation.options.extend(value.map(|value| OptionEntry { name: name.to_owned(), value }));
    };
    let lower = |debug: String| debug.to_lowercase();
    option("truth-format", args.truth_format.map(|f| lower(format!("{f:?}"))));
    option("truth-frame", args.truth_frame.map(|f| lower(format!("{f:?}"))));
    option("poses-format", args.poses_format.map(|f| lower(format!("{f:?}"))));
    option("poses-frame", args.poses_frame.map(|f| lower(format!("{f:?}"))));
    option("align", args.align.and_then(|a| a.to_possible_value()).map(|v| v.get_name().to_owned()));
    option("max-diff", Some(args.max_diff.to_string()));
    option("interpolate-truth", args.interpolate_truth.map(|gap| gap.to_string()));
    option("time-offset", (args.time_offset != 0.0).then(|| args.time_offset.to_string()));
}

fn associate(args: &EvalArgs) -> AssociateOptions {
    AssociateOptions { max_diff_s: args.max_diff, max_gap_s: args.interpolate_truth, time_offset_s: args.time_offset }
}

fn read_truth(args: &EvalArgs) -> Result<PosesFile, Failure> {
    let options = PosesOptions { format: args.truth_format, frame: args.truth_frame, fps: None };
    // The messages of the file's reader name the options for poses.
    let refused = |why: trajectory::PosesError| {
        let why = why.to_string().replace("--poses-format", "--truth-format").replace("--poses-frame", "--truth-frame");
        Failure::input("the truth", why, &args.truth)
    };
    let Some(times) = &args.truth_times else { return trajectory::read(&args.truth, &options).map_err(refused) };
    std::fs::metadata(times).map_err(|why| Failure::input("the times", why, times))?;
    let truth = trajectory::read_with_times(&args.truth, &options, times).map_err(refused)?;
    if !matches!(truth.format, PosesFormat::Kitti | PosesFormat::Carmen) {
        return Err(Failure::usage("--truth-times is for KITTI poses and robots' corrected logs; this truth carries its own times"));
    }
    Ok(truth)
}

/// What `locate` or `track` left in their folder.
fn of_folder(args: &EvalArgs, notes: &mut Vec<String>) -> Result<Answer, Failure> {
    if args.poses_format.is_some() || args.poses_frame.is_some() {
        return Err(Failure::usage("--poses-format and --poses-frame are for a single trajectory; a folder of results says them itself"));
    }
    let file = |name: &str| Some(args.result.join(name)).filter(|path| path.is_file());
    let result: Option<ResultFile> = file("result.json").map(|path| read_json(&path)).transpose()?;
    let track = file("track.csv").map(|path| read_table(&path)).transpose()?;
    let filter = file("filter.csv").filter(|_| track.is_some()).map(|path| read_table(&path)).transpose()?.unwrap_or_default();
    let odometry = file("odometry.tum").map(|path| read_odometry(&path, result.as_ref())).transpose()?;
    if track.is_none() && odometry.is_none() {
        let why = "it holds neither track.csv nor odometry.tum; give the output folder of planwalk locate or track, or a trajectory file";
        return Err(Failure::input("the folder", why, &args.result));
    }
    if let Some(error) = result.as_ref().and_then(|r| r.error.as_ref()) {
        notes.push(format!("this run gave no answer: {error}"));
    }
    let entries = result.map(|r| r.hypotheses).unwrap_or_default();
    let places = entries.iter().map(|h| (h.probability, PlanPose::new(h.pose.x_m, h.pose.y_m, h.pose.yaw_rad))).collect();
    let timing = file("timing.json").map(|path| read_json(&path)).transpose()?;
    Ok(Answer { track, filter, places, odometry, timing })
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let text = std::fs::read_to_string(path).map_err(|why| Failure::input("the result", why, path))?;
    serde_json::from_str(&text).map_err(|why| Failure::input("the result", why, path))
}

fn read_table(path: &Path) -> Result<Vec<Estimate>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|why| Failure::input("the track", why, path))?;
    planwalk::tables::estimates_of_csv(&text).map_err(|why| Failure::input("the track", why, path))
}

/// The poses of a video's odometry are its camera's; those of `--poses` were laid flat.
fn read_odometry(path: &Path, result: Option<&ResultFile>) -> Result<Odometry, Failure> {
    let read = |frame: PosesFrame| {
        let options = PosesOptions { format: Some(PosesFormat::Tum), frame: Some(frame), fps: None };
        trajectory::read(path, &options).map_err(|why| Failure::input("the odometry", why, path))
    };
    let camera = match result {
        Some(result) => result.odometry.is_some(),
        None => !upright(read(PosesFrame::Body)?.trajectory.poses()),
    };
    if camera {
        return Ok(Odometry { poses: read(PosesFrame::Camera)?, usual: Alignment::Sim3, body: true });
    }
    let metric = result.is_some_and(|r| r.options.iter().any(|o| o.name == "odometry-scale" && o.value == "metric"));
    let usual = if metric { Alignment::Se2 } else { Alignment::Sim2 };
    Ok(Odometry { poses: read(PosesFrame::Body)?, usual, body: true })
}

/// A trajectory from elsewhere: an odometry, and with `--align none` also a track on the plan.
fn of_file(args: &EvalArgs, notes: &mut Vec<String>) -> Result<Answer, Failure> {
    let path = &args.result;
    let options = PosesOptions { format: args.poses_format, frame: args.poses_frame, fps: None };
    let refused = |why| Failure::input("the trajectory", why, path);
    let mut poses = trajectory::read(path, &options).map_err(refused)?;
    let own = trajectory::times_beside(path).filter(|_| args.truth_times.is_none());
    let times = args.truth_times.clone().or_else(|| trajectory::times_beside(&args.truth));
    if let (PosesFormat::Kitti, None, Some(times)) = (poses.format, own, times) {
        // KITTI's estimates are written without times: they are those of the truth.
        poses = trajectory::read_with_times(path, &options, &times).map_err(refused)?;
    }
    notes.append(&mut poses.notes);
    let track = args.align.map(Alignment::from) == Some(Alignment::None);
    let track = track.then(|| poses.trajectory.poses().iter().map(|(stamp, pose)| unclaimed(*stamp, pose)).collect());
    let body = options.frame.is_some() || poses.frame == PosesFrame::Camera;
    Ok(Answer { track, odometry: Some(Odometry { poses, usual: Alignment::Sim3, body }), ..Answer::default() })
}

/// A pose on the plan that claims nothing of its doubt.
fn unclaimed(stamp: Stamp, pose: &Rigid3<Odom, Body>) -> Estimate {
    let (pose, covariance) = (on_plan(pose), Matrix3::zeros());
    Estimate { stamp, pose, covariance, radius95_m: 0.0, probability: 0.0, status: Status::Lost, scale: None }
}

/// The plan is the frame of a truth, and of a track from elsewhere.
fn on_plan(pose: &Rigid3<Odom, Body>) -> PlanPose {
    Rigid3::<Plan, Body>::new(pose.iso).on_floor()
}

/// Whether the body's z axis points up on average, within 60°.
fn upright(poses: &Poses) -> bool {
    let up: f64 = poses.iter().map(|(_, pose)| (pose.iso.rotation * Vector3::z()).z).sum();
    up > 0.5 * poses.len() as f64
}

/// Refuses truths that are poses of something else, or in another world than the plan.
fn check_frames(truth: &PosesFile, answer: &Answer, args: &EvalArgs) -> Result<(), Failure> {
    let needs_body = answer.track.is_some() || answer.odometry.as_ref().is_some_and(|o| o.body);
    if needs_body && !upright(truth.trajectory.poses()) {
        let why = "its poses lie on their side, as a camera's do (x right, y down, z forward): say --truth-frame camera";
        return Err(Failure::input("the truth", why, &args.truth));
    }
    if answer.track.is_some() && truth.turned {
        let why = "its world does not have z up, so it is not the plan's: a place on the plan needs a truth in metres on the plan";
        return Err(Failure::input("the truth", why, &args.truth));
    }
    Ok(())
}

/// An option out of range is wrong use; all else is in the files.
fn refused(why: EvaluateError, args: &EvalArgs) -> Failure {
    match why {
        EvaluateError::BadOption { .. } => Failure::usage(why),
        why => Failure::input("the truth", why, &args.truth),
    }
}

fn score_place(evaluation: &mut Evaluation, answer: &Answer, truth: &PosesFile, args: &EvalArgs) -> Result<Option<Curves>, Failure> {
    let Some(track) = &answer.track else { return Ok(None) };
    let options = PlaceOptions { associate: associate(args), truth_faces: truth.faces, ..PlaceOptions::default() };
    let on_plan: Vec<(Stamp, PlanPose)> = truth.trajectory.poses().iter().map(|(stamp, pose)| (*stamp, on_plan(pose))).collect();
    let curves = curves(track, &answer.filter, &on_plan, &options).map_err(|why| refused(why, args))?;
    evaluation.place = place::scores_of(&curves, &options);
    if let (Some(scores), Some(end)) = (&mut evaluation.place, track.last()) {
        scores.hypotheses = place::hypotheses(&answer.places, end.stamp, &on_plan, &options);
    }
    Ok(Some(curves))
}

fn score_odometry(
    evaluation: &mut Evaluation,
    answer: &Answer,
    truth: &PosesFile,
    args: &EvalArgs,
) -> Result<Option<odometry::Aligned>, Failure> {
    let Some(odometry) = &answer.odometry else { return Ok(None) };
    let alignment = args.align.map_or(odometry.usual, Alignment::from);
    let truth_faces = truth.faces && odometry.poses.faces;
    let options = OdometryScoreOptions { associate: associate(args), truth_faces, ..OdometryScoreOptions::default() };
    let (estimate, truth) = (odometry.poses.trajectory.poses(), truth.trajectory.poses());
    match odometry::score(estimate, truth, alignment, &options) {
        Ok(scores) => evaluation.odometry = Some(scores),
        // The place is scored already; an odometry that cannot be aligned takes nothing from it.
        Err(why) if evaluation.place.is_some() => {
            evaluation.notes.push(format!("the odometry is not scored: {why}"));
            return Ok(None);
        }
        Err(why) => return Err(refused(why, args)),
    }
    odometry::pairs(estimate, truth, alignment, &options.associate).map(Some).map_err(|why| refused(why, args))
}

fn draw(
    output: &Output,
    evaluation: &Evaluation,
    curves: Option<&Curves>,
    aligned: Option<&odometry::Aligned>,
    args: &EvalArgs,
) -> Result<(), Failure> {
    let picture = |name: &str, svg: &str| {
        output.write(&format!("{name}.svg"), svg)?;
        let png = png_of(svg).map_err(|why| Failure::output(why, &output.path(&format!("{name}.png"))))?;
        output.write(&format!("{name}.png"), png)
    };
    let name = format!("{} against {}", evaluation.name, name_of(&args.truth));
    if let Some(curves) = curves {
        let right_m = PlaceOptions::default().right_m;
        picture("eval-error", &ErrorPicture { title: &name, curves, right_m }.svg())?;
        picture("eval-calibration", &CalibrationPicture { title: &evaluation.name, curves }.svg())?;
        output.write("eval-curves.csv", words::curves_csv(curves))?;
    }
    if let (Some(aligned), Some(scores)) = (aligned, &evaluation.odometry) {
        let share = scores.ate_percent.map_or_else(String::new, |p| format!(" = {p:.2} % of {:.1} m", scores.length_m));
        let subtitle = format!("{}: ATE {:.3} m{share}", words::alignment(scores.alignment), scores.ate_m.rmse);
        picture("eval-odometry", &OverlayPicture { title: &name, subtitle: &subtitle, pairs: &aligned.pairs }.svg())?;
    }
    Ok(())
}
