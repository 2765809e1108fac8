//! One building, one walk, one camera: what is filmed, and what is true?

use std::sync::OnceLock;

use nalgebra::Vector2;
use planwalk_types::{Cam, Camera, FloorPlan, Plan, PlanPose, Pt2, Pt3, Rigid3, Seed, Stamp, VideoFrame, Wall};
use rand::Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::building::{Building, BuildingOptions};
use crate::camera::CameraOptions;
use crate::error::SimError;
use crate::exposure::{self, Exposure};
use crate::film::{self, Shot};
use crate::look::Look;
use crate::odometry::{OdometryNoise, SimulatedOdometry, simulate_carried};
use crate::render::Renderer;
use crate::walker::{Walk, WalkOptions};
use crate::world::{Crowd, DecorKind, People, World};

/// Cell of the plan, metres.
const PLAN_CELL_M: f64 = 0.05;
/// Free space around the plan, metres.
const PLAN_MARGIN_M: f64 = 1.0;

/// Longest side of the small pictures by which brightness and people are measured, pixels.
const METER_PX: usize = 36;
/// Times at which the share of people is measured: every half second, but no more than this many.
const WATCHES: usize = 240;

/// Options of a scene; all parts have defaults, so that a file need only state what differs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneOptions {
    /// What everything grows from.
    pub seed: Seed,
    /// The building, where it is generated.
    pub building: BuildingOptions,
    /// The walk, where it is not given.
    pub walk: WalkOptions,
    /// The camera and its frame rate.
    pub camera: CameraOptions,
    /// Texture and furniture.
    pub look: Look,
    /// Who else walks there.
    pub people: People,
}

impl Default for SceneOptions {
    /// Half a minute of 640×480 video at 15 frames/s in an ordinary empty office.
    fn default() -> Self {
        Self {
            seed: Seed(1),
            building: BuildingOptions::default(),
            walk: WalkOptions::default(),
            camera: CameraOptions::default(),
            look: Look::default(),
            people: People::default(),
        }
    }
}

/// A corner that can be found in the pictures: of a picture frame on a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landmark {
    /// Where it is.
    pub at: Pt3<Plan>,
    /// The way along the wall's surface that leads out of the frame, on the floor; a unit vector.
    pub outward: (f64, f64),
    /// The wall's normal on the floor, towards whoever looks at it; a unit vector.
    pub normal: (f64, f64),
}

/// A simulated walk: what the camera films, and where it truly was.
#[derive(Debug, Clone)]
pub struct Scene {
    building: Building,
    world: World,
    plan: FloorPlan,
    walk: Walk,
    camera: CameraOptions,
    people: People,
    seed: Seed,
    renderer: Renderer,
    /// The same camera with few pixels, to measure by.
    meter: Renderer,
    /// Who is there: found when the first frame is drawn, for it takes looking at the whole walk.
    crowd: OnceLock<Crowd>,
    /// What the automatic exposure does: likewise.
    gains: OnceLock<Vec<f32>>,
}

impl Scene {
    /// A small office and a walk of about 30 s through it, through doors and along the corridor: 640×480 at 15 frames/s.
    pub fn demo(seed: Seed) -> Self {
        // Not every building that is drawn allows such a walk; most do, so this ends after a try or two.
        let mut attempt = 0;
        loop {
            let seed = if attempt == 0 { seed } else { seed.child("demo", attempt) };
            if let Ok(scene) = Self::with_options(&SceneOptions { seed, ..Default::default() })
                && scene.walk.doors_passed() >= 2
                && scene.walk.turns() >= 2
            {
                return scene;
            }
            attempt += 1;
        }
    }

    /// A scene in a generated office.
    ///
    /// # Errors
    /// [`SimError`] when an option is outside its range, or when the building that the seed gives has no walk of that length.
    pub fn with_options(options: &SceneOptions) -> Result<Self, SimError> {
        Self::new(Building::generate(&options.building, options.seed)?, options)
    }

