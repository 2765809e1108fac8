//! Where should one go to find out which of two places it is?
//!
//! two poses on the plan ──go on, straight, left or right, in both at once──▶ views ──▶ where they first differ clearly, and how
//!
//! Both walks go as far as neither is stopped by a wall. A view differs only if it does so whichever of the neighbouring ways
//! and places it is compared with: a hypothesis is not known to the centimetre, nor a heading to the degree.

use planwalk_types::{Cell, FloorPlan, Hypothesis, Plan, PlanPose, Pt2};

/// How far the walks are followed, metres, and in which steps.
const FAR_M: f64 = 30.0;
const STEP_M: f64 = 0.25;
/// How far one sees at most, metres: beyond, it is open.
const SIGHT_M: f64 = 8.0;
/// How near a wall one walks up, metres.
const STOP_M: f64 = 0.6;
/// Views differ when distances do by this, metres, and by this share of the shorter.
const DIFFER_M: f64 = 0.8;
const DIFFER_SHARE: f64 = 0.3;
/// Places along the other way that a view is compared with: so many steps back and ahead.
const SLACK: usize = 3;
/// Narrower gaps are doors, metres.
const DOOR_M: f64 = 1.8;
/// Directions of a view, in quarter turns from straight ahead, anticlockwise: what has a name.
const LOOKS: [i32; 3] = [-1, 0, 1];
/// Neighbouring ways that a view is compared with: metres to the left, radians to the left.
const NEIGHBOURS: [(f64, f64); 5] = [(0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.0, 0.06), (0.0, -0.06)];

/// Which way one goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Going {
    /// As the walker faces.
    Straight,
    /// After a quarter turn to the left.
    Left,
    /// After a quarter turn to the right.
    Right,
}

/// What is seen in a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View {
    /// A wall, so many metres off.
    Wall(f64),
    /// A gap in a wall, narrow as a door.
    Door,
    /// Nothing for at least so many metres.
    Open(f64),
}

/// What would tell two hypotheses apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// The hypotheses, by their place in the list; the first is the likeliest.
    pub first: usize,
    /// The other one.
    pub second: usize,
    /// How one would have to go on; `None` when nothing within 30 m tells them apart.
    pub going: Option<Going>,
    /// How far, metres; 0 where a look around would do.
    pub after_m: f64,
    /// Where to look then: radians anticlockwise from ahead.
    pub look_rad: f64,
    /// What is there under the first hypothesis.
    pub at_first: View,
    /// And under the second.
    pub at_second: View,
}

/// What would tell the likeliest hypothesis from each other one: for each the nearest way.
pub fn apart(plan: &FloorPlan, hypotheses: &[Hypothesis]) -> Vec<Apart> {
    let Some(first) = hypotheses.first() else { return Vec::new() };
    (1..hypotheses.len()).map(|second| between(plan, &first.pose, &hypotheses[second].pose, second)).collect()
}

fn between(plan: &FloorPlan, first: &PlanPose, other: &PlanPose, second: usize) -> Apart {
    let quarter = std::f64::consts::FRAC_PI_2;
    let ways = [(Going::Straight, 0.0), (Going::Left, quarter), (Going::Right, -quarter)];
    let mut best = Apart {
        first: 0,
        second,
        going: None,
        after_m: FAR_M,
        look_rad: 0.0,
        at_first: View::Open(SIGHT_M),
        at_second: View::Open(SIGHT_M),
    };
    for (going, turn_rad) in ways {
        let ways_of = |pose: &PlanPose| NEIGHBOURS.map(|by| Way::new(plan, pose, turn_rad, by));
        let (a, b) = (ways_of(first), ways_of(other));
        if let Some((step, look)) = differ(&a, &b).filter(|(step, _)| (*step as f64) * STEP_M < best.after_m) {
            best.going = Some(going);
            best.after_m = step as f64 * STEP_M;
            best.look_rad = f64::from(LOOKS[look]) * quarter;
            (best.at_first, best.at_second) = (a[0].view(step, look), b[0].view(step, look));
        }
    }
    best
}

/// Views along a straight way: distances by [`LOOKS`], every [`STEP_M`], up to a wall.
struct Way {
    views: Vec<[f64; LOOKS.len()]>,
}

impl Way {
    fn new(plan: &FloorPlan, pose: &PlanPose, turn_rad: f64, (left_m, left_rad): (f64, f64)) -> Self {
        let heading = pose.heading_rad + turn_rad + left_rad;
        let (s, c) = libm::sincos(heading);
        let (x, y) = (pose.x - left_m * s, pose.y + left_m * c);
        let ahead = distance(plan, x, y, heading, FAR_M + STOP_M);
        let steps = ((ahead - STOP_M).max(0.0) / STEP_M) as usize;
        let view = |i: usize| {
            let way = i as f64 * STEP_M;
            LOOKS.map(|quarters| {
                let look = heading + f64::from(quarters) * std::f64::consts::FRAC_PI_2;
                distance(plan, x + way * c, y + way * s, look, SIGHT_M)
            })
        };
        Self { views: (0..=steps).map(view).collect() }
    }

