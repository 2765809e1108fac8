//! What does light meet? The building as boxes, their upright faces, and what hangs on these.
//!
//! A [`Solid`] is an upright box over an oblong footprint: a piece of wall, the lintel over a door, a door leaf, a cupboard.
//! Its [`Face`]s are all that a ray of light can meet from the side. Its top or bottom needs no face of its own: a ray that
//! meets a face from *behind* must have come in through one of them.

mod cloth;
mod decor;
mod figure;
mod furniture;
mod index;
mod light;
mod people;

use planwalk_types::{FloorPlan, Plan, PlanError, Pt2, Pt3, Seed, Wall};

use crate::building::{Building, Door, distance_to_wall};
use crate::look::Look;

pub(crate) use decor::{Decor, DecorKind};
pub(crate) use figure::{Cast, Met};
use index::Index;
pub(crate) use light::Light;
pub use people::People;
pub(crate) use people::{Crowd, Footing, Watch};

/// Below this two places are the same, metres: far under a wall's thickness, far over round-off.
const SAME_M: f64 = 1e-6;

/// What a box is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SolidKind {
    Wall,
    /// The wall over a door.
    Lintel,
    /// A door's leaf, open or shut.
    Leaf,
    Cupboard,
    Desk,
    /// Open boards with books and boxes.
    Shelf,
    /// A pot with leaves.
    Plant,
    /// For waste.
    Bin,
    /// A cardboard box.
    Crate,
    /// A whiteboard on wheels: it stands above the floor.
    Whiteboard,
    /// A sofa or a bed.
    Soft,
    /// A worktop with doors under it.
    Counter,
}

/// An upright box: all points within `half_m` across the line, from one end of it to the other, between two heights.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solid {
    pub line: Wall,
    pub half_m: f64,
    pub z: [f64; 2],
    pub kind: SolidKind,
    /// Unit vector along the line.
    e: [f64; 2],
    /// Length of the line, metres.
    length: f64,
}

impl Solid {
    pub fn new(line: Wall, half_m: f64, z: [f64; 2], kind: SolidKind) -> Self {
        let (dx, dy) = (line.to.x - line.from.x, line.to.y - line.from.y);
        let length = libm::hypot(dx, dy).max(SAME_M);
        Self { line, half_m, z, kind, e: [dx / length, dy / length], length }
    }

    /// Distance on the floor from a point to the footprint, metres; 0 inside.
    pub fn distance(&self, point: Pt2<Plan>) -> f64 {
        self.distance2(point).sqrt()
    }

    /// Its square: walks ask for it millions of times.
    #[inline]
    fn distance2(&self, point: Pt2<Plan>) -> f64 {
        let (px, py) = (point.x - self.line.from.x, point.y - self.line.from.y);
        let (s, t) = (px * self.e[0] + py * self.e[1], px * self.e[1] - py * self.e[0]);
        let (beyond, beside) = ((-s).max(s - self.length).max(0.0), (t.abs() - self.half_m).max(0.0));
        beyond * beyond + beside * beside
    }

    /// The rectangle around the footprint.
    fn span(&self) -> ([f64; 2], [f64; 2]) {
        let Wall { from, to } = self.line;
        let h = self.half_m;
        ([from.x.min(to.x) - h, from.y.min(to.y) - h], [from.x.max(to.x) + h, from.y.max(to.y) + h])
    }

    /// The four sides of the footprint, counter-clockwise: what is outside lies to the right of each.
    pub fn sides(&self) -> [Wall; 4] {
        let ([ex, ey], length, h, from) = (self.e, self.length, self.half_m, self.line.from);
        let corner = |s: f64, t: f64| Pt2::new(from.x + s * ex + t * ey, from.y + s * ey - t * ex);
        let corners = [corner(0.0, h), corner(length, h), corner(length, -h), corner(0.0, -h)];
        [0, 1, 2, 3].map(|k| Wall { from: corners[k], to: corners[(k + 1) % 4] })
    }

    /// Whether a walker would bump into it.
    pub fn in_the_way(&self) -> bool {
        self.z[0] < 1.9
    }

