//! Where are doors? Where their leaves swing: a quarter of a circle about the hinge, from one jamb into the room.

use planwalk_types::{Element, ElementKind, Form};

use super::super::PlanFileError;
use super::nearby::Nearby;
use super::{Drawn, Piece, SketchPath, SketchPoint, point};

/// Width of a leaf, metres.
const LEAF_M: std::ops::RangeInclusive<f64> = 0.5..=1.5;
/// How far a leaf swings, radians: 25° to 120° (some are drawn ajar, some a little more than square).
const SWING_RAD: std::ops::RangeInclusive<f64> = 0.43..=2.1;
/// Points of an arc lie this near to their circle, as a share of the radius, and of how far the arc bulges, whichever is less.
const ROUND: [f64; 2] = [0.05, 0.4];
/// An arc that a file has as a chain of chords has so many points at least.
const CHAIN_POINTS: usize = 5;
/// Along with a leaf go the lines of its threshold and its other side, up to this far off, metres.
const BESIDE_LEAF_M: f64 = 0.3;
/// A leaf is drawn this near to where its arc ends, metres: half of its thickness …
const LEAF_OFF_M: f64 = 0.08;
/// … and where an arc turns less than this, radians, its centre is less sure, and so is the hinge, metres.
const AJAR_RAD: f64 = 1.04;
const AJAR_OFF_M: f64 = 0.2;
/// A door fills the gap in its wall up to this, metres.
const JAMB_M: f64 = 0.2;

