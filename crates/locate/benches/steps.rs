//! How long does a step take? Odometry and walls on an office floor of 100 m × 60 m at 5 cm, and the scoring of sightings.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use planwalk_locate::bench_entry::{Cloud, office};

fn steps(criterion: &mut Criterion) {
    let Ok(plan) = office(100.0, 5) else { return };
    for (name, rays, counts) in [("walls", 0, &[2_000, 20_000, 200_000, 2_000_000][..]), ("walls and 16 sightings", 16, &[2_000, 200_000])]
    {
        for threads in [1, 2] {
            let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else { continue };
            let mut group = criterion.benchmark_group(format!("{name}, {threads} threads"));
            group.sample_size(10);
            for count in counts {
                group.throughput(Throughput::Elements(*count as u64));
                let mut cloud = pool.install(|| Cloud::new(&plan, *count));
                group.bench_function(BenchmarkId::from_parameter(count), |b| b.iter(|| pool.install(|| cloud.step(rays))));
            }
            group.finish();
        }
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
