//! Which walks does a bench walk? Suites in TOML: data, plan, what is known beforehand, seeds, noise.
//!
//! A case is one walk, or a family of simulated ones; a job is one walk with one seed. Paths are relative to the data folder.

use std::path::PathBuf;

use planwalk::Method;
use planwalk::bench::{Target, metric};
use planwalk::evaluate::Alignment;
use planwalk::types::{OdometryScale, Seed};
use planwalk_sim::{OdometryNoise, SceneOptions, WalkOptions};
use serde::Deserialize;

use crate::args::odometry_scale;
use crate::failure::Failure;

/// The suites that come along, by name.
const SHIPPED: [(&str, &str); 6] = [
    ("smoke", include_str!("../../suites/smoke.toml")),
    ("sim", include_str!("../../suites/sim.toml")),
    ("locate", include_str!("../../suites/locate.toml")),
    ("real", include_str!("../../suites/real.toml")),
    ("odometry", include_str!("../../suites/odometry.toml")),
    ("speed", include_str!("../../suites/speed.toml")),
];

/// What a bench walks.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Its name.
    pub name: String,
    /// One line for people.
    pub about: String,
    /// Seeds of each case that says nothing else.
    #[serde(default = "one")]
    pub seeds: u64,
    /// Whether jobs share the machine; where time is measured they must not.
    #[serde(default = "yes")]
    pub parallel: bool,
    /// Localisers that walk it, where the command line names none; else all.
    #[serde(default)]
    pub methods: Vec<Method>,
    /// Columns of its table, by their heads; else the usual ones.
    #[serde(default)]
    pub columns: Vec<String>,
    /// What is to be reached, by the first of its methods.
    #[serde(default, rename = "target")]
    pub targets: Vec<Target>,
    /// The walks.
    #[serde(rename = "case")]
    pub cases: Vec<Case>,
}

fn one() -> u64 {
    1
}

fn yes() -> bool {
    true
}

/// One walk, or a family of simulated ones. Exactly one of `video`, `poses`, `along`, `track` and `simulate` says where it
/// comes from.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name; unique in the suite.
    pub name: String,
    /// Row of the table that it counts in; its name, where nothing is said.
    pub group: Option<String>,
    /// Seeds, where not the suite's.
    pub seeds: Option<u64>,
    /// A video: file, or folder of images.
    pub video: Option<PathBuf>,
    /// Frames per second of a folder of images.
    pub fps: Option<f64>,
    /// The video's camera.
    pub camera: Option<PathBuf>,
    /// A path from elsewhere.
    pub poses: Option<PathBuf>,
    /// A true path along which odometry and sightings are simulated, with [`Case::noise`].
    pub along: Option<PathBuf>,
    /// Somebody else's answer: a trajectory, scored as it is.
    pub track: Option<PathBuf>,
    /// A generated building and walks through it.
    pub simulate: Option<Simulate>,
    /// Format of `poses` or `track`, where its content does not say.
    pub poses_format: Option<String>,
    /// Frame of `poses`, `along` or `track`: body or camera.
    pub poses_frame: Option<String>,
    /// What the localiser is told of the metres in a unit of `poses`, or of simulated odometry, as on the command line.
    pub odometry_scale: Option<String>,
    /// Sightings to go with `poses`.
    pub sightings: Option<PathBuf>,
    /// Whether the localiser is kept from what was seen: odometry and walls only.
    #[serde(default)]
    pub blind: bool,
    /// Whether the walker is carried elsewhere half-way, unfelt by the odometry, and walks on there: on another walk through the
    /// same building, or earlier on the path that `along` gives.
    #[serde(default)]
    pub kidnap: bool,
    /// How simulated odometry errs; else as a hand-held camera does.
    pub noise: Option<OdometryNoise>,
    /// The plan; without one, only the odometry is scored.
    pub plan: Option<PathBuf>,
    /// Metres in a pixel of the plan's image.
    pub metres_per_pixel: Option<f64>,
    /// Where it truly went. Not needed where the simulator knows.
    pub truth: Option<PathBuf>,
    /// The raw log whose scans the truth, a corrected log, shares: the truth takes its stamps.
    pub truth_scans_of: Option<PathBuf>,
    /// Frame of the truth: body or camera.
    pub truth_frame: Option<String>,
    /// Added to the truth's stamps, seconds.
    #[serde(default)]
    pub truth_offset_s: f64,
    /// A truth this coarse is interpolated, seconds.
    pub truth_gap_s: Option<f64>,
    /// Whether only the odometry is scored, though there is a plan.
    #[serde(default)]
    pub tracking_only: bool,
    /// Whether the localiser is told where the walk begins (within half a metre and 10°).
    #[serde(default)]
    pub start_known: bool,
    /// Alignment of the odometry with the truth: se2, sim2, se3 or sim3.
    pub align: Option<Alignment>,
}

