//! Which camera took this? `camera.yaml` in the layouts of ROS `camera_info` and of Kalibr's `camchain`.
//!
//! Pixel centres are at integers in both. Kalibr's `radtan` is ROS's `plumb_bob` without k3.

use std::path::Path;

use planwalk_types::{Camera, CameraError, Distortion, IntrinsicsSource};
use serde_norway::Value;

use crate::text;

/// Why a camera file cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum CameraFileError {
    /// The file system refuses.
    #[error("the camera file cannot be read or written: {0}")]
    Io(#[from] std::io::Error),
    /// Not YAML.
    #[error("the camera file is not YAML: {0}")]
    Yaml(#[from] serde_norway::Error),
    /// YAML, but of neither layout.
    #[error("the camera file has neither camera_matrix (ROS camera_info) nor cam0 (Kalibr camchain): one of them must be there")]
    UnknownLayout,
    /// A key is not there, or is not what it should be.
    #[error("the camera file's \"{key}\" is missing or is not {expected}")]
    BadKey {
        /// The key.
        key: &'static str,
        /// What is expected there.
        expected: &'static str,
    },
    /// A lens or projection that is not supported.
    #[error(
        "the camera model \"{model}\" is not supported: calibrate as pinhole with plumb_bob/radtan (up to 5 coefficients) \
         or equidistant (fisheye, 4 coefficients)"
    )]
    UnsupportedModel {
        /// What the file says.
        model: String,
    },
    /// The wrong number of coefficients.
    #[error("{got} distortion coefficients for \"{model}\", which has {expected}")]
    Coefficients {
        /// The lens model.
        model: String,
        /// How many stand there.
        got: usize,
        /// How many there should be.
        expected: &'static str,
    },
    /// Numbers that no camera has.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

/// Reads a camera, of either layout, or a bare 3×3 matrix (7-Scenes' `camera-intrinsics.txt`, Stray Scanner's
/// `camera_matrix.csv`), which says nothing of the pictures' size: they are then taken to be `size`, columns and rows.
///
/// # Errors
/// [`CameraFileError`].
pub fn read_for(path: &Path, size: (usize, usize)) -> Result<Camera, CameraFileError> {
    match bare_matrix(&text::read(path)?) {
        Some([fx, cx, fy, cy]) => {
            let camera = Camera { fx, fy, cx, cy, source: IntrinsicsSource::Stated, ..Camera::phone_prior(size.0, size.1) };
            Ok(camera.checked()?)
        }
        None => read(path),
    }
}

/// fx, cx, fy, cy of a text that is nine numbers: `fx 0 cx 0 fy cy 0 0 1`.
fn bare_matrix(text: &str) -> Option<[f64; 4]> {
    let tokens = text::data_lines(text).flat_map(|(_, line)| line.split(|c: char| c == ',' || c.is_whitespace()));
    let matrix: Vec<f64> = tokens.filter(|t| !t.is_empty()).map(|t| t.parse().ok()).collect::<Option<_>>()?;
    let [fx, _, cx, a, fy, cy, b, c, one] = matrix[..] else { return None };
    ((a, b, c, one) == (0.0, 0.0, 0.0, 1.0)).then_some([fx, cx, fy, cy])
}

/// Reads a camera, of either layout.
///
/// # Errors
/// [`CameraFileError`].
pub fn read(path: &Path) -> Result<Camera, CameraFileError> {
    // OpenCV writes `%YAML:1.0` and `!!opencv-matrix`, and people indent by tabs: neither is YAML, both are common.
    let text = text::read(path)?.replace('\t', "    ").replace("!!opencv-matrix", "");
    let body: String = text.lines().filter(|line| !line.starts_with('%')).flat_map(|line| [line, "\n"]).collect();
    let value: Value = serde_norway::from_str(&body)?;
    let camera = if value.get("camera_matrix").is_some() {
        from_ros(&value)?
    } else {
        from_kalibr(value.get("cam0").ok_or(CameraFileError::UnknownLayout)?)?
    };
    Ok(camera.checked()?)
}

fn from_ros(value: &Value) -> Result<Camera, CameraFileError> {
    let matrix = numbers(value.get("camera_matrix").and_then(|m| m.get("data")))
        .filter(|m| m.len() == 9)
        .ok_or(CameraFileError::BadKey { key: "camera_matrix.data", expected: "a list of 9 numbers" })?;
    let model = value.get("distortion_model").and_then(Value::as_str).unwrap_or("plumb_bob");
    let key = "distortion_coefficients.data";
    let coefficients = match value.get("distortion_coefficients") {
        None => Vec::new(),
        Some(d) => numbers(d.get("data")).ok_or(CameraFileError::BadKey { key, expected: "a list of numbers" })?,
    };
    Ok(Camera {
        width: size(value.get("image_width"), "image_width")?,
        height: size(value.get("image_height"), "image_height")?,
        fx: matrix[0],
        fy: matrix[4],
        cx: matrix[2],
        cy: matrix[5],
        distortion: lens(model, &coefficients)?,
        source: IntrinsicsSource::Stated,
    })
}

