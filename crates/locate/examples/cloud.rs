//! Steps of the filter's core on one office floor: `cloud PARTICLES STEPS [RAYS] [THREADS]`; to be timed, or run under callgrind.

#![expect(clippy::print_stdout, reason = "a program for the terminal")]

use std::time::Instant;

use planwalk_locate::bench_entry::{Cloud, office};

fn main() {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let number = |i: usize, otherwise: usize| numbers.get(i).copied().unwrap_or(otherwise);
    let (particles, steps, rays, threads) = (number(0, 200_000), number(1, 20), number(2, 0), number(3, 1));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let Ok(plan) = office(100.0, 5) else { return };
    let run = || {
        let mut cloud = Cloud::new(&plan, particles);
        cloud.step(rays);
        let before = Instant::now();
        (0..steps).for_each(|_| cloud.step(rays));
        let seconds = before.elapsed().as_secs_f64();
        let per_second = particles as f64 * steps as f64 / seconds;
        println!(
            "{particles} particles, {rays} rays, {threads} threads: {:.2} ms a step, {:.1} M particles/s, {} resamplings, sum {}",
            1e3 * seconds / steps.max(1) as f64,
            1e-6 * per_second,
            cloud.resampled,
            cloud.checksum()
        );
    };
    match pool {
        Ok(pool) => pool.install(run),
        Err(error) => println!("no threads: {error}"),
    }
}
