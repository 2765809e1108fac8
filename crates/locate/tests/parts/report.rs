//! The baseline: what the recipe of 2013 can do, and what it cannot.

use planwalk_locate::{ReportOptions, localize_by_report};
use planwalk_types::{Seed, Status};

use super::{SCALE, WALK, WORLD, World, off, office, start_of, walk};

#[test]
fn the_recipe_follows_a_walk_whose_start_and_scale_it_is_told() {
    let plan = office();
    let walk = walk(&WALK, &plan, World { drift: 0.002, ..WORLD }, 1);
    let options = ReportOptions { start: Some(start_of(&walk)), metres_per_unit: SCALE, particles: 5000, ..ReportOptions::new(Seed(1)) };
    let found = localize_by_report(&walk.path, &plan, &options, &mut |_| {}).unwrap();
    assert_eq!(found.filter.len(), walk.truth.len(), "one estimate a moment");
    assert_eq!(found.hypotheses[0].track.len(), walk.truth.len());
    let (end, truth) = (&found.filter[found.filter.len() - 1], &walk.truth[walk.truth.len() - 1]);
    // It ends in the right room: half of the room's width.
    assert!(off(&end.pose, truth) < 1.2, "{} m off", off(&end.pose, truth));
    assert_eq!(found.scale.metres_per_unit, SCALE);
}

#[test]
fn a_wrong_scale_ends_the_recipe_in_a_wall_or_in_another_place() {
    let plan = office();
    let walk = walk(&WALK, &plan, WORLD, 1);
    let options =
        ReportOptions { start: Some(start_of(&walk)), metres_per_unit: 0.6 * SCALE, particles: 5000, ..ReportOptions::new(Seed(1)) };
    let found = localize_by_report(&walk.path, &plan, &options, &mut |_| {}).unwrap();
    let (end, truth) = (&found.filter[found.filter.len() - 1], &walk.truth[walk.truth.len() - 1]);
    assert!(found.status == Status::Lost || off(&end.pose, truth) > 2.0, "{} at {} m", found.status, off(&end.pose, truth));
}

#[test]
fn the_recipe_gives_the_same_bytes_on_any_number_of_threads() {
    let plan = office();
    let walk = walk(&WALK, &plan, WORLD, 2);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = ReportOptions { particles: 20_000, metres_per_unit: SCALE, ..ReportOptions::new(Seed(4)) };
        pool.install(|| localize_by_report(&walk.path, &plan, &options, &mut |_| {})).unwrap()
    };
    let poses = |found: planwalk_locate::Localization| found.filter.iter().map(|e| (e.pose.x, e.pose.y)).collect::<Vec<_>>();
    assert_eq!(poses(with(1)), poses(with(3)));
}