    /// What stands there, in words' terms: a long look between two short ones of the same side is a door.
    fn view(&self, step: usize, look: usize) -> View {
        let distance = self.views[step][look];
        let sideways = LOOKS[look] != 0;
        if sideways {
            let wall = |i: &usize| self.views[*i][look] < distance - DIFFER_M;
            let back = (0..step).rev().find(wall).map(|i| step - i);
            let on = (step + 1..self.views.len()).find(wall).map(|i| i - step);
            if let (Some(back), Some(on)) = (back, on)
                && (back + on - 1) as f64 * STEP_M < DOOR_M
            {
                return View::Door;
            }
        }
        if distance >= SIGHT_M { View::Open(SIGHT_M) } else { View::Wall(distance) }
    }
}

/// The first step and look at which one way's view is unlike those of all neighbours of the other.
fn differ(a: &[Way], b: &[Way]) -> Option<(usize, usize)> {
    let (own_a, own_b) = (a.first()?, b.first()?);
    let unlike = |one: &Way, others: &[Way], step: usize, look: usize| {
        let here = one.views[step][look];
        let near = others.iter().flat_map(|w| w.views.iter().take(step + SLACK + 1).skip(step.saturating_sub(SLACK))).map(|v| v[look]);
        let (mut low, mut high, mut alike) = (f64::INFINITY, f64::NEG_INFINITY, false);
        for d in near {
            (low, high) = (low.min(d), high.max(d));
            alike |= (d - here).abs() <= DIFFER_M.max(DIFFER_SHARE * d.min(here));
        }
        // What lies between two neighbouring views is no news either.
        !alike && (here < low || here > high)
    };
    // Ahead first: it needs no turn of the head.
    let order = [1, 2, 0];
    (0..own_a.views.len().min(own_b.views.len())).find_map(|step| {
        order.iter().find(|look| unlike(own_a, b, step, **look) || unlike(own_b, a, step, **look)).map(|look| (step, *look))
    })
}

/// Metres to the first wall in a direction, at most `limit`; off the plan nothing stands.
fn distance(plan: &FloorPlan, x: f64, y: f64, direction_rad: f64, limit: f64) -> f64 {
    let (s, c) = libm::sincos(direction_rad);
    let step = 0.7 * plan.cell_m();
    let count = (limit / step).min(1e5) as usize;
    let wall = |i: usize| matches!(plan.at(Pt2::<Plan>::new(x + i as f64 * step * c, y + i as f64 * step * s)), Cell::Wall | Cell::Window);
    // A hypothesis that stands in a wall looks out of it.
    let out = (0..count).find(|i| !wall(*i)).unwrap_or(0);
    (out..count).find(|i| wall(*i)).map_or(limit, |i| i as f64 * step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Wall;

    fn wall(x0: f64, y0: f64, x1: f64, y1: f64) -> Wall {
        Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) }
    }

    /// A hall of 40 m × 3 m, the same from both ends but for a door on its lower side, if there is one.
    fn hall(door: Option<f64>) -> FloorPlan {
        let mut walls = vec![wall(0.0, 3.0, 40.0, 3.0), wall(0.0, 0.0, 0.0, 3.0), wall(40.0, 0.0, 40.0, 3.0)];
        match door {
            Some(x) => walls.extend([wall(0.0, 0.0, x, 0.0), wall(x + 1.2, 0.0, 40.0, 0.0)]),
            None => walls.push(wall(0.0, 0.0, 40.0, 0.0)),
        }
        FloorPlan::from_walls(&walls, 0.1, 10.0).unwrap()
    }

    #[test]
    fn a_door_on_one_side_of_a_symmetric_hall_tells_its_ends_apart() {
        let plan = hall(Some(14.0));
        // From the left end to the right and the other way round: the door comes after 6 m on the right of the first.
        let (a, b) = (PlanPose::new(8.6, 1.5, 0.0), PlanPose::new(31.4, 1.5, std::f64::consts::PI));
        let found = between(&plan, &a, &b, 1);
        assert_eq!(found.going, Some(Going::Straight), "{found:?}");
        // It begins after 5.4 m and ends after 6.6 m.
        assert!(found.after_m > 5.3 && found.after_m < 6.6, "{found:?}");
        assert!(found.look_rad < 0.0, "on the right: {found:?}");
        assert_eq!(found.at_first, View::Door);
        assert!(matches!(found.at_second, View::Wall(d) if (d - 1.5).abs() < 0.2), "{found:?}");
    }

    #[test]
    fn nothing_tells_apart_what_is_perfectly_symmetric() {
        let plan = hall(None);
        let (a, b) = (PlanPose::new(8.6, 1.5, 0.1), PlanPose::new(31.5, 1.4, std::f64::consts::PI + 0.1));
        let found = between(&plan, &a, &b, 1);
        assert_eq!(found.going, None, "{found:?}");
        assert!((found.after_m - FAR_M).abs() < 1e-12);
    }

    #[test]
    fn a_wall_near_by_against_an_open_hall_is_seen_at_once() {
        let plan = hall(None);
        let (a, b) = (PlanPose::new(8.0, 1.5, 0.0), PlanPose::new(37.0, 1.5, 0.0));
        let found = between(&plan, &a, &b, 1);
        assert_eq!((found.going, found.after_m, found.look_rad), (Some(Going::Straight), 0.0, 0.0), "{found:?}");
        assert_eq!(found.at_first, View::Open(SIGHT_M));
        assert!(matches!(found.at_second, View::Wall(d) if (d - 3.0).abs() < 0.2), "{found:?}");
    }
}