/// The swings on a drawing.
pub(super) fn on(drawn: &[&Drawn<'_>]) -> Vec<Swing> {
    drawn.iter().filter_map(|path| Swing::of(path)).collect()
}

/// The lines that are no leaves and no thresholds: these go as far as from the hinge of a swing to one of its ends, and no farther.
pub(super) fn without_leaves(lines: Vec<Piece>, swings: &[Swing]) -> Result<Vec<Piece>, PlanFileError> {
    let mut leaves: Vec<Piece> = swings.iter().flat_map(|swing| swing.ends.map(|end| Piece { from: swing.hinge, to: end })).collect();
    let mut offs: Vec<f64> =
        swings.iter().flat_map(|swing| [if swing.swept_rad < AJAR_RAD { AJAR_OFF_M } else { LEAF_OFF_M }; 2]).collect();
    leaves.extend(in_pairs(swings)?);
    offs.resize(leaves.len(), AJAR_OFF_M);
    let nearby = Nearby::of(leaves.iter().enumerate());
    let is_leaf = |line: &Piece| {
        let same = |leaf: &Piece, off: f64| {
            let [[a, left], [b, other]] = [line.from, line.to].map(|at| leaf.seen_from(at));
            let as_long = a.min(b).abs() <= off && (a.max(b) - leaf.length()).abs() <= off;
            as_long && left.abs().max(other.abs()) <= BESIDE_LEAF_M && (left - other).abs() <= off
        };
        nearby.to_point(line.from).into_iter().any(|i| same(&leaves[i], offs[i]))
    };
    let rest = lines.into_iter().filter(|line| !is_leaf(line)).collect();
    nearby.check()?;
    Ok(rest)
}

/// From hinge to hinge of doors of two leaves, which meet in the middle.
fn in_pairs(swings: &[Swing]) -> Result<Vec<Piece>, PlanFileError> {
    let ends: Vec<(usize, SketchPoint)> = swings.iter().enumerate().flat_map(|(i, swing)| swing.ends.map(|end| (i, end))).collect();
    let points: Vec<Piece> = ends.iter().map(|(_, at)| Piece { from: *at, to: *at }).collect();
    let nearby = Nearby::of(points.iter().enumerate());
    let mut pairs = Vec::new();
    for (i, end) in &ends {
        for (j, other) in nearby.to_point(*end).into_iter().filter_map(|k| ends.get(k)).filter(|(j, _)| j > i) {
            let (a, b) = (&swings[*i], &swings[*j]);
            // In line, or the leaves stand side by side.
            let in_line = distance(a.hinge, b.hinge) >= 0.95 * (a.radius + b.radius);
            if in_line && distance(*end, *other) <= AJAR_OFF_M {
                pairs.push(Piece { from: a.hinge, to: b.hinge });
            }
        }
    }
    nearby.check()?;
    Ok(pairs)
}

/// Doors that swing between walls that were found.
pub(super) fn doors(swings: &[Swing], found: &[Element]) -> Result<Vec<Element>, PlanFileError> {
    let walls: Vec<Piece> = found
        .iter()
        .filter(|element| element.kind == ElementKind::Wall)
        .flat_map(|element| {
            let closed = matches!(element.form, Form::Area(_));
            element.form.chains().flat_map(move |chain| {
                let ends = if closed { chain.len() } else { chain.len().saturating_sub(1) };
                (0..ends).map(move |i| {
                    let (from, to) = (chain[i], chain[(i + 1) % chain.len()]);
                    Piece { from: [from.x, from.y], to: [to.x, to.y] }
                })
            })
        })
        .collect();
    let nearby = Nearby::of(walls.iter().enumerate());
    let mut doors: Vec<Element> = swings.iter().filter_map(|swing| swing.door(&walls, &nearby)).collect();
    let wall_m = |at: SketchPoint| nearby.to_point(at).into_iter().map(|i| walls[i].distance_to(at)).fold(f64::INFINITY, f64::min);
    for pair in in_pairs(swings)? {
        let jambs = wall_m(pair.from) <= JAMB_M && wall_m(pair.to) <= JAMB_M;
        let open = [0.3, 0.7].iter().all(|share| wall_m(pair.point_at(share * pair.length(), 0.0)) > JAMB_M);
        doors.extend((jambs && open).then(|| Element::new(ElementKind::Door, Form::Line(vec![point(pair.from), point(pair.to)]))));
    }
    nearby.check()?;
    Ok(doors)
}

/// An arc of a leaf.
pub(in crate::plan) struct Swing {
    /// Centre of the arc.
    pub hinge: SketchPoint,
    /// Where the arc begins and ends.
    pub ends: [SketchPoint; 2],
    /// Width of the leaf.
    pub radius: f64,
    /// How far it turns.
    pub swept_rad: f64,
}

impl Swing {
    /// One as large as a door, metres.
    pub(super) fn of(path: &Drawn<'_>) -> Option<Self> {
        Self::of_any_size(path.path, &path.points).filter(|swing| LEAF_M.contains(&swing.radius))
    }

    /// The circle through the first, the middle and the last point, if all others lie on it and it turns as far as a door does.
    pub(in crate::plan) fn of_any_size(path: &SketchPath, points: &[SketchPoint]) -> Option<Self> {
        let (p, count) = (points, points.len());
        if path.closed || count < if path.curved { 3 } else { CHAIN_POINTS } {
            return None;
        }
        let (a, b, c) = (p[0], p[count / 2], p[count - 1]);
        let hinge = centre(a, b, c)?;
        let radius = distance(hinge, a);
        // Twice the angle at the rim is the angle at the centre.
        let swept = 2.0 * (0.5 * distance(a, c) / radius).clamp(-1.0, 1.0).asin();
        let off = (ROUND[0] * radius).min(ROUND[1] * radius * (1.0 - (0.5 * swept).cos()));
        let round = p.iter().all(|at| (distance(hinge, *at) - radius).abs() < off);
        (radius > 0.0 && round && SWING_RAD.contains(&swept)).then_some(Self { hinge, ends: [a, c], radius, swept_rad: swept })
    }

    /// From the hinge to the end at which the leaf meets the other jamb: both near a wall, and none between.
    fn door(&self, walls: &[Piece], nearby: &Nearby) -> Option<Element> {
        let near = |at: [f64; 2]| nearby.to_point(at).into_iter().map(|i| walls[i].distance_to(at)).fold(f64::INFINITY, f64::min);
        if near(self.hinge) > JAMB_M {
            return None;
        }
        let middle = |end: [f64; 2]| [0, 1].map(|k| 0.5 * (self.hinge[k] + end[k]));
        let fits = |end: &[f64; 2]| near(*end) <= JAMB_M && near(middle(*end)) > JAMB_M;
        let mut fitting = self.ends.into_iter().filter(fits);
        // Where both ends would do, nothing tells which of two openings it is.
        let (end, None) = (fitting.next()?, fitting.next()) else { return None };
        Some(Element::new(ElementKind::Door, Form::Line(vec![point(self.hinge), point(end)])))
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Of the circle through three points; `None` where they lie on a line.
fn centre(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<[f64; 2]> {
    let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let twice = 2.0 * (p[0] * q[1] - p[1] * q[0]);
    let (pp, qq) = (p[0] * p[0] + p[1] * p[1], q[0] * q[0] + q[1] * q[1]);
    let at = [a[0] + (q[1] * pp - p[1] * qq) / twice, a[1] + (p[0] * qq - q[0] * pp) / twice];
    at.iter().all(|v| v.is_finite()).then_some(at)
}
