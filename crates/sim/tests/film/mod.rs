//! Is what is filmed what is true? Lenses, shutters, exposure, and the people in the pictures.

use nalgebra::{Vector2, Vector3};
use planwalk_sim::{CameraOptions, Lens, People, Scene, SceneOptions, WalkOptions};
use planwalk_types::{Camera, Distortion, GrayImage, Plan, Pt3, Seed, wrap_angle};

use crate::small;

/// Brightness between pixels.
fn bilinear(image: &GrayImage, u: f64, v: f64) -> Option<f64> {
    if !(u >= 0.0 && v >= 0.0 && u < (image.width() - 1) as f64 && v < (image.height() - 1) as f64) {
        return None;
    }
    let (i, j, a, b) = (u as usize, v as usize, u.fract(), v.fract());
    let row = |j: usize| f64::from(image.at(i, j)) * (1.0 - a) + f64::from(image.at(i + 1, j)) * a;
    Some(row(j) * (1.0 - b) + row(j + 1) * b)
}

/// Where brightness rises from the dark side to the bright one along pixel positions `at(0..)`, as a fraction of their number:
/// the crossing of the middle between both ends' means.
fn edge(image: &GrayImage, at: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
    let values: Option<Vec<f64>> = (-8..=8).map(|k| bilinear(image, at(f64::from(k) * 0.25).0, at(f64::from(k) * 0.25).1)).collect();
    let values = values?;
    let (dark, bright) = (values[..4].iter().sum::<f64>() / 4.0, values[13..].iter().sum::<f64>() / 4.0);
    if bright - dark < 40.0 {
        return None;
    }
    let middle = 0.5 * (dark + bright);
    let k = values.windows(2).position(|w| w[0] < middle && w[1] >= middle)?;
    Some((k as f64 - 8.0 + (middle - values[k]) / (values[k + 1] - values[k])) * 0.25)
}

/// How far the edges of picture frames are from where truth and camera say, pixels; each of the two edges of each corner that is seen
/// near and steep enough.
pub fn landmark_errors(scene: &Scene, frames: impl Iterator<Item = usize>) -> Vec<f64> {
    let (landmarks, truth) = (scene.landmarks(), scene.truth());
    let mut errors = Vec::new();
    for index in frames {
        let eye = truth[index].1.origin().coords;
        let mut image = None;
        for mark in &landmarks {
            // Both edges of the corner, 12 cm away from it: the upright one and the level one; and the way out of the frame.
            let (ox, oy) = mark.outward;
            let c = mark.at.coords;
            let upright = (Pt3::<Plan>::new(c.x, c.y, c.z - 0.12), Vector3::new(ox, oy, 0.0));
            let level = (Pt3::<Plan>::new(c.x - 0.12 * ox, c.y - 0.12 * oy, c.z), Vector3::new(0.0, 0.0, 1.0));
            for (point, out) in [upright, level] {
                let ahead = eye - point.coords;
                let slant = (ahead.x * mark.normal.0 + ahead.y * mark.normal.1) / ahead.norm();
                // Steep and near enough for the frame's 25 mm to be wider than the 2 px that the edge is sought in.
                let near_m = 3.6 / 512.0 * scene.camera().focal_px();
                if slant < 0.6 || ahead.norm() > near_m || !scene.sees(index, Pt3::from_vector(point.coords + 0.01 * ahead)) {
                    continue;
                }
                let (at, off) = (project(scene, index, point.coords), project(scene, index, point.coords + 0.01 * out));
                let (Some(at), Some(off)) = (at, off) else { continue };
                let way = (off - at).normalize();
                let frame = image.get_or_insert_with(|| scene.frame(index).image);
                if let Some(found) = edge(frame, |k| (at.x + k * way.x, at.y + k * way.y)) {
                    // One pixel for each: beside some edges light falls off or another frame hangs near, which moves the middle level.
                    assert!(found.abs() < 1.0, "frame {index}: the edge at {at:?} is {found:.2} px off");
                    errors.push(found);
                }
            }
        }
    }
    errors
}

