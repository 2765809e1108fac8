//! What is built? Walls with door openings, the rooms between them, and the plan that is drawn of them.
//!
//! Walls are stored by their centre lines, already cut at every opening. A plan draws all doors as openings: it does not know
//! which of them are shut today; and it may lie about walls, see [`Lies`].
//!
//! Options ─▶ layout of its kind (rooms, lines with doors) ─▶ cut ([`Building::generate`]); or
//! plan ─▶ outlines of its walls, regions of its floor ([`Building::from_plan`], where walls are surfaces without thickness).

mod flat;
mod large_office;
mod lies;
mod office;
mod open_plan;
mod options;
mod raster;
mod regions;
mod ring;
mod room;
mod round;
mod sketch;
mod traced;
mod tracing;

use std::sync::Arc;

use planwalk_types::{FloorPlan, Plan, PlanError, Pt2, Seed, Wall};

use crate::error::SimError;
use crate::world::{Solid, SolidKind, wall_solids};
pub use options::{BuildingKind, BuildingOptions, Lies, PlanWorldOptions};
use raster::draw;
pub(crate) use raster::fill;
pub(crate) use room::bounds_of;
pub use room::{Room, RoomKind};
use traced::Traced;

/// An opening in a wall, with or without a shut leaf in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Door {
    /// The two ends of the opening, on the wall's centre line.
    pub opening: Wall,
    /// Whether one can walk through today. The plan does not know.
    pub open: bool,
    /// Into which room the leaf swings, an index into [`Building::rooms`].
    pub swings_into: usize,
    /// Whether the leaf hangs at `opening.from` (else at `opening.to`).
    pub hinge_at_from: bool,
}

impl Door {
    /// The middle of the opening.
    pub fn centre(&self) -> Pt2<Plan> {
        let Wall { from, to } = self.opening;
        Pt2::new(0.5 * (from.x + to.x), 0.5 * (from.y + to.y))
    }

    /// Clear width, metres.
    pub fn width_m(&self) -> f64 {
        self.opening.from.distance(self.opening.to)
    }
}

/// Walls, doors and rooms of one floor.
#[derive(Debug, Clone, PartialEq)]
pub struct Building {
    /// Centre lines of the walls as built, cut at every opening, metres. Where the thickness is 0 they are surfaces, with the
    /// room to their right.
    pub walls: Vec<Wall>,
    /// The same as drawn on the plan: some of these walls were never built, and some that were are not among them.
    pub drawn: Vec<Wall>,
    /// The openings.
    pub doors: Vec<Door>,
    /// The rooms; a corridor with a bend may be two of them.
    pub rooms: Vec<Room>,
    /// Thickness of the walls, metres.
    pub thickness_m: f64,
    /// From floor to ceiling, metres.
    pub height_m: f64,
    /// Clear height of the doors, metres.
    pub door_height_m: f64,
    /// Whether desks and cupboards are all its furniture: so in a small office.
    pub(crate) plain: bool,
    /// The plan that it was traced from.
    traced: Option<Arc<Traced>>,
}

/// No room's number in a grid of rooms.
pub(crate) const NO_ROOM: u16 = u16::MAX;
/// Up to this size an office has one corridor with a bend, metres.
const SMALL_OFFICE_M: (f64, f64) = (26.0, 17.0);

impl Building {
    /// A building of the kind and size that the options say. The same seed gives the same building.
    ///
    /// # Errors
    /// [`SimError::Option`] for a size that no such building has.
    pub fn generate(options: &BuildingOptions, seed: Seed) -> Result<Self, SimError> {
        let size_m = options.size_m()?;
        let mut rng = seed.derive("building", 0);
        let (sketch, size_m) = match options.kind {
            BuildingKind::Office if size_m.0 <= SMALL_OFFICE_M.0 && size_m.1 <= SMALL_OFFICE_M.1 => office::small(size_m, &mut rng),
            BuildingKind::Office => large_office::layout(size_m, &mut rng),
            BuildingKind::OpenPlan => open_plan::layout(size_m, &mut rng),
            BuildingKind::Flat => flat::layout(size_m, &mut rng),
            BuildingKind::Loop => ring::layout(size_m, &mut rng),
            BuildingKind::Round => round::layout(size_m, &mut rng),
        };
        Ok(sketch.build(options, size_m, seed, &mut rng))
    }

    /// The world of a given plan: its walls as high as the storey, its floor split into rooms, no doors in its openings.
    ///
    /// Cells finer than 5 cm are put together. Walls are traced around the plan's wall cells; what
    /// [`FloorPlan::inside`] says is outside is not walked, neither is what the plan does not know.
    ///
    /// # Errors
    /// [`SimError::Option`] for options out of range, [`SimError::NoInside`] where nothing is inside.
    pub fn from_plan(plan: &FloorPlan, options: &PlanWorldOptions, seed: Seed) -> Result<Self, SimError> {
        options.check()?;
        traced::build(plan, options, seed)
    }

