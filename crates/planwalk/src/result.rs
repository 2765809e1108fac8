//! What does `result.json` say? The answer for programs; the schema is versioned.

use planwalk_locate::{Apart, ApartView, ContradictedKind, ContradictedWall, Going, Localization, Quality};
use planwalk_odometry::{Cue, Evidence, FrameQuality, Gap, Odometry};
use planwalk_types::{Camera, Estimate, Hypothesis, PlanPose, ScaleEstimate, Seed, Status, TrackingState};
use serde::{Deserialize, Serialize};

/// Name and version of the schema. A field may be added under the same number; what changes or goes raises it.
pub const SCHEMA: &str = "planwalk-result/1";

/// The whole of `result.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResultFile {
    /// [`SCHEMA`].
    pub schema: String,
    /// Version of the program.
    pub version: String,
    /// Which command wrote it.
    pub command: String,
    /// What chance grew from.
    pub seed: Seed,
    /// The verdict at the end; absent where nothing was localised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub status: Option<Status>,
    /// What explains the walk, likeliest first.
    pub hypotheses: Vec<HypothesisEntry>,
    /// Metres per unit of odometry.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<ScaleEstimate>,
    /// How well the answer holds up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quality: Option<QualityEntry>,
    /// Drawn walls that the walk went or saw through.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contradicted: Vec<ContradictedEntry>,
    /// What would tell the likeliest place from each other one, where the verdict is ambiguous.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub apart: Vec<ApartEntry>,
    /// The video's odometry, where there was a video.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry: Option<OdometryEntry>,
    /// Where the path fits (`planwalk place`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placement: Option<PlacementEntry>,
    /// The camera and where its numbers come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// What went in.
    pub inputs: Vec<InputEntry>,
    /// Stretches of video in which nothing usable was seen.
    pub gaps: Vec<GapEntry>,
    /// Options in force, named as on the command line.
    #[serde(default)]
    pub options: Vec<OptionEntry>,
    /// What a person should know: assumptions made, oddities met.
    pub notes: Vec<String>,
    /// Why there is no answer, where there is none; what was found before that is in the other fields and files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// How far off the truth is, where it is known (`planwalk demo`).
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub truth: Option<TruthEntry>,
}

/// An option in force.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OptionEntry {
    /// Without the dashes.
    pub name: String,
    /// As it could be given.
    pub value: String,
}

/// One place that explains the walk.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HypothesisEntry {
    /// Share of the whole mass, 0..=1.
    pub probability: f64,
    /// Where the walk ended.
    pub pose: PoseEntry,
    /// Where the walk began.
    pub start: PoseEntry,
    /// Covariance of (x, y, heading) at the end, row by row: m², m·rad, rad².
    pub covariance: [f64; 9],
    /// Radius that holds 95 % of its mass at the end, metres.
    pub radius95_m: f64,
    /// Metres per unit of odometry here.
    pub scale: ScaleEstimate,
}

/// A pose on the plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseEntry {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Radians, anticlockwise from +x.
    pub yaw_rad: f64,
}

/// How well the answer holds up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QualityEntry {
    /// Share of the sightings that drawn walls explain along the track.
    pub seen_explained: f64,
    /// Share of the sightings whose ray goes through a drawn wall.
    pub seen_through_walls: f64,
    /// Sightings used.
    pub seen: usize,
    /// How often the track enters a wall.
    pub wall_crossings: usize,
    /// Steps of the path.
    pub steps: usize,
    /// Most particles at any time.
    pub particles_max: usize,
    /// Particles at the end.
    pub particles_end: usize,
    /// Nats by which the track beats calling everything seen furniture.
    pub score_nats: f64,
    /// Independent runs over the walk.
    pub attempts: usize,
    /// How far off the plan draws walls, metres, one standard deviation; absent where too little was seen on walls.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plan_sigma_m: Option<f64>,
}

/// A drawn wall that the walk contradicts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContradictedEntry {
    /// How.
    pub kind: ContradictedKindEntry,
    /// Where, metres.
    pub x_m: f64,
    /// Where, metres.
    pub y_m: f64,
    /// Extent of what was seen through, metres; 0 for a crossing.
    pub length_m: f64,
    /// How often the walk goes through.
    pub times_crossed: usize,
    /// How sure that is, 0..=1.
    pub confidence: f64,
    /// Looks that go through.
    pub rays_through: usize,
    /// Looks that end there.
    pub rays_ending: usize,
}

