//! Stories of the front door: what a person gets to see of a walk, and how it is scored.

mod parts;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use planwalk::evaluate::{PlaceOptions, place};
use planwalk::figure::{ParticleCloud, ParticlePicture, PlacementPicture, TrackPicture, TrajectoryPicture, png_of};
use planwalk::locate::StartPrior;
use planwalk::types::path::StepNoise;
use planwalk::types::{
    CameraPose, Estimate, FloorPlan, Hypothesis, OdometryScale, Path, Plan, PlanPose, Pt2, Rigid3, ScaleEstimate, Seed, Sighting, Stamp,
    Status, TrackingState, Wall,
};
use planwalk::{LocalizeOptions, Method, Walk, check_start, filmstrip, localize};

fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Wall {
    Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) }
}

/// An L of two corridors, 12 m and 8 m long and 2 m wide.
fn corridors() -> [Wall; 6] {
    [
        wall(0.0, 0.0, 12.0, 0.0),
        wall(12.0, 0.0, 12.0, 8.0),
        wall(12.0, 8.0, 10.0, 8.0),
        wall(10.0, 8.0, 10.0, 2.0),
        wall(10.0, 2.0, 0.0, 2.0),
        wall(0.0, 2.0, 0.0, 0.0),
    ]
}

fn plan() -> FloorPlan {
    FloorPlan::from_walls(&corridors(), 0.05, 1.0).unwrap()
}

/// Along one corridor, round the corner, and down the other: one pose each 0.5 s, 0.5 m apart.
fn truth() -> Vec<(Stamp, PlanPose)> {
    let mut poses = Vec::new();
    let mut pose = PlanPose::new(1.0, 1.0, 0.0);
    for i in 0..=32 {
        poses.push((Stamp(i * 500_000_000), pose));
        let turn = if (19..22).contains(&i) { std::f64::consts::FRAC_PI_2 / 3.0 } else { 0.0 };
        pose = PlanPose::new(pose.x + 0.5 * pose.heading_rad.cos(), pose.y + 0.5 * pose.heading_rad.sin(), pose.heading_rad + turn);
    }
    poses
}

/// Distance from a place to the first wall in a direction.
fn range(from: Pt2<Plan>, angle: f64) -> f64 {
    let (s, c) = angle.sin_cos();
    let hit = |w: &Wall| {
        let (ex, ey) = (w.to.x - w.from.x, w.to.y - w.from.y);
        let (dx, dy) = (w.from.x - from.x, w.from.y - from.y);
        let det = ex * s - ey * c;
        let (t, u) = ((ex * dy - ey * dx) / det, (c * dy - s * dx) / det);
        (t > 0.0 && (0.0..=1.0).contains(&u)).then_some(t)
    };
    corridors().iter().filter_map(hit).fold(50.0, f64::min)
}

/// The walk as an exact odometry in metres gives it, with what it saw of the walls.
fn walk() -> Walk {
    let truth = truth();
    let step = |pair: &[(Stamp, PlanPose)]| {
        let moved = pair[0].1.inverse() * pair[1].1;
        StepNoise::default().step(pair[0].0, pair[1].0, moved.x, moved.y, moved.heading_rad)
    };
    let look = |(stamp, pose): &(Stamp, PlanPose)| {
        let see = |bearing_rad: f64| Sighting {
            stamp: *stamp,
            bearing_rad,
            range: range(pose.origin(), pose.heading_rad + bearing_rad),
            sigma: 0.05,
        };
        [-0.6, -0.3, 0.0, 0.3, 0.6].map(see)
    };
    let path = Path { steps: truth.windows(2).map(step).collect() };
    Walk { path, sightings: truth[1..].iter().flat_map(look).collect(), scale: OdometryScale::Metric }
}

fn start() -> StartPrior {
    StartPrior { x: 1.0, y: 1.0, heading_rad: Some(0.0), sigma_m: 0.3, sigma_rad: 0.1 }
}