    /// A scene in this building; `options.building` is not used.
    ///
    /// # Errors
    /// As [`Scene::with_options`]; also when the numbers make no camera, or the walls no plan.
    pub fn new(building: Building, options: &SceneOptions) -> Result<Self, SimError> {
        let (plan, camera) = check(&building, options)?;
        let world = World::new(&building, &options.look, options.seed);
        let walk = Walk::new(&building, &world, &options.walk, options.seed)?;
        Ok(Self::assemble(building, plan, world, walk, camera, options))
    }

    /// A scene in this building along a given walk, see [`Walk::along`]; `options.building` and `options.walk` are not used.
    ///
    /// # Errors
    /// As [`Scene::new`], but that there is a walk.
    pub fn along(building: Building, mut walk: Walk, options: &SceneOptions) -> Result<Self, SimError> {
        let (plan, camera) = check(&building, options)?;
        let world = World::new(&building, &options.look, options.seed);
        walk.count_doors(&building);
        Ok(Self::assemble(building, plan, world, walk, camera, options))
    }

    fn assemble(building: Building, plan: FloorPlan, world: World, walk: Walk, camera: Camera, options: &SceneOptions) -> Self {
        let meter = Renderer::new(small(&camera));
        Self {
            building,
            world,
            plan,
            walk,
            camera: options.camera.clone(),
            people: options.people,
            seed: options.seed,
            renderer: Renderer::new(camera),
            meter,
            crowd: OnceLock::new(),
            gains: OnceLock::new(),
        }
    }

    /// The building.
    pub fn building(&self) -> &Building {
        &self.building
    }

    /// Centre lines of the walls as the plan draws them: every door an opening.
    pub fn walls(&self) -> &[Wall] {
        &self.building.walls
    }

    /// The floor plan that a localiser is given.
    pub fn plan(&self) -> FloorPlan {
        self.plan.clone()
    }

    /// The plan of everything that one bumps into in this scene: walls as built, shut doors, open leaves, furniture.
    ///
    /// # Errors
    /// As [`FloorPlan::new`], for a cell or a margin that is none.
    pub fn as_built_plan(&self, cell_m: f64, margin_m: f64) -> Result<FloorPlan, planwalk_types::PlanError> {
        self.world.as_built_plan(cell_m, margin_m)
    }

    /// The walk.
    pub fn walk(&self) -> &Walk {
        &self.walk
    }

    /// The camera that films it.
    pub fn camera(&self) -> &Camera {
        self.renderer.camera()
    }

    /// How it films.
    pub fn camera_options(&self) -> &CameraOptions {
        &self.camera
    }

    /// Frames in the video.
    pub fn frame_count(&self) -> usize {
        (self.walk.duration_s() * self.camera.fps).floor() as usize
    }

    /// When frame `index` is taken: the middle of the exposure of its middle line.
    pub fn stamp(&self, index: usize) -> Stamp {
        Stamp((index as f64 / self.camera.fps * 1e9).round() as i64)
    }

    /// Draws one frame; past the end of the walk the camera stands still.
    pub fn frame(&self, index: usize) -> VideoFrame {
        let stamp = self.stamp(index);
        let time_s = stamp.as_secs();
        let seed = self.seed.derive("noise", index as u64).next_u32();
        // A slow drift: two waves without a common period.
        let (a, b) = (libm::sin(0.9 * time_s), libm::sin(0.37 * time_s + 1.0));
        let drift = (1.0 + self.camera.exposure_drift * 0.5 * (a + b)) as f32;
        let exposure = Exposure {
            gain: drift * exposure::gain_at(self.gains(), time_s),
            noise_grey: self.camera.noise_grey as f32,
            shot_noise_grey: self.camera.shot_noise_grey as f32,
            vignetting: self.camera.vignetting as f32,
            seed,
        };
        let image = self.shot(time_s, |shot| film::film(&self.renderer, &self.camera.shutter(), shot, exposure));
        VideoFrame { stamp, image }
    }

