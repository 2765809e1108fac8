//! The main job: what was walked in the video, and where on the plan is that?

use planwalk_locate::{
    FilterView, Localization, Localizer, LocateError, LocateOptions, ReportOptions, ScalePrior, StartPrior, localize_by_report,
    localize_observed,
};
use planwalk_odometry::{FocalEstimate, LensSample, Odometry, OdometryError, OdometryOptions, VisualOdometry};
use planwalk_types::{Camera, FloorPlan, OdometryScale, Path, Plan, Pt2, Seed, Sighting, VideoFrame};
use serde::{Deserialize, Serialize};

use crate::figure::ParticleCloud;
use crate::film::Film;

/// What came of a video.
#[derive(Debug)]
pub struct Followed<E> {
    /// The odometry of all frames that came.
    pub odometry: Result<Odometry, OdometryError>,
    /// Frames that came.
    pub frames: usize,
    /// Why the video ended early, if it did.
    pub cut_short: Option<E>,
}

/// Visual odometry of a video, frame by frame. A source that fails ends the video there: what came before is kept.
///
/// `on_frame` is told how many frames are done.
pub fn follow<E>(
    frames: impl Iterator<Item = Result<VideoFrame, E>>,
    camera: &Camera,
    options: &OdometryOptions,
    on_frame: &mut dyn FnMut(usize),
) -> Followed<E> {
    let mut odometry = VisualOdometry::new(camera.clone(), *options);
    let (mut count, mut cut_short, mut refused) = (0, None, None);
    for frame in frames {
        match frame {
            Ok(frame) => match odometry.push(&frame) {
                Ok(_) => count += 1,
                // The first refusal explains an empty result; later frames may still be good.
                Err(why) => refused = refused.or(Some(why)),
            },
            Err(why) => {
                cut_short = Some(why);
                break;
            }
        }
        on_frame(count);
    }
    let odometry = odometry.finish().map_err(|why| if count == 0 { refused.unwrap_or(why) } else { why });
    Followed { odometry, frames: count, cut_short }
}

/// The focal length that a video shows, from its beginning; a source that fails ends the video there.
///
/// `on_frame` is told how many frames were looked at.
pub fn measure_lens<E>(
    frames: impl Iterator<Item = Result<VideoFrame, E>>,
    size: (usize, usize),
    seed: Seed,
    on_frame: &mut dyn FnMut(usize),
) -> FocalEstimate {
    let mut sample = LensSample::new(size.0, size.1);
    for (count, frame) in frames.map_while(Result::ok).enumerate() {
        sample.push(&frame);
        on_frame(count + 1);
        if sample.is_enough() {
            break;
        }
    }
    sample.estimate(seed)
}

/// A walk from any source: how the body moved, and what it saw.
#[derive(Debug, Clone)]
pub struct Walk {
    /// Steps on the floor, in the odometry's unit.
    pub path: Path,
    /// What was seen, same unit; may be empty.
    pub sightings: Vec<Sighting>,
    /// What is known of the metres in one unit.
    pub scale: OdometryScale,
}

impl From<&Odometry> for Walk {
    /// A single camera says nothing of metres; whoever carries it does.
    fn from(odometry: &Odometry) -> Self {
        let scale = OdometryScale::Relative(odometry.unit.relative_sigma);
        Self { path: odometry.path.clone(), sightings: odometry.sightings.clone(), scale }
    }
}

/// How a walk is localised.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Ours: walls bumped into and walls seen, scale in the state, several runs, a verdict.
    #[default]
    Planwalk,
    /// The recipe of Chu 2013, as the baseline to beat (see [`planwalk_locate::localize_by_report`]).
    Report,
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Planwalk => "planwalk",
            Self::Report => "report",
        })
    }
}

/// Options of [`localize`].
#[derive(Debug, Clone, Copy)]
pub struct LocalizeOptions {
    /// What chance grows from.
    pub seed: Seed,
    /// Where the walk began, if that is known.
    pub start: Option<StartPrior>,
    /// Which localiser.
    pub method: Method,
}

/// A localised walk.
#[derive(Debug, Clone)]
pub struct Run {
    /// Posterior, track, verdict.
    pub localization: Localization,
    /// The filter's particles at the moments that tell most (see [`crate::filmstrip`]), in time order.
    pub clouds: Vec<ParticleCloud>,
}

