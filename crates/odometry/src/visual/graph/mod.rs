//! Where were the keyframes, when places are seen again? A pose graph: keyframes, and what was measured between pairs of them.
//!
//! keyframes + measured pairs ─▶ [`Graph`] ─▶ [`optimise`] ([`gauss_newton`] or [`olson`]) ─▶ [`Solution`]
//!
//! A single camera's unit of length creeps, so a keyframe is a similarity: `odom_from_keyframe`, whose scale says how many of
//! odom's units the keyframe's own unit has (Strasdat, Montiel & Davison 2010). What is minimised is Σ rᵀ Ω r over all edges, with r as
//! in [`residual`]; edges that say a place, or a floor, was seen again may lie, and are doubted ([`robust`]).
//!
//! Pitfall: an edge may know no scale, or only the direction in which the other keyframe lies: its information then has a lower rank
//! ([`information`] with an infinite sigma, [`without_length`]). Directions that no edge knows stay as they are.

pub mod gauss_newton;
pub mod olson;
mod problem;
pub mod residual;
pub mod robust;
pub mod sparse;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod worlds;

use nalgebra::{SMatrix, Vector3};
use planwalk_types::{Seed, Similarity, Tangent7};

use crate::visual::axes::Fix;
use crate::visual::map::KeyframeId;
use problem::Problem;

/// What a measurement knows: inverse covariance of [ρ; θ; λ] in the second keyframe's axes and unit, as measured.
pub type Information = SMatrix<f64, 7, 7>;

/// A keyframe.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// Where it was, how it was turned, and how many of odom's units its own unit has.
    pub odom_from_keyframe: Similarity,
    /// What the building's edges say of its rotation; that is known absolutely, and no loop may bend it.
    pub fix: Option<Fix>,
}

/// How two keyframes came to be measured against each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeKind {
    /// Neighbours of the odometry.
    Chain,
    /// Another pair that is measured: of one window, or by the speed of the walk at both.
    Pair,
    /// A place that was seen again.
    Loop,
    /// The height over a floor, or under a ceiling, that is taken for the same at both.
    Level,
}

impl EdgeKind {
    /// Whether it may be all wrong, and is to be doubted where it disagrees with the rest.
    pub fn may_lie(self) -> bool {
        matches!(self, Self::Loop | Self::Level)
    }
}

/// One keyframe as measured from another.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    /// The keyframe it was measured from.
    pub a: KeyframeId,
    /// The keyframe that was measured.
    pub b: KeyframeId,
    /// What was measured.
    pub a_from_b: Similarity,
    /// How well. Parts that are not known have none.
    pub information: Information,
    /// How it came about.
    pub kind: EdgeKind,
}

/// Keyframes in the order of the walk, and what was measured between them.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    /// The keyframes, by [`KeyframeId`].
    pub nodes: Vec<Node>,
    /// What was measured; the same pair may come several times.
    pub edges: Vec<Edge>,
}

/// How the graph is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GraphSolver {
    /// Exact steps, damped: few of them from a good start, a wrong valley from a poor one.
    #[default]
    GaussNewton,
    /// Stochastic gradient descent (Olson, Leonard & Teller 2006), which comes near the minimum from poor starts too, and from there
    /// [`GraphOptions::steps`] of Gauss–Newton. With no steps it is Olson's alone.
    Olson,
}

/// Options of [`optimise`].
#[derive(Debug, Clone, Copy)]
pub struct GraphOptions {
    /// Which solver.
    pub solver: GraphSolver,
    /// Most steps of Gauss–Newton, those that were tried in vain included: usually some six are enough, now and then some hundreds.
    pub steps: usize,
    /// Passes of [`GraphSolver::Olson`] over all edges.
    pub passes: usize,
    /// Squared Mahalanobis distance at which an edge that may lie has a quarter of its weight. Infinite: all edges are believed alike.
    ///
    /// The default, 24.3, is 99.9 % of a chi-square of 7 degrees of freedom.
    pub doubt: f64,
    /// What the order of [`GraphSolver::Olson`]'s edges grows from.
    pub seed: Seed,
}

impl Default for GraphOptions {
    fn default() -> Self {
        Self { solver: GraphSolver::default(), steps: 1000, passes: 100, doubt: 24.3, seed: Seed(0) }
    }
}

/// What became of a graph.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// `odom_from_keyframe` of all keyframes.
    pub nodes: Vec<Similarity>,
    /// Sum of all squared Mahalanobis distances, of fixes too, before; an edge that may lie counts [`GraphOptions::doubt`] at most.
    pub squared_before: f64,
    /// The same after; never more than before.
    pub squared_after: f64,
    /// Passes and steps that were made.
    pub iterations: usize,
    /// Squared Mahalanobis distance of each edge after, undiminished by any doubt; `None` for an edge that was left out: not made of
    /// numbers, not between two keyframes of the graph, or with an information that is none.
    pub squared: Vec<Option<f64>>,
}

/// Moves the keyframes to where all edges and fixes agree best.
///
/// The first keyframe stays, and so does the first of each group of keyframes that no edge joins with it. Where nothing better
/// is found, all stay.
pub fn optimise(graph: &Graph, options: &GraphOptions) -> Solution {
    let problem = Problem::new(graph, options.doubt);
    let start: Vec<Similarity> = graph.nodes.iter().map(|n| n.odom_from_keyframe).collect();
    let squared_before = problem.squared(&start, 1.0);
    let (moved, iterations) = match options.solver {
        GraphSolver::GaussNewton => gauss_newton::descend(&problem, start.clone(), options.steps),
        GraphSolver::Olson => {
            let (near, passes) = olson::descend(&problem, &start, options.passes, options.seed);
            let (nodes, steps) = gauss_newton::descend(&problem, near, options.steps);
            (nodes, passes + steps)
        }
    };
    let squared_moved = problem.squared(&moved, 1.0);
    let (nodes, squared_after) = if squared_moved < squared_before { (moved, squared_moved) } else { (start, squared_before) };
    let squared = problem.each_squared(&nodes);
    Solution { nodes, squared_before, squared_after, iterations, squared }
}

/// Information of a measurement whose shift, turn and logarithm of scale have these standard deviations, each alike in all its
/// directions. An infinite one says nothing.
pub fn information(sigma_move: f64, sigma_turn_rad: f64, sigma_log_scale: f64) -> Information {
    let (shift, turn, scale) = (sigma_move.powi(-2), sigma_turn_rad.powi(-2), sigma_log_scale.powi(-2));
    Information::from_diagonal(&Tangent7::from([shift, shift, shift, turn, turn, turn, scale]))
}

/// The same for a measurement that knows in which direction B lies, but not how far: two views of a single camera.
///
/// Across that direction it keeps its information per unit of length, so `a_from_b` needs a length of about the right size.
pub fn without_length(information: &Information, a_from_b: &Similarity) -> Information {
    let Some(along) = (a_from_b.rotation.inverse() * a_from_b.translation).try_normalize(1e-12) else { return *information };
    let mut across = Information::identity();
    across.fixed_view_mut::<3, 3>(0, 0).copy_from(&(nalgebra::Matrix3::identity() - along * along.transpose()));
    across * information * across
}

/// The same for a keyframe of which only the turn is known: two views from one place, in front of a blank wall.
pub fn of_turn_only(information: &Information) -> Information {
    let mut only = Information::zeros();
    only.fixed_view_mut::<3, 3>(3, 3).copy_from(&information.fixed_view::<3, 3>(3, 3));
    only
}

fn part(tangent: &Tangent7, row: usize) -> Vector3<f64> {
    tangent.fixed_rows::<3>(row).into_owned()
}
