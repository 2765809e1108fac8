//! Stories: what is filmed is what is true, and a walk is one that a person could take.

mod film;
mod site;
mod walk;

use std::sync::LazyLock;

use planwalk_sim::{
    Building, BuildingOptions, CLEARANCE_M, CameraOptions, Lens, Look, OdometryNoise, People, RoomKind, Scene, SceneOptions, SimError,
    WalkOptions, simulate_odometry,
};
use planwalk_types::{Camera, Cell, GrayImage, Pt2, Seed, Stamp, wrap_angle};

/// The demos of the first few seeds.
static DEMOS: LazyLock<Vec<Scene>> = LazyLock::new(|| (0..6).map(|seed| Scene::demo(Seed(seed))).collect());

/// A small quick scene: the demo's building and walk, at a quarter of its pixels.
fn small(seed: u64) -> SceneOptions {
    let camera = CameraOptions { width: 320, height: 240, ..Default::default() };
    SceneOptions { seed: Seed(seed), camera, ..Default::default() }
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let film = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let scene = Scene::with_options(&small(3)).unwrap();
            [0, 100, 200].map(|i| scene.frame(i).image)
        })
    };
    let (one, two, three) = (film(1), film(2), film(3));
    assert!(one == two && two == three);
    // With everything on: shutter, blur, exposure, habits and people.
    let all = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let camera = CameraOptions { width: 120, height: 90, ..CameraOptions::phone() };
            let options = SceneOptions { camera, walk: WalkOptions::lively(), people: People::filling(0.2), ..small(3) };
            let scene = Scene::with_options(&options).unwrap();
            [100, 500, 900].map(|i| scene.frame(i).image)
        })
    };
    assert!(all(1) == all(3));
    let other = Scene::with_options(&small(4)).unwrap();
    assert!(other.frame(100).image != one[1], "another seed films another building");
}

#[test]
fn frames_come_in_order_and_differ() {
    let mut options = small(5);
    options.walk.duration_s = 3.0;
    let scene = Scene::with_options(&options).unwrap();
    let frames: Vec<_> = scene.frames().collect();
    assert_eq!(frames.len(), scene.frame_count());
    assert_eq!(frames.len(), 45);
    assert_eq!(frames.len(), scene.truth().len());
    for (pair, truth) in frames.windows(2).zip(scene.truth()) {
        assert!(pair[0].stamp < pair[1].stamp && pair[0].stamp == truth.0);
        assert!(pair[0].image != pair[1].image);
        let mean = pair[0].image.data().iter().map(|p| f64::from(*p)).sum::<f64>() / (320.0 * 240.0);
        assert!(mean > 50.0 && mean < 220.0, "neither black nor burnt out: {mean}");
    }
}

#[test]
fn nobody_walks_through_walls_or_furniture() {
    for (seed, scene) in DEMOS.iter().enumerate() {
        let plan = scene.plan();
        for (stamp, pose) in scene.truth_on_floor() {
            // The walk was checked every 5 cm; between these the clearance changes by no more than 2.5 cm.
            let clear = scene.clearance_m(pose.origin());
            assert!(clear > CLEARANCE_M - 0.025, "seed {seed}: {clear} m at {:.2} s", stamp.as_secs());
            assert_eq!(plan.at(pose.origin()), Cell::Free, "seed {seed}");
        }
    }
}

#[test]
fn a_demo_walk_passes_doors_turns_and_is_long_enough_to_tell_where_it_is() {
    for (seed, scene) in DEMOS.iter().enumerate() {
        let truth = scene.truth_on_floor();
        assert!(scene.walk().doors_passed() >= 2, "seed {seed}");
        let length = scene.walk().length_m();
        assert!(length > 20.0 && length < 40.0, "seed {seed}: {length} m");
        assert!(scene.walk().turns() >= 2, "seed {seed}");
        let kinds = |kind: RoomKind| {
            truth
                .iter()
                .filter(|(_, p)| scene.building().room_at(p.origin()).is_some_and(|r| scene.building().rooms[r].kind == kind))
                .count()
        };
        assert!(kinds(RoomKind::Corridor) > 30, "seed {seed}: two seconds at least in the corridor");
    }
}