/// Most particles kept a moment.
const CLOUD_SIZE: usize = 3000;

/// Checks, before any long work, that the stated start is a place on this plan.
///
/// # Errors
/// [`LocateError::BadStart`] and [`LocateError::StartOffPlan`].
pub fn check_start(plan: &FloorPlan, options: &LocalizeOptions) -> Result<(), LocateError> {
    if options.start.is_none() {
        return Ok(());
    }
    // The scale plays no part in the check.
    let mut locate = LocateOptions::new(options.seed, ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.1 });
    locate.start = options.start;
    Localizer::new(plan, &locate).map(|_| ())
}

/// Where on the plan the walk was. `progress` is told the share done, 0..=1.
///
/// # Errors
/// [`LocateError`] when the walk or the start make no sense; not knowing the place is an answer, not an error.
pub fn localize(walk: &Walk, plan: &FloorPlan, options: &LocalizeOptions, progress: &mut dyn FnMut(f64)) -> Result<Run, LocateError> {
    if options.method == Method::Report {
        let report = ReportOptions { start: options.start, ..ReportOptions::new(options.seed) };
        let localization = localize_by_report(&walk.path, plan, &report, progress)?;
        return Ok(Run { localization, clouds: Vec::new() });
    }
    let mut locate = LocateOptions::new(options.seed, ScalePrior::of(walk.scale, &walk.path));
    locate.start = options.start;
    let mut of_runs: Vec<Film> = Vec::new();
    let localization = localize_observed(&walk.path, &walk.sightings, plan, &locate, progress, &mut |run, view| {
        of_runs.resize_with(of_runs.len().max(run + 1), Film::default);
        of_runs[run].push(cloud(view));
    })?;
    let clouds = of_runs.into_iter().nth(localization.quality.attempt).unwrap_or_default().into_clouds();
    Ok(Run { localization, clouds })
}

/// The particles as a picture wants them.
fn cloud(view: &FilterView<'_>) -> ParticleCloud {
    let places = thinned(view);
    // Ground in squares of half a metre.
    let mut squares: Vec<(i64, i64)> = places.iter().map(|p| ((2.0 * p.x).floor() as i64, (2.0 * p.y).floor() as i64)).collect();
    squares.sort_unstable();
    squares.dedup();
    let (mut weight, mut sum, mut square) = (0.0, 0.0, 0.0);
    // A few thousand give the scale to a fraction of its own spread.
    let stride = (view.x.len() / CLOUD_SIZE).max(1);
    for (log_scale, w) in view.log_scale.iter().zip(view.weight).step_by(stride) {
        let (log_scale, w) = (f64::from(*log_scale), f64::from(*w));
        (weight, sum, square) = (weight + w, sum + w * log_scale, square + w * log_scale * log_scale);
    }
    let mean = sum / weight.max(f64::MIN_POSITIVE);
    ParticleCloud {
        stamp: view.stamp,
        count: view.x.len(),
        places,
        area_m2: 0.25 * squares.len() as f64,
        modes: view.modes,
        status: view.status,
        metres_per_unit: mean.exp(),
        relative_sigma: (square / weight.max(f64::MIN_POSITIVE) - mean * mean).max(0.0).sqrt(),
    }
}

/// Particles at equal shares of the weight, at most [`CLOUD_SIZE`]: dots show belief, not bookkeeping.
fn thinned(view: &FilterView<'_>) -> Vec<Pt2<Plan>> {
    let total: f64 = view.weight.iter().map(|w| f64::from(*w)).sum();
    let apart = total / CLOUD_SIZE.min(view.x.len()).max(1) as f64;
    let (mut next, mut sum, mut places) = (0.5 * apart, 0.0, Vec::new());
    for ((x, y), weight) in view.x.iter().zip(view.y).zip(view.weight) {
        sum += f64::from(*weight);
        // A heavy particle is one dot, however many shares it holds.
        if sum > next && apart > 0.0 {
            places.push(Pt2::new(view.origin.x + f64::from(*x), view.origin.y + f64::from(*y)));
            next += apart * ((sum - next) / apart).ceil();
        }
    }
    places
}
