//! From pictures to camera poses: [`image`] ─▶ [`corners`] ─▶ [`track`] ─▶ [`two_view`] ─▶ [`map`]; [`lines`] ─▶ [`axes`] ─▶
//! [`compass`] hold the rotation; [`turn`], and before blank walls [`grain`], say how the picture as a whole went; [`focal`] says how
//! long the lens is where nobody does.

pub mod axes;
pub mod begin;
pub mod compass;
pub mod corners;
mod filter;
pub mod focal;
pub mod grain;
pub mod graph;
pub mod image;
pub mod klt;
pub mod lines;
pub mod map;
pub mod motion;
pub mod odometry;
pub mod outcome;
mod posed;
pub mod recall;
mod repeat;
pub mod track;
pub mod turn;
pub mod two_view;
mod view;
