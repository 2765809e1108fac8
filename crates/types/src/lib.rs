//! The nouns of Planwalk, in the order in which data meets them.
//!
//! video ─▶ [`frame`] ─▶ [`motion`] ─▶ [`path`] + [`sightings`] ─▶ [`posterior`] on the [`plan`], a storey of a [`building`]
//!
//! Every other crate speaks in these nouns and knows none of its neighbours. Two tools that more than one of them needs stand beside
//! them: [`groups`] (what hangs together) and [`distance`] (how far the nearest is). Nothing here touches a file,
//! a clock or entropy: chance comes from a [`Seed`], time from the frames' own [`Stamp`]s.
//!
//! # Frames of reference and units
//! Metres, radians and seconds inside; whatever is measured otherwise wears its unit in its name.
//! * [`Plan`]: x right, y **up**, origin at the plan's own origin; heading anticlockwise from +x.
//! * [`Odom`]: where the odometry began; z up; its unit of length is the odometry's own.
//! * [`Body`]: x forward, y left, z up (REP-103).
//! * [`Cam`]: x right, y down, z forward; pixel centres at integers.

pub mod building;
pub mod camera;
pub mod connection;
pub mod distance;
pub mod frame;
pub mod groups;
pub mod motion;
pub mod path;
pub mod plan;
pub mod posterior;
pub mod rigid;
pub mod seed;
pub mod sightings;
pub mod similarity;
pub mod space;
pub mod time;

pub use building::{Building, Element, ElementKind, Form, Georeference, Level};
pub use camera::{Camera, CameraError, Distortion, IntrinsicsSource};
pub use connection::{Connection, connections};
pub use frame::{GrayImage, VideoFrame};
pub use groups::Groups;
pub use motion::{CameraPose, TrackingState};
pub use path::{OdometryScale, Path, Step, Trajectory, TrajectoryError};
pub use plan::{Cell, FloorPlan, PlanError, Wall};
pub use posterior::{Estimate, Hypothesis, PlanPose, ScaleEstimate, Status};
pub use rigid::{Rigid2, Rigid3, wrap_angle};
pub use seed::{Seed, StreamRng};
pub use sightings::Sighting;
pub use similarity::{Similarity, Tangent7};
pub use space::{Body, Cam, Odom, Plan, Pt2, Pt3};
pub use time::Stamp;
