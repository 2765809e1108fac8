//! Where were the keyframes, given the places that were seen again and the building's edges? The pose graph at the end of a walk.
//!
//! chain of keyframes + pairs of each window + [`Link`]s + usual speed (`pace`) + floor and ceiling (`levels`) + fixes ─▶
//! [`crate::visual::graph`] ─▶ keyframes moved, each with its own unit; frames and points go along
//!
//! Where none of them disagrees with the chain nothing is moved.

use nalgebra::{Matrix3, Vector3};
use planwalk_types::Similarity;

use super::VisualOdometry;
use super::reseen::Link;
use crate::visual::axes::Fix;
use crate::visual::graph::{Edge, EdgeKind, Graph, GraphOptions, Node, information, optimise};
use crate::visual::map::{Keyframe, KeyframeId, Pose};
use crate::visual::recall::Odometer;
use crate::visual::two_view::rotation::median;

/// How a keyframe was reached from the one before: what may have gone wrong between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage {
    /// The walk's own measure at the keyframe.
    pub odometer: Odometer,
    /// Followed points with a distance: they hand on the unit of length.
    pub known: usize,
    /// The keyframe in the frame of the one before, as it was reached, if it was then put elsewhere: where its view was known again.
    pub reached: Option<Pose>,
}

/// What one step of the chain may be off, pairs aside that hold it too: as a share of its way, and of the way that nothing measured;
/// radians, and radians for each
/// second in which nothing said how the camera turned.
const CHAIN_WAY: f64 = 0.045;
const CHAIN_ADRIFT: f64 = 0.7;
const CHAIN_STILL: f64 = 2e-3;
const CHAIN_TURN_RAD: f64 = 4.5e-3;
const CHAIN_BLIND_RAD_S: f64 = 0.3;
/// Logarithm of the unit's error from one keyframe to the next that no point with a distance joins; n of them leave the (n + 1)th part.
const CHAIN_UNIT: f64 = 1.0;
/// Error of a link: units, share of the points' distance, radians, and logarithm of the scale.
const LINK_MOVE: f64 = 0.01;
const LINK_FAR: f64 = 0.015;
const LINK_TURN_RAD: f64 = 0.015;
const LINK_SCALE: f64 = 0.15;
/// Error that the fixes of all keyframes of a second have in common, 0.6°: some ten of them, so each counts as a tenth.
const FIX_SHARED_RAD2: f64 = 10.0 * 1.1e-4;
/// What differs more from a keyframe than this was not believed on the way, 6°.
const FIXED_RAD: f64 = 0.1;

impl VisualOdometry {
    /// Notes how the newest keyframe was reached.
    pub(super) fn pass(&mut self) {
        let known = self.in_view().filter(|l| l.has_depth()).count();
        self.passages.push(Passage { odometer: self.odometer, known, reached: None });
    }

    /// The keyframes that are `within` have their lengths times `factor`: what was measured from them goes along.
    pub(super) fn rescale_links(&mut self, factor: f64, within: impl Fn(KeyframeId) -> bool) {
        for link in &mut self.links {
            let (a, b) = (within(link.a), within(link.b));
            link.a_from_b.translation.vector *= if a { factor } else { 1.0 };
            link.scale = link.scale.map(|scale| scale * if a { factor } else { 1.0 } / if b { factor } else { 1.0 });
        }
        for pair in self.window_pairs.iter_mut().filter(|pair| within(pair.a)) {
            pair.far *= factor;
        }
        let after = self.passages.iter_mut().enumerate().filter(|(k, _)| k.checked_sub(1).is_some_and(|before| within(KeyframeId(before))));
        for reached in after.filter_map(|(_, passage)| passage.reached.as_mut()) {
            reached.translation.vector *= factor;
        }
    }

    /// Moves the keyframes to where the places that were seen again, the edges of the building, the usual speed of the walk, the floor under
    /// `up`, and the way between them agree; returns by how much lengths changed, in the median.
    pub(super) fn close_links(&mut self, up: &Vector3<f64>) -> f64 {
        let fix = |k: &Keyframe| k.fix.filter(|fix| fix.error(&k.pose.rotation).norm() < FIXED_RAD).map(|fix| shared(&fix));
        let nodes = self.map.keyframes.iter().map(|k| Node { odom_from_keyframe: Similarity::from(&k.pose), fix: fix(k) }).collect();
        let pairs = self.window_pairs.iter().map(|pair| pair.edge(self.map.pose(pair.a), self.map.pose(pair.b)));
        let measured = self.chain().chain(pairs).chain(self.links.iter().map(of_link));
        let edges = measured.chain(self.pace_edges()).chain(self.level_edges(up)).collect();
        let graph = Graph { nodes, edges };
        let solution =
            optimise(&graph, &GraphOptions { solver: self.options.graph_solver, seed: self.options.seed, ..GraphOptions::default() });
        self.apply(&solution.nodes);
        if solution.nodes.is_empty() { 1.0 } else { median(solution.nodes.iter().map(|n| n.scale).collect()) }
    }

