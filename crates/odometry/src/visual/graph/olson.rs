//! Which keyframes agree best with all edges, from a poor start? Stochastic gradient descent along the walk.
//!
//! edge, one after another ─▶ what is missing between its ends ─▶ spread over all keyframes between them; each pass moves less
//!
//! Olson, Leonard & Teller 2006: the state is the walk's increments, so one edge moves all keyframes between its ends a little and
//! carries all later ones along. Each increment takes its share by the inverse of how much holds it (their preconditioner M), and
//! the rate falls as one over the passes. Trees make a change O(log N), as theirs do.
//!
//! In space: shifts and turns are in odom's axes, turns are spread by angle about one axis (Grisetti, Stachniss, Grzonka & Burgard
//! 2007), the logarithm of the scale is one increment more. Within a pass a keyframe's turn since the pass began is one rotation
//! vector; a new turn is added to it as the vector that gives the exact rotation at the edge's far end.
//!
//! We depart from Olson in two things. Each of shift, turn and scale has one strength an edge, not one a coordinate: a world turned
//! about must give the same answer. And an edge takes the share λ w Σ 1/M of what is missing, at most all of it, which is gradient
//! descent preconditioned by M; his learning rate is relative to the weakest edge, and one weak edge lets all others leap.
//!
//! Pitfall: it comes near the minimum, not to it, however long it goes on: a shift's error turns nobody here (nor in Olson's
//! increments), though on a long loop it is headings that shift the far end. [`super::optimise`] therefore ends with Gauss–Newton.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Seed, Similarity, Tangent7};
use rand::seq::SliceRandom;

use super::part;
use super::problem::{Problem, squared};
use super::residual::residual;

/// Passes in which the rate falls to a half: λ = 1 / (1 + t/10). Olson's own 1/t halves after one, and leaves no time for positions to
/// follow headings.
const HALF_RATE_PASSES: f64 = 10.0;

/// The keyframes after so many passes, and the number of passes.
///
/// Not the best ones of all passes: among lies that are hardly believed a start that contradicts all loops may seem good.
pub(super) fn descend(problem: &Problem<'_>, start: &[Similarity], passes: usize, seed: Seed) -> (Vec<Similarity>, usize) {
    let mut walks: Vec<Walk<'_, '_>> = problem.groups.iter().map(|members| Walk::new(problem, members, start)).collect();
    let (first_widening, mut now) = (problem.first_widening(start), start.to_vec());
    for pass in 0..passes {
        // Doubt narrows evenly, and is as narrow as it gets in the last third.
        let narrowed = (1.5 * pass as f64 / passes as f64).min(1.0);
        let widening = libm::pow(first_widening, 1.0 - narrowed);
        let rate = 1.0 / (1.0 + pass as f64 / HALF_RATE_PASSES);
        for walk in &mut walks {
            walk.pass(&mut now, rate, widening, seed, pass);
        }
    }
    (now, passes)
}

/// What pulls on a walk: an edge between two of its keyframes, or what the building's edges say of one.
#[derive(Clone, Copy)]
struct Pull {
    /// Places on the walk; the increments between them give way. A fix pulls on all since the beginning.
    early: usize,
    late: usize,
    /// The edge, by its number in the graph; none is a fix.
    edge: Option<usize>,
    /// How strongly it holds shift, turn and scale, in the keyframes' own unit.
    strength: [f64; 3],
}

/// One group of keyframes.
struct Walk<'p, 'g> {
    problem: &'p Problem<'g>,
    members: &'p [usize],
    pulls: Vec<Pull>,
}

impl<'p, 'g> Walk<'p, 'g> {
    fn new(problem: &'p Problem<'g>, members: &'p [usize], start: &[Similarity]) -> Self {
        let mut place = vec![None; start.len()];
        for (at, node) in members.iter().enumerate() {
            place[*node] = Some(at);
        }
        let of_edge = |e: &usize| {
            let edge = &problem.graph.edges[*e];
            let (a, b) = (place[edge.a.0]?, place[edge.b.0]?);
            let block = |row: usize| edge.information.fixed_view::<3, 3>(row, row).into_owned();
            let strength = [strength(&block(0)), strength(&block(3)), edge.information[(6, 6)]];
            Some(Pull { early: a.min(b), late: a.max(b), edge: Some(*e), strength })
        };
        let of_fix = |at: usize| {
            let fix = problem.fix(members[at])?;
            Some(Pull { early: 0, late: at, edge: None, strength: [0.0, strength(&fix.information), 0.0] })
        };
        let pulls = problem.edges.iter().filter_map(of_edge).chain((1..members.len()).filter_map(of_fix)).collect();
        Self { problem, members, pulls }
    }

