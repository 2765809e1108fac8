//! What does a localiser get, and what is true? A job's walk: read, followed, or simulated.
//!
//! Failures come back as text: one bad file must not end a bench, and its record says why there are no scores.

use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;
use std::time::{Duration, Instant};

use planwalk::Walk;
use planwalk::evaluate::{self, Alignment, AssociateOptions, OdometryScoreOptions, OdometryScores, PlaceOptions, PlaceScores, scale};
use planwalk::locate::StartPrior;
use planwalk::odometry::{Odometry, OdometryOptions};
use planwalk::types::path::StepNoise;
use planwalk::types::{Body, Cam, Estimate, FloorPlan, OdometryScale, Plan, PlanPose, Rigid3, Seed, Stamp, Status, VideoFrame};
use planwalk_io::plan::PlanOptions;
use planwalk_io::trajectory::{PosesFormat, PosesFrame, PosesOptions, UnknownName};
use planwalk_io::video::VideoOptions;

use super::simulated;
use super::suite::{Case, Job};

/// How surely a stated start is known: half a metre and 10°, as a person points at it.
const START_SIGMA: (f64, f64) = (0.5, 0.175);
/// Truths farther apart than this are no neighbours: frames of a 12 Hz video find theirs.
const MAX_DIFF_S: f64 = 0.05;

/// Poses on the plan, of a body or of whatever a file is of.
type Poses = Vec<(Stamp, Rigid3<Plan, Body>)>;

/// A walk with its truth.
pub struct Prepared {
    /// What the localiser gets.
    pub walk: Walk,
    /// Where it is to be found; none where only the odometry is scored.
    pub plan: Option<FloorPlan>,
    /// Where it begins, if the localiser is told.
    pub start: Option<StartPrior>,
    /// Where it truly went.
    pub truth: Vec<(Stamp, PlanPose)>,
    /// True metres in a unit of its odometry, moment by moment; empty where nobody knows.
    pub units: Vec<(Stamp, f64)>,
    /// How its moments and those of the truth are brought together.
    pub options: PlaceOptions,
    /// Time that the odometry took, seconds, where it was ours.
    pub odometry_s: Option<f64>,
    /// How the odometry followed.
    pub odometry: Option<OdometryScores>,
    /// How somebody else's answer scores on the plan.
    pub place: Option<PlaceScores>,
}

impl Prepared {
    /// From the first step to the last, seconds.
    pub fn duration_s(&self) -> f64 {
        let steps = &self.walk.path.steps;
        steps.first().zip(steps.last()).map_or(0.0, |(first, last)| last.to.secs_since(first.from))
    }
}

/// Makes a job's walk.
pub fn prepare(job: &Job<'_>, data: &Path) -> Result<Prepared, String> {
    let case = job.case;
    let mut prepared = match (&case.simulate, &case.video, &case.poses, &case.along, &case.track) {
        (Some(simulate), ..) => simulated::family(job, simulate)?,
        (_, Some(video), ..) => from_video(job, data, video)?,
        (_, _, Some(poses), ..) => from_poses(case, data, poses)?,
        (_, _, _, Some(path), _) => simulated::along(job, data, path)?,
        (_, _, _, _, Some(track)) => foreign(case, data, track)?,
        _ => return Err("it has no walk".to_owned()),
    };
    if case.blind {
        prepared.walk.sightings.clear();
    }
    if case.start_known {
        prepared.start = prepared.truth.first().map(|(_, pose)| StartPrior {
            x: pose.x,
            y: pose.y,
            heading_rad: prepared.options.truth_faces.then_some(pose.heading_rad),
            sigma_m: START_SIGMA.0,
            sigma_rad: START_SIGMA.1,
        });
    }
    Ok(prepared)
}

fn from_video(job: &Job<'_>, data: &Path, video: &Path) -> Result<Prepared, String> {
    let case = job.case;
    let truth = Truth::read(case, data)?;
    let plan = plan(case, data)?;
    let source = planwalk_io::video::open(&data.join(video), &VideoOptions { fps: case.fps }).map_err(say("the video", video))?;
    let camera = match &case.camera {
        Some(file) => planwalk_io::camera::read_for(&data.join(file), source.size()).map_err(say("the camera", file))?,
        None => {
            let (width, height) = source.size();
            let again = planwalk_io::video::open(&data.join(video), &VideoOptions { fps: case.fps }).map_err(say("the video", video))?;
            planwalk::measure_lens(again, (width, height), planwalk::types::Seed(job.seed), &mut |_| {}).camera(width, height)
        }
    };
    let (odometry, seconds) = follow(source, &camera, job.seed)?;
    let scores = truth.score_camera(case, &odometry)?;
    Ok(truth.prepared(case, Walk::from(&odometry), plan, Some(seconds), Some(scores)))
}