fn from_kalibr(cam: &Value) -> Result<Camera, CameraFileError> {
    let projection = cam.get("camera_model").and_then(Value::as_str).unwrap_or("pinhole");
    if projection != "pinhole" {
        return Err(CameraFileError::UnsupportedModel { model: projection.to_owned() });
    }
    let intrinsics = numbers(cam.get("intrinsics"))
        .filter(|k| k.len() == 4)
        .ok_or(CameraFileError::BadKey { key: "cam0.intrinsics", expected: "a list of 4 numbers" })?;
    let model = cam.get("distortion_model").and_then(Value::as_str).unwrap_or("none");
    let key = "cam0.distortion_coeffs";
    let coefficients = match cam.get("distortion_coeffs") {
        None => Vec::new(),
        Some(d) => numbers(Some(d)).ok_or(CameraFileError::BadKey { key, expected: "a list of numbers" })?,
    };
    let resolution = cam.get("resolution");
    Ok(Camera {
        width: size(resolution.and_then(|r| r.get(0)), "cam0.resolution")?,
        height: size(resolution.and_then(|r| r.get(1)), "cam0.resolution")?,
        fx: intrinsics[0],
        fy: intrinsics[1],
        cx: intrinsics[2],
        cy: intrinsics[3],
        distortion: lens(model, &coefficients)?,
        source: IntrinsicsSource::Stated,
    })
}

fn lens(model: &str, c: &[f64]) -> Result<Distortion, CameraFileError> {
    let wrong = |expected| CameraFileError::Coefficients { model: model.to_owned(), got: c.len(), expected };
    // Eight coefficients with zeros at the end are the five of the simple model.
    let c = if c.len() > 5 && c[5..].iter().all(|v| *v == 0.0) { &c[..5] } else { c };
    let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
    match model {
        "none" if c.iter().all(|v| *v == 0.0) => Ok(Distortion::NONE),
        "plumb_bob" | "radtan" => match c.len() {
            0 | 4 | 5 => Ok(Distortion::RadTan { k1: at(0), k2: at(1), p1: at(2), p2: at(3), k3: at(4) }),
            _ => Err(wrong("4 or 5")),
        },
        "equidistant" | "fisheye" => match c.len() {
            0 | 4 => Ok(Distortion::Equidistant { k: [at(0), at(1), at(2), at(3)] }),
            _ => Err(wrong("4")),
        },
        other => Err(CameraFileError::UnsupportedModel { model: other.to_owned() }),
    }
}

fn numbers(value: Option<&Value>) -> Option<Vec<f64>> {
    value?.as_sequence()?.iter().map(Value::as_f64).collect()
}

fn size(value: Option<&Value>, key: &'static str) -> Result<usize, CameraFileError> {
    let whole = value.and_then(Value::as_u64).and_then(|v| usize::try_from(v).ok());
    whole.ok_or(CameraFileError::BadKey { key, expected: "a whole number of pixels" })
}