    /// Each pull once, in an order of chance.
    fn pass(&mut self, nodes: &mut [Similarity], rate: f64, widening: f64, seed: Seed, pass: usize) {
        let held: Vec<Tangent7> = self.pulls.iter().map(|pull| self.held(pull, nodes, widening)).collect();
        let mut shifts = Shifts::new(&self.give(&held));
        let mut order: Vec<usize> = (0..self.pulls.len()).collect();
        let step = (self.members[0] as u64) << 32 | pass as u64;
        order.shuffle(&mut seed.derive("pose graph", step));
        for pull in order {
            let missing = self.missing(&self.pulls[pull], nodes, &shifts);
            let Pull { early, late, .. } = self.pulls[pull];
            let share = (held[pull] * rate).component_mul(&shifts.give_between(early, late)).map(|s| s.min(1.0));
            shifts.turn_and_shift(early, late, &share.component_mul(&missing));
        }
        for (at, node) in self.members.iter().enumerate() {
            nodes[*node] = shifted(&nodes[*node], &shifts.at(at));
        }
    }

    /// How strongly a pull holds the increments between its ends, odom's unit, as far as it is believed.
    fn held(&self, pull: &Pull, nodes: &[Similarity], widening: f64) -> Tangent7 {
        let [shift, turn, scale] = pull.strength;
        let (weight, unit) = pull.edge.map_or((1.0, 1.0), |e| {
            let edge = &self.problem.graph.edges[e];
            let unit = nodes[edge.a.0].scale * edge.a_from_b.scale;
            (self.problem.weight(edge, squared(edge, nodes), widening), unit)
        });
        let shift = shift / (unit * unit);
        Tangent7::from([shift, shift, shift, turn, turn, turn, scale]) * weight
    }

    /// How easily each increment gives way: the inverse of all that holds it. What nothing holds is left alone.
    fn give(&self, held: &[Tangent7]) -> Vec<Tangent7> {
        let mut change = vec![Tangent7::zeros(); self.members.len() + 1];
        for (pull, held) in self.pulls.iter().zip(held) {
            change[pull.early + 1] += held;
            change[pull.late + 1] -= held;
        }
        let mut all = Tangent7::zeros();
        let mut most = Tangent7::zeros();
        let mut give = Vec::with_capacity(self.members.len());
        for change in &change[..self.members.len()] {
            all += change;
            most = most.sup(&all);
            // Where holds end, round-off of them is left.
            give.push(all.zip_map(&most, |held, most| if held > 1e-12 * most { 1.0 / held } else { 0.0 }));
        }
        give
    }

    /// By how much the later end would have to be shifted, turned and scaled against the earlier one, odom's axes and unit.
    fn missing(&self, pull: &Pull, nodes: &[Similarity], shifts: &Shifts) -> Tangent7 {
        let now = |at: usize| shifted(&nodes[self.members[at]], &shifts.at(at));
        let (early, late) = (now(pull.early), now(pull.late));
        let Some(edge) = pull.edge.map(|e| &self.problem.graph.edges[e]) else {
            let Some(fix) = self.problem.fix(self.members[pull.late]) else { return Tangent7::zeros() };
            let turn = -(late.rotation * known(&fix.information, &fix.error(&late.rotation), pull.strength[1]));
            return joined(&Vector3::zeros(), &turn, 0.0);
        };
        let forward = self.members[pull.late] == edge.b.0;
        let (a, b) = if forward { (early, late) } else { (late, early) };
        let r = residual(&edge.a_from_b, &a, &b);
        let block = |row: usize| edge.information.fixed_view::<3, 3>(row, row).into_owned();
        let (shift, turn) = (known(&block(0), &part(&r, 0), pull.strength[0]), known(&block(3), &part(&r, 3), pull.strength[1]));
        let shift = a.rotation * (edge.a_from_b.rotation * shift) * (a.scale * edge.a_from_b.scale);
        let of_b = joined(&-shift, &-(b.rotation * turn), -r[6]);
        if forward { of_b } else { -of_b }
    }
}

/// How strongly a block of information holds: of equal eigenvalues that value, even where others are zero.
fn strength(block: &nalgebra::Matrix3<f64>) -> f64 {
    let trace = block.trace();
    if trace > 0.0 { block.norm_squared() / trace } else { 0.0 }
}

/// The part of an error that is known of.
fn known(block: &nalgebra::Matrix3<f64>, error: &Vector3<f64>, strength: f64) -> Vector3<f64> {
    if strength > 0.0 { block * error / strength } else { Vector3::zeros() }
}

fn joined(shift: &Vector3<f64>, turn: &Vector3<f64>, log_scale: f64) -> Tangent7 {
    Tangent7::from([shift.x, shift.y, shift.z, turn.x, turn.y, turn.z, log_scale])
}

/// A keyframe after a shift, turn and scaling in odom's axes, each by itself.
fn shifted(node: &Similarity, by: &Tangent7) -> Similarity {
    let turned = UnitQuaternion::from_scaled_axis(part(by, 3)) * node.rotation;
    Similarity {
        scale: node.scale * libm::exp(by[6]),
        rotation: UnitQuaternion::new_normalize(turned.into_inner()),
        translation: node.translation + part(by, 0),
    }
}