    /// The part of `a + s·e` that lies strictly inside the footprint.
    fn clip(&self, a: [f64; 2], e: [f64; 2]) -> Option<(f64, f64)> {
        let (axis, length) = (self.e, self.length);
        let (px, py) = (a[0] - self.line.from.x, a[1] - self.line.from.y);
        let position = [px * axis[0] + py * axis[1], px * axis[1] - py * axis[0]];
        let velocity = [e[0] * axis[0] + e[1] * axis[1], e[0] * axis[1] - e[1] * axis[0]];
        let slabs = [(SAME_M, length - SAME_M), (SAME_M - self.half_m, self.half_m - SAME_M)];
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for ((p, v), (low, high)) in position.into_iter().zip(velocity).zip(slabs) {
            if v.abs() < 1e-12 {
                if p <= low || p >= high {
                    return None;
                }
            } else {
                let (one, other) = ((low - p) / v, (high - p) / v);
                from = from.max(one.min(other));
                to = to.min(one.max(other));
            }
        }
        (to > from + SAME_M).then_some((from, to))
    }
}

/// One upright rectangle that light can meet.
#[derive(Debug, Clone)]
pub(crate) struct Face {
    /// Where s = 0, plan metres.
    pub a: [f64; 2],
    /// Direction of growing s: to the right of whoever looks at the face.
    pub e: [f64; 2],
    /// Outward normal.
    pub n: [f64; 2],
    pub length: f64,
    pub z: [f64; 2],
    pub kind: SolidKind,
    /// From floor to ceiling: nothing behind it can be seen.
    pub full: bool,
    /// Which ends are no inner corner: they do not darken.
    pub jamb: [bool; 2],
    /// Which ends are the edge of a door opening.
    pub doorway: [bool; 2],
    /// Room in front of it.
    pub room: Option<usize>,
    /// How rough its plaster looks, 0 for blank.
    pub roughness: f32,
    pub seed: u32,
    pub decor: Vec<Decor>,
}

/// Everything that is there.
#[derive(Debug, Clone)]
pub(crate) struct World {
    pub solids: Vec<Solid>,
    pub faces: Vec<Face>,
    pub light: Light,
    pub height_m: f64,
    /// The solids by place.
    index: Index,
    /// What it was made of.
    building: Building,
}

/// Squares of the index of solids, metres: a doorway is two of them, a wall of a room ten.
const INDEX_CELL_M: f64 = 0.5;

impl World {
    pub fn new(building: &Building, look: &Look, seed: Seed) -> Self {
        let surfaces = building.thickness_m == 0.0;
        let mut solids = building.wall_solids(&building.walls);
        let walls = solids.len();
        solids.extend(door_solids(building));
        furniture::place(building, look.furniture, seed, &mut solids);
        let index = index_of(&solids);
        let mut faces = Vec::new();
        for (i, solid) in solids.iter().enumerate() {
            if i < walls && surfaces {
                faces.push(face_of(solid, [0.0, solid.length], solid.line.from, solid.e));
                continue;
            }
            let (low, high) = solid.span();
            let near = if i < walls { index.around(low, high) } else { Vec::new() };
            let others: Vec<&Solid> = near.iter().map(|k| *k as usize).filter(|k| *k < walls && *k != i).map(|k| &solids[k]).collect();
            add_faces(solid, &others, &mut faces);
        }
        mark_ends(&mut faces, building);
        for (i, face) in faces.iter_mut().enumerate() {
            face.full = face.z[0] <= 0.0 && face.z[1] >= building.height_m;
            face.room = building.room_at(in_front(face, 0.5 * face.length, 0.1));
            decor::hang(face, building, look, seed.child("decor", i as u64));
        }
        let light = Light::new(building, seed);
        Self { solids, faces, light, height_m: building.height_m, index, building: building.clone() }
    }

    /// Distance on the floor from a point to the nearest thing that one bumps into, metres; 0 inside the walls of a traced plan.
    pub fn clearance(&self, point: Pt2<Plan>) -> f64 {
        self.clearance_up_to(point, f64::INFINITY)
    }

    /// The same, or `limit_m` where there is nothing within it: much faster in wide rooms.
    pub fn clearance_up_to(&self, point: Pt2<Plan>, limit_m: f64) -> f64 {
        if self.building.is_in_wall(point) {
            return 0.0;
        }
        let distance2 = |k: usize| {
            let solid = &self.solids[k];
            if solid.in_the_way() { solid.distance2(point) } else { f64::INFINITY }
        };
        self.index.nearest2(point, limit_m, distance2).sqrt()
    }

    /// The plan of everything that one bumps into today: walls as built, shut doors, open leaves, furniture.
    ///
    /// # Errors
    /// As [`FloorPlan::new`].
    pub fn as_built_plan(&self, cell_m: f64, margin_m: f64) -> Result<FloorPlan, PlanError> {
        let built = self.building.as_built(cell_m, margin_m)?;
        let solids: Vec<Solid> = self.solids.iter().filter(|s| s.in_the_way() && s.kind != SolidKind::Wall).cloned().collect();
        let mut cells = built.cells().to_vec();
        for solid in &solids {
            crate::building::fill(solid, &built, &mut cells);
        }
        FloorPlan::new(built.origin(), built.cell_m(), built.width(), built.height(), cells)
    }

