//! What does a person need to see? Drawings as SVG text, and as PNG through [`png_of`]; no fonts, no files, no network.
//!
//! [`TrackPicture`]: the walk on the plan with its doubt · [`TrajectoryPicture`]: the camera's path by itself ·
//! [`PlacementPicture`]: all places where a path fits · [`AmbiguityPicture`]: where a plan would fool anyone · [`ParticlePicture`]: the filter at work · [`BenchPicture`]: many walks.
//! With a truth: [`ErrorPicture`]: error along the walk · [`CalibrationPicture`]: whether the doubt was honest ·
//! [`OverlayPicture`]: an odometry over the truth.
//!
//! Plans are drawn y up, in metres; the sheet itself is SVG's pixels, y down.

mod ambiguity;
mod animation;
mod bench;
mod calibration;
mod chart;
mod colour;
mod error;
mod font;
mod lettering;
mod map;
mod marks;
mod overlay;
mod particles;
mod placement;
mod png;
pub(crate) mod svg;
mod track;
mod trajectory;

pub use ambiguity::AmbiguityPicture;
pub use animation::gif_of;
pub use bench::BenchPicture;
pub use calibration::CalibrationPicture;
pub use error::ErrorPicture;
pub use lettering::lettered;
pub use overlay::OverlayPicture;
pub use particles::{ParticleCloud, ParticlePicture};
pub use placement::PlacementPicture;
pub use png::{PictureError, png_of, png_within};
pub use track::TrackPicture;
pub use trajectory::TrajectoryPicture;
