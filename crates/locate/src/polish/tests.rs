use super::*;
use crate::likelihood::Ray;
use crate::prior::ScalePrior;
use crate::walls::GroundCosts;
use planwalk_types::{Pt2, Seed, Stamp, Step, Wall};

/// Metres in a unit.
const SCALE: f64 = 0.8;

/// Two rooms and a doorway, drawn to 5 cm; local coordinates begin 1 m outside.
fn plan() -> FloorPlan {
    let wall = |x0: f64, y0: f64, x1: f64, y1: f64| Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) };
    let walls = [
        wall(0.0, 0.0, 12.0, 0.0),
        wall(12.0, 0.0, 12.0, 6.0),
        wall(12.0, 6.0, 0.0, 6.0),
        wall(0.0, 6.0, 0.0, 0.0),
        wall(6.0, 0.0, 6.0, 2.2),
        wall(6.0, 3.8, 6.0, 6.0),
    ];
    FloorPlan::from_walls(&walls, 0.05, 1.0).unwrap()
}

/// From one room into the other, a quarter of a metre a link, swaying.
fn truth() -> Vec<Vector4<f64>> {
    (0..36)
        .map(|i| {
            let way = 0.25 * f64::from(i);
            let (y, heading) = (4.0 + 0.3 * (0.7 * way).sin(), (0.3 * 0.7 * (0.7 * way).cos()).atan());
            Vector4::new(2.0 + way, y, heading, SCALE.ln())
        })
        .collect()
}

fn motions(truth: &[Vector4<f64>]) -> Vec<Motion> {
    let mut all = vec![Motion::none()];
    for pair in truth.windows(2) {
        let (s, c) = pair[0][2].sin_cos();
        let (dx, dy) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        let (forward, left, turn_rad) = ((c * dx + s * dy) / SCALE, (-s * dx + c * dy) / SCALE, pair[1][2] - pair[0][2]);
        let covariance = Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-4, 1e-4));
        let step = Step { from: Stamp(0), to: Stamp(1), forward, left, turn_rad, covariance, unit_change: 0.0 };
        all.push(Motion::of(&step, 1.0));
    }
    all
}

/// Metres to the face of the first wall; a cast alone ends up to a third of a cell within it.
fn face_m(walls: &Walls, at: &Vector4<f64>, angle: f64) -> f64 {
    let (s, c) = libm::sincos(angle);
    let mut range = (f64::from(walls.cast(at[0] as f32, at[1] as f32, c as f32, s as f32, 20.0)) - 0.1).max(0.0);
    while range < 20.0 && !walls.is_wall((at[0] + range * c) as f32, (at[1] + range * s) as f32) {
        range += 0.001;
    }
    range
}

/// Where walls are seen from each link, in units; every `furniture`-th look ends half-way.
fn rays(walls: &Walls, truth: &[Vector4<f64>], furniture: usize) -> Vec<Vec<Ray>> {
    let mut count = 0;
    let of = |at: &Vector4<f64>| {
        (-7..=7)
            .map(|i| {
                let bearing = f64::from(i) * 0.15;
                let mut range = face_m(walls, at, at[2] + bearing) / SCALE;
                count += 1;
                if furniture > 0 && count % furniture == 0 {
                    range *= 0.5;
                }
                let (s, c) = libm::sincos(bearing);
                Ray { from: (0.0, 0.0), to: (range * c, range * s), sigma: 0.02 * range }
            })
            .collect()
    };
    truth.iter().map(of).collect()
}

struct World {
    plan: FloorPlan,
    walls: Walls,
    options: LocateOptions,
    truth: Vec<Vector4<f64>>,
    motions: Vec<Motion>,
    rays: Vec<Vec<Ray>>,
}

impl World {
    fn new(furniture: usize) -> Self {
        let plan = plan();
        let walls = Walls::new(&plan, GroundCosts::default());
        let truth = truth();
        let (motions, rays) = (motions(&truth), rays(&walls, &truth, furniture));
        let options = LocateOptions::new(Seed(1), ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.3 });
        Self { plan, walls, options, truth, motions, rays }
    }

    fn problem(&self) -> Problem<'_> {
        let links = self.motions.iter().zip(&self.rays).map(|(motion, rays)| Link { motion: *motion, rays }).collect();
        Problem::new(links, &self.truth, &self.plan, &self.walls, &self.options)
    }

    /// The truth bent and shifted as a smoother's walk is.
    fn bent(&self) -> Vec<Vector4<f64>> {
        let bend = |(i, at): (usize, &Vector4<f64>)| {
            let t = i as f64 / 10.0;
            at + Vector4::new(0.12 * t.sin(), 0.10 * t.cos(), 0.04 * (1.3 * t).sin(), 0.03)
        };
        self.truth.iter().enumerate().map(bend).collect()
    }
}