#[test]
fn people_walk_at_a_human_speed_and_bob_with_their_steps() {
    let scene = Scene::with_options(&SceneOptions { camera: CameraOptions { fps: 50.0, ..Default::default() }, ..small(6) }).unwrap();
    let truth = scene.truth();
    let speeds: Vec<f64> = truth
        .windows(25)
        .map(|w| {
            let d = w[24].1.origin().coords - w[0].1.origin().coords;
            d.x.hypot(d.y) / w[24].0.secs_since(w[0].0)
        })
        .collect();
    let mut sorted = speeds.clone();
    sorted.sort_by(f64::total_cmp);
    let (median, top) = (sorted[sorted.len() / 2], sorted[sorted.len() - 1]);
    assert!(median > 0.8 && median < 1.4, "median {median} m/s");
    assert!(top < 1.6, "top {top} m/s");
    assert!(sorted[0] < 0.5 * median, "they slow down somewhere: {} m/s", sorted[0]);
    let heights: Vec<f64> = truth.iter().map(|(_, p)| p.origin().coords.z).collect();
    let (low, high) = heights.iter().fold((f64::INFINITY, 0.0f64), |(l, h), z| (l.min(*z), h.max(*z)));
    assert!(high - low > 0.03 && high - low < 0.08, "bobbing of {} m", high - low);
    // Steps in the middle ten seconds: upward crossings of the mean height.
    let middle = &heights[500..1000];
    let mean = middle.iter().sum::<f64>() / 500.0;
    let steps = middle.windows(2).filter(|w| w[0] < mean && w[1] >= mean).count() as f64 / 10.0;
    assert!(steps > 1.2 && steps < 2.3, "{steps} steps a second");
}

#[test]
fn heads_do_not_spin() {
    for (seed, scene) in DEMOS.iter().enumerate() {
        let truth = scene.truth_on_floor();
        for pair in truth.windows(2) {
            let rate = wrap_angle(pair[1].1.heading_rad - pair[0].1.heading_rad).abs() / pair[1].0.secs_since(pair[0].0);
            // The body's 1 rad/s; the gaze runs ahead of it while it speeds up (0.25 s · 4 rad/s²), and looks around a little.
            assert!(rate < 2.3, "seed {seed}: {rate} rad/s");
        }
    }
}

#[test]
fn a_slower_walker_gets_less_far_and_a_trolley_does_not_bob() {
    let walked = |speed_mps: f64| {
        let walk = WalkOptions { speed_mps, gait: 0.0, ..Default::default() };
        Scene::with_options(&SceneOptions { walk, ..small(7) }).unwrap()
    };
    let (slow, fast) = (walked(0.8), walked(1.3));
    assert!(slow.walk().length_m() < 0.85 * fast.walk().length_m());
    assert!(slow.truth().iter().all(|(_, p)| (p.origin().coords.z - 1.52).abs() < 1e-12));
}

/// A scene that differs from the others of this kind in its look and camera only: without furniture the walk is the same.
fn with_look(texture_density: f64, furniture: f64, noise_grey: f64, exposure_drift: f64) -> Scene {
    let look = Look { texture_density, furniture };
    let mut options = SceneOptions { look, ..small(8) };
    (options.camera.noise_grey, options.camera.exposure_drift) = (noise_grey, exposure_drift);
    Scene::with_options(&options).unwrap()
}

#[test]
fn a_bare_building_shows_less_than_a_rich_one() {
    let edges = |texture_density: f64| {
        let scene = with_look(texture_density, 0.0, 0.0, 0.0);
        let steep = |image: &GrayImage| {
            (0..image.height()).map(|v| image.row(v).windows(2).filter(|w| w[0].abs_diff(w[1]) > 4).count()).sum::<usize>()
        };
        (0..scene.frame_count()).step_by(30).map(|i| steep(&scene.frame(i).image)).sum::<usize>()
    };
    let (bare, ordinary, rich) = (edges(0.0), edges(1.0), edges(2.0));
    // Doors, tiles and lamps are there in all of them.
    assert!(5 * ordinary > 6 * bare && rich > ordinary, "edges: bare {bare}, ordinary {ordinary}, rich {rich}");
}

#[test]
fn furniture_stands_in_rooms_and_on_no_plan() {
    let free = |furniture: f64| {
        let scene = with_look(1.0, furniture, 1.5, 0.05);
        let plan = scene.plan();
        let open = (0..plan.height()).step_by(4).flat_map(|row| (0..plan.width()).step_by(4).map(move |column| (column, row)));
        (open.filter(|(c, r)| scene.clearance_m(plan.centre(*c, *r)) > 0.2).count(), plan)
    };
    let ((empty, plan), (full, same)) = (free(0.0), free(1.0));
    assert!(empty > full + 100, "cells of 20 cm: {empty} free in an empty building, {full} in a furnished one");
    assert!(plan == same);
}