/// A family of simulated walks.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simulate {
    /// Buildings.
    #[serde(default = "one")]
    pub buildings: u64,
    /// Walks through each.
    #[serde(default = "one")]
    pub walks: u64,
    /// Whether pictures are drawn, and the odometry made from them; else the odometry is simulated.
    #[serde(default)]
    pub render: bool,
    /// Poses a second of simulated odometry.
    #[serde(default = "five")]
    pub odometry_hz: f64,
    /// Whether the walker has every habit that real ones have ([`WalkOptions::lively`]); of `scene.walk` only the duration then
    /// counts.
    #[serde(default)]
    pub lively: bool,
    /// Metres to walk; the walk then takes as long as that needs, and `scene.walk.duration_s` says only with which to try.
    pub length_m: Option<f64>,
    /// Building, walker, camera.
    #[serde(default)]
    pub scene: SceneOptions,
}

impl Simulate {
    /// The scene with this seed.
    pub fn scene(&self, seed: Seed) -> SceneOptions {
        let walk =
            if self.lively { WalkOptions { duration_s: self.scene.walk.duration_s, ..WalkOptions::lively() } } else { self.scene.walk };
        SceneOptions { seed, walk, ..self.scene.clone() }
    }

    fn check(&self) -> Result<(), String> {
        let usual = WalkOptions { duration_s: self.scene.walk.duration_s, ..WalkOptions::default() };
        if self.lively && self.scene.walk != usual {
            return Err("a lively walker has its own habits: of scene.walk, say duration_s only".to_owned());
        }
        if !(self.odometry_hz > 0.0 && self.odometry_hz <= 1000.0) {
            return Err(format!("{} poses a second is no rate: give more than 0 and at most 1000", self.odometry_hz));
        }
        match self.length_m {
            Some(_) if self.render => Err("a filmed walk ends by its time: length_m is for simulated odometry".to_owned()),
            Some(length_m) if !(length_m > 0.0 && length_m <= 2000.0) => {
                Err(format!("{length_m} m is no length of a walk: give more than 0 and at most 2000"))
            }
            _ => Ok(()),
        }
    }
}

fn five() -> f64 {
    5.0
}

/// One walk with one seed.
#[derive(Debug, Clone)]
pub struct Job<'a> {
    /// What it is of.
    pub case: &'a Case,
    /// Case, and where it has several, which building and which walk.
    pub name: String,
    /// Seed of the localiser, and of whatever is simulated.
    pub seed: u64,
    /// Which building and which walk through it, of simulated ones.
    pub of: Option<(u64, u64)>,
}

impl Suite {
    /// A shipped suite by its name, or one from a file.
    pub fn open(name: &str) -> Result<Self, Failure> {
        let shipped = SHIPPED.iter().find(|(known, _)| *known == name);
        let path = PathBuf::from(name);
        let text = match shipped {
            Some((_, text)) => (*text).to_owned(),
            None => std::fs::read_to_string(&path).map_err(|why| {
                let known: Vec<&str> = SHIPPED.iter().map(|(name, _)| *name).collect();
                let hint = format!("{why}; shipped suites are {}, anything else is a TOML file", known.join(", "));
                Failure::input("the suite", hint, &path)
            })?,
        };
        let suite: Self = toml::from_str(&text).map_err(|why| Failure::input("the suite", why, &path))?;
        suite.check().map_err(|why| Failure::input("the suite", why, &path))?;
        Ok(suite)
    }