    /// Whether nothing lies between two points of the air; the surface that the second one lies on does not count.
    pub fn free_line(&self, from: Pt3<Plan>, to: Pt3<Plan>) -> bool {
        let d = to.coords - from.coords;
        !self.faces.iter().any(|face| {
            let toward = d.x * face.n[0] + d.y * face.n[1];
            let t = ((face.a[0] - from.coords.x) * face.n[0] + (face.a[1] - from.coords.y) * face.n[1]) / toward;
            let s = (from.coords.x + t * d.x - face.a[0]) * face.e[0] + (from.coords.y + t * d.y - face.a[1]) * face.e[1];
            let z = from.coords.z + t * d.z;
            t > 0.0 && t < 0.995 && s >= 0.0 && s <= face.length && z >= face.z[0] && z <= face.z[1]
        })
    }
}

/// The point of the floor `off_m` in front of the face at `s`.
pub(crate) fn in_front(face: &Face, s: f64, off_m: f64) -> Pt2<Plan> {
    Pt2::new(face.a[0] + s * face.e[0] + off_m * face.n[0], face.a[1] + s * face.e[1] + off_m * face.n[1])
}

fn index_of(solids: &[Solid]) -> Index {
    let bounds = solids.iter().map(Solid::span).fold(([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]), |(low, high), (from, to)| {
        ([low[0].min(from[0]), low[1].min(from[1])], [high[0].max(to[0]), high[1].max(to[1])])
    });
    // Nothing built: one empty square.
    let bounds = if solids.is_empty() { ([0.0; 2], [0.0; 2]) } else { bounds };
    Index::new(bounds, INDEX_CELL_M, solids.len(), |k| solids[k].span(), |k, p, radius_m| solids[k].distance2(p) <= radius_m * radius_m)
}

/// Walls with their thickness. Where a wall meets another it reaches to that one's far side, so that corners are filled.
/// `reach_m` beyond the other one's centre line: a little less than half of its thickness hides the end inside of it.
pub(crate) fn wall_solids(walls: &[Wall], thickness_m: f64, height_m: f64, reach_m: f64) -> Vec<Solid> {
    let half_m = 0.5 * thickness_m;
    let plain: Vec<Solid> = walls.iter().map(|wall| Solid::new(*wall, half_m, [0.0, height_m], SolidKind::Wall)).collect();
    if half_m == 0.0 {
        return plain;
    }
    let index = index_of(&plain);
    let touches = |i: usize, p: Pt2<Plan>| {
        let near = index.around([p.x - SAME_M, p.y - SAME_M], [p.x + SAME_M, p.y + SAME_M]);
        near.into_iter().any(|j| j as usize != i && distance_to_wall(p, &walls[j as usize]) < SAME_M)
    };
    let mut solids = Vec::with_capacity(walls.len());
    for (i, wall) in walls.iter().enumerate() {
        let mut line = *wall;
        let e = plain[i].e;
        if touches(i, wall.from) {
            line.from = Pt2::new(wall.from.x - reach_m * e[0], wall.from.y - reach_m * e[1]);
        }
        if touches(i, wall.to) {
            line.to = Pt2::new(wall.to.x + reach_m * e[0], wall.to.y + reach_m * e[1]);
        }
        solids.push(Solid::new(line, half_m, [0.0, height_m], SolidKind::Wall));
    }
    solids
}

/// Lintels and leaves.
fn door_solids(building: &Building) -> Vec<Solid> {
    let half_wall_m = 0.5 * building.thickness_m;
    let mut solids = Vec::new();
    for door in &building.doors {
        let z = [building.door_height_m, building.height_m];
        let lintel = Solid::new(door.opening, half_wall_m, z, SolidKind::Lintel);
        let e = lintel.e;
        solids.push(lintel);
        let half_m = 0.022;
        let z = [0.0, building.door_height_m];
        if !door.open {
            solids.push(Solid::new(door.opening, half_m, z, SolidKind::Leaf));
            continue;
        }
        // Leaves stand neither in each other's way nor in another doorway: then the door hangs at its other end, or has none.
        let hung = [door.hinge_at_from, !door.hinge_at_from].into_iter().map(|at_from| open_leaf(building, door, e, at_from, half_m, z));
        let clear = |leaf: &Solid| {
            let doorways = building.doors.iter().filter(|other| *other != door).all(|other| leaf.distance(other.centre()) > 0.9);
            doorways && solids.iter().filter(|s| s.kind == SolidKind::Leaf).all(|other| !near(leaf, other, 0.15))
        };
        if let Some(leaf) = hung.into_iter().find(clear) {
            solids.push(leaf);
        }
    }
    solids
}