#[test]
fn noise_and_exposure_are_as_strong_as_asked_for() {
    let film = |noise_grey: f64, exposure_drift: f64| with_look(1.0, 0.0, noise_grey, exposure_drift);
    let (clean, noisy, drifting) = (film(0.0, 0.0), film(4.0, 0.0), film(0.0, 0.3));
    let (a, b) = (clean.frame(40).image, noisy.frame(40).image);
    // Away from black and white, where nothing is cut off.
    let errors: Vec<f64> =
        a.data().iter().zip(b.data()).filter(|(p, _)| **p > 20 && **p < 235).map(|(p, q)| f64::from(*q) - f64::from(*p)).collect();
    let sigma = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    // Rounding to whole grey levels adds 1/12 to each variance: 0.02 in sigma; 5 % is generous for 10⁴ and more pixels.
    assert!((sigma - 4.0).abs() < 0.2, "{sigma} grey levels");
    let mean = |image: &GrayImage| image.data().iter().map(|p| f64::from(*p)).sum::<f64>();
    let gains: Vec<f64> = (0..450).step_by(45).map(|i| mean(&drifting.frame(i).image) / mean(&clean.frame(i).image)).collect();
    let (low, high) = gains.iter().fold((f64::INFINITY, 0.0f64), |(l, h), g| (l.min(*g), h.max(*g)));
    assert!(high - low > 0.15 && low > 0.65 && high < 1.35, "gains {gains:?}");
}

#[test]
fn noise_free_odometry_is_the_truth() {
    let scene = &DEMOS[2];
    let truth = scene.truth_on_floor();
    let noise = OdometryNoise { metres_per_unit: 2.5, ..OdometryNoise::none() };
    let (path, sightings) = simulate_odometry(&truth, scene.walls(), &noise, Seed(1));
    assert_eq!(path.steps.len() + 1, truth.len());
    let start = truth[0].1;
    for ((step, pose), (stamp, true_pose)) in path.stamps().zip(path.poses()).zip(&truth) {
        assert_eq!(step, *stamp);
        let (s, c) = start.heading_rad.sin_cos();
        let (x, y) = (2.5 * pose.x, 2.5 * pose.y);
        let back = Pt2::new(start.x + c * x - s * y, start.y + s * x + c * y);
        // Round-off of 450 compositions over 30 m.
        assert!(back.distance(true_pose.origin()) < 1e-9);
    }
    assert!(sightings.len() > 500, "{}", sightings.len());
    let plan = scene.plan();
    for sighting in &sightings {
        let (_, pose) = truth.iter().find(|(stamp, _)| *stamp == sighting.stamp).unwrap();
        let (s, c) = (pose.heading_rad + sighting.bearing_rad).sin_cos();
        // Centre lines lie inside the walls that the plan draws; at a wall's end it may have rounded the last cell, 5 cm, away.
        let on_wall = |dx: f64, dy: f64| {
            plan.at(Pt2::new(pose.x + 2.5 * sighting.range * c + dx, pose.y + 2.5 * sighting.range * s + dy)) == Cell::Wall
        };
        let cell = plan.cell_m();
        assert!(
            [(0.0, 0.0), (cell, 0.0), (-cell, 0.0), (0.0, cell), (0.0, -cell)].iter().any(|(dx, dy)| on_wall(*dx, *dy)),
            "{sighting:?}"
        );
    }
}

#[test]
fn odometry_errs_as_its_noise_says() {
    let scene = &DEMOS[2];
    let truth = scene.truth_on_floor();
    let length = scene.walk().length_m();
    let noise = OdometryNoise { furniture_share: 0.4, ..Default::default() };
    let exact = OdometryNoise { furniture_share: 0.0, range_relative: 0.0, bearing_sigma_rad: 0.0, ..noise };
    let (runs, mut squares) = (400, 0.0);
    let turned: f64 = truth.windows(2).map(|w| wrap_angle(w[1].1.heading_rad - w[0].1.heading_rad)).sum();
    for seed in 0..runs {
        let (path, _) = simulate_odometry(&truth, &[], &noise, Seed(seed));
        squares += (path.steps.iter().map(|s| s.turn_rad).sum::<f64>() - turned).powi(2);
    }
    let sigma = (squares / runs as f64).sqrt();
    let by_turns: f64 = truth.windows(2).map(|w| (0.01 * wrap_angle(w[1].1.heading_rad - w[0].1.heading_rad)).powi(2)).sum();
    // The camera's path is longer than the body's by its sway: a few per cent.
    let said = (noise.heading_walk_rad_per_sqrt_m.powi(2) * length + by_turns).sqrt();
    // A deviation from 400 runs has a standard error of 1/√800 = 3.5 %; four of them, and 3 % for the sway.
    assert!((sigma / said - 1.0).abs() < 0.17, "{sigma} rad, said {said} rad");
    // Each noise has its own stream: the exact sightings are those of the same rays.
    let (_, noisy) = simulate_odometry(&truth, scene.walls(), &noise, Seed(9));
    let (_, sharp) = simulate_odometry(&truth, scene.walls(), &exact, Seed(9));
    assert_eq!(noisy.len(), sharp.len());
    let nearer = noisy.iter().zip(&sharp).filter(|(a, b)| a.range < 0.8 * b.range).count() as f64 / noisy.len() as f64;
    // Furniture stands at 15 % to 95 % of the way: 81 % of it nearer than 0.8. Bernoulli, n > 500: 4 σ < 0.09.
    assert!((nearer - 0.4 * 0.81).abs() < 0.09, "{nearer}");
}

