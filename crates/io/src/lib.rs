//! Files ↔ nouns: videos, floor plans, cameras, trajectories and sightings, read and written.
//!
//! | file | noun |
//! |---|---|
//! | video file, folder of images | [`video::open`] → [`planwalk_types::VideoFrame`]s, one at a time |
//! | `camera.yaml` (ROS, Kalibr) | [`camera::read`] → [`planwalk_types::Camera`] |
//! | image, ROS `map.yaml`, SVG, PDF, DXF, GeoJSON, IMDF, OpenStreetMap, list of walls | [`plan::read`] → [`planwalk_types::FloorPlan`], or [`plan::import`] → [`planwalk_types::Building`] |
//! | `*.plan.json` | the same, and [`plan::native::write`]; other ways out in [`plan::export`] |
//! | TUM, KITTI, EuRoC, CARMEN, CSV | [`trajectory::read`] → [`planwalk_types::Trajectory`] |
//! | `sightings.csv`, a CARMEN log's scans | [`sightings::read`] → [`planwalk_types::Sighting`]s |
//!
//! Nothing is trusted: sizes are checked before memory is taken, every refusal says what was met and what to do.
//! Errors do not repeat the path that the caller gave (the caller knows it); they name files found on the way.

pub mod camera;
pub mod inputs;
pub mod plan;
pub mod raster;
pub mod sightings;
mod text;
pub mod trajectory;
pub mod video;
