//! What would the camera have seen, had somebody walked there? Simulated buildings, walkers and cameras with known truth.
//!
//! ```text
//! Seed ─▶ building ──────────────┬─▶ world (boxes, faces, what hangs on them) ─┐
//!           └─▶ walker (route, gait, head) ─▶ truth, one pose a frame ─────────┼─▶ render ─▶ VideoFrame
//!                                             └─▶ odometry (no pictures) ─▶ Path + Sightings
//! ```
//! [`Scene`] ties them together. Everything grows from a [`planwalk_types::Seed`]: the same seed gives the same bytes on any
//! number of threads and any machine (`libm` for what platforms disagree on, counter-based noise in the pictures).
//!
//! Frames: plan coordinates in metres, z up, floor at z = 0. The truth is the camera's: `plan_from_camera`.

pub mod building;
mod cast;
mod error;
mod look;
pub mod odometry;
mod render;
pub mod scene;
mod texture;
pub mod walker;
mod world;

pub use building::{Building, BuildingKind, BuildingOptions, Door, Lies, PlanWorldOptions, Room, RoomKind};
pub use error::SimError;
pub use look::Look;
pub use odometry::{OdometryNoise, simulate_odometry};
pub use scene::{Landmark, Scene, SceneOptions};
pub use walker::{CLEARANCE_M, Walk, WalkOptions, WalkPose};