#[test]
fn odometry_is_the_same_for_the_same_seed() {
    let truth = DEMOS[2].truth_on_floor();
    let run = |seed: u64| simulate_odometry(&truth, DEMOS[2].walls(), &OdometryNoise::default(), Seed(seed));
    let (a, b) = (run(4), run(4));
    assert!(a.0.steps == b.0.steps && a.1 == b.1);
    assert!(a.0.steps != run(5).0.steps);
}

#[test]
fn what_makes_no_scene_is_refused_with_the_numbers() {
    let with = |change: fn(&mut SceneOptions)| {
        let mut options = small(1);
        change(&mut options);
        Scene::with_options(&options).unwrap_err().to_string()
    };
    assert!(with(|o| o.camera.fps = f64::NAN).contains("frame rate"));
    assert!(with(|o| o.walk.duration_s = -1.0).contains("-1"));
    assert!(with(|o| o.camera.width = 0).contains("width"));
    assert!(with(|o| o.camera.noise_grey = 1e9).contains("noise"));
    let mut walls = Building::generate(&BuildingOptions::default(), Seed(1)).unwrap();
    walls.walls.clear();
    let none = Scene::new(walls, &small(1)).unwrap_err();
    assert!(matches!(none, SimError::Plan(_)), "{none}");
}

#[test]
fn a_building_with_all_doors_shut_says_that_there_is_no_way() {
    let mut building = Building::generate(&BuildingOptions::default(), Seed(1)).unwrap();
    for door in &mut building.doors {
        door.open = false;
    }
    let error = Scene::new(building, &small(1)).unwrap_err();
    assert!(matches!(error, SimError::NoWalk { .. }), "{error}");
    assert!(error.to_string().contains("doors"));
}

#[test]
fn stamps_follow_the_frame_rate() {
    let options = SceneOptions { camera: CameraOptions { fps: 30.0, ..Default::default() }, ..small(1) };
    let scene = Scene::with_options(&options).unwrap();
    assert_eq!(scene.frame_count(), 900);
    assert_eq!((scene.stamp(0), scene.stamp(1), scene.stamp(30)), (Stamp(0), Stamp(33_333_333), Stamp(1_000_000_000)));
}

#[test]
fn options_can_be_stated_in_a_file_and_come_back_from_it() {
    let text = "seed = 7\n[walk]\nspeed_mps = 0.9\nstops_per_minute = 2.0\n[camera]\nlens = \"fisheye\"\nfov_deg = 120.0\nportrait = true\n\
                readout_ms = 20.0\n[people]\nshare = 0.2\n[look]\nfurniture = 0.0\n";
    let options: SceneOptions = toml::from_str(text).unwrap();
    assert_eq!((options.seed, options.camera.lens, options.people.share), (Seed(7), Lens::Fisheye, 0.2));
    assert_eq!(options.walk.duration_s, WalkOptions::default().duration_s, "what is not stated has its default");
    let back: SceneOptions = toml::from_str(&toml::to_string(&options).unwrap()).unwrap();
    assert_eq!(back, options);
    let calibrated = CameraOptions { calibration: Some(Camera::phone_prior(64, 48)), ..Default::default() };
    assert_eq!(toml::from_str::<CameraOptions>(&toml::to_string(&calibrated).unwrap()).unwrap(), calibrated);
    let error = toml::from_str::<SceneOptions>("[walk]\nspeed = 1.0\n").unwrap_err().to_string();
    assert!(error.contains("speed_mps"), "a misspelt option is refused with the names that there are: {error}");
}
