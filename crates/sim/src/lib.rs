//! What would the camera have seen, had somebody walked there? Simulated buildings, walkers and cameras with known truth.
//!
//! ```text
//! Seed ─▶ building ──────────────┬─▶ world (boxes, faces, what hangs on them) ─┐
//!           └─▶ walker (route, gait, habits) ─▶ truth, one pose a frame ───────┼─▶ film (shutter, people) ─▶ render ─▶ exposure ─▶ VideoFrame
//!                                             └─▶ odometry (no pictures) ─▶ Path + Sightings
//! ```
//! [`Scene`] ties them together. Everything grows from a [`planwalk_types::Seed`]: the same seed gives the same bytes on any
//! number of threads and any machine (`libm` for what platforms disagree on, counter-based noise in the pictures).
//!
//! Frames: plan coordinates in metres, z up, floor at z = 0. The truth is the camera's: `plan_from_camera`.

pub mod building;
pub mod camera;
mod cast;
mod error;
mod exposure;
mod film;
mod look;
pub mod odometry;
mod render;
pub mod scene;
mod texture;
pub mod walker;
mod world;

pub use building::{Building, BuildingKind, BuildingOptions, Door, Lies, PlanWorldOptions, Room, RoomKind};
pub use camera::{CameraOptions, Lens};
pub use error::SimError;
pub use look::Look;
pub use odometry::{OdometryNoise, SimulatedOdometry, simulate_carried, simulate_odometry};
pub use scene::{Landmark, Scene, SceneOptions};
pub use walker::statistics::{WalkStatistics, walk_statistics};
pub use walker::{CLEARANCE_M, Walk, WalkOptions, WalkPose};
pub use world::People;