/// How a wall is contradicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContradictedKindEntry {
    /// The walk goes through it.
    Crossed,
    /// What is behind it was seen.
    SeenThrough,
}

/// What would tell two hypotheses apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ApartEntry {
    /// The hypotheses, counted from 0 in `hypotheses`.
    pub hypotheses: [usize; 2],
    /// Which way to go on: `straight`, `left` or `right`; absent where nothing within reach tells them apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub go: Option<String>,
    /// How far, metres.
    pub distance_m: f64,
    /// Where to look then: radians anticlockwise from ahead.
    pub direction_rad: f64,
    /// What is there at the first, in words.
    pub at_first: String,
    /// And at the second.
    pub at_second: String,
}

/// The video's odometry in figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OdometryEntry {
    /// Frames followed.
    pub frames: usize,
    /// Seconds from the first to the last.
    pub seconds: f64,
    /// Length of the path, units.
    pub length: f64,
    /// Points of the map seen from keyframes.
    pub sightings: usize,
    /// Solver of the relative pose.
    pub solver: SolverEntry,
    /// Standard deviation of the logarithm of a unit's metres, before the plan is looked at; its median is 1.
    #[serde(default)]
    pub unit_sigma: f64,
    /// What of the walking body says so.
    #[serde(default)]
    pub unit_evidence: Vec<EvidenceEntry>,
    /// How well the video was followed, second by second.
    #[serde(default)]
    pub quality: Vec<SecondEntry>,
}

/// How well a second of video was followed: means over its frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SecondEntry {
    /// Its beginning, seconds after the first frame.
    pub from_s: f64,
    /// Share of its frames that were posed on the map.
    pub mapped: f64,
    /// Points followed.
    pub points: f64,
    /// Share of the map's points in view that contradict the camera's motion: people, doors, reflections, slips.
    pub movers: f64,
    /// How fast points at a usual distance go by, the camera's turn aside, degrees a second.
    pub parallax_deg_s: f64,
    /// Steepness of the picture at full size over that at a quarter: 0.6 to 1 if sharp, half of that if smeared over ten pixels.
    pub sharpness: f64,
    /// Standard deviation of the direction of gravity, degrees.
    pub tilt_sigma_deg: f64,
    /// Standard deviation of a frame's turn against the map around it, an axis, degrees.
    #[serde(default)]
    pub turn_sigma_deg: f64,
    /// Standard deviation of a frame's position against the map around it, an axis, in the path's unit.
    #[serde(default)]
    pub shift_sigma: f64,
}

impl SecondEntry {
    /// Of each second of a clip; one without frames is left out.
    pub fn of(odometry: &Odometry) -> Vec<Self> {
        let Some(first) = odometry.poses.first() else { return Vec::new() };
        let frames: Vec<(i64, bool, &FrameQuality)> = (odometry.poses.iter().zip(&odometry.quality))
            .map(|(pose, quality)| (pose.stamp.secs_since(first.stamp).floor() as i64, pose.state == TrackingState::Mapped, quality))
            .collect();
        frames.chunk_by(|a, b| a.0 == b.0).map(Self::mean).collect()
    }

    fn mean(frames: &[(i64, bool, &FrameQuality)]) -> Self {
        let mean = |of: &dyn Fn(bool, &FrameQuality) -> f64| frames.iter().map(|f| of(f.1, f.2)).sum::<f64>() / frames.len() as f64;
        Self {
            from_s: frames[0].0 as f64,
            mapped: mean(&|mapped, _| f64::from(u8::from(mapped))),
            points: mean(&|_, q| q.points as f64),
            movers: mean(&|_, q| q.movers),
            parallax_deg_s: mean(&|_, q| q.parallax_rad_s.to_degrees()),
            sharpness: mean(&|_, q| q.sharpness),
            tilt_sigma_deg: mean(&|_, q| q.tilt_sigma_rad.to_degrees()),
            turn_sigma_deg: mean(&|_, q| q.turn_sigma_rad.to_degrees()),
            shift_sigma: mean(&|_, q| q.shift_sigma),
        }
    }
}

/// What says how long a unit of odometry is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EvidenceEntry {
    /// Which cue.
    pub cue: CueEntry,
    /// What was measured: units, steps a second, units a second.
    pub measured: f64,
    /// Metres in a unit by this cue alone.
    pub metres_per_unit: f64,
    /// Standard deviation of its logarithm.
    pub relative_sigma: f64,
}