/// Writes a camera in the layout of ROS `camera_info`; a comment says where its numbers come from.
///
/// # Errors
/// [`CameraFileError::Io`].
pub fn write(path: &Path, camera: &Camera) -> Result<(), CameraFileError> {
    let source = match camera.source {
        IntrinsicsSource::Stated => "as stated by the user's calibration".to_owned(),
        IntrinsicsSource::PhonePrior { relative_sigma } => {
            format!("NOT calibrated: a guess for a phone, focal length ± {:.0} %", 100.0 * relative_sigma)
        }
        IntrinsicsSource::Measured { relative_sigma } => {
            format!("NOT calibrated: focal length measured from the video itself, ± {:.1} %", 100.0 * relative_sigma)
        }
    };
    let (model, coefficients) = match camera.distortion {
        Distortion::RadTan { k1, k2, p1, p2, k3 } => ("plumb_bob", vec![k1, k2, p1, p2, k3]),
        Distortion::Equidistant { k } => ("equidistant", k.to_vec()),
    };
    let list = |values: &[f64]| values.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(", ");
    let matrix = list(&[camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]);
    let text = format!(
        "# ROS camera_info layout; pixel centres at integers\n\
         # intrinsics: {source}\n\
         image_width: {}\nimage_height: {}\ncamera_name: camera\n\
         camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{matrix}]\n\
         distortion_model: {model}\n\
         distortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\n",
        camera.width,
        camera.height,
        coefficients.len(),
        list(&coefficients)
    );
    Ok(std::fs::write(path, text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bare_matrix_takes_the_size_of_the_video() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("camera-intrinsics.txt");
        std::fs::write(&path, "5.85e+02\t0 3.2e+02\n0, 585.5, 240\n0 0 1\n").unwrap();
        let camera = read_for(&path, (640, 480)).unwrap();
        assert_eq!((camera.fx, camera.fy, camera.cx, camera.cy), (585.0, 585.5, 320.0, 240.0));
        assert_eq!((camera.width, camera.height, camera.distortion), (640, 480, Distortion::NONE));
        std::fs::write(&path, "1 2 3 4 5 6 7 8 9").unwrap();
        assert!(read_for(&path, (640, 480)).is_err(), "any nine numbers are no camera");
    }

    fn read_text(content: &str) -> Result<Camera, CameraFileError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("camera.yaml");
        std::fs::write(&path, content).unwrap();
        read(&path)
    }

    const ROS: &str = "image_width: 640\nimage_height: 480\ncamera_matrix:\n  data: [500, 0, 320, 0, 510.5, 240, 0, 0, 1]\n";

    #[test]
    fn what_was_written_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("camera.yaml");
        let plain = Camera { source: IntrinsicsSource::Stated, ..Camera::phone_prior(1920, 1080) };
        let lenses = [
            Distortion::RadTan { k1: 0.1, k2: -1e-7, p1: 1.0 / 3.0, p2: 0.0, k3: 5e-9 },
            Distortion::Equidistant { k: [0.03, -0.02, 1e-21, 0.0] },
        ];
        for distortion in lenses {
            let camera = Camera { distortion, ..plain.clone() };
            write(&path, &camera).unwrap();
            assert_eq!(read(&path).unwrap(), camera);
        }
    }

    #[test]
    fn a_guessed_camera_says_that_it_is_guessed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("camera.yaml");
        write(&path, &Camera::phone_prior(640, 480)).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("NOT calibrated") && text.contains("15 %"), "{text}");
        let measured = Camera { source: IntrinsicsSource::Measured { relative_sigma: 0.023 }, ..Camera::phone_prior(640, 480) };
        let path = dir.path().join("measured.yaml");
        write(&path, &measured).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.contains("NOT calibrated: focal length measured from the video itself, ± 2.3 %"), "{text}");
    }

    #[test]
    fn kalibr_chains_are_read_with_their_odd_first_line() {
        let text = "%YAML:1.0 # need to specify the file type\n---\n# a comment\ncam0:\n\tcamera_model: pinhole\n\
                    \tdistortion_model: equidistant\n\tdistortion_coeffs: [0.1, 0.2, 0.3, 0.4]\n\
                    \tintrinsics: [461.6, 459.7, 732.9, 720.5]\n\tresolution: [1472, 1440]\n";
        let camera = read_text(text).unwrap();
        assert_eq!((camera.width, camera.height, camera.fx, camera.cy), (1472, 1440, 461.6, 720.5));
        assert_eq!(camera.distortion, Distortion::Equidistant { k: [0.1, 0.2, 0.3, 0.4] });
    }

    #[test]
    fn four_and_eight_coefficients_are_understood_where_they_mean_the_same() {
        let with = |data: &str| read_text(&format!("{ROS}distortion_model: plumb_bob\ndistortion_coefficients: {{data: {data}}}\n"));
        let expected = Distortion::RadTan { k1: 0.1, k2: 0.2, p1: 0.3, p2: 0.4, k3: 0.0 };
        assert_eq!(with("[0.1, 0.2, 0.3, 0.4]").unwrap().distortion, expected);
        assert_eq!(with("[0.1, 0.2, 0.3, 0.4, 0, 0, 0, 0]").unwrap().distortion, expected);
        assert!(matches!(with("[0.1, 0.2, 0.3, 0.4, 0, 0, 0, 1]"), Err(CameraFileError::Coefficients { got: 8, .. })));
    }

    #[test]
    fn models_that_are_not_supported_are_named() {
        let error = read_text(&format!("{ROS}distortion_model: rational_polynomial\n")).unwrap_err();
        assert!(error.to_string().contains("rational_polynomial"), "{error}");
        let error = read_text("cam0:\n  camera_model: eucm\n").unwrap_err();
        assert!(error.to_string().contains("eucm"), "{error}");
    }

    #[test]
    fn what_is_no_camera_file_is_refused() {
        assert!(matches!(read_text("just words"), Err(CameraFileError::UnknownLayout)));
        assert!(matches!(read_text("{"), Err(CameraFileError::Yaml(_))));
        assert!(matches!(read_text(""), Err(CameraFileError::UnknownLayout)));
        assert!(matches!(read_text("camera_matrix:\n  data: [1, 2]\n"), Err(CameraFileError::BadKey { .. })));
        assert!(matches!(read_text(&ROS.replace("640", "0")), Err(CameraFileError::Camera(_))));
        assert!(matches!(read_text(&ROS.replace("500", ".nan")), Err(CameraFileError::Camera(_))));
        assert!(matches!(read(Path::new("no such file")), Err(CameraFileError::Io(_))));
    }
}