/// The odometry of a video and the seconds that it took, without those in which frames were read or drawn.
pub(super) fn follow<E: Display>(
    mut frames: impl Iterator<Item = Result<VideoFrame, E>>,
    camera: &planwalk::types::Camera,
    seed: u64,
) -> Result<(Odometry, f64), String> {
    let (began, mut fetching) = (Instant::now(), Duration::ZERO);
    let timed = std::iter::from_fn(|| {
        let asked = Instant::now();
        let frame = frames.next();
        fetching += asked.elapsed();
        frame
    });
    let options = OdometryOptions { seed: Seed(seed), ..OdometryOptions::default() };
    let followed = planwalk::follow(timed, camera, &options, &mut |_| {});
    let seconds = began.elapsed().saturating_sub(fetching).as_secs_f64();
    if let Some(why) = followed.cut_short {
        return Err(format!("the video ends early, after {} frames: {why}", followed.frames));
    }
    let odometry = followed.odometry.map_err(|why| format!("the video gives no odometry: {why}"))?;
    Ok((odometry, seconds))
}

fn from_poses(case: &Case, data: &Path, poses: &Path) -> Result<Prepared, String> {
    let truth = Truth::read(case, data)?;
    let plan = plan(case, data)?;
    let file = planwalk_io::trajectory::read(&data.join(poses), &poses_options(case)?).map_err(say("the poses", poses))?;
    let sightings = match &case.sightings {
        Some(file) => planwalk_io::sightings::read(&data.join(file)).map_err(say("the sightings", file))?,
        None => Vec::new(),
    };
    let walk = Walk { path: file.trajectory.to_path(&StepNoise::default()), sightings, scale: case.scale()? };
    let scores = truth.score_body(case, file.trajectory.poses())?;
    Ok(truth.prepared(case, walk, plan, None, Some(scores)))
}

/// Somebody else's answer.
fn foreign(case: &Case, data: &Path, track: &Path) -> Result<Prepared, String> {
    let truth = Truth::read(case, data)?;
    let (path, options) = (data.join(track), poses_options(case)?);
    let mut file = planwalk_io::trajectory::read(&path, &options).map_err(say("the track", track))?;
    let of_truth = case.truth.as_ref().and_then(|truth| planwalk_io::trajectory::times_beside(&data.join(truth)));
    if let (PosesFormat::Kitti, None, Some(times)) = (file.format, planwalk_io::trajectory::times_beside(&path), of_truth) {
        // KITTI's estimates are written without times: they are those of the truth.
        file = planwalk_io::trajectory::read_with_times(&path, &options, &times).map_err(say("the track", track))?;
    }
    let path = file.trajectory.to_path(&StepNoise::default());
    let walk = Walk { path, sightings: Vec::new(), scale: OdometryScale::Metric };
    let (mut scores, mut place) = (None, None);
    if case.plan.is_some() {
        let answer: Vec<Estimate> =
            file.trajectory.poses().iter().map(|(stamp, pose)| estimate(*stamp, Rigid3::<Plan, Body>::new(pose.iso).on_floor())).collect();
        let options = place_options(case.truth_gap_s, truth.faces);
        place = Some(evaluate::place::score(&answer, &[], &truth.on_floor, &options).map_err(|why| why.to_string())?);
    } else {
        scores = Some(truth.score_body(case, file.trajectory.poses())?);
    }
    let mut prepared = truth.prepared(case, walk, None, None, scores);
    prepared.place = place;
    Ok(prepared)
}

/// A pose without any claim of how sure it is.
fn estimate(stamp: Stamp, pose: PlanPose) -> Estimate {
    let covariance = nalgebra::Matrix3::zeros();
    Estimate { stamp, pose, covariance, radius95_m: 0.0, probability: 1.0, status: Status::Tracking, scale: None }
}

/// Where it truly went.
struct Truth {
    /// A body's poses, whatever the file is of.
    poses: Poses,
    on_floor: Vec<(Stamp, PlanPose)>,
    faces: bool,
}

