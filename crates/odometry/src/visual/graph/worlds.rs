//! Walks with known truth, and what an odometry would say of them: for tests only.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Seed, Similarity, StreamRng, Tangent7};

use super::{Edge, EdgeKind, Graph, Node, information};
use crate::visual::map::KeyframeId;
use crate::visual::two_view::scene::uniform;

/// Standard deviations of shift (units), turn (rad) and logarithm of scale between neighbours.
pub const SIGMAS: [f64; 3] = [0.02, 0.01, 0.01];

/// About a normal variate of standard deviation 1: four uniform ones.
fn normal(rng: &mut StreamRng) -> f64 {
    (0..4).map(|_| uniform(rng, -1.0, 1.0)).sum::<f64>() * 0.75f64.sqrt()
}

/// Noise of these standard deviations.
pub fn noise(rng: &mut StreamRng, [shift, turn, scale]: [f64; 3]) -> Tangent7 {
    let sigmas = Tangent7::from([shift, shift, shift, turn, turn, turn, scale]);
    sigmas.map(|sigma| sigma * normal(rng))
}

/// Rounds of a corridor of 20 × 12 units, a keyframe every 0.32 of it, looking ahead, with a nod.
pub fn corridor(keyframes: usize, per_round: usize) -> Vec<Similarity> {
    let at = |k: usize| {
        let along = 64.0 * (k % per_round) as f64 / per_round as f64;
        let (x, y, heading) = match along {
            s if s < 20.0 => (s, 0.0, 0.0),
            s if s < 32.0 => (20.0, s - 20.0, 0.5),
            s if s < 52.0 => (52.0 - s, 12.0, 1.0),
            s => (0.0, 64.0 - s, 1.5),
        };
        let nod = 0.05 * libm::sin(0.7 * k as f64);
        let rotation = UnitQuaternion::from_euler_angles(0.0, nod, heading * std::f64::consts::PI);
        Similarity { scale: 1.0, rotation, translation: Vector3::new(x, y, 0.02 * nod) }
    };
    (0..keyframes).map(at).collect()
}

/// A walk between the crossings of a grid, a unit a step, turning now and then; within 12 units.
pub fn streets(keyframes: usize, seed: u64) -> Vec<Similarity> {
    let mut rng = Seed(seed).derive("streets", 0);
    let (mut at, mut heading) = ([0i32, 0i32], 0i32);
    let mut walk = Vec::with_capacity(keyframes);
    for _ in 0..keyframes {
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), f64::from(heading) * std::f64::consts::FRAC_PI_2);
        walk.push(Similarity { scale: 1.0, rotation, translation: Vector3::new(f64::from(at[0]), f64::from(at[1]), 0.0) });
        if uniform(&mut rng, 0.0, 1.0) < 0.3 {
            heading += if uniform(&mut rng, 0.0, 1.0) < 0.5 { 1 } else { 3 };
        }
        let step = |heading: i32| [[1, 0], [0, 1], [-1, 0], [0, -1]][(heading.rem_euclid(4)) as usize];
        let inside = |at: [i32; 2], step: [i32; 2]| (0..2).all(|i| (at[i] + step[i]).abs() <= 6);
        while !inside(at, step(heading)) {
            heading += 1;
        }
        at = [at[0] + step(heading)[0], at[1] + step(heading)[1]];
    }
    walk
}

/// Pairs of keyframes at one place, at least `apart` keyframes from each other; every `every`-th of them.
pub fn meetings(truth: &[Similarity], apart: usize, every: usize) -> Vec<(usize, usize)> {
    let near = |i: usize, j: usize| (truth[i].translation - truth[j].translation).norm() < 0.3;
    let all = (0..truth.len()).flat_map(|j| (0..j.saturating_sub(apart)).map(move |i| (i, j)));
    all.filter(|(i, j)| near(*i, *j)).step_by(every.max(1)).collect()
}

/// A measured pair with this noise.
pub fn measured(truth: &[Similarity], (a, b): (usize, usize), sigmas: [f64; 3], kind: EdgeKind, rng: &mut StreamRng) -> Edge {
    let a_from_b = truth[a].inverse() * truth[b] * Similarity::from_tangent(&noise(rng, sigmas));
    let [shift, turn, scale] = sigmas;
    Edge { a: KeyframeId(a), b: KeyframeId(b), a_from_b, information: information(shift, turn, scale), kind }
}

/// What an odometry would make of a walk: noisy steps, its own keyframes by adding them up, and loops between these pairs.
///
/// Seen from keyframe to keyframe the scale creeps, though each has the unit of the one before, so the chain's own sum drifts.
pub fn drifted(truth: &[Similarity], pairs: &[(usize, usize)], sigmas: [f64; 3], seed: u64) -> Graph {
    let mut rng = Seed(seed).derive("drifted", 0);
    let chain = (1..truth.len()).map(|k| measured(truth, (k - 1, k), sigmas, EdgeKind::Chain, &mut rng));
    let mut edges: Vec<Edge> = chain.collect();
    let nodes = integrated(truth[0], &edges);
    edges.extend(pairs.iter().map(|pair| measured(truth, *pair, SIGMAS, EdgeKind::Loop, &mut rng)));
    Graph { nodes, edges }
}

/// Keyframes by adding up a chain.
pub fn integrated(first: Similarity, chain: &[Edge]) -> Vec<Node> {
    let mut at = first;
    let mut nodes = vec![Node { odom_from_keyframe: at, fix: None }];
    for edge in chain {
        at = at * edge.a_from_b;
        nodes.push(Node { odom_from_keyframe: at, fix: None });
    }
    nodes
}

/// Root mean square distance of the keyframes, without any alignment: the first one is the truth's own.
pub fn error(nodes: &[Similarity], truth: &[Similarity]) -> f64 {
    let squares: f64 = nodes.iter().zip(truth).map(|(n, t)| (n.translation - t.translation).norm_squared()).sum();
    (squares / truth.len() as f64).sqrt()
}

/// Where the keyframes of a graph are before anything is done.
pub fn start(graph: &Graph) -> Vec<Similarity> {
    graph.nodes.iter().map(|n| n.odom_from_keyframe).collect()
}
