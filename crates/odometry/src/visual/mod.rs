//! From pictures to camera poses: [`image`] ─▶ [`corners`] ─▶ [`track`] ─▶ [`two_view`] ─▶ [`map`].

pub mod begin;
pub mod corners;
pub mod image;
pub mod klt;
pub mod map;
pub mod odometry;
pub mod track;
pub mod turn;
pub mod two_view;