/// The leaf of a door that is open by 90°: beside the opening, in the room that it swings into.
fn open_leaf(building: &Building, door: &Door, e: [f64; 2], hinge_at_from: bool, half_m: f64, z: [f64; 2]) -> Solid {
    let hinge = if hinge_at_from { door.opening.from } else { door.opening.to };
    let beside = if hinge_at_from { -half_m } else { half_m };
    let mut n = [-e[1], e[0]];
    let centre = door.centre();
    let probe = Pt2::new(centre.x + 0.3 * n[0], centre.y + 0.3 * n[1]);
    if !building.rooms.get(door.swings_into).is_some_and(|room| room.holds(probe)) {
        n = [e[1], -e[0]];
    }
    let at = |off: f64| Pt2::new(hinge.x + beside * e[0] + off * n[0], hinge.y + beside * e[1] + off * n[1]);
    let half_wall_m = 0.5 * building.thickness_m;
    Solid::new(Wall { from: at(half_wall_m), to: at(half_wall_m + 0.94 * door.width_m()) }, half_m, z, SolidKind::Leaf)
}

/// Whether any place of one footprint's line, every 5 cm, is closer than `gap_m` to another footprint.
fn near(one: &Solid, other: &Solid, gap_m: f64) -> bool {
    let (e, length) = (one.e, one.length);
    let steps = (length / 0.05).ceil() as usize;
    (0..=steps).any(|i| {
        let s = length * i as f64 / steps as f64;
        other.distance(Pt2::new(one.line.from.x + s * e[0], one.line.from.y + s * e[1])) < gap_m
    })
}

/// Adds the faces of a solid, without what lies inside `others`.
fn add_faces(solid: &Solid, others: &[&Solid], faces: &mut Vec<Face>) {
    let ([ex, ey], length) = (solid.e, solid.length);
    let (h, from) = (solid.half_m, solid.line.from);
    let corner = |s: f64, t: f64| [from.x + s * ex + t * ey, from.y + s * ey - t * ex];
    // Counter-clockwise: right side, far end, left side, near end; the outward normal is to the right of each edge.
    let sides = [(0.0, h), (length, h), (length, -h), (0.0, -h)];
    for (k, &(s, t)) in sides.iter().enumerate() {
        let (a, b) = (corner(s, t), corner(sides[(k + 1) % 4].0, sides[(k + 1) % 4].1));
        let side_length = libm::hypot(b[0] - a[0], b[1] - a[1]);
        let e = [(b[0] - a[0]) / side_length, (b[1] - a[1]) / side_length];
        let mut hidden: Vec<(f64, f64)> = others.iter().filter_map(|other| other.clip(a, e)).collect();
        hidden.sort_by(|p, q| p.0.total_cmp(&q.0));
        let mut done = 0.0;
        for (low, high) in hidden.into_iter().chain([(side_length, f64::INFINITY)]) {
            let end = low.min(side_length);
            if end > done + 1e-4 {
                let mut face = face_of(solid, [done, end], Pt2::new(a[0], a[1]), e);
                face.jamb = [solid.kind == SolidKind::Wall && done == 0.0, solid.kind == SolidKind::Wall && end == side_length];
                faces.push(face);
            }
            done = f64::max(done, high);
        }
    }
}