fn off_m(a: &Smoothed, b: &Vector4<f64>) -> f64 {
    (a.mean.x - b[0]).hypot(a.mean.y - b[1])
}

#[test]
fn slopes_agree_with_differences() {
    let world = World::new(0);
    let problem = world.problem();
    let walk = world.bent();
    let worth = problem.worth(&walk, &Calibration::prior(0.05));
    let step = 1e-6;
    for i in [1, 9, 20] {
        let (before, here) = problem.motion_slopes(&walk, i);
        for (link, slopes) in [(i - 1, before), (i, here)] {
            for k in 0..4 {
                let at = |by: f64| {
                    let mut moved = walk.clone();
                    moved[link][k] += by;
                    problem.motion_residual(&moved, i).0
                };
                let difference = (at(step) - at(-step)) / (2.0 * step);
                // Central differences of smooth functions: round-off over the step.
                assert!((difference - slopes.column(k)).norm() < 1e-7, "link {link}, unknown {k}: {difference} against {slopes}");
            }
        }
        for (index, ray) in world.rays[i].iter().enumerate() {
            let touch = |at: &Vector4<f64>| problem.fate(i, ray, at, worth[i][index].sigma_m).touch;
            // Far from corners the nearest face is flat, and the field's slope is its normal.
            let Some(here) = touch(&walk[i]).filter(|t| t.normal.0.abs().max(t.normal.1.abs()) > 0.99999) else { continue };
            for k in 0..4 {
                let at = |by: f64| {
                    let mut moved = walk[i];
                    moved[k] += by;
                    touch(&moved)
                };
                let (Some(after), Some(before)) = (at(step), at(-step)) else { continue };
                if after.normal != here.normal || before.normal != here.normal {
                    continue;
                }
                let difference = (after.residual_m - before.residual_m) / (2.0 * step);
                // Casts and the field are in single precision: 1e-7 of metres over the step, where a face is met; else exact.
                assert!((difference - here.slope[k]).abs() < 0.3, "{difference} against {:?}", here.slope);
            }
        }
    }
}

#[test]
fn without_noise_the_polish_returns_the_truth() {
    let world = World::new(0);
    let polished = world.problem().polish(&world.bent(), &[]).unwrap();
    for (i, (found, truth)) in polished.walk.iter().zip(&world.truth).enumerate() {
        // Corners, where the field rounds over half a cell, pull a little: 2 cm of the 5 cm that a cell is wide.
        assert!(off_m(found, truth) < 0.02, "link {i}: {} m off", off_m(found, truth));
        assert!(wrap_angle(found.mean.z - truth[2]).abs() < 0.01, "link {i}");
        assert!((found.log_scale - SCALE.ln()).abs() < 0.01, "link {i}: scale {}", found.log_scale.exp());
    }
}

#[test]
fn furniture_does_not_pull() {
    let world = World::new(2);
    let polished = world.problem().polish(&world.bent(), &[]).unwrap();
    let worst = polished.walk.iter().zip(&world.truth).map(|(f, t)| off_m(f, t)).fold(0.0, f64::max);
    assert!(worst < 0.05, "{worst} m off with half of the looks on furniture");
}

#[test]
fn the_polish_never_makes_the_cost_worse() {
    let world = World::new(3);
    let problem = world.problem();
    for start in [world.truth.clone(), world.bent()] {
        let worth = problem.worth(&start, &Calibration::prior(0.05));
        let before = problem.cost(&start, &worth).0;
        let mut walk = start;
        let after = problem.descend(&mut walk, &worth, STEPS);
        assert!(after <= before, "{before} → {after}");
        assert!((problem.cost(&walk, &worth).0 - after).abs() < 1e-9, "it says what it left");
    }
}

#[test]
fn a_walk_that_saw_nothing_is_left_to_the_smoother() {
    let mut world = World::new(0);
    world.rays.iter_mut().for_each(Vec::clear);
    assert!(world.problem().polish(&world.bent(), &[]).is_none());
}

#[test]
fn draws_that_do_not_merge_stay_visible_as_spread() {
    let world = World::new(0);
    // Scale and heading lost together: the far room's walls from the wrong side.
    let elsewhere: Vec<Vector4<f64>> = world.truth.iter().map(|at| at + Vector4::new(0.0, -2.0, 0.0, 0.0)).collect();
    let alone = world.problem().polish(&world.bent(), &[]).unwrap();
    let both = world.problem().polish(&world.bent(), &[elsewhere]).unwrap();
    let spread = |p: &Polished| p.walk[10].radius95_m;
    assert!(spread(&both) >= spread(&alone), "{} and {}", spread(&both), spread(&alone));
}
