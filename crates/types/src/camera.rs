//! Which ray of light made this pixel? Pinhole and fisheye cameras.
//!
//! Camera frame: x right, y down, z forward; pixel centres at integers, so the image spans −0.5..width−0.5.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// How the lens bends rays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distortion {
    /// Radial–tangential (Brown–Conrady; OpenCV's `k1 k2 p1 p2 k3`, ROS `plumb_bob`, Kalibr `radtan`).
    RadTan {
        /// Radial, r².
        k1: f64,
        /// Radial, r⁴.
        k2: f64,
        /// Tangential.
        p1: f64,
        /// Tangential.
        p2: f64,
        /// Radial, r⁶.
        k3: f64,
    },
    /// Equidistant fisheye (Kannala & Brandt 2006; OpenCV's fisheye, `θ + k1 θ³ + k2 θ⁵ + k3 θ⁷ + k4 θ⁹`).
    Equidistant {
        /// The four coefficients.
        k: [f64; 4],
    },
}

impl Distortion {
    /// A lens that bends nothing.
    pub const NONE: Self = Self::RadTan { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 };
}

/// Where the intrinsics come from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum IntrinsicsSource {
    /// Given by the user.
    Stated,
    /// A generic phone: the focal length has this relative standard deviation.
    PhonePrior {
        /// Standard deviation of log focal length.
        relative_sigma: f64,
    },
    /// Measured from the video itself, by straight edges and turns: the focal length has this relative standard deviation.
    Measured {
        /// Standard deviation of log focal length.
        relative_sigma: f64,
    },
}

/// A calibrated camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Columns of the images.
    pub width: usize,
    /// Rows of the images.
    pub height: usize,
    /// Focal length, pixels along a row.
    pub fx: f64,
    /// Focal length, pixels along a column.
    pub fy: f64,
    /// Principal point, column.
    pub cx: f64,
    /// Principal point, row.
    pub cy: f64,
    /// The lens.
    pub distortion: Distortion,
    /// Where these numbers come from.
    pub source: IntrinsicsSource,
}

/// Why numbers make no camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A stated camera is for other images.
    #[error(
        "the camera is for {camera_width}×{camera_height} px images, but the video has {video_width}×{video_height} px: \
         give the calibration of this video mode, or scale it"
    )]
    SizeMismatch {
        /// Columns that the calibration is for.
        camera_width: usize,
        /// Rows that the calibration is for.
        camera_height: usize,
        /// Columns of the video.
        video_width: usize,
        /// Rows of the video.
        video_height: usize,
    },
    /// A focal length or size that no camera has.
    #[error("focal lengths {fx}, {fy} px for {width}×{height} px images are not those of a camera: all must be finite and positive")]
    NotACamera {
        /// Focal length, pixels along a row.
        fx: f64,
        /// Focal length, pixels along a column.
        fy: f64,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
}

impl Camera {
    /// A phone about which nothing is known: f = 0.78 · long side, ± 15 % (FOV of 24–28 mm equivalents with and without
    /// electronic stabilisation), principal point in the centre, no distortion.
    pub fn phone_prior(width: usize, height: usize) -> Self {
        let focal = 0.78 * width.max(height) as f64;
        Self {
            width,
            height,
            fx: focal,
            fy: focal,
            cx: (width as f64 - 1.0) / 2.0,
            cy: (height as f64 - 1.0) / 2.0,
            distortion: Distortion::NONE,
            source: IntrinsicsSource::PhonePrior { relative_sigma: 0.15 },
        }
    }

    /// Checks that the numbers are those of a camera.
    ///
    /// # Errors
    /// [`CameraError::NotACamera`] when a size is zero, or a number is not finite, or a focal length not positive.
    pub fn checked(self) -> Result<Self, CameraError> {
        let lens: [f64; 5] = match self.distortion {
            Distortion::RadTan { k1, k2, p1, p2, k3 } => [k1, k2, p1, p2, k3],
            Distortion::Equidistant { k } => [k[0], k[1], k[2], k[3], 0.0],
        };
        let finite = [self.fx, self.fy, self.cx, self.cy].iter().chain(&lens).all(|v| v.is_finite());
        if finite && self.fx > 0.0 && self.fy > 0.0 && self.width > 0 && self.height > 0 {
            Ok(self)
        } else {
            Err(CameraError::NotACamera { fx: self.fx, fy: self.fy, width: self.width, height: self.height })
        }
    }

    /// Checks that the camera is one for images of this size.
    ///
    /// # Errors
    /// [`CameraError::SizeMismatch`] with both sizes.
    pub fn check_size(&self, video_width: usize, video_height: usize) -> Result<(), CameraError> {
        if (self.width, self.height) == (video_width, video_height) {
            return Ok(());
        }
        Err(CameraError::SizeMismatch { camera_width: self.width, camera_height: self.height, video_width, video_height })
    }

    /// Mean focal length, pixels.
    pub fn focal_px(&self) -> f64 {
        0.5 * (self.fx + self.fy)
    }

