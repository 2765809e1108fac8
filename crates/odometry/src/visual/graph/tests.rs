use super::worlds::*;
use super::*;

#[test]
fn explore() {
    for (n, per, seed) in [(200, 190, 1), (400, 190, 2)] {
        let truth = corridor(n, per);
        let pairs = meetings(&truth, 100, 3);
        let graph = drifted(&truth, &pairs, SIGMAS, seed);
        println!("{n} nodes {} loops ate {}", pairs.len(), error(&start(&graph), &truth));
        for solver in [GraphSolver::GaussNewton, GraphSolver::Olson] {
            let t = std::time::Instant::now();
            let s = optimise(&graph, &GraphOptions { solver, ..Default::default() });
            println!("{solver:?} {} -> {} in {} ({:?}), ate {}", s.squared_before, s.squared_after, s.iterations, t.elapsed(), error(&s.nodes, &truth));
        }
    }
}
