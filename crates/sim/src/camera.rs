//! What films the walk? Lens, size, shutter and exposure of a phone.
//!
//! options ─▶ [`planwalk_types::Camera`] (rays of pixels) + shutter (when each pixel is seen)
//!
//! A **rolling shutter** sees one line of the picture after the other. A frame's stamp is the moment of its *middle* line, at the
//! middle of its exposure, so truth at the stamp is right to half a readout everywhere and errs to neither side. In a **portrait**
//! video the sensor is turned by a quarter, so its lines are the frame's columns, and they are read from right to left, as by a
//! phone whose sensor's upper edge lies on the right when it is held upright.

use planwalk_types::{Camera, Distortion, IntrinsicsSource};
use serde::{Deserialize, Serialize};

use crate::error::{SimError, in_range};

/// A fisheye's departure from `r = f·θ`: that of ordinary wide lenses; monotonic to 130° off the axis.
const FISHEYE_K: [f64; 4] = [0.03, -0.015, 0.002, 0.0];

/// How the lens maps directions to pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Lens {
    /// Straight lines stay straight.
    #[default]
    Pinhole,
    /// Equidistant, with a little of the bending that real ones have.
    Fisheye,
}

/// A phone's camera: what it sees, when, and how bright.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraOptions {
    /// The lens.
    pub lens: Lens,
    /// Field of view along the picture's long side, degrees.
    pub fov_deg: f64,
    /// Columns of the frames (where [`portrait`](Self::portrait) is off).
    pub width: usize,
    /// Rows of the frames (where [`portrait`](Self::portrait) is off).
    pub height: usize,
    /// The phone is held upright: frames are stored upright, with their long side upright, and the shutter runs along their columns.
    pub portrait: bool,
    /// A calibrated camera; takes the place of `lens`, `fov_deg`, `width` and `height`. It is that of the frames as they are stored,
    /// so `portrait` then only says which way the shutter runs.
    pub calibration: Option<Camera>,
    /// Frames per second.
    pub fps: f64,
    /// Time from the first line's exposure to the last one's, milliseconds: 0 a global shutter, 5 to 30 a phone's rolling one.
    pub readout_ms: f64,
    /// How long a line gathers light, milliseconds: 0 freezes everything, 8 to 20 is a phone indoors.
    pub exposure_ms: f64,
    /// Whether the camera steers its mean brightness, with the lag and the overshoot of phones.
    pub auto_exposure: bool,
    /// How far the exposure drifts up and down for no reason of the scene's, as a share of it.
    pub exposure_drift: f64,
    /// How much darker the corners are than the middle, as a share.
    pub vignetting: f64,
    /// Standard deviation of the noise that is there in the dark, grey levels out of 255.
    pub noise_grey: f64,
    /// Standard deviation of the photons' noise at full white, grey levels; grows with the root of brightness.
    pub shot_noise_grey: f64,
}

impl Default for CameraOptions {
    /// An ordinary phone in good light held level, 640×480 at 15 frames/s: a frozen picture, a little noise and drifting exposure.
    fn default() -> Self {
        Self {
            lens: Lens::Pinhole,
            // A focal length of 0.8 of the long side: a 28 mm equivalent with a little stabilisation crop.
            fov_deg: 2.0 * libm::atan(0.5 / 0.8).to_degrees(),
            width: 640,
            height: 480,
            portrait: false,
            calibration: None,
            fps: 15.0,
            readout_ms: 0.0,
            exposure_ms: 0.0,
            auto_exposure: false,
            exposure_drift: 0.05,
            vignetting: 0.0,
            noise_grey: 1.5,
            shot_noise_grey: 0.0,
        }
    }
}

impl CameraOptions {
    /// A phone as people have it, held upright indoors: 30 frames/s, rolling shutter, motion blur, exposure that hunts, dark corners.
    pub fn phone() -> Self {
        Self {
            portrait: true,
            fps: 30.0,
            readout_ms: 16.0,
            exposure_ms: 10.0,
            auto_exposure: true,
            exposure_drift: 0.01,
            vignetting: 0.2,
            noise_grey: 1.2,
            shot_noise_grey: 2.5,
            ..Self::default()
        }
    }