    /// The pixel (u, v) of a point in the camera frame; `None` where the camera cannot see it (behind a pinhole).
    pub fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        let (x, y) = match self.distortion {
            Distortion::RadTan { .. } => {
                if point.z <= 1e-9 {
                    return None;
                }
                self.distort(point.x / point.z, point.y / point.z)
            }
            Distortion::Equidistant { .. } => {
                let radius = point.x.hypot(point.y);
                if radius <= 1e-12 * point.norm() {
                    if point.z <= 0.0 {
                        return None;
                    }
                    (0.0, 0.0)
                } else {
                    let theta_d = self.bend(libm::atan2(radius, point.z));
                    (theta_d * point.x / radius, theta_d * point.y / radius)
                }
            }
        };
        Some(Vector2::new(self.fx * x + self.cx, self.fy * y + self.cy))
    }

    /// The unit ray of pixel (u, v), camera frame. Inverts [`Camera::project`] by fixed-point (radial–tangential) or
    /// Newton (fisheye) iteration, to about 1e-9 inside the image of an ordinary lens.
    pub fn ray(&self, u: f64, v: f64) -> Vector3<f64> {
        let (xd, yd) = ((u - self.cx) / self.fx, (v - self.cy) / self.fy);
        match self.distortion {
            Distortion::RadTan { .. } => {
                let (x, y) = self.undistort(xd, yd);
                Vector3::new(x, y, 1.0).normalize()
            }
            Distortion::Equidistant { k } => {
                let theta_d = xd.hypot(yd);
                if theta_d < 1e-12 {
                    return Vector3::z();
                }
                let mut theta = theta_d.min(std::f64::consts::PI);
                for _ in 0..20 {
                    let t2 = theta * theta;
                    let slope = 1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
                    // A lens polynomial may turn back outside the image; a bounded slope keeps the iterate finite there.
                    let step = (self.bend(theta) - theta_d) / slope.max(0.1);
                    theta = (theta - step).clamp(0.0, std::f64::consts::PI);
                    if step.abs() < 1e-12 {
                        break;
                    }
                }
                let (s, c) = libm::sincos(theta);
                Vector3::new(s * xd / theta_d, s * yd / theta_d, c)
            }
        }
    }

    /// θ → θ_d of the fisheye.
    fn bend(&self, theta: f64) -> f64 {
        let Distortion::Equidistant { k } = self.distortion else { return theta };
        let t2 = theta * theta;
        theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))))
    }

    fn distort(&self, x: f64, y: f64) -> (f64, f64) {
        let Distortion::RadTan { k1, k2, p1, p2, k3 } = self.distortion else { return (x, y) };
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        (x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y)
    }

    fn undistort(&self, xd: f64, yd: f64) -> (f64, f64) {
        let Distortion::RadTan { k1, k2, p1, p2, k3 } = self.distortion else { return (xd, yd) };
        let (mut x, mut y) = (xd, yd);
        for _ in 0..50 {
            let r2 = x * x + y * y;
            // Never below a tenth: far outside the image the polynomial may pass through zero.
            let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))).max(0.1);
            let (dx, dy) = (2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
            let next = ((xd - dx) / radial, (yd - dy) / radial);
            let moved = (next.0 - x).abs() + (next.1 - y).abs();
            (x, y) = next;
            if moved < 1e-13 {
                break;
            }
        }
        (x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pinhole() -> Camera {
        // The lens of a real RGB-D camera.
        let distortion = Distortion::RadTan { k1: 0.0354, k2: -0.0476, p1: 0.00107, p2: 0.00127, k3: -0.207 };
        Camera { distortion, fx: 537.6, fy: 539.0, cx: 315.1, cy: 244.5, source: IntrinsicsSource::Stated, ..Camera::phone_prior(640, 480) }
    }

    fn fisheye() -> Camera {
        let distortion = Distortion::Equidistant { k: [0.0344, -0.0216, 0.0031, -0.0005] };
        Camera {
            distortion,
            fx: 461.6,
            fy: 459.7,
            cx: 732.9,
            cy: 720.5,
            source: IntrinsicsSource::Stated,
            ..Camera::phone_prior(1472, 1440)
        }
    }

    proptest! {
        #[test]
        fn a_pixels_ray_projects_back_to_the_pixel(a in 0.0..1.0f64, b in 0.0..1.0f64) {
            for camera in [pinhole(), fisheye()] {
                let pixel = Vector2::new(a * (camera.width - 1) as f64, b * (camera.height - 1) as f64);
                // This fisheye's polynomial turns back at 2 rad, in the corners that its image circle leaves black.
                let from_axis = (pixel - Vector2::new(camera.cx, camera.cy)).norm() / camera.focal_px();
                if from_axis > 1.6 {
                    continue;
                }
                let back = camera.project(&camera.ray(pixel.x, pixel.y)).unwrap();
                // The iterations stop at 1e-12 in normalised units: some 1e-9 px.
                prop_assert!((back - pixel).norm() < 1e-6, "{pixel} came back as {back}");
            }
        }
    }

    #[test]
    fn nothing_behind_a_pinhole_is_seen() {
        assert_eq!(pinhole().project(&Vector3::new(0.1, 0.2, -1.0)), None);
        assert!(fisheye().project(&Vector3::new(1.0, 0.2, -0.1)).is_some(), "a fisheye sees past 90°");
    }

    #[test]
    fn another_video_size_names_both_sizes() {
        let message = pinhole().check_size(1280, 720).unwrap_err().to_string();
        assert!(message.contains("640×480") && message.contains("1280×720"), "{message}");
    }

    #[test]
    fn numbers_that_are_no_camera_are_refused() {
        assert!(Camera { fx: f64::NAN, ..pinhole() }.checked().is_err());
        assert!(Camera { fy: -1.0, ..pinhole() }.checked().is_err());
        assert!(Camera { distortion: Distortion::Equidistant { k: [f64::INFINITY, 0.0, 0.0, 0.0] }, ..pinhole() }.checked().is_err());
        assert!(pinhole().checked().is_ok());
    }
}