    /// A storey in which nothing is built yet.
    fn empty() -> Self {
        Self {
            walls: Vec::new(),
            drawn: Vec::new(),
            doors: Vec::new(),
            rooms: Vec::new(),
            thickness_m: 0.12,
            height_m: 2.7,
            door_height_m: 2.1,
            plain: false,
            traced: None,
        }
    }

    /// The plan as it is drawn: walls as thick as they are, every door an opening, nothing of the furniture.
    ///
    /// # Errors
    /// As [`FloorPlan::new`].
    pub fn plan(&self, cell_m: f64, margin_m: f64) -> Result<FloorPlan, PlanError> {
        if self.walls.is_empty() {
            return Err(PlanError::NoWalls);
        }
        if let Some(traced) = &self.traced {
            return traced.plan(&traced.drawn, cell_m, margin_m);
        }
        draw(&self.drawn, &self.wall_solids(&self.drawn), cell_m, margin_m)
    }

    /// What one would measure in the empty building today: the walls that are there, and shut doors.
    ///
    /// # Errors
    /// As [`FloorPlan::new`].
    pub fn as_built(&self, cell_m: f64, margin_m: f64) -> Result<FloorPlan, PlanError> {
        if self.walls.is_empty() {
            return Err(PlanError::NoWalls);
        }
        if let Some(traced) = &self.traced {
            return traced.plan(&traced.built, cell_m, margin_m);
        }
        let mut solids = self.wall_solids(&self.walls);
        solids.extend(self.shut_doors().map(|door| Solid::new(door, 0.022, [0.0, self.door_height_m], SolidKind::Leaf)));
        draw(&self.drawn, &solids, cell_m, margin_m)
    }

    /// Every line that a ray meets at the height of the eyes in the empty building: both faces and the ends of each wall that is
    /// there, and shut doors. Lines may lie inside other walls where walls meet; no ray gets there.
    pub fn solid_lines(&self) -> Vec<Wall> {
        if self.thickness_m == 0.0 {
            return self.walls.iter().copied().chain(self.shut_doors()).collect();
        }
        let walls = self.wall_solids(&self.walls);
        walls.iter().flat_map(Solid::sides).chain(self.shut_doors()).collect()
    }

    /// These walls with their thickness.
    pub(crate) fn wall_solids(&self, walls: &[Wall]) -> Vec<Solid> {
        // Ends that lie in the other wall's surface would be seen as a strip in it; a small office hides them in its corners.
        let reach_m = 0.5 * self.thickness_m - if self.plain { 0.0 } else { 0.002 };
        wall_solids(walls, self.thickness_m, self.height_m, reach_m)
    }

    fn shut_doors(&self) -> impl Iterator<Item = Wall> + '_ {
        self.doors.iter().filter(|door| !door.open).map(|door| door.opening)
    }

    /// The room that holds this point.
    pub fn room_at(&self, point: Pt2<Plan>) -> Option<usize> {
        if let Some(traced) = &self.traced {
            return traced.room_at(point);
        }
        self.rooms.iter().position(|room| room.holds(point))
    }

    /// The room of each cell of a grid, whose cell (i, j) has its centre at `origin + (i + ½, j + ½) · cell_m`; [`NO_ROOM`] elsewhere.
    /// In a traced plan the rooms reach a little into the walls, whose surfaces are only near the cells' borders.
    pub(crate) fn room_cells(&self, origin: [f64; 2], cell_m: f64, size: [usize; 2]) -> Vec<u16> {
        let mut cells = vec![NO_ROOM; size[0] * size[1]];
        if let Some(traced) = &self.traced {
            for (i, cell) in cells.iter_mut().enumerate() {
                let centre = |k: usize, axis: usize| origin[axis] + (k as f64 + 0.5) * cell_m;
                *cell = traced.floor_at(Pt2::new(centre(i % size[0], 0), centre(i / size[0], 1)));
            }
            return cells;
        }
        // Where rooms overlap the first one counts, as in `room_at`.
        for (i, room) in self.rooms.iter().enumerate().take(usize::from(NO_ROOM)).rev() {
            room.paint(i as u16, origin, cell_m, size, &mut cells);
        }
        cells
    }

    /// Whether what lies behind a wall's surface is outdoors; `n` is the surface's normal.
    pub(crate) fn outdoors_behind(&self, surface: Pt2<Plan>, n: [f64; 2]) -> bool {
        let behind = |m: f64| Pt2::new(surface.x - m * n[0], surface.y - m * n[1]);
        match &self.traced {
            None => self.room_at(behind(2.0 * self.thickness_m)).is_none(),
            Some(traced) => traced.outdoors_behind(behind),
        }
    }

    /// Whether a point lies inside the walls of a traced plan.
    pub(crate) fn is_in_wall(&self, point: Pt2<Plan>) -> bool {
        self.traced.as_ref().is_some_and(|traced| traced.is_wall(point))
    }

    /// Lower left and upper right corner of everything built; both at the origin where nothing is.
    pub fn bounds(&self) -> (Pt2<Plan>, Pt2<Plan>) {
        if self.walls.is_empty() {
            return (Pt2::new(0.0, 0.0), Pt2::new(0.0, 0.0));
        }
        let ends: Vec<Pt2<Plan>> = self.walls.iter().flat_map(|w| [w.from, w.to]).collect();
        bounds_of(&ends)
    }
}