/// How far each keyframe of a walk has been moved during a pass. A move is spread over the increments (early, late] as they give,
/// and carries along all that comes later.
///
/// With C the amount per give that increment i got, the sum to k is Σ g_i Σ_{j ≤ i} c_j = G_k Σ c_j − Σ c_j G_{j−1}, where c is the
/// change of C and G the sum of g: two binary indexed trees (Fenwick 1994), O(log N) for a move and for a look.
struct Shifts {
    /// Sum of give up to and with each increment.
    give: Vec<Tangent7>,
    /// Σ c and Σ c G, by Fenwick's ranges.
    trees: Vec<(Tangent7, Tangent7)>,
}

impl Shifts {
    fn new(give: &[Tangent7]) -> Self {
        let mut sum = Tangent7::zeros();
        let give: Vec<Tangent7> = give
            .iter()
            .map(|g| {
                sum += g;
                sum
            })
            .collect();
        let trees = vec![(Tangent7::zeros(), Tangent7::zeros()); give.len() + 1];
        Self { give, trees }
    }

    fn give_between(&self, early: usize, late: usize) -> Tangent7 {
        self.give[late] - self.give[early]
    }

    /// How far this keyframe has been moved.
    fn at(&self, place: usize) -> Tangent7 {
        let (mut changes, mut offset) = (Tangent7::zeros(), Tangent7::zeros());
        let mut i = place + 1;
        while i > 0 {
            changes += self.trees[i].0;
            offset += self.trees[i].1;
            i &= i - 1;
        }
        self.give[place].component_mul(&changes) - offset
    }

    /// Moves the late end by this, and the increments between early and late as they give.
    fn spread(&mut self, early: usize, late: usize, by: &Tangent7) {
        let per_give = by.zip_map(&self.give_between(early, late), |by, give| if give > 0.0 { by / give } else { 0.0 });
        self.change(early, &per_give);
        self.change(late, &-per_give);
    }

    /// Changes the amount per give of all increments after `place`.
    fn change(&mut self, place: usize, by: &Tangent7) {
        let offset = by.component_mul(&self.give[place]);
        // Increment place + 1, and Fenwick counts from one.
        let mut i = place + 2;
        while i < self.trees.len() {
            self.trees[i].0 += by;
            self.trees[i].1 += offset;
            i += i & i.wrapping_neg();
        }
    }

    /// The same where the turn is one on top of what the late end has turned already.
    fn turn_and_shift(&mut self, early: usize, late: usize, by: &Tangent7) {
        let before = part(&self.at(late), 3);
        let turned = UnitQuaternion::from_scaled_axis(part(by, 3)) * UnitQuaternion::from_scaled_axis(before);
        let after = nearest_turn(&turned.scaled_axis(), &before);
        let mut by = *by;
        by.fixed_rows_mut::<3>(3).copy_from(&(after - before));
        self.spread(early, late, &by);
    }
}

/// Of all rotation vectors with this one's rotation, that nearest to another: beside half a turn it goes on to more.
fn nearest_turn(turn: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    let Some(axis) = turn.try_normalize(1e-12) else { return *turn };
    let whole_turns = ((to - turn).dot(&axis) / std::f64::consts::TAU).round();
    turn + axis * (whole_turns * std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn trees_agree_with_moving_each_keyframe_by_itself(
            gives in prop::collection::vec(0.01..3.0f64, 2..40), moves in prop::collection::vec((0..1000usize, 0..1000usize, -2.0..2.0f64), 1..30)
        ) {
            let give: Vec<Tangent7> = gives.iter().map(|g| Tangent7::repeat(*g)).collect();
            let (mut shifts, mut each) = (Shifts::new(&give), vec![0.0; gives.len()]);
            for (i, j, by) in moves {
                let (i, j) = (i % gives.len(), j % gives.len());
                let (early, late) = (i.min(j), i.max(j));
                if early == late {
                    continue;
                }
                shifts.spread(early, late, &Tangent7::repeat(by));
                let all: f64 = gives[early + 1..=late].iter().sum();
                let mut so_far = 0.0;
                for k in early + 1..gives.len() {
                    so_far += if k <= late { by * gives[k] / all } else { 0.0 };
                    each[k] += so_far;
                }
            }
            for (k, expected) in each.iter().enumerate() {
                // Amounts per give reach 2 / 0.01, gives 120, moves 30: round-off of 1e-16 · 7e5.
                prop_assert!((shifts.at(k) - Tangent7::repeat(*expected)).amax() < 1e-9, "{k}: {} for {expected}", shifts.at(k));
            }
        }
    }

    #[test]
    fn a_turn_goes_on_beyond_half_a_turn() {
        let (before, after) = (Vector3::z() * 3.0, Vector3::z() * (3.3 - std::f64::consts::TAU));
        assert!((nearest_turn(&after, &before) - Vector3::z() * 3.3).norm() < 1e-12);
        assert_eq!(nearest_turn(&Vector3::zeros(), &before), Vector3::zeros());
    }

    #[test]
    fn a_direction_that_is_not_known_of_is_no_strength_less() {
        let plane = nalgebra::Matrix3::from_diagonal(&Vector3::new(4.0, 4.0, 0.0));
        assert_eq!(strength(&plane), 4.0);
        assert_eq!(known(&plane, &Vector3::new(1.0, 2.0, 3.0), 4.0), Vector3::new(1.0, 2.0, 0.0));
    }
}