/// What of a walking body speaks for a length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CueEntry {
    /// Height of the camera over the floor.
    CameraHeight,
    /// Steps a second.
    Gait,
    /// Usual speed.
    WalkingSpeed,
}

impl From<&Evidence> for EvidenceEntry {
    fn from(evidence: &Evidence) -> Self {
        let cue = match evidence.cue {
            Cue::CameraHeight => CueEntry::CameraHeight,
            Cue::Gait => CueEntry::Gait,
            Cue::WalkingSpeed => CueEntry::WalkingSpeed,
        };
        let Evidence { measured, metres_per_unit, relative_sigma, .. } = *evidence;
        Self { cue, measured, metres_per_unit, relative_sigma }
    }
}

/// Solver of the relative pose between two views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverEntry {
    /// Nistér's.
    FivePoint,
    /// Hartley's.
    EightPoint,
}

/// Where a path fits without hitting a wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlacementEntry {
    /// Area of the possible starts, m².
    pub area_m2: f64,
    /// Headings times scales that were tried.
    pub tried: usize,
    /// Separate places, largest first.
    pub modes: Vec<PlacementModeEntry>,
    /// Area of the possible ends, m².
    #[serde(default)]
    pub end_area_m2: f64,
    /// Separate places of the end, largest first.
    #[serde(default)]
    pub end_modes: Vec<EndModeEntry>,
}

/// One place where a path can end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EndModeEntry {
    /// An end there.
    pub end: PoseEntry,
    /// Metres per unit of the path.
    pub metres_per_unit: f64,
    /// Share of all placements.
    pub share: f64,
}

/// One place where a path fits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlacementModeEntry {
    /// A start there.
    pub start: PoseEntry,
    /// Metres per unit of the path.
    pub metres_per_unit: f64,
    /// Share of all placements.
    pub share: f64,
}

/// A file or folder that went in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputEntry {
    /// What it was used as.
    pub role: String,
    /// The path as it was given.
    pub path: String,
    /// SHA-256 of its bytes; of a folder, over names and contents.
    pub sha256: String,
}

/// A stretch of video in which nothing usable was seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GapEntry {
    /// Seconds on the video's clock.
    pub from_s: f64,
    /// Seconds on the video's clock.
    pub to_s: f64,
    /// What was missing.
    pub cause: String,
}

/// How far off the truth is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TruthEntry {
    /// Distance at the end, metres.
    pub truth_end_error_m: f64,
    /// Median distance over the walk, metres.
    pub truth_median_error_m: f64,
    /// Whether the true end lies in the 95 % region.
    pub truth_in_region95: bool,
}

impl ResultFile {
    /// A result that says nothing yet.
    pub fn new(command: &str, seed: Seed) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: command.to_owned(),
            seed,
            status: None,
            hypotheses: Vec::new(),
            scale: None,
            quality: None,
            contradicted: Vec::new(),
            apart: Vec::new(),
            odometry: None,
            placement: None,
            camera: None,
            inputs: Vec::new(),
            gaps: Vec::new(),
            options: Vec::new(),
            notes: Vec::new(),
            error: None,
            truth: None,
        }
    }

    /// Takes in a localisation.
    pub fn set_localization(&mut self, found: &Localization) {
        self.status = Some(found.status);
        self.hypotheses = found.hypotheses.iter().map(HypothesisEntry::from).collect();
        self.scale = Some(found.scale);
        self.quality = Some(QualityEntry::from(&found.quality));
        self.contradicted = found.contradicted.iter().map(ContradictedEntry::from).collect();
        self.apart = found.apart.iter().map(ApartEntry::from).collect();
    }

    /// Pretty JSON with a newline at the end.
    pub fn to_json(&self) -> String {
        // Every field is a number, a string or a list of them: nothing here can fail to be written.
        serde_json::to_string_pretty(self).map(|text| text + "\n").unwrap_or_default()
    }
}

impl From<&PlanPose> for PoseEntry {
    fn from(pose: &PlanPose) -> Self {
        Self { x_m: pose.x, y_m: pose.y, yaw_rad: pose.heading_rad }
    }
}

impl From<&Hypothesis> for HypothesisEntry {
    fn from(h: &Hypothesis) -> Self {
        let start = h.track.first().map_or(&h.pose, |(_, pose)| pose);
        Self {
            probability: h.probability,
            pose: PoseEntry::from(&h.pose),
            start: PoseEntry::from(start),
            covariance: std::array::from_fn(|i| h.covariance[(i / 3, i % 3)]),
            radius95_m: h.radius95_m,
            scale: h.scale,
        }
    }
}