#[test]
fn a_walk_from_a_known_start_is_found_and_its_particles_are_kept() {
    let options = LocalizeOptions { seed: Seed(3), start: Some(start()), method: Method::Planwalk };
    let mut shares = Vec::new();
    let run = localize(&walk(), &plan(), &options, &mut |share| shares.push(share)).unwrap();
    assert!(shares.windows(2).all(|w| w[0] <= w[1]) && shares.last() == Some(&1.0), "progress rises to 1");
    let errors = place::score(&run.localization.track, &run.localization.filter, &truth(), &PlaceOptions::default()).unwrap().track;
    // Half a corridor's half width: the picture then shows the walk where it was.
    assert!(errors.median_m < 0.5 && errors.end_m < 0.5, "{errors:?}");
    assert!((2..=48).contains(&run.clouds.len()), "{} moments for the animation", run.clouds.len());
    let strip = filmstrip(&run.clouds);
    assert!((2..=8).contains(&strip.len()), "{} moments for the picture", strip.len());
    assert_eq!(strip.last().map(|c| c.stamp), run.clouds.last().map(|c| c.stamp), "the last moment is shown");
    assert!(run.clouds.windows(2).all(|w| w[0].stamp < w[1].stamp) && run.clouds.iter().all(|c| !c.places.is_empty()));
}

#[test]
fn a_start_off_the_plan_is_known_before_any_work() {
    let far = LocalizeOptions { seed: Seed(1), start: Some(StartPrior { x: 900.0, ..start() }), method: Method::Planwalk };
    assert!(check_start(&plan(), &far).unwrap_err().to_string().contains("off the plan"));
    assert!(check_start(&plan(), &LocalizeOptions { seed: Seed(1), start: None, method: Method::Planwalk }).is_ok());
}

fn estimates() -> Vec<Estimate> {
    let covariance = Matrix3::from_diagonal(&Vector3::new(0.04, 0.01, 0.01));
    let estimate =
        |(stamp, pose)| Estimate { stamp, pose, covariance, radius95_m: 0.45, probability: 0.75, status: Status::Ambiguous, scale: None };
    truth().into_iter().map(estimate).collect()
}

fn hypotheses() -> Vec<Hypothesis> {
    let scale = ScaleEstimate { metres_per_unit: 1.0, relative_sigma: 0.03 };
    let of = |probability: f64, dx: f64| {
        let track: Vec<_> = truth().into_iter().map(|(t, p)| (t, PlanPose::new(p.x + dx, p.y, p.heading_rad))).collect();
        let pose = track[track.len() - 1].1;
        Hypothesis { probability, pose, covariance: Matrix3::identity(), radius95_m: 0.4, scale, track }
    };
    vec![of(0.75, 0.0), of(0.2, -0.7), of(0.05, -0.3)]
}

/// All words of a drawing, as those hear them who do not see it.
fn words(svg: &str) -> Vec<&str> {
    svg.split("aria-label=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

fn picture<'a>(plan: &'a FloorPlan, track: &'a [Estimate], hypotheses: &'a [Hypothesis]) -> TrackPicture<'a> {
    let scale = ScaleEstimate { metres_per_unit: 1.0, relative_sigma: 0.03 };
    TrackPicture { title: "a <walk> & a plan", plan, track, hypotheses, status: Status::Ambiguous, scale, truth: &[], contradicted: &[] }
}

#[test]
fn the_picture_says_what_a_person_must_know() {
    let (plan, track, hypotheses) = (plan(), estimates(), hypotheses());
    let svg = picture(&plan, &track, &hypotheses).svg();
    let words = words(&svg);
    for said in ["a &lt;walk&gt; &amp; a plan", "AMBIGUOUS", "start", "end", "5 s", "10 s", "16.0 s", "95 % region", "x / m", "2 m"] {
        assert!(words.contains(&said), "{said:?} is not among {words:?}");
    }
    assert!(words.contains(&"other place, 20 %") && words.contains(&"20 %"), "the other hypothesis is in the legend and at its end");
    assert!(!words.contains(&"true walk"), "no truth was given");
    assert_eq!(svg.matches("stroke-dasharray=\"7 5\"").count(), 4, "two dashed walks and their legend");
    let png = png_of(&svg).unwrap();
    assert!(png.len() > 10_000 && svg.len() < 300_000, "{} bytes of PNG, {} of SVG", png.len(), svg.len());
}

#[test]
fn a_small_walk_on_a_large_plan_is_shown_large_with_an_overview() {
    let hall = [wall(-80.0, -60.0, 90.0, -60.0), wall(90.0, 70.0, -80.0, 70.0)];
    let plan = FloorPlan::from_walls(&[&corridors()[..], &hall].concat(), 0.1, 1.0).unwrap();
    let track = estimates();
    assert!(words(&picture(&plan, &track, &[]).svg()).contains(&"The whole plan"));
}

#[test]
fn numbers_that_are_none_do_not_break_a_picture() {
    let (plan, mut track, mut hypotheses) = (plan(), estimates(), hypotheses());
    track[3].pose = PlanPose::new(f64::NAN, 1.0, f64::NAN);
    track[7].covariance = Matrix3::repeat(f64::NAN);
    hypotheses[1].track.clear();
    for part in [&track[..], &track[..1], &[]] {
        let svg = picture(&plan, part, &hypotheses).svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        assert!(png_of(&svg).is_ok());
    }
}

