//! What of a graph can be solved, and how well is it solved? Edges that mean something, and groups of keyframes that they join.

use planwalk_types::{Groups, Similarity};

use super::robust::Doubt;
use super::{Edge, Graph, Information, Node, residual};
use crate::visual::axes::Fix;

/// A graph without what means nothing.
pub(super) struct Problem<'g> {
    pub(super) graph: &'g Graph,
    /// Edges that mean something, by their number in the graph.
    pub(super) edges: Vec<usize>,
    /// Groups of keyframes that edges join, each in the order of the walk; the first of each group is held.
    pub(super) groups: Vec<Vec<usize>>,
    /// Squared Mahalanobis distance at which an edge that may lie has a quarter of its weight.
    pub(super) doubt_at: f64,
}

impl<'g> Problem<'g> {
    pub(super) fn new(graph: &'g Graph, doubt_at: f64) -> Self {
        let edges: Vec<usize> = (0..graph.edges.len()).filter(|e| means_something(graph, &graph.edges[*e])).collect();
        let mut joined = Groups::new(graph.nodes.len());
        for edge in edges.iter().map(|e| &graph.edges[*e]) {
            joined.join(edge.a.0, edge.b.0);
        }
        let mut by_first = vec![Vec::new(); graph.nodes.len()];
        for node in 0..graph.nodes.len() {
            by_first[joined.first(node)].push(node);
        }
        let groups = by_first.into_iter().filter(|members| members.len() > 1).collect();
        // Whoever doubts everything, or nobody knows what, gets all the doubt there is.
        let doubt_at = if doubt_at > 0.0 { doubt_at } else { f64::MIN_POSITIVE };
        Self { graph, edges, groups, doubt_at }
    }

    /// The edges that mean something.
    pub(super) fn edges(&self) -> impl Iterator<Item = &'g Edge> {
        self.edges.iter().map(|e| &self.graph.edges[*e])
    }

    /// Doubt of what may lie, this many times wider than at the end.
    pub(super) fn doubt(&self, widening: f64) -> Doubt {
        Doubt { at: self.doubt_at * widening }
    }

    /// Weight of an edge at this squared Mahalanobis distance.
    pub(super) fn weight(&self, edge: &Edge, squared: f64, widening: f64) -> f64 {
        if edge.kind.may_lie() { self.doubt(widening).weight(squared) } else { 1.0 }
    }

    /// What is minimised: squared Mahalanobis distances of edges and fixes, those of edges that may lie as far as they are believed.
    pub(super) fn squared(&self, nodes: &[Similarity], widening: f64) -> f64 {
        let of_edge = |edge: &Edge| {
            let squared = squared(edge, nodes);
            if edge.kind.may_lie() { self.doubt(widening).cost(squared) } else { squared }
        };
        let of_fixes = nodes.iter().enumerate().filter_map(|(k, at)| Some(self.fix(k)?.cost(&at.rotation)));
        self.edges().map(of_edge).sum::<f64>() + of_fixes.sum::<f64>()
    }

    /// What the building's edges say of a keyframe's rotation, if that means something.
    pub(super) fn fix(&self, node: usize) -> Option<&'g Fix> {
        let Node { odom_from_keyframe, fix } = self.graph.nodes.get(node)?;
        let numbers = |fix: &&Fix| fix.rotation.coords.iter().chain(fix.information.iter()).all(|v| v.is_finite());
        fix.as_ref().filter(numbers).filter(|_| odom_from_keyframe.is_sound())
    }

    /// Squared Mahalanobis distance of each edge of the graph that means something.
    pub(super) fn each_squared(&self, nodes: &[Similarity]) -> Vec<Option<f64>> {
        let mut each = vec![None; self.graph.edges.len()];
        for e in &self.edges {
            each[*e] = Some(squared(&self.graph.edges[*e], nodes));
        }
        each
    }

    /// By how much doubt is widened at first: see [`super::robust::first_widening`].
    pub(super) fn first_widening(&self, nodes: &[Similarity]) -> f64 {
        let doubted = self.edges().filter(|edge| edge.kind.may_lie());
        super::robust::first_widening(self.doubt_at, doubted.map(|edge| squared(edge, nodes)).fold(0.0, f64::max))
    }
}

/// Squared Mahalanobis distance of an edge.
pub(super) fn squared(edge: &Edge, nodes: &[Similarity]) -> f64 {
    let r = residual::residual(&edge.a_from_b, &nodes[edge.a.0], &nodes[edge.b.0]);
    r.dot(&(edge.information * r))
}

fn means_something(graph: &Graph, edge: &Edge) -> bool {
    let sound = |k: usize| graph.nodes.get(k).is_some_and(|node| node.odom_from_keyframe.is_sound());
    edge.a != edge.b && sound(edge.a.0) && sound(edge.b.0) && edge.a_from_b.is_sound() && is_information(&edge.information)
}

/// Whether a matrix is symmetric and without negative eigenvalues, within round-off.
fn is_information(matrix: &Information) -> bool {
    let size = matrix.trace();
    let symmetric = (matrix - matrix.transpose()).amax() <= 1e-9 * size;
    symmetric && size > 0.0 && size.is_finite() && (matrix + Information::identity() * (1e-9 * size)).cholesky().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::graph::{information, of_turn_only, without_length};
    use nalgebra::Vector3;

    #[test]
    fn information_of_lower_rank_is_information_and_what_is_none_is_refused() {
        let whole = information(0.01, 0.002, 0.03);
        let aside = Similarity { translation: Vector3::new(0.3, -0.2, 0.9), ..Similarity::identity() };
        for fine in [whole, information(0.01, 0.002, f64::INFINITY), without_length(&whole, &aside), of_turn_only(&whole)] {
            assert!(is_information(&fine), "{fine}");
        }
        let mut skewed = whole;
        skewed[(0, 4)] = 5.0;
        for wrong in [Information::zeros(), -whole, whole * f64::NAN, whole * f64::INFINITY, skewed] {
            assert!(!is_information(&wrong), "{wrong}");
        }
    }
}