    /// What no reader of TOML can see.
    fn check(&self) -> Result<(), String> {
        for (index, case) in self.cases.iter().enumerate() {
            if self.cases[..index].iter().any(|other| other.name == case.name) {
                return Err(format!("two cases are called \"{}\"", case.name));
            }
            case.check().map_err(|why| format!("case \"{}\": {why}", case.name))?;
        }
        if let Some(column) = self.columns.iter().find(|column| metric::named(column).is_none()) {
            let known: Vec<String> = metric::METRICS.iter().map(|m| format!("\"{}\"", m.head)).collect();
            return Err(format!("there is no column \"{column}\"; there are: {}", known.join(", ")));
        }
        let groups = || self.cases.iter().map(Case::group);
        self.targets.iter().try_for_each(|target| target.check(groups())).map_err(|why| why.to_string())?;
        if self.cases.is_empty() { Err("it has no cases".to_owned()) } else { Ok(()) }
    }

    /// Every walk with every seed, in order.
    pub fn jobs(&self, seeds: Option<u64>) -> Vec<Job<'_>> {
        let mut jobs = Vec::new();
        for case in &self.cases {
            let family = case.simulate.as_ref().map_or((1, 1), |s| (s.buildings, s.walks));
            let of_case = if case.track.is_some() { 1 } else { seeds.or(case.seeds).unwrap_or(self.seeds) };
            for building in 0..family.0 {
                for walk in 0..family.1 {
                    let simulated = case.simulate.is_some();
                    let name = if simulated { format!("{}/{building}/{walk}", case.name) } else { case.name.clone() };
                    let job = |seed| Job { case, name: name.clone(), seed, of: simulated.then_some((building, walk)) };
                    jobs.extend((0..of_case).map(job));
                }
            }
        }
        jobs
    }
}

impl Case {
    /// Row of the table that it counts in.
    pub fn group(&self) -> &str {
        self.group.as_deref().unwrap_or(&self.name)
    }

    /// What is known of the metres in a unit of its odometry.
    pub fn scale(&self) -> Result<OdometryScale, String> {
        self.odometry_scale.as_deref().map_or(Ok(OdometryScale::Unknown), odometry_scale)
    }

