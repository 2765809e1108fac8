//! The main job: what was walked in the video, and where on the plan is that?

use planwalk_locate::{
    FilterView, Localization, Localizer, LocateError, LocateOptions, ReportOptions, ScalePrior, StartPrior, localize_by_report,
    localize_observed,
};
use planwalk_odometry::{Odometry, OdometryError, OdometryOptions, VisualOdometry};
use planwalk_types::{Camera, FloorPlan, OdometryScale, Path, Plan, Pt2, Seed, Sighting, Stamp, VideoFrame};
use serde::{Deserialize, Serialize};

use crate::figure::ParticleCloud;

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
    /// A single camera says nothing of metres.
    fn from(odometry: &Odometry) -> Self {
        Self { path: odometry.path.clone(), sightings: odometry.sightings.clone(), scale: OdometryScale::Unknown }
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
    /// The filter's particles at a few moments.
    pub clouds: Vec<ParticleCloud>,
}

/// Shares of the walk's time at which the particles are kept for the picture: most is decided early, at the first corners.
const CLOUD_MOMENTS: [f64; 4] = [0.0, 0.08, 0.25, 1.0];
/// Most particles kept a moment.
const CLOUD_SIZE: usize = 4000;

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
    let moments = cloud_moments(&walk.path);
    let mut of_runs: Vec<Vec<ParticleCloud>> = Vec::new();
    let localization = localize_observed(&walk.path, &walk.sightings, plan, &locate, progress, &mut |run, view| {
        of_runs.resize_with(of_runs.len().max(run + 1), Vec::new);
        let clouds = &mut of_runs[run];
        // The last view is kept up to date, because nobody knows which update is the last.
        let due = moments.get(clouds.len()).is_some_and(|m| view.stamp >= *m);
        if !due && clouds.len() < moments.len() {
            return;
        }
        if clouds.len() == moments.len() {
            clouds.pop();
        }
        clouds.push(ParticleCloud { stamp: view.stamp, count: view.x.len(), places: thinned(view) });
    })?;
    let clouds = of_runs.into_iter().nth(localization.quality.attempt).unwrap_or_default();
    Ok(Run { localization, clouds })
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

fn cloud_moments(path: &Path) -> Vec<Stamp> {
    let (Some(first), Some(last)) = (path.steps.first(), path.steps.last()) else { return Vec::new() };
    let span = last.to.0.saturating_sub(first.from.0);
    // The last moment is a hair early: the filter gathers steps and may never update at the very end.
    CLOUD_MOMENTS.map(|share| Stamp(first.from.0 + (0.97 * share * span as f64) as i64)).to_vec()
}
