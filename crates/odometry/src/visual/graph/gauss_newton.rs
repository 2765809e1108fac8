//! Which keyframes agree best with all edges, from a good start? Gauss–Newton, damped (Levenberg 1944, Marquardt 1963).
//!
//! keyframes ─▶ normal equations ([`super::residual`]) ─▶ step ([`super::sparse`]) ─▶ taken if it is better, else damped more; doubt of loops
//! narrows from round to round ([`super::robust`]).
//!
//! Pitfall: a long chain bends softly: N keyframes' slowest bend is N² times softer than one edge. Damping relative to the diagonal
//! must be far below 1/N², or it holds what a loop should move: it begins at 1e-10.

use nalgebra::Matrix3;
use planwalk_types::{Similarity, Tangent7};

use super::problem::Problem;
use super::residual::{by_right_turn, linearised, moved};
use super::robust::NARROWING;
use super::sparse::{Block, Pattern, System};

/// Damping at the beginning and at least, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-10;
const LEAST_DAMPING: f64 = 1e-14;
/// Damping beyond which no step is any use.
const MOST_DAMPING: f64 = 1e8;
/// Information that holds each keyframe where it is during a step: 1000 units, radians or factors of e. It keeps what no edge knows in
/// its place, and is nothing beside what an edge knows.
const HOLD: f64 = 1e-6;
/// A round ends when a step gains less than this share of what is left: the last one, and those before it.
const LEAST_GAIN: f64 = 1e-9;
const ROUGH_GAIN: f64 = 1e-2;
/// Most steps of a round before the last.
const ROUND_STEPS: usize = 5;
/// Squared standard deviations per edge that are no error at all.
const NOTHING: f64 = 1e-12;

/// The keyframes where the sum of squares is least, and the number of steps tried.
pub(super) fn descend(problem: &Problem<'_>, mut nodes: Vec<Similarity>, steps: usize) -> (Vec<Similarity>, usize) {
    let descent = Descent::new(problem);
    let (mut widening, mut tried) = (problem.first_widening(&nodes), 0);
    loop {
        let last = widening <= 1.0;
        let (least_gain, most) = if last { (LEAST_GAIN, steps - tried) } else { (ROUGH_GAIN, ROUND_STEPS.min(steps - tried)) };
        tried += descent.round(&mut nodes, widening, least_gain, most);
        if last || tried >= steps {
            return (nodes, tried);
        }
        // Where the worst loop has come near, doubt may narrow at once.
        widening = (widening / NARROWING).min(problem.first_widening(&nodes)).max(1.0);
    }
}

struct Descent<'p, 'g> {
    problem: &'p Problem<'g>,
    /// The variable of each keyframe that may move.
    variables: Vec<Option<usize>>,
    pattern: Pattern,
}

impl<'p, 'g> Descent<'p, 'g> {
    fn new(problem: &'p Problem<'g>) -> Self {
        let mut variables = vec![None; problem.graph.nodes.len()];
        let mut movable: Vec<usize> = problem.groups.iter().flat_map(|members| members[1..].iter().copied()).collect();
        movable.sort_unstable();
        for (variable, node) in movable.iter().enumerate() {
            variables[*node] = Some(variable);
        }
        let pairs = problem.edges().filter_map(|edge| Some((variables[edge.a.0]?, variables[edge.b.0]?)));
        let pattern = Pattern::new(movable.len(), pairs);
        Self { problem, variables, pattern }
    }

    /// Steps at one width of doubt; returns how many were tried.
    fn round(&self, nodes: &mut Vec<Similarity>, widening: f64, least_gain: f64, most: usize) -> usize {
        let nothing = NOTHING * self.problem.edges.len() as f64;
        let mut squared = self.problem.squared(nodes, widening);
        let mut system = self.normal_equations(nodes, widening);
        let (mut damping, mut growth) = (FIRST_DAMPING, 10.0);
        for tried in 0..most {
            if !(squared > nothing) || damping > MOST_DAMPING {
                return tried;
            }
            let next = self.step(&system, nodes, damping).map(|next| (self.problem.squared(&next, widening), next));
            match next.filter(|(next_squared, _)| *next_squared < squared) {
                Some((next_squared, next)) => {
                    let gain = squared - next_squared;
                    (*nodes, squared) = (next, next_squared);
                    if gain < least_gain * squared {
                        return tried + 1;
                    }
                    system = self.normal_equations(nodes, widening);
                    (damping, growth) = ((0.1 * damping).max(LEAST_DAMPING), 10.0);
                }
                None => {
                    // Faster and faster: from 1e-10 to 1 there are many tens.
                    damping *= growth;
                    growth *= 10.0;
                }
            }
        }
        most
    }

    fn normal_equations(&self, nodes: &[Similarity], widening: f64) -> System<'_> {
        let mut system = System::new(&self.pattern);
        for edge in self.problem.edges() {
            let (r, by_a, by_b) = linearised(&edge.a_from_b, &nodes[edge.a.0], &nodes[edge.b.0]);
            let weight = self.problem.weight(edge, r.dot(&(edge.information * r)), widening);
            let information = edge.information * weight;
            let (weighted_a, weighted_b) = (by_a.tr_mul(&information), by_b.tr_mul(&information));
            let (a, b) = (self.variables[edge.a.0], self.variables[edge.b.0]);
            if let Some(a) = a {
                system.add(a, &(weighted_a * by_a), &-(weighted_a * r));
            }
            if let Some(b) = b {
                system.add(b, &(weighted_b * by_b), &-(weighted_b * r));
            }
            if let (Some(a), Some(b)) = (a, b) {
                system.couple(a, b, &(weighted_a * by_b));
            }
        }
        self.add_fixes(nodes, &mut system);
        system
    }

    fn add_fixes(&self, nodes: &[Similarity], system: &mut System<'_>) {
        for (k, variable) in self.variables.iter().enumerate() {
            let (Some(variable), Some(fix)) = (variable, self.problem.fix(k)) else { continue };
            let error = fix.error(&nodes[k].rotation);
            let by_turn = by_right_turn(&error);
            let weighted: Matrix3<f64> = by_turn.tr_mul(&fix.information);
            let (mut block, mut right) = (Block::zeros(), Tangent7::zeros());
            block.fixed_view_mut::<3, 3>(3, 3).copy_from(&(weighted * by_turn));
            right.fixed_rows_mut::<3>(3).copy_from(&-(weighted * error));
            system.add(*variable, &block, &right);
        }
    }

    /// The keyframes after one damped step; `None` where the system is not positive definite.
    fn step(&self, system: &System<'_>, nodes: &[Similarity], damping: f64) -> Option<Vec<Similarity>> {
        let mut damped = system.clone();
        damped.damp(damping, HOLD);
        let step = damped.solve()?;
        let next = nodes.iter().zip(&self.variables).map(|(node, variable)| variable.map_or(*node, |v| moved(node, &step[v])));
        Some(next.collect())
    }
}