    fn check(&self) -> Result<(), String> {
        let sources = [
            ("video", self.video.is_some()),
            ("poses", self.poses.is_some()),
            ("along", self.along.is_some()),
            ("track", self.track.is_some()),
            ("simulate", self.simulate.is_some()),
        ];
        let given: Vec<&str> = sources.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
        if given.len() != 1 {
            let got = if given.is_empty() { "none".to_owned() } else { given.join(" and ") };
            return Err(format!("give exactly one of video, poses, along, track and simulate, not {got}"));
        }
        if self.truth.is_none() && self.simulate.is_none() && self.along.is_none() {
            return Err("it has no truth".to_owned());
        }
        if self.truth_scans_of.is_some() && (self.truth.is_none() || self.truth_frame.is_some()) {
            return Err("truth_scans_of goes with a truth that is a robot's corrected log, of the body".to_owned());
        }
        if self.along.is_some() && self.plan.is_none() {
            return Err("odometry along a path needs a plan to see".to_owned());
        }
        let drawn = self.simulate.as_ref().is_some_and(|s| s.render);
        if self.odometry_scale.is_some() && (self.video.is_some() || drawn || self.track.is_some()) {
            return Err("a video's unit is unknown, and a track is in metres: leave odometry_scale out".to_owned());
        }
        if self.kidnap && (self.along.is_none() && self.simulate.is_none() || drawn) {
            return Err("only a walker whose odometry is simulated can be kidnapped: along, or simulate without render".to_owned());
        }
        if let Some(simulate) = &self.simulate {
            simulate.check()?;
        }
        if let Some([low, high]) = self.noise.and_then(|noise| noise.scale_range)
            && !(low > 0.0 && low <= high && high.is_finite())
        {
            return Err(format!("a unit between {low} and {high} times its median is none: give two numbers above 0, in order"));
        }
        self.scale().map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_suites_that_come_along_are_sound() {
        for (name, _) in SHIPPED {
            let suite = Suite::open(name).unwrap_or_else(|why| panic!("{name}: {}", why.message));
            assert_eq!(suite.name, name);
            assert!(!suite.jobs(None).is_empty() && suite.jobs(Some(2)).len() >= suite.cases.len());
        }
    }

    #[test]
    fn the_sim_suite_has_ten_walks_through_twenty_buildings() {
        let suite = Suite::open("sim").unwrap();
        let of = |s: &Simulate| (s.buildings, s.walks);
        let families: Vec<(u64, u64)> = suite.cases.iter().filter_map(|c| c.simulate.as_ref().map(of)).collect();
        assert!(families.iter().map(|f| f.0).sum::<u64>() >= 20 && families.iter().all(|f| f.1 >= 10), "{families:?}");
    }

    #[test]
    fn targets_of_localisation_rest_on_enough_walks() {
        let suite = Suite::open("locate").unwrap();
        let jobs = suite.jobs(None);
        for target in &suite.targets {
            let walks = jobs.iter().filter(|job| target.group == "all" || job.case.group() == target.group).count();
            assert!(walks >= 20, "{}: {walks} walks", target.group);
        }
        let covered = Suite::open("sim").unwrap();
        assert!(covered.jobs(None).len() >= 200 && covered.targets.iter().any(|t| t.group == "all" && t.metric.contains("90 %")));
    }

    #[test]
    fn what_makes_no_sense_is_named() {
        let refused = |text: &str| toml::from_str::<Suite>(text).map_err(|e| e.to_string()).and_then(|s| s.check()).unwrap_err();
        let head = "name = \"x\"\nabout = \"y\"\n[[case]]\nname = \"a\"\n";
        assert!(refused(head).contains("exactly one of video"));
        assert!(refused(&format!("{head}poses = \"p\"\nvideo = \"v\"\ntruth = \"t\"")).contains("video and poses"));
        assert!(refused(&format!("{head}poses = \"p\"")).contains("no truth"));
        let camera = format!("{head}poses = \"p\"\ntruth = \"t\"\ntruth_scans_of = \"r\"\ntruth_frame = \"camera\"");
        assert!(refused(&camera).contains("corrected log"));
        let simulated = format!("{head}[case.simulate]\n");
        assert!(refused(&format!("{simulated}odometry_hz = 0")).contains("no rate"));
        assert!(refused(&format!("{simulated}lively = true\n[case.simulate.scene.walk]\nspeed_mps = 1.0")).contains("duration_s only"));
        assert!(refused(&format!("{head}kidnap = true\nposes = \"p\"\ntruth = \"t\"")).contains("kidnapped"));
        assert!(refused(&format!("{head}kidnap = true\n[case.simulate]\nrender = true")).contains("kidnapped"));
        assert!(refused(&format!("{simulated}render = true\nlength_m = 20")).contains("length_m"));
        assert!(refused(&format!("{simulated}length_m = -1")).contains("-1 m is no length"));
        assert!(refused(&format!("{head}odometry_scale = \"0.3\"\nvideo = \"v\"\ntruth = \"t\"")).contains("odometry_scale"));
        assert!(refused(&format!("{head}noise = {{ scale_range = [2.0, 1.0] }}\n[case.simulate]")).contains("in order"));
        assert!(refused(&format!("columns = [\"gold\"]\n{simulated}")).contains("gold"));
        let target = "[[target]]\nmetric = \"end right %\"\ngroup = \"b\"\nat_least = 1\n";
        assert!(refused(&format!("{simulated}{target}")).contains("no walks are called so"));
        assert!(refused(&format!("{head}possess = \"p\"")).contains("possess"));
        assert!(refused(&format!("{head}poses = \"p\"\ntruth = \"t\"\nodometry_scale = \"feet\"")).contains("metric"));
    }
}
