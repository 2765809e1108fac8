//! Where were the keyframes, given the places that were seen again? The pose graph at the end of a walk.
//!
//! chain of keyframes + [`Link`]s ─▶ [`crate::visual::graph`] ─▶ keyframes moved, each with its own unit; frames and points go along
//!
//! Without a link nothing is touched.

use planwalk_types::Similarity;

use super::VisualOdometry;
use super::reseen::Link;
use crate::visual::graph::{Edge, EdgeKind, Graph, GraphOptions, Node, information, optimise};
use crate::visual::map::{KeyframeId, Pose};
use crate::visual::recall::Odometer;

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

/// What one step of the chain may be off: as a share of its way, and of the way that nothing measured; radians, and radians for each
/// second in which nothing said how the camera turned.
const CHAIN_WAY: f64 = 0.03;
const CHAIN_ADRIFT: f64 = 0.7;
const CHAIN_STILL: f64 = 2e-3;
const CHAIN_TURN_RAD: f64 = 3e-3;
const CHAIN_BLIND_RAD_S: f64 = 0.3;
/// Logarithm of the unit's error from one keyframe to the next that no point with a distance joins; n of them leave the (n + 1)th part.
const CHAIN_UNIT: f64 = 0.5;
/// Error of a link: units, share of the points' distance, radians, and logarithm of the scale.
const LINK_MOVE: f64 = 0.03;
const LINK_FAR: f64 = 0.02;
const LINK_TURN_RAD: f64 = 0.015;
const LINK_SCALE: f64 = 0.15;

impl VisualOdometry {
    /// Notes how the newest keyframe was reached.
    pub(super) fn pass(&mut self) {
        let known = self.in_view().filter(|l| l.has_depth()).count();
        self.passages.push(Passage { odometer: self.odometer, known, reached: None });
    }

    /// Moves the keyframes to where the places that were seen again agree with the way between them.
    pub(super) fn close_links(&mut self) {
        if self.links.is_empty() {
            return;
        }
        let nodes = self.map.keyframes.iter().map(|k| Node { odom_from_keyframe: Similarity::from(&k.pose), fix: k.fix }).collect();
        let edges = self.chain().chain(self.links.iter().map(of_link)).collect();
        let graph = Graph { nodes, edges };
        let solution = optimise(&graph, &GraphOptions { seed: self.options.seed, ..GraphOptions::default() });
        self.apply(&solution.nodes);
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

fn of_link(link: &Link) -> Edge {
    let sigma_scale = if link.scale.is_some() { LINK_SCALE } else { f64::INFINITY };
    let a_from_b = Similarity { scale: link.scale.unwrap_or(1.0), ..Similarity::from(&link.a_from_b) };
    let information = information(LINK_MOVE + LINK_FAR * link.far, LINK_TURN_RAD, sigma_scale);
    Edge { a: link.a, b: link.b, a_from_b, information, kind: EdgeKind::Loop }
}