/// Distance from a point to a wall's centre line, metres.
pub(crate) fn distance_to_wall(point: Pt2<Plan>, wall: &Wall) -> f64 {
    let (dx, dy) = (wall.to.x - wall.from.x, wall.to.y - wall.from.y);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 { ((point.x - wall.from.x) * dx + (point.y - wall.from.y) * dy) / length2 } else { 0.0 };
    let t = along.clamp(0.0, 1.0);
    libm::hypot(point.x - wall.from.x - t * dx, point.y - wall.from.y - t * dy)
}

#[cfg(test)]
mod tests {
    use planwalk_types::Cell;

    use super::*;

    fn office(seed: u64) -> Building {
        Building::generate(&BuildingOptions::default(), Seed(seed)).unwrap()
    }

    #[test]
    fn an_office_has_rooms_doors_and_a_corridor_with_a_bend() {
        for seed in 0..50 {
            let building = office(seed);
            let corridors = building.rooms.iter().filter(|r| r.kind == RoomKind::Corridor).count();
            assert!(building.rooms.len() >= 9 && corridors == 2 && building.doors.len() >= 8, "seed {seed}: {:?}", building.rooms);
            let (low, high) = building.bounds();
            assert!((high.x - low.x - 20.0).abs() <= 1.0 + 1e-9 && (high.y - low.y - 14.0).abs() <= 0.7 + 1e-9, "seed {seed}");
        }
    }

    #[test]
    fn rooms_differ_in_size_so_that_a_walk_tells_where_it_is() {
        for seed in 0..50 {
            let building = office(seed);
            let mut areas: Vec<f64> = building.rooms.iter().map(Room::area_m2).collect();
            areas.sort_by(f64::total_cmp);
            // The largest room is at least twice the smallest: no two ends of the building look the same.
            assert!(areas[areas.len() - 1] > 2.0 * areas[0], "seed {seed}: {areas:?}");
        }
    }

    #[test]
    fn every_door_is_an_opening_of_the_plan_and_every_wall_is_closed() {
        for seed in 0..20 {
            let building = office(seed);
            let plan = building.plan(0.05, 1.0).unwrap();
            for door in &building.doors {
                assert_eq!(plan.at(door.centre()), Cell::Free, "seed {seed}: {door:?}");
            }
            for wall in &building.walls {
                assert_eq!(plan.at(Pt2::new(0.5 * (wall.from.x + wall.to.x), 0.5 * (wall.from.y + wall.to.y))), Cell::Wall);
            }
        }
    }

    #[test]
    fn another_seed_is_another_building() {
        assert_eq!(office(3), office(3));
        assert_ne!(office(3), office(4));
    }

    #[test]
    fn fewer_doors_are_open_where_one_asks_for_it() {
        let open = |open_doors: f64| {
            let options = BuildingOptions { open_doors, ..Default::default() };
            Building::generate(&options, Seed(5)).unwrap().doors.iter().filter(|d| d.open).count()
        };
        assert!(open(0.0) < open(1.0));
        // The hall's door to the corridor alone.
        assert_eq!(open(0.0), 1);
    }

    #[test]
    fn sizes_that_are_no_office_are_refused() {
        let odd = |width_m: f64, open_doors: f64| BuildingOptions { width_m: Some(width_m), open_doors, ..Default::default() };
        assert!(matches!(Building::generate(&odd(f64::NAN, 0.5), Seed(1)), Err(SimError::Option { .. })));
        assert!(matches!(Building::generate(&odd(1e6, 0.5), Seed(1)), Err(SimError::Option { .. })));
        assert!(matches!(Building::generate(&odd(20.0, 1.5), Seed(1)), Err(SimError::Option { .. })));
    }
}