    /// The video: as many frames at a time as there are threads, drawn when they are asked for.
    pub fn frames(&self) -> impl Iterator<Item = VideoFrame> + '_ {
        let (count, at_once) = (self.frame_count(), rayon::current_num_threads().clamp(1, 64));
        (0..count).step_by(at_once).flat_map(move |first| {
            let indices: Vec<usize> = (first..(first + at_once).min(count)).collect();
            indices.into_par_iter().map(|index| self.frame(index)).collect::<Vec<_>>()
        })
    }

    /// Share of frame `index` that people fill, 0..=1, by a picture of few pixels.
    pub fn people_share(&self, index: usize) -> f64 {
        self.shot(self.stamp(index).as_secs(), |shot| film::people_share(&self.meter, shot))
    }

    /// What is filmed at a moment.
    fn shot<T>(&self, time_s: f64, take: impl FnOnce(&Shot) -> T) -> T {
        let pose_at = |time_s: f64| self.walk.at(time_s).plan_from_camera;
        take(&Shot { world: &self.world, crowd: self.crowd(), pose_at: &pose_at, time_s })
    }

    fn crowd(&self) -> &Crowd {
        self.crowd.get_or_init(|| {
            if self.people.share <= 0.0 {
                return Crowd::default();
            }
            let duration_s = self.walk.duration_s();
            let count = ((2.0 * duration_s).ceil() as usize).clamp(8, WATCHES);
            let pose_at = |time_s: f64| self.walk.at(time_s).plan_from_camera;
            let empty = Crowd::default();
            let watches: Vec<_> = (0..count)
                .into_par_iter()
                .map(|i| {
                    let time_s = (i as f64 + 0.5) / count as f64 * duration_s;
                    film::watch(&self.meter, &Shot { world: &self.world, crowd: &empty, pose_at: &pose_at, time_s })
                })
                .collect();
            Crowd::gather(&self.people, &self.world, &self.walk.footings(), &watches, self.seed)
        })
    }

    /// Gains of the automatic exposure; none where the camera has none.
    fn gains(&self) -> &[f32] {
        self.gains.get_or_init(|| {
            if !self.camera.auto_exposure {
                return Vec::new();
            }
            let count = (self.walk.duration_s() / exposure::METER_S).ceil() as usize + 1;
            let brightness: Vec<f32> = (0..count)
                .into_par_iter()
                .map(|i| self.shot(exposure::METER_S * i as f64, |shot| film::meter(&self.meter, shot)))
                .collect();
            exposure::follow(&brightness)
        })
    }

    /// Where a point is in frame `index`, pixels, each line seen from where the camera was at that line's time; it may lie outside of
    /// the picture. `None` where this camera does not see that way.
    pub fn pixel(&self, index: usize, point: Pt3<Plan>) -> Option<Vector2<f64>> {
        let (stamp_s, shutter) = (self.stamp(index).as_secs(), self.camera.shutter());
        let mut delay_s = 0.0;
        let mut pixel = None;
        // The line decides the pose, which decides the line: each round errs by a line's motion in its own error, a few per cent of it.
        for _ in 0..8 {
            let pose = self.walk.at(stamp_s + delay_s).plan_from_camera;
            let found = self.camera().project(&(pose.inverse() * point).coords)?;
            pixel = Some(found);
            let (width, height) = (self.camera().width as f64, self.camera().height as f64);
            delay_s = shutter.delay_s(self.camera(), found.x.clamp(-0.5, width - 0.5), found.y.clamp(-0.5, height - 0.5));
            if shutter.readout_s <= 0.0 {
                break;
            }
        }
        pixel
    }

    /// Where the camera truly was, one pose a frame; z up, metres.
    pub fn truth(&self) -> Vec<(Stamp, Rigid3<Plan, Cam>)> {
        (0..self.frame_count()).map(|i| (self.stamp(i), self.walk.at(self.stamp(i).as_secs()).plan_from_camera)).collect()
    }

    /// The same on the floor; headings are where the camera looks.
    pub fn truth_on_floor(&self) -> Vec<(Stamp, PlanPose)> {
        (0..self.frame_count()).map(|i| (self.stamp(i), self.walk.at(self.stamp(i).as_secs()).on_floor)).collect()
    }

    /// What odometry would say of the walk, without any picture, at `hz` poses a second; sightings are of the walls as they stand.
    pub fn odometry(&self, noise: &OdometryNoise, hz: f64) -> SimulatedOdometry {
        let count = (self.walk.duration_s() * hz).floor().clamp(0.0, 1e7) as usize + 1;
        let stamp = |i: usize| Stamp((i as f64 / hz * 1e9).round() as i64);
        let truth: Vec<_> = (0..count).map(|i| (stamp(i), self.walk.at(stamp(i).as_secs()).on_floor)).collect();
        simulate_carried(truth, &[], &self.building.solid_lines(), noise, self.seed)
    }

    /// Distance on the floor from a point to the nearest thing that one bumps into, furniture and shut doors included, metres.
    pub fn clearance_m(&self, point: Pt2<Plan>) -> f64 {
        self.world.clearance(point)
    }

    /// Upper corners of the picture frames on the walls: known points, to check that video and truth agree.
    pub fn landmarks(&self) -> Vec<Landmark> {
        let mut landmarks = Vec::new();
        for face in &self.world.faces {
            for decor in face.decor.iter().filter(|d| d.kind == DecorKind::Poster) {
                for (s, sign) in [(decor.s[0], -1.0), (decor.s[1], 1.0)] {
                    let at = Pt3::new(face.a[0] + s * face.e[0], face.a[1] + s * face.e[1], decor.z[1]);
                    let outward = (sign * face.e[0], sign * face.e[1]);
                    landmarks.push(Landmark { at, outward, normal: (face.n[0], face.n[1]) });
                }
            }
        }
        landmarks
    }

    /// Whether the camera of frame `index` has a free line of sight to a point: no wall or furniture in between, and inside the picture.
    /// People are not asked.
    pub fn sees(&self, index: usize, point: Pt3<Plan>) -> bool {
        let pose = self.walk.at(self.stamp(index).as_secs()).plan_from_camera;
        let Some(pixel) = self.pixel(index, point) else { return false };
        let (width, height) = (self.camera().width as f64, self.camera().height as f64);
        let inside = pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x <= width - 1.0 && pixel.y <= height - 1.0;
        inside && self.world.free_line(pose.origin(), point)
    }
}

/// What can be refused before there is a walk, and what comes of it: the plan and the camera.
fn check(building: &Building, options: &SceneOptions) -> Result<(FloorPlan, Camera), SimError> {
    options.look.checked()?;
    options.camera.check()?;
    options.people.check()?;
    Ok((building.plan(PLAN_CELL_M, PLAN_MARGIN_M)?, options.camera.camera()?))
}

/// The same camera with fewer, larger pixels.
fn small(camera: &Camera) -> Camera {
    let share = (METER_PX as f64 / camera.width.max(camera.height) as f64).min(1.0);
    let pixels = |n: usize| ((n as f64 * share).round() as usize).max(2);
    let (width, height) = (pixels(camera.width), pixels(camera.height));
    let (sx, sy) = (width as f64 / camera.width as f64, height as f64 / camera.height as f64);
    Camera {
        width,
        height,
        fx: camera.fx * sx,
        fy: camera.fy * sy,
        cx: (camera.cx + 0.5) * sx - 0.5,
        cy: (camera.cy + 0.5) * sy - 0.5,
        ..camera.clone()
    }
}