    fn chain(&self) -> impl Iterator<Item = Edge> {
        let pairs = self.map.keyframes.windows(2).zip(self.passages.windows(2)).enumerate();
        pairs.map(|(k, (keyframes, passages))| {
            let (then, now) = (passages[0].odometer, passages[1].odometer);
            let sigma_move = CHAIN_STILL + CHAIN_WAY * (now.way - then.way) + CHAIN_ADRIFT * (now.adrift - then.adrift);
            let sigma_turn = CHAIN_TURN_RAD + CHAIN_BLIND_RAD_S * (now.blind_s - then.blind_s);
            let sigma_unit = CHAIN_UNIT / (passages[1].known + 1) as f64;
            let a_from_b = passages[1].reached.unwrap_or(keyframes[0].pose.inverse() * keyframes[1].pose);
            let information = information(sigma_move, sigma_turn, sigma_unit);
            Edge { a: KeyframeId(k), b: KeyframeId(k + 1), a_from_b: Similarity::from(&a_from_b), information, kind: EdgeKind::Chain }
        })
    }

    /// Keyframes where they now are; what was measured from them is in their unit.
    fn apply(&mut self, nodes: &[Similarity]) {
        for posed in &mut self.posed {
            if let Some(node) = posed.reference.and_then(|k| nodes.get(k.0)) {
                posed.reference_from_camera.translation.vector *= node.scale;
            }
        }
        for seen in &mut self.seen_points {
            if let Ok(at) = self.map.keyframes.binary_search_by_key(&seen.stamp, |k| k.stamp) {
                *seen = seen.scaled(nodes[at].scale);
            }
        }
        for (keyframe, node) in self.map.keyframes.iter_mut().zip(nodes) {
            keyframe.pose = Pose::from_parts(node.translation.into(), node.rotation);
        }
    }
}

/// A fix with the error that it shares with its neighbours: (C + σ²)⁻¹ = (1 + σ² C⁻¹)⁻¹ C⁻¹, where C may know nothing of some turn.
fn shared(fix: &Fix) -> Fix {
    let softened = (Matrix3::identity() + fix.information * FIX_SHARED_RAD2).try_inverse().map_or(fix.information, |m| m * fix.information);
    Fix { information: 0.5 * (softened + softened.transpose()), ..*fix }
}