impl Truth {
    fn read(case: &Case, data: &Path) -> Result<Self, String> {
        let path = case.truth.as_ref().ok_or("it has no truth")?;
        let frame: Option<PosesFrame> = named(case.truth_frame.as_deref())?;
        // As the file has them: the plan's world is not to be turned.
        let options = PosesOptions { frame: Some(PosesFrame::Body), fps: case.fps, ..PosesOptions::default() };
        let file = match &case.truth_scans_of {
            Some(raw) => planwalk_io::trajectory::read_with_times(&data.join(path), &options, &data.join(raw)),
            None => planwalk_io::trajectory::read(&data.join(path), &options),
        }
        .map_err(say("the truth", path))?;
        let of_camera = frame == Some(PosesFrame::Camera) || matches!(file.format, PosesFormat::Kitti | PosesFormat::Matrices);
        let shift = |stamp: Stamp| Stamp::from_secs(case.truth_offset_s).map_or(stamp, |by| Stamp(stamp.0.saturating_add(by.0)));
        let body = |iso: &nalgebra::Isometry3<f64>| if of_camera { Rigid3::<Plan, Cam>::new(*iso).body() } else { Rigid3::new(*iso) };
        let poses: Poses = file.trajectory.poses().iter().map(|(stamp, pose)| (shift(*stamp), body(&pose.iso))).collect();
        let on_floor = poses.iter().map(|(stamp, pose)| (*stamp, pose.on_floor())).collect();
        Ok(Self { poses, on_floor, faces: file.faces })
    }

    fn prepared(
        self,
        case: &Case,
        walk: Walk,
        plan: Option<FloorPlan>,
        odometry_s: Option<f64>,
        odometry: Option<OdometryScores>,
    ) -> Prepared {
        let options = place_options(case.truth_gap_s, self.faces);
        let units = scale::by_chords(&walk.path, &self.on_floor, &options.associate);
        Prepared { walk, plan, start: None, truth: self.on_floor, units, options, odometry_s, odometry, place: None }
    }

    /// A video's odometry, as that of its camera.
    fn score_camera(&self, case: &Case, odometry: &Odometry) -> Result<OdometryScores, String> {
        let cameras: Vec<_> = self.poses.iter().map(|(stamp, pose)| (*stamp, pose.camera())).collect();
        let seen: Vec<_> = odometry.poses.iter().map(|p| (p.stamp, p.odom_from_camera)).collect();
        self.score(case, &seen, &cameras, Alignment::Sim3)
    }

    /// A body's poses, on the floor where nothing else is said.
    fn score_body<A>(&self, case: &Case, poses: &[(Stamp, Rigid3<A, Body>)]) -> Result<OdometryScores, String> {
        self.score(case, poses, &self.poses, Alignment::Sim2)
    }

    fn score<A, B>(
        &self,
        case: &Case,
        estimate: &[(Stamp, Rigid3<A, B>)],
        truth: &[(Stamp, Rigid3<Plan, B>)],
        usual: Alignment,
    ) -> Result<OdometryScores, String> {
        let alignment = case.align.unwrap_or(usual);
        let options = OdometryScoreOptions { associate: associate(case.truth_gap_s), truth_faces: self.faces, ..Default::default() };
        evaluate::odometry::score(estimate, truth, alignment, &options).map_err(|why| format!("the odometry cannot be scored: {why}"))
    }
}

pub(super) fn associate(max_gap_s: Option<f64>) -> AssociateOptions {
    AssociateOptions { max_diff_s: MAX_DIFF_S, max_gap_s, ..AssociateOptions::default() }
}

pub(super) fn place_options(max_gap_s: Option<f64>, truth_faces: bool) -> PlaceOptions {
    PlaceOptions { associate: associate(max_gap_s), truth_faces, ..PlaceOptions::default() }
}

pub(super) fn plan(case: &Case, data: &Path) -> Result<Option<FloorPlan>, String> {
    let options = PlanOptions { metres_per_pixel: case.metres_per_pixel, ..PlanOptions::default() };
    let read = |file: &std::path::PathBuf| planwalk_io::plan::read(&data.join(file), &options).map_err(say("the plan", file));
    Ok(case.plan.as_ref().map(read).transpose()?.map(|file| file.plan))
}

pub(super) fn poses_options(case: &Case) -> Result<PosesOptions, String> {
    Ok(PosesOptions { format: named(case.poses_format.as_deref())?, frame: named(case.poses_frame.as_deref())?, fps: case.fps })
}

/// A format or a frame by its name, where one is given.
fn named<T: FromStr<Err = UnknownName>>(name: Option<&str>) -> Result<Option<T>, String> {
    name.map(str::parse).transpose().map_err(|why: UnknownName| why.to_string())
}

pub(super) fn say<'a, E: Display>(what: &'a str, path: &'a Path) -> impl FnOnce(E) -> String + 'a {
    move |why| format!("{what} cannot be used: {why} ({})", path.display())
}