/// The pixel of a point by truth, camera and shutter alone. A shutter's line is seen at its share of the readout from the middle line,
/// rows from the top, columns of portrait frames from the right.
fn project(scene: &Scene, index: usize, point: Vector3<f64>) -> Option<Vector2<f64>> {
    let (camera, options) = (scene.camera(), scene.camera_options());
    let stamp_s = scene.stamp(index).as_secs();
    let mut delay_s = 0.0;
    let mut pixel = None;
    for _ in 0..if options.readout_ms > 0.0 { 10 } else { 1 } {
        let pose = scene.walk().at(stamp_s + delay_s).plan_from_camera;
        let found = camera.project(&(pose.inverse() * Pt3::<Plan>::from_vector(point)).coords)?;
        let (width, height) = (camera.width as f64, camera.height as f64);
        let share = if options.portrait { (width - 1.0 - found.x) / width } else { found.y / height };
        let middle = if options.portrait { 0.5 - 0.5 / width } else { 0.5 - 0.5 / height };
        delay_s = 1e-3 * options.readout_ms * (share - middle);
        pixel = Some(found);
    }
    pixel
}

#[test]
fn picture_frames_are_drawn_where_truth_and_camera_say() {
    let lens = Distortion::RadTan { k1: -0.12, k2: 0.04, p1: 0.001, p2: -0.0007, k3: 0.0 };
    let perfect = CameraOptions::noiseless();
    let bent = CameraOptions { calibration: Some(Camera { distortion: lens, ..Camera::phone_prior(640, 480) }), ..perfect.clone() };
    let fisheye = CameraOptions { lens: Lens::Fisheye, fov_deg: 100.0, ..perfect.clone() };
    let portrait = CameraOptions { portrait: true, ..perfect.clone() };
    // A turning head and a slow shutter: lines at the edges are tens of pixels from where the middle line's pose puts them.
    let rolling = CameraOptions { readout_ms: 30.0, ..perfect.clone() };
    let upright = CameraOptions { portrait: true, ..rolling.clone() };
    let lively = WalkOptions { glances_per_minute: 12.0, tremor_rad: 0.01, ..Default::default() };
    for (name, camera, walk, seeds) in [
        ("pinhole", perfect, WalkOptions::default(), [1, 3]),
        ("radial and tangential", bent, WalkOptions::default(), [2, 4]),
        ("fisheye", fisheye, WalkOptions::default(), [1, 2]),
        ("portrait", portrait, WalkOptions::default(), [3, 4]),
        ("rolling shutter", rolling, lively, [1, 2]),
        ("portrait with rolling shutter", upright, lively, [3, 4]),
    ] {
        let mut errors = Vec::new();
        for seed in seeds {
            let scene =
                Scene::with_options(&SceneOptions { seed: Seed(seed), camera: camera.clone(), walk, ..Default::default() }).unwrap();
            errors.extend(landmark_errors(&scene, (5..scene.frame_count()).step_by(12)));
        }
        assert!(errors.len() >= 25, "{name}: only {} edges were seen", errors.len());
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let spread = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        // A tenth of a pixel in the mean: truth and pixel centres agree to far less than the half pixel that a wrong convention costs.
        assert!(mean.abs() < 0.1 && spread < 0.25, "{name}: edges are {mean:.3} px off in the mean, {spread:.3} px root mean square");
    }
}

#[test]
fn the_scene_itself_says_on_which_line_a_point_is_seen() {
    let camera = CameraOptions { readout_ms: 30.0, ..CameraOptions::noiseless() };
    let scene = Scene::with_options(&SceneOptions { camera, ..small(1) }).unwrap();
    for index in (0..scene.frame_count()).step_by(40) {
        for mark in scene.landmarks().iter().filter(|mark| scene.sees(index, mark.at)) {
            let (one, other) = (scene.pixel(index, mark.at).unwrap(), project(&scene, index, mark.at.coords).unwrap());
            // Both iterations have converged: each round errs by a few per cent of the one before.
            assert!((one - other).norm() < 1e-3, "{one} {other}");
        }
    }
}

/// Mean share of pixels in which two videos of the same walk differ.
fn differing(one: &Scene, other: &Scene, every: usize) -> f64 {
    let frames: Vec<usize> = (0..one.frame_count()).step_by(every).collect();
    let share = |index: &usize| {
        let (a, b) = (one.frame(*index).image, other.frame(*index).image);
        a.data().iter().zip(b.data()).filter(|(p, q)| p != q).count() as f64 / a.data().len() as f64
    };
    frames.iter().map(share).sum::<f64>() / frames.len() as f64
}