fn of_link(link: &Link) -> Edge {
    let sigma_scale = if link.scale.is_some() { LINK_SCALE } else { f64::INFINITY };
    let a_from_b = Similarity { scale: link.scale.unwrap_or(1.0), ..Similarity::from(&link.a_from_b) };
    let information = information(LINK_MOVE + LINK_FAR * link.far, LINK_TURN_RAD, sigma_scale);
    Edge { a: link.a, b: link.b, a_from_b, information, kind: EdgeKind::Loop }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use planwalk_types::{Camera, Stamp};

    use super::*;
    use crate::visual::graph::GraphSolver;
    use crate::visual::odometry::OdometryOptions;
    use crate::visual::odometry::pairs::WindowPair;
    use crate::visual::odometry::walks::up;

    /// A walk straight ahead and back again, a unit a keyframe, of which the steps from `lost` to `found` are in another unit.
    fn walk(lost: usize, found: usize, other_unit: f64) -> VisualOdometry {
        let mut odometry = VisualOdometry::new(Camera::phone_prior(640, 480), OdometryOptions::default());
        let mut at = Vector3::zeros();
        for k in 0..21 {
            let step = if k == 0 { 0.0 } else { 1.0 } * if k <= 10 { 1.0 } else { -1.0 };
            at.z += step * if (lost + 1..=found).contains(&k) { other_unit } else { 1.0 };
            let pose = Pose::from_parts(at.into(), UnitQuaternion::identity());
            odometry.map.keyframes.push(Keyframe { stamp: Stamp(k as i64), pose, turn: UnitQuaternion::identity(), fix: None });
            let odometer = Odometer { way: k as f64, ..Odometer::default() };
            let known = if k == lost || k == found { 0 } else { 60 };
            odometry.passages.push(Passage { odometer, known, reached: None });
        }
        odometry
    }

    /// A keyframe that was seen again from another one, so far ahead of it.
    fn link(a: usize, b: usize, ahead: f64, scale: Option<f64>) -> Link {
        Link { a: KeyframeId(a), b: KeyframeId(b), a_from_b: Pose::translation(0.0, 0.0, ahead), scale, far: 4.0 }
    }

    #[test]
    fn a_stretch_in_another_unit_is_put_right_by_a_place_that_is_seen_again() {
        for solver in [GraphSolver::GaussNewton, GraphSolver::Olson] {
            let mut odometry = walk(7, 9, 3.0);
            odometry.options.graph_solver = solver;
            let away = |o: &VisualOdometry, k: usize| o.map.keyframes[k].pose.translation.z;
            assert!((away(&odometry, 15) - 9.0).abs() < 1e-9, "two steps of three units instead of one: four too far");
            odometry.links = vec![link(5, 15, 0.0, Some(1.0)), link(3, 17, 0.0, Some(1.0))];
            odometry.close_links(&up());
            // Four keyframes back from the turn at 10; a link counts for 0.07 units, and the steps for a tenth together.
            assert!((away(&odometry, 15) - away(&odometry, 5)).abs() < 0.2, "{solver:?}: {}", away(&odometry, 15));
            assert!((away(&odometry, 10) - 10.0).abs() < 0.5, "{solver:?}: the far end is where it was: {}", away(&odometry, 10));
        }
    }

    #[test]
    fn without_links_and_fixes_nothing_moves_and_a_lie_is_not_believed() {
        let mut odometry = walk(0, 0, 1.0);
        let before: Vec<Pose> = odometry.map.keyframes.iter().map(|k| k.pose).collect();
        odometry.close_links(&up());
        assert!(odometry.map.keyframes.iter().zip(&before).all(|(k, b)| k.pose == *b));
        // One says that the walk stood still, three that it went on.
        odometry.links = vec![link(2, 8, 0.0, None), link(1, 8, 7.0, None), link(2, 9, 7.0, None), link(3, 8, 5.0, None)];
        odometry.close_links(&up());
        let worst = odometry.map.keyframes.iter().zip(&before).map(|(k, b)| (k.pose.translation.vector - b.translation.vector).norm());
        assert!(worst.fold(0.0, f64::max) < 0.15, "less than a sigma of the lie");
    }

    #[test]
    fn what_was_seen_from_a_whole_window_bends_less_than_what_was_not() {
        let moved = |paired: bool| {
            let mut odometry = walk(0, 0, 1.0);
            let saw_alike = |a: usize, b: usize| (a < 5) == (b < 5);
            let pairs =
                (0..10usize).flat_map(|a| (a + 2..=(a + 4).min(10)).map(move |b| (a, b))).filter(|(a, b)| paired && saw_alike(*a, *b));
            odometry.window_pairs = pairs.map(|(a, b)| WindowPair { a: KeyframeId(a), b: KeyframeId(b), shared: 60, far: 4.0 }).collect();
            // Half a unit less from the first to the last.
            odometry.links = (0..3).map(|_| link(0, 10, 9.5, None)).collect();
            odometry.close_links(&up());
            let step = |k: usize| {
                (odometry.map.pose(KeyframeId(k + 1)).translation.z - odometry.map.pose(KeyframeId(k)).translation.z - 1.0).abs()
            };
            // Between 4 and 5 nothing was seen from both sides.
            (step(4), (0..10).filter(|k| *k != 4).map(step).fold(0.0, f64::max))
        };
        let (gap, others) = moved(false);
        assert!((gap - others).abs() < 0.02, "a chain bends alike everywhere: {gap} and {others}");
        let (gap, others) = moved(true);
        assert!(gap > 1.5 * others, "pairs hold what they see: {gap} and {others}");
    }

    #[test]
    fn links_follow_a_change_of_unit() {
        let mut odometry = walk(0, 0, 1.0);
        odometry.links = vec![link(2, 8, 6.0, Some(1.0)), link(6, 9, 3.0, Some(1.0)), link(1, 3, 2.0, Some(1.0))];
        odometry.rescale_links(2.0, |k| k >= KeyframeId(5));
        let found: Vec<(f64, Option<f64>)> = odometry.links.iter().map(|l| (l.a_from_b.translation.z, l.scale)).collect();
        // From an old keyframe to a new one: lengths are the old one's, of which the new one's unit is now half.
        assert_eq!(found, [(6.0, Some(0.5)), (6.0, Some(1.0)), (2.0, Some(1.0))]);
    }

    #[test]
    fn a_fix_that_knows_no_heading_still_knows_none() {
        let up = Vector3::y() * Vector3::y().transpose();
        let sharp = Fix {
            rotation: UnitQuaternion::identity(),
            information: (Matrix3::identity() - up) * 1e6,
            edges: 9,
            upright: 9,
            heading: false,
        };
        let soft = shared(&sharp).information;
        // 1e6 is 0.06°: what is shared is all that is left, 1.9°.
        assert!((soft[(0, 0)] - 1.0 / (FIX_SHARED_RAD2 + 1e-6)).abs() < 1e-6 * soft[(0, 0)] && soft[(1, 1)].abs() < 1e-9, "{soft}");
    }
}
