//! One building, one walk, one camera: what is filmed, and what is true?

use planwalk_types::{
    Cam, Camera, Distortion, FloorPlan, IntrinsicsSource, Plan, PlanPose, Pt2, Pt3, Rigid3, Seed, Stamp, VideoFrame, Wall,
};
use rand::Rng;

use crate::building::{Building, BuildingOptions};
use crate::error::{SimError, in_range};
use crate::look::Look;
use crate::render::{Exposure, Renderer};
use crate::walker::{Walk, WalkOptions};
use crate::world::{DecorKind, World};

/// Cell of the plan, metres.
const PLAN_CELL_M: f64 = 0.05;
/// Free space around the plan, metres.
const PLAN_MARGIN_M: f64 = 1.0;

/// Options of [`Scene::with_options`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// What everything grows from.
    pub seed: Seed,
    /// Columns of the video.
    pub width: usize,
    /// Rows of the video.
    pub height: usize,
    /// The building.
    pub building: BuildingOptions,
    /// The walk, its duration and frame rate.
    pub walk: WalkOptions,
    /// Texture, furniture, noise.
    pub look: Look,
}

impl Default for SceneOptions {
    /// Half a minute of 640×480 video at 15 frames/s in an ordinary office.
    fn default() -> Self {
        let (building, walk, look) = (BuildingOptions::default(), WalkOptions::default(), Look::default());
        Self { seed: Seed(1), width: 640, height: 480, building, walk, look }
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
    renderer: Renderer,
    look: Look,
    seed: Seed,
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

    /// A scene in a generated office, filmed by a pinhole camera whose focal length is 0.8 of the picture's width.
    ///
    /// # Errors
    /// [`SimError`] when an option is outside its range, or when the building that the seed gives has no walk of that length.
    pub fn with_options(options: &SceneOptions) -> Result<Self, SimError> {
        let building = Building::generate(&options.building, options.seed)?;
        let focal_px = 0.8 * options.width as f64;
        let camera = Camera {
            fx: focal_px,
            fy: focal_px,
            distortion: Distortion::NONE,
            source: IntrinsicsSource::Stated,
            ..Camera::phone_prior(options.width, options.height)
        };
        Self::new(building, options.walk, camera, options.look, options.seed)
    }

    /// A scene in this building with this camera.
    ///
    /// # Errors
    /// As [`Scene::with_options`]; also when the numbers make no camera, or the walls no plan.
    pub fn new(building: Building, walk: WalkOptions, camera: Camera, look: Look, seed: Seed) -> Result<Self, SimError> {
        in_range("the picture's width in pixels", camera.width as f64, 16.0, 8192.0)?;
        in_range("the picture's height in pixels", camera.height as f64, 16.0, 8192.0)?;
        let (camera, look) = (camera.checked()?, look.checked()?);
        let plan = building.plan(PLAN_CELL_M, PLAN_MARGIN_M)?;
        let world = World::new(&building, &look, seed);
        let walk = Walk::new(&building, &world, &walk, seed)?;
        Ok(Self { building, world, plan, walk, renderer: Renderer::new(camera), look, seed })
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

    /// Frames in the video.
    pub fn frame_count(&self) -> usize {
        (self.walk.options().duration_s * self.walk.options().fps).floor() as usize
    }

    /// When frame `index` is taken.
    pub fn stamp(&self, index: usize) -> Stamp {
        Stamp((index as f64 / self.walk.options().fps * 1e9).round() as i64)
    }

    /// Draws one frame; past the end of the walk the camera stands still.
    pub fn frame(&self, index: usize) -> VideoFrame {
        let stamp = self.stamp(index);
        let pose = self.walk.at(stamp.as_secs());
        let seed = self.seed.derive("noise", index as u64).next_u32();
        // A slow exposure control: two waves without a common period.
        let (a, b) = (libm::sin(0.9 * stamp.as_secs()), libm::sin(0.37 * stamp.as_secs() + 1.0));
        let gain = (1.0 + self.look.exposure_drift * 0.5 * (a + b)) as f32;
        let exposure = Exposure { gain, noise_grey: self.look.noise_grey as f32, seed };
        VideoFrame { stamp, image: self.renderer.render(&self.world, &pose.plan_from_camera, exposure) }
    }

    /// The video, drawn frame by frame as it is asked for.
    pub fn frames(&self) -> impl Iterator<Item = VideoFrame> + '_ {
        (0..self.frame_count()).map(|index| self.frame(index))
    }

    /// Where the camera truly was, one pose a frame; z up, metres.
    pub fn truth(&self) -> Vec<(Stamp, Rigid3<Plan, Cam>)> {
        (0..self.frame_count()).map(|i| (self.stamp(i), self.walk.at(self.stamp(i).as_secs()).plan_from_camera)).collect()
    }

    /// The same on the floor; headings are where the camera looks.
    pub fn truth_on_floor(&self) -> Vec<(Stamp, PlanPose)> {
        (0..self.frame_count()).map(|i| (self.stamp(i), self.walk.at(self.stamp(i).as_secs()).on_floor)).collect()
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

    /// Whether the camera of frame `index` has a free line of sight to a point: nothing in between, and inside the picture.
    pub fn sees(&self, index: usize, point: Pt3<Plan>) -> bool {
        let pose = self.walk.at(self.stamp(index).as_secs()).plan_from_camera;
        let in_camera = pose.inverse() * point;
        let Some(pixel) = self.camera().project(&in_camera.coords) else { return false };
        let (width, height) = (self.camera().width as f64, self.camera().height as f64);
        let inside = pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x <= width - 1.0 && pixel.y <= height - 1.0;
        inside && self.world.free_line(pose.origin(), point)
    }
}