#[test]
fn people_fill_as_much_of_the_view_as_asked_for() {
    for seed in [1, 2] {
        let camera = CameraOptions { width: 160, height: 120, ..CameraOptions::noiseless() };
        let with = |share: f64| {
            let people = People::filling(share);
            Scene::with_options(&SceneOptions { seed: Seed(seed), camera: camera.clone(), people, ..Default::default() }).unwrap()
        };
        let empty = with(0.0);
        for share in [0.1, 0.3, 0.5] {
            let full = with(share);
            assert_eq!(full.truth(), empty.truth(), "people are in nobody's way");
            assert!(full.plan() == empty.plan());
            // Clothes may have the grey of the wall behind: a few per cent of their pixels.
            let found = differing(&full, &empty, 10);
            assert!((found / share - 1.0).abs() < 0.3, "seed {seed}: {found} of the view for {share}");
            let told: Vec<f64> = (0..full.frame_count()).step_by(10).map(|i| full.people_share(i)).collect();
            let told = told.iter().sum::<f64>() / told.len() as f64;
            assert!((told - found).abs() < 0.1 * share + 0.01, "it says {told}, but it is {found}");
        }
    }
}

#[test]
fn a_longer_exposure_blurs_what_moves_and_only_that() {
    let with = |exposure_ms: f64| {
        let camera = CameraOptions { exposure_ms, ..CameraOptions { fps: 10.0, ..CameraOptions::noiseless() } };
        let walk = WalkOptions { glances_per_minute: 20.0, ..Default::default() };
        Scene::with_options(&SceneOptions { camera: CameraOptions { width: 320, height: 240, ..camera }, walk, ..small(2) }).unwrap()
    };
    let (sharp, blurred) = (with(0.0), with(40.0));
    let steepness = |scene: &Scene, index: usize| {
        let image = scene.frame(index).image;
        (0..image.height()).flat_map(|v| image.row(v).windows(2).map(|w| f64::from(w[0].abs_diff(w[1]))).collect::<Vec<_>>()).sum::<f64>()
    };
    let turning = |index: usize| {
        let heading = |s: f64| sharp.walk().at(s).on_floor.heading_rad;
        let t = sharp.stamp(index).as_secs();
        (wrap_angle(heading(t + 0.02) - heading(t - 0.02)) / 0.04).abs()
    };
    let mut by_rate: Vec<usize> = (0..sharp.frame_count()).collect();
    by_rate.sort_by(|a, b| turning(*a).total_cmp(&turning(*b)));
    let fastest = by_rate[by_rate.len() - 1];
    assert!(turning(fastest) > 1.0, "{} rad/s", turning(fastest));
    assert!(steepness(&blurred, fastest) < 0.7 * steepness(&sharp, fastest));
    // Past its end the walk stands still.
    let end = sharp.frame_count() + 20;
    assert!(sharp.frame(end).image == blurred.frame(end).image);
}

#[test]
fn the_automatic_exposure_evens_out_what_the_rooms_do_not() {
    let with = |auto_exposure: bool| {
        let camera = CameraOptions { width: 64, height: 48, auto_exposure, ..CameraOptions::noiseless() };
        Scene::with_options(&SceneOptions { camera, walk: WalkOptions::lively(), ..small(3) }).unwrap()
    };
    let spread = |scene: &Scene| {
        let means: Vec<f64> = (0..scene.frame_count())
            .step_by(5)
            .map(|i| scene.frame(i).image.data().iter().map(|p| f64::from(*p)).sum::<f64>() / (64.0 * 48.0))
            .collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        ((means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / means.len() as f64).sqrt(), mean)
    };
    let ((loose, _), (steady, mean)) = (spread(&with(false)), spread(&with(true)));
    assert!(steady < 0.8 * loose, "deviation of {steady} grey levels with it, {loose} without");
    assert!(steady > 0.5, "it lags");
    // 0.46 of white.
    assert!((mean - 117.0).abs() < 12.0, "{mean}");
}
