use super::*;
use planwalk_types::{Cell, Pt2, Wall};

fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Wall {
    Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) }
}

/// A corridor of 24 m with three rooms below it.
fn half() -> Vec<Wall> {
    let mut walls = vec![wall(0.0, 0.0, 24.0, 0.0), wall(0.0, 0.0, 0.0, 6.0), wall(24.0, 0.0, 24.0, 6.0)];
    walls.extend([wall(7.0, 0.0, 7.0, 5.0), wall(17.0, 0.0, 17.0, 5.0)]);
    for (from, to) in [(0.0, 3.0), (4.2, 12.0), (13.2, 20.0), (21.2, 24.0)] {
        walls.push(wall(from, 5.0, to, 5.0));
    }
    walls
}

/// The same turned by 180°, so that both together look the same from both ends; a third of it told apart on request.
fn building(told_apart: bool) -> FloorPlan {
    let mut walls = half();
    let turned = |w: &Wall| wall(24.0 - w.from.x, 12.0 - w.from.y, 24.0 - w.to.x, 12.0 - w.to.y);
    walls.extend(half().iter().map(turned));
    if told_apart {
        walls.extend([wall(3.5, 0.0, 3.5, 3.5), wall(10.0, 2.0, 14.0, 2.0), wall(15.2, 0.0, 15.2, 2.5), wall(19.0, 2.5, 22.0, 2.5)]);
        walls.extend([wall(9.0, 7.0, 9.0, 9.0), wall(4.0, 10.0, 6.0, 8.5), wall(23.0, 5.0, 23.0, 6.2), wall(20.5, 9.5, 22.0, 9.5)]);
    }
    FloorPlan::from_walls(&walls, 0.1, 0.5).unwrap()
}

fn options() -> AmbiguityOptions {
    AmbiguityOptions { places: 20, length_m: 24.0, ..Default::default() }
}

fn of(plan: &FloorPlan) -> Ambiguity {
    ambiguity(plan, &options(), Seed(1), &mut |_| {})
}

#[test]
fn a_building_that_looks_the_same_from_both_ends_never_tells_them_apart() {
    let found = of(&building(false));
    assert!(found.walks.len() >= 20, "{}", found.walks.len());
    assert!(found.never > 0.95, "{} of the walks are told apart", 1.0 - found.never);
    assert_eq!((found.median_m, found.p90_m), (None, None));
    // The rival is the place turned by 180° about the middle.
    let mirrored = |pair: &&ConfusablePair| {
        let (x, y) = (24.0 - pair.a.x, 12.0 - pair.a.y);
        (pair.b.x - x).hypot(pair.b.y - y) < 1.5 && wrap_angle(pair.b.heading_rad - pair.a.heading_rad).abs() > 2.8
    };
    let right = found.pairs.iter().filter(mirrored).count();
    assert!(!found.pairs.is_empty() && 2 * right > found.pairs.len(), "{:?}", found.pairs);
    assert!(found.pairs.iter().all(|pair| pair.to_the_end));
}

#[test]
fn a_building_without_symmetry_becomes_clear() {
    let found = of(&building(true));
    // Some rooms are the same as their counterparts: who never leaves them cannot tell.
    assert!(found.never < 0.45, "{} never", found.never);
    assert!(found.median_m.is_some_and(|m| m <= 16.0), "{:?}", found.median_m);
    for walk in &found.walks {
        assert!(walk.alike[0] >= walk.alike[walk.alike.len() - 1], "longer walks tell more: {:?}", walk.alike);
    }
}

#[test]
fn the_true_place_always_fits() {
    let found = of(&building(true));
    let kept = found.walks.iter().filter(|w| w.kept_itself).count() as f64 / found.walks.len() as f64;
    // The grid's roundings may lose a walk that grazes a door's edge.
    assert!(kept >= 0.9, "{kept}");
}

#[test]
fn the_noise_matters() {
    let sharp = AmbiguityOptions { range_sigma_m: 0.02, range_sigma_share: 0.01, ..options() };
    let never = ambiguity(&building(true), &sharp, Seed(1), &mut |_| {}).never;
    assert!(never <= of(&building(true)).never);
}

#[test]
fn threads_do_not_matter_and_progress_ends_at_one() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut last = 0.0;
        let few = AmbiguityOptions { places: 6, length_m: 8.0, ..Default::default() };
        let found = pool.install(|| ambiguity(&building(true), &few, Seed(3), &mut |share| last = share));
        assert_eq!(last, 1.0);
        found
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_plan_without_an_inside_has_no_walks() {
    let cells = (0..1600).map(|i| if i == 820 { Cell::Wall } else { Cell::Free }).collect();
    let plan = FloorPlan::new(Pt2::new(0.0, 0.0), 0.5, 40, 40, cells).unwrap();
    let found = of(&plan);
    assert!(found.walks.is_empty() && found.pairs.is_empty() && found.never == 0.0);
}
