//! Where on a floor plan was a first-person video walked? The front door: the main job in three calls.
//!
//! frames ──[`follow`]──▶ odometry ──▶ [`Walk`] ──[`localize`] with a plan──▶ [`Run`] ──▶ [`figure`], [`report`], [`tables`], [`result`] ──[`evaluate`] with the truth──▶ scores
//!
//! Files are not opened here: frames, plans and poses come in as nouns (`planwalk-types`), pictures and tables go out as text
//! and bytes. The same seed gives the same bytes on any number of threads.

pub mod bench;
pub mod evaluate;
pub mod figure;
mod film;
pub mod plan_info;
pub mod report;
pub mod result;
pub mod run;
pub mod tables;
pub mod words;

pub use film::filmstrip;
pub use planwalk_locate as locate;
pub use planwalk_odometry as odometry;
pub use planwalk_types as types;
pub use run::{Followed, LocalizeOptions, Method, Run, Walk, check_start, follow, localize, measure_lens};