    /// A perfect camera of the default's size: no noise, no drift; for tests of geometry.
    pub fn noiseless() -> Self {
        Self { exposure_drift: 0.0, noise_grey: 0.0, ..Self::default() }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SimError::Option`] names what is outside its range.
    pub fn check(&self) -> Result<(), SimError> {
        in_range("the frame rate in frames per second", self.fps, 0.5, 1000.0)?;
        // Lines of one frame are read before the next one begins; stamps are rounded to a nanosecond.
        let frame_ms = 1000.0 / self.fps;
        in_range("the readout in milliseconds (no longer than a frame)", self.readout_ms, 0.0, frame_ms.min(100.0))?;
        in_range("the exposure in milliseconds (no longer than a frame)", self.exposure_ms, 0.0, frame_ms.min(100.0))?;
        in_range("the exposure drift", self.exposure_drift, 0.0, 0.9)?;
        in_range("the vignetting", self.vignetting, 0.0, 0.95)?;
        in_range("the camera noise in grey levels", self.noise_grey, 0.0, 50.0)?;
        in_range("the photons' noise in grey levels", self.shot_noise_grey, 0.0, 50.0)
    }

    /// The camera of the frames as they are stored.
    ///
    /// # Errors
    /// [`SimError::Option`] for a size or field of view that is outside its range, [`SimError::Camera`] for a calibration that is none.
    pub fn camera(&self) -> Result<Camera, SimError> {
        let camera = match &self.calibration {
            Some(camera) => camera.clone(),
            None => self.ideal()?,
        };
        in_range("the picture's width in pixels", camera.width as f64, 16.0, 8192.0)?;
        in_range("the picture's height in pixels", camera.height as f64, 16.0, 8192.0)?;
        Ok(camera.checked()?)
    }

    fn ideal(&self) -> Result<Camera, SimError> {
        let (mut width, mut height) = (self.width, self.height);
        if self.portrait {
            (width, height) = (width.min(height), width.max(height));
        }
        let half_px = 0.5 * width.max(height) as f64;
        let half_rad = 0.5 * self.fov_deg.to_radians();
        let (reach, distortion) = match self.lens {
            Lens::Pinhole => {
                in_range("a pinhole's field of view in degrees", self.fov_deg, 10.0, 140.0)?;
                (libm::tan(half_rad), Distortion::NONE)
            }
            Lens::Fisheye => {
                in_range("a fisheye's field of view in degrees", self.fov_deg, 30.0, 190.0)?;
                let (t2, k) = (half_rad * half_rad, FISHEYE_K);
                (half_rad * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))), Distortion::Equidistant { k })
            }
        };
        // To a millionth of a pixel: the round-off of degrees and tangents is nobody's focal length.
        let focal_px = (half_px / reach * 1e6).round() / 1e6;
        let source = IntrinsicsSource::Stated;
        Ok(Camera { fx: focal_px, fy: focal_px, distortion, source, ..Camera::phone_prior(width, height) })
    }

    /// When pixels of these frames are seen.
    pub(crate) fn shutter(&self) -> Shutter {
        Shutter { readout_s: 1e-3 * self.readout_ms, exposure_s: 1e-3 * self.exposure_ms, columns: self.portrait }
    }
}

/// When each pixel of a frame is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shutter {
    /// From the first line to the last, seconds.
    pub readout_s: f64,
    /// How long each line gathers light, seconds.
    pub exposure_s: f64,
    /// Lines are columns, read from right to left; else rows, from top to bottom.
    pub columns: bool,
}

impl Shutter {
    /// The middle of the exposure of pixel (u, v), seconds after the frame's stamp.
    pub fn delay_s(&self, camera: &Camera, u: f64, v: f64) -> f64 {
        let (line, lines) = if self.columns { (camera.width as f64 - 1.0 - u, camera.width) } else { (v, camera.height) };
        (line - 0.5 * (lines as f64 - 1.0)) / lines as f64 * self.readout_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn the_long_side_sees_the_field_of_view() {
        for (lens, fov_deg) in [(Lens::Pinhole, 70.0), (Lens::Fisheye, 70.0), (Lens::Fisheye, 180.0)] {
            for portrait in [false, true] {
                let camera = CameraOptions { lens, fov_deg, portrait, ..Default::default() }.camera().unwrap();
                assert_eq!((camera.width, camera.height), if portrait { (480, 640) } else { (640, 480) });
                let half = (0.5 * fov_deg).to_radians();
                let edge = if portrait { Vector3::new(0.0, half.sin(), half.cos()) } else { Vector3::new(half.sin(), 0.0, half.cos()) };
                // The outer edge of the last pixel; not quite at 90°, where a pinhole sees nothing.
                let pixel = camera.project(&edge).unwrap();
                let (at, end) = if portrait { (pixel.y, 639.5) } else { (pixel.x, 639.5) };
                // The focal length is rounded to 1e-6 px.
                assert!((at - end).abs() < 1e-5, "{lens:?} {fov_deg}°: {at} px");
            }
        }
    }

    #[test]
    fn the_default_focal_length_is_four_fifths_of_the_width() {
        assert_eq!(CameraOptions::default().camera().unwrap().fx, 0.8 * 640.0);
    }

    #[test]
    fn the_stamp_is_that_of_the_middle_line() {
        let options = CameraOptions { readout_ms: 20.0, ..Default::default() };
        let (camera, shutter) = (options.camera().unwrap(), options.shutter());
        assert_eq!(shutter.delay_s(&camera, 5.0, 239.5), 0.0);
        assert!(shutter.delay_s(&camera, 5.0, 0.0) < 0.0, "the upper edge comes first");
        let options = CameraOptions { portrait: true, ..options };
        let (camera, shutter) = (options.camera().unwrap(), options.shutter());
        assert_eq!(shutter.delay_s(&camera, 239.5, 5.0), 0.0);
        assert!(shutter.delay_s(&camera, 479.0, 5.0) < 0.0, "the right edge comes first");
    }

    #[test]
    fn what_is_no_camera_is_refused_with_the_numbers() {
        let refused = |options: CameraOptions| options.check().and_then(|()| options.camera().map(|_| ())).unwrap_err().to_string();
        assert!(refused(CameraOptions { fov_deg: 175.0, ..Default::default() }).contains("175"));
        assert!(refused(CameraOptions { readout_ms: 80.0, ..Default::default() }).contains("readout"));
        assert!(refused(CameraOptions { vignetting: f64::NAN, ..Default::default() }).contains("vignetting"));
        assert!(refused(CameraOptions { width: 8, ..Default::default() }).contains("width"));
        let bad = Camera { fx: -1.0, ..Camera::phone_prior(64, 48) };
        assert!(refused(CameraOptions { calibration: Some(bad), ..Default::default() }).contains("focal"));
    }
}
