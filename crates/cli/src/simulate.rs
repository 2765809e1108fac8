//! What scene is meant? A file of options, what is said beside it, and a plan or a path from elsewhere.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use planwalk::types::{Body, Cam, Plan, Rigid3, Seed};
use planwalk_io::trajectory::{PosesFormat, PosesFrame, PosesOptions};
use planwalk_sim::{
    Building, BuildingOptions, CameraOptions, Lens, Look, OdometryNoise, People, PlanWorldOptions, Scene, SceneOptions, SimError, Walk,
    WalkOptions,
};
use serde::{Deserialize, Serialize};

use crate::args::{NoiseName, SimArgs, SimKind};
use crate::failure::Failure;
use crate::inputs;

/// Seeds tried before a building is said to have no walk.
const TRIES: u64 = 8;

/// Everything that can be said of a scene: `scene.toml`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneFile {
    /// What everything grows from.
    pub seed: u64,
    /// The building, where it is generated.
    pub building: BuildingOptions,
    /// The building, where a plan is built.
    pub built_plan: PlanWorldOptions,
    /// The walker.
    pub walk: WalkOptions,
    /// The camera.
    pub camera: CameraOptions,
    /// Texture and furniture.
    pub look: Look,
    /// Who else walks there.
    pub people: People,
    /// How simulated odometry errs.
    pub noise: Option<OdometryNoise>,
}

impl SceneFile {
    /// The file where one is given, and what is said beside it.
    pub fn of(args: &SimArgs) -> Result<Self, Failure> {
        let mut file = match &args.scene {
            Some(path) => {
                let text = std::fs::read_to_string(path).map_err(|why| Failure::input("the scene", why, path))?;
                toml::from_str(&text).map_err(|why| Failure::input("the scene", why, path))?
            }
            None => Self::default(),
        };
        if args.lively {
            file.walk = WalkOptions { duration_s: file.walk.duration_s, ..WalkOptions::lively() };
        }
        if args.phone {
            let CameraOptions { width, height, calibration, .. } = file.camera;
            file.camera = CameraOptions { width, height, calibration, ..CameraOptions::phone() };
        }
        set(&mut file.seed, args.common.seed);
        set(&mut file.building.kind, args.building);
        if let Some((width_m, depth_m)) = args.size {
            (file.building.width_m, file.building.depth_m) = (Some(width_m), Some(depth_m));
        }
        for lies in [&mut file.building.lies, &mut file.built_plan.lies] {
            set(&mut lies.missing_share, args.missing_walls);
            set(&mut lies.extra_count, args.extra_walls);
        }
        set(&mut file.walk.duration_s, args.duration);
        if args.fisheye {
            file.camera.lens = Lens::Fisheye;
        }
        set(&mut file.camera.fov_deg, args.fov);
        set(&mut file.camera.fps, args.fps);
        if let Some((width, height)) = args.resolution {
            (file.camera.width, file.camera.height) = (width, height);
        }
        if let Some(path) = &args.camera {
            let camera = planwalk_io::camera::read(path).map_err(|why| Failure::input("the camera file", why, path))?;
            file.camera.calibration = Some(camera);
        }
        set(&mut file.people.share, args.people);
        set(&mut file.look.texture_density, args.texture);
        set(&mut file.look.furniture, args.furniture);
        file.noise = match (args.noise, args.what) {
            (Some(NoiseName::None), _) => Some(OdometryNoise::none()),
            (Some(NoiseName::Monocular), _) => Some(OdometryNoise::monocular()),
            (None, SimKind::Odometry) => file.noise.or_else(|| Some(OdometryNoise::monocular())),
            (None, SimKind::Video) => file.noise,
        };
        Ok(file)
    }

    /// As the simulator wants it.
    pub fn options(&self) -> SceneOptions {
        let Self { building, walk, camera, look, people, .. } = self.clone();
        SceneOptions { seed: Seed(self.seed), building, walk, camera, look, people }
    }
}

fn set<T>(option: &mut T, said: Option<T>) {
    if let Some(said) = said {
        *option = said;
    }
}

/// Where scenes are: a plan that is built, or buildings that are generated.
pub enum Site {
    /// One building for all walks.
    Built(Box<Building>),
    /// What its kind and the seed give.
    Generated(BuildingOptions),
}

impl Site {
    /// The site that is meant.
    pub fn of(args: &SimArgs, file: &SceneFile) -> Result<Self, Failure> {
        let Some(path) = &args.plan else {
            return match args.reading.said().first() {
                None => Ok(Self::Generated(file.building)),
                Some((name, _)) => {
                    Err(Failure::usage(format!("--{name} says how a plan is to be read: give --plan PLAN, or leave it away")))
                }
            };
        };
        let plan = inputs::plan_at(path, &args.reading)?.value;
        let building =
            Building::from_plan(&plan, &file.built_plan, Seed(file.seed)).map_err(|why| Failure::input("the plan", why, path))?;
        Ok(Self::Built(Box::new(building)))
    }

    /// A walker's scene. Where a building (every door shut) or a draw of the walk allows none, another is drawn, a few times.
    ///
    /// # Errors
    /// [`SimError`] of the last try; an option out of its range is said at once.
    pub fn scene(&self, building: Seed, options: &SceneOptions) -> Result<Scene, SimError> {
        let mut refused = None;
        for attempt in 0..TRIES {
            let again = |seed: Seed, n: u64| if n == 0 { seed } else { seed.child("attempt", n) };
            let options = SceneOptions { seed: again(options.seed, attempt), ..options.clone() };
            match self.building(again(building, attempt / 2)).and_then(|building| Scene::new(building, &options)) {
                Err(why @ SimError::NoWalk { .. }) => refused = Some(why),
                other => return other,
            }
        }
        Err(refused.unwrap_or(SimError::NoWalk { wanted_m: 0.0, found_m: 0.0, tries: 0 }))
    }

    /// The building of this seed, where there is a choice.
    ///
    /// # Errors
    /// As [`Building::generate`].
    pub fn building(&self, seed: Seed) -> Result<Building, SimError> {
        match self {
            Self::Built(building) => Ok((**building).clone()),
            Self::Generated(options) => Building::generate(options, seed),
        }
    }
}

/// A path of the camera from a file of poses, taken as the file has them: the plan's world is not to be turned. `mount_rad` turns
/// the camera about its right, down and forward axes on what the poses are of.
pub fn walk_along(path: &Path, format: Option<PosesFormat>, frame: PosesFrame, mount_rad: [f64; 3]) -> Result<Walk, String> {
    let options = PosesOptions { format, frame: Some(PosesFrame::Body), fps: None };
    let file = planwalk_io::trajectory::read(path, &options).map_err(|why| why.to_string())?;
    let camera = |pose: &Rigid3<_, _>| match frame {
        PosesFrame::Camera => Rigid3::<Plan, Cam>::new(pose.iso),
        PosesFrame::Body => Rigid3::<Plan, Body>::new(pose.iso).camera(),
    };
    let poses: Vec<_> = file.trajectory.poses().iter().map(|(stamp, pose)| (*stamp, camera(pose))).collect();
    let [x, y, z] = mount_rad;
    let turn = |axis: &nalgebra::Unit<Vector3<f64>>, angle: f64| UnitQuaternion::from_axis_angle(axis, angle);
    let mount = turn(&Vector3::x_axis(), x) * turn(&Vector3::y_axis(), y) * turn(&Vector3::z_axis(), z);
    Walk::along(&poses, mount).map_err(|why| why.to_string())
}