#[test]
fn the_trajectory_is_drawn_from_the_first_camera() {
    // The first camera looks along odom's x: ahead on the sheet is x, right on the sheet is −y.
    let turn = UnitQuaternion::from_matrix(&Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0));
    let pose = |i: i64| CameraPose {
        stamp: Stamp(i * 100_000_000),
        odom_from_camera: Rigid3::from_parts(Vector3::new(0.1 * i as f64, -0.05 * i as f64, 1.5), turn),
        state: if i < 90 { TrackingState::Mapped } else { TrackingState::Propagated },
        inliers: 50,
    };
    let poses: Vec<_> = (0..100).map(pose).collect();
    // A wall 2 to the left all along; one point whose distance is a guess.
    let wall = poses.iter().map(|p| Sighting { stamp: p.stamp, bearing_rad: std::f64::consts::FRAC_PI_2, range: 2.0, sigma: 0.05 });
    let mut sightings: Vec<Sighting> = wall.collect();
    sightings.push(Sighting { stamp: poses[99].stamp, bearing_rad: 0.0, range: 5.0, sigma: 2.0 });
    let svg = TrajectoryPicture { title: "straight", poses: &poses, sightings: &sightings }.svg();
    let words = words(&svg);
    assert!(words.contains(&"100 frames: 90 posed on the map, 0 by rotation only, 10 carried on unseen"), "{words:?}");
    let disc = |colour: &str| {
        let before = svg.split(&format!("r=\"6\" fill=\"{colour}\"")).next().unwrap();
        let mut parts = before.rsplit("<circle cx=\"").next().unwrap().split('"');
        let x: f64 = parts.next().unwrap().parse().unwrap();
        (x, parts.nth(1).unwrap().parse::<f64>().unwrap())
    };
    let (start, end) = (disc("#2e7d32"), disc("#c62828"));
    assert!(end.0 > start.0 && end.1 < start.1, "start {start:?}, end {end:?}");
    let centre = |part: &str| part.split('"').next().unwrap().parse::<f64>().unwrap();
    let dots: Vec<f64> = svg.split("<circle cx=\"").skip(1).filter(|c| c.contains("r=\"1.3\"")).map(centre).collect();
    // Three more stand for them in the legend.
    assert_eq!(dots.len(), 103, "every sure point, and no other");
    assert!(dots[0] < start.0, "the wall is on the left");
    assert!(png_of(&TrajectoryPicture { title: "nothing", poses: &[], sightings: &[] }.svg()).is_ok());
}

#[test]
fn placements_and_particles_are_drawn() {
    let plan = plan();
    let region: Vec<bool> = (0..plan.cells().len()).map(|i| i % plan.width() < 40 && i / plan.width() < 40).collect();
    let picture = PlacementPicture {
        title: "p",
        plan: &plan,
        start_region: &region,
        area_m2: 1.5,
        end_region: &region,
        end_area_m2: 2.5,
        best: &[truth()],
        drifts: false,
        conditions: "all headings",
    };
    let svg = picture.svg();
    assert!(
        words(&svg).contains(&"The path can start anywhere in the red region, 1.5 m², and end in the blue one, 2.5 m² (all headings)."),
        "{:?}",
        words(&svg)
    );
    let nowhere = PlacementPicture { start_region: &[], best: &[], ..picture }.svg();
    assert!(words(&nowhere).iter().any(|w| w.contains("fits nowhere")));
    let cloud = |i: i64| ParticleCloud {
        stamp: Stamp(i * 1_000_000_000),
        count: 5000,
        places: vec![Pt2::new(1.0, 1.0); 10],
        area_m2: 0.25,
        modes: 1,
        status: Status::Ambiguous,
        metres_per_unit: 0.84,
        relative_sigma: 0.05,
    };
    let svg = ParticlePicture { title: "p", plan: &plan, track: &truth(), moments: &[cloud(1), cloud(4), cloud(9)] }.svg();
    assert!(words(&svg).contains(&"1 place, 5,000 particles, scale 0.840 ± 5 %"));
    assert_eq!(svg.matches("<circle").count(), 3, "a ring around each cloud that is too small to be seen");
    assert!(png_of(&svg).is_ok() && png_of(&nowhere).is_ok());
    assert!(png_of(&ParticlePicture { title: "p", plan: &plan, track: &[], moments: &[] }.svg()).is_ok());
}
