//! One exhaustive look over an office floor: `look WIDTH_M BLOCKS [SIGMA_PERCENT] [THREADS]`; a block is 12 m deep.

#![expect(clippy::print_stdout, reason = "a program for the terminal")]

use std::time::Instant;

use planwalk_locate::bench_entry::{corridor_walk, office};
use planwalk_locate::{LocateOptions, ScalePrior, first_look};
use planwalk_types::Seed;

fn main() {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let number = |i: usize, otherwise: usize| numbers.get(i).copied().unwrap_or(otherwise);
    let (width, blocks, percent, threads) = (number(0, 46), number(1, 2), number(2, 30), number(3, 2));
    let Ok(plan) = office(width as f64, blocks as i32) else { return };
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else { return };
    let (path, seen) = corridor_walk(&plan);
    let scale = ScalePrior { metres_per_unit: 1.1, relative_sigma: percent as f64 / 100.0 };
    let options = LocateOptions::new(Seed(1), scale);
    let before = Instant::now();
    let Ok(found) = pool.install(|| first_look(&path, &seen, &plan, &options)) else { return };
    let seconds = before.elapsed().as_secs_f64();
    println!(
        "{} m², scale within {percent} %, {threads} threads: {seconds:.2} s, {} of {} cells scored, {} kept",
        width * blocks * 12,
        found.scored,
        found.cells,
        found.kept
    );
    for place in found.places.iter().take(3) {
        let (pose, scale) = (&place.pose, &place.scale);
        println!("  {:.3} at ({:.2}, {:.2}) m, {:.3} m a unit", place.probability, pose.x, pose.y, scale.metres_per_unit);
    }
}