/// Finds the edges of doorways, and the ends where a wall goes on in nearly the same direction or turns away from the room.
fn mark_ends(faces: &mut [Face], building: &Building) {
    // A small office has free ends at doorways alone.
    if building.plain {
        faces.iter_mut().for_each(|face| face.doorway = face.jamb);
        return;
    }
    let end_of = |face: &Face, end: usize| {
        let s = if end == 0 { 0.0 } else { face.length };
        Pt2::<Plan>::new(face.a[0] + s * face.e[0], face.a[1] + s * face.e[1])
    };
    let ends: Vec<Pt2<Plan>> = faces.iter().flat_map(|face| [end_of(face, 0), end_of(face, 1)]).collect();
    let jambs: Vec<Pt2<Plan>> = building.doors.iter().flat_map(|door| [door.opening.from, door.opening.to]).collect();
    let index_points = |points: &[Pt2<Plan>]| {
        let walls: Vec<Solid> = points.iter().map(|p| Solid::new(Wall { from: *p, to: *p }, 0.0, [0.0, 1.0], SolidKind::Wall)).collect();
        index_of(&walls)
    };
    let (by_end, by_jamb) = (index_points(&ends), index_points(&jambs));
    let reach_m = 0.5 * building.thickness_m + 0.03;
    let around = |index: &Index, p: Pt2<Plan>, r: f64| index.around([p.x - r, p.y - r], [p.x + r, p.y + r]);
    for i in 0..faces.len() {
        if faces[i].kind != SolidKind::Wall {
            continue;
        }
        let (e, n) = (faces[i].e, faces[i].n);
        for end in 0..2 {
            let p = ends[2 * i + end];
            let doorway = around(&by_jamb, p, reach_m).into_iter().any(|k| jambs[k as usize].distance(p) < reach_m);
            let goes_on = around(&by_end, p, 0.02).into_iter().map(|k| k as usize).any(|k| {
                let other = &faces[k / 2];
                let straight = other.e[0] * e[0] + other.e[1] * e[1];
                // The neighbour begins where this one ends; it turns away if it leads behind this face.
                let away = (if end == 1 { 1.0 } else { -1.0 }) * (other.e[0] * n[0] + other.e[1] * n[1]) < 0.0;
                k / 2 != i && k % 2 != end && other.kind == SolidKind::Wall && ends[k].distance(p) < 0.02 && (straight > 0.87 || away)
            });
            faces[i].doorway[end] = doorway && faces[i].jamb[end];
            faces[i].jamb[end] |= goes_on;
        }
    }
}

/// The part from `s[0]` to `s[1]` of a side of a solid that begins at `a` and leads along `e`.
fn face_of(solid: &Solid, s: [f64; 2], a: Pt2<Plan>, e: [f64; 2]) -> Face {
    Face {
        a: [a.x + s[0] * e[0], a.y + s[0] * e[1]],
        e,
        n: [e[1], -e[0]],
        length: s[1] - s[0],
        z: solid.z,
        kind: solid.kind,
        full: false,
        jamb: [false; 2],
        doorway: [false; 2],
        room: None,
        roughness: 1.0,
        seed: 0,
        decor: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::building::{BuildingKind, BuildingOptions};

    fn world(seed: u64) -> (Building, World) {
        world_of(BuildingKind::Office, seed)
    }

    fn world_of(kind: BuildingKind, seed: u64) -> (Building, World) {
        let building = Building::generate(&BuildingOptions { kind, ..Default::default() }, Seed(seed)).unwrap();
        let world = World::new(&building, &Look::default(), Seed(seed));
        (building, world)
    }

    #[test]
    fn a_box_is_as_far_away_as_its_nearest_side() {
        let line = Wall { from: Pt2::new(0.0, 0.0), to: Pt2::new(2.0, 0.0) };
        let solid = Solid::new(line, 0.5, [0.0, 1.0], SolidKind::Desk);
        assert_eq!(solid.distance(Pt2::new(1.0, 1.5)), 1.0);
        assert_eq!(solid.distance(Pt2::new(5.0, 4.5)), 5.0);
        assert_eq!(solid.distance(Pt2::new(1.0, 0.2)), 0.0);
    }

    #[test]
    fn no_face_lies_inside_a_wall() {
        for seed in 0..5 {
            let (_, world) = world(seed);
            for face in world.faces.iter().filter(|f| f.kind == SolidKind::Wall) {
                let p = in_front(face, 0.5 * face.length, 0.003);
                let inside = world.solids.iter().filter(|s| s.kind == SolidKind::Wall && s.distance(p) == 0.0).count();
                assert_eq!(inside, 0, "seed {seed}: {face:?}");
            }
        }
    }

    #[test]
    fn doorways_are_free_where_doors_are_open() {
        for (seed, kind) in (0..10).flat_map(|seed| BuildingKind::ALL.map(|kind| (seed, kind))) {
            let (building, world) = world_of(kind, seed);
            for door in &building.doors {
                let free = world.clearance(door.centre());
                if door.open {
                    // Where the wall bends at the door, a corner of its thickness reaches in: 6 cm · sin 7°.
                    let bend_m = if kind == BuildingKind::Round { 0.008 } else { 1e-6 };
                    assert!((free - 0.5 * door.width_m()).abs() < bend_m, "{kind} {seed}: {free} m in {door:?}");
                } else {
                    assert_eq!(free, 0.0);
                }
            }
        }
    }
}