impl From<&Quality> for QualityEntry {
    fn from(q: &Quality) -> Self {
        Self {
            seen_explained: q.seen_explained,
            seen_through_walls: q.seen_through_walls,
            seen: q.seen,
            wall_crossings: q.wall_crossings,
            steps: q.steps,
            particles_max: q.particles_max,
            particles_end: q.particles_end,
            score_nats: q.score_nats,
            attempts: q.attempts,
            plan_sigma_m: q.plan_sigma_m,
        }
    }
}

impl From<&ContradictedWall> for ContradictedEntry {
    fn from(wall: &ContradictedWall) -> Self {
        let kind = match wall.kind {
            ContradictedKind::Crossed => ContradictedKindEntry::Crossed,
            ContradictedKind::SeenThrough => ContradictedKindEntry::SeenThrough,
        };
        Self {
            kind,
            x_m: wall.place.x,
            y_m: wall.place.y,
            length_m: wall.length_m,
            times_crossed: wall.crossed,
            confidence: wall.confidence,
            rays_through: wall.through,
            rays_ending: wall.ending,
        }
    }
}

impl From<&Apart> for ApartEntry {
    fn from(apart: &Apart) -> Self {
        let seen = |view: &ApartView| match view {
            ApartView::Wall(distance) => format!("a wall {distance:.1} m off"),
            ApartView::Door => "a door".to_owned(),
            ApartView::Open(distance) => format!("open for {distance:.0} m and more"),
        };
        let go = apart.going.map(|going| match going {
            Going::Straight => "straight",
            Going::Left => "left",
            Going::Right => "right",
        });
        Self {
            hypotheses: [apart.first, apart.second],
            go: go.map(str::to_owned),
            distance_m: apart.after_m,
            direction_rad: apart.look_rad,
            at_first: seen(&apart.at_first),
            at_second: seen(&apart.at_second),
        }
    }
}

impl From<&Gap> for GapEntry {
    fn from(gap: &Gap) -> Self {
        Self { from_s: gap.from.as_secs(), to_s: gap.to.as_secs(), cause: gap.cause.clone() }
    }
}

/// Length of a track on the plan, metres.
pub fn length_m(track: &[Estimate]) -> f64 {
    track.windows(2).map(|pair| pair[0].pose.origin().distance(pair[1].pose.origin())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clip_is_told_second_by_second() {
        let pose = |tenths: i64| planwalk_types::CameraPose {
            stamp: planwalk_types::Stamp(tenths * 100_000_000),
            odom_from_camera: planwalk_types::Rigid3::identity(),
            state: if tenths < 15 { TrackingState::Mapped } else { TrackingState::Propagated },
            inliers: 0,
        };
        let poses: Vec<_> = (0..20).chain(40..45).map(pose).collect();
        let quality = (0..poses.len()).map(|i| FrameQuality { points: i, ..FrameQuality::default() }).collect();
        let unit = planwalk_odometry::MetricScale { metres_per_unit: 1.0, relative_sigma: 0.1, evidence: Vec::new() };
        let path = planwalk_types::Path { steps: Vec::new() };
        let seconds = SecondEntry::of(&Odometry { poses, path, sightings: Vec::new(), gaps: Vec::new(), quality, unit });
        let told: Vec<_> = seconds.iter().map(|s| (s.from_s, s.mapped, s.points)).collect();
        assert_eq!(told, [(0.0, 1.0, 4.5), (1.0, 0.5, 14.5), (4.0, 0.0, 22.0)], "two seconds in which nothing was filmed are left out");
    }

    #[test]
    fn a_result_reads_back_as_it_was_written() {
        let mut result = ResultFile::new("demo", Seed(7));
        result.status = Some(Status::Ambiguous);
        result.notes.push("a \"note\" with <signs>".to_owned());
        result.truth = Some(TruthEntry { truth_end_error_m: 0.25, truth_median_error_m: 0.125, truth_in_region95: true });
        let text = result.to_json();
        assert_eq!(serde_json::from_str::<ResultFile>(&text).unwrap(), result);
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!((value["schema"].as_str(), value["status"].as_str()), (Some(SCHEMA), Some("ambiguous")));
        assert_eq!(value["truth_end_error_m"].as_f64(), Some(0.25));
    }
}
