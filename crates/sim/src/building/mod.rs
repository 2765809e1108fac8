//! What is built? Walls with door openings, the rooms between them, and the plan that is drawn of them.
//!
//! Walls are stored by their centre lines, already cut at every opening. A plan draws all doors as openings: it does not know
//! which of them are shut today.

mod generate;

use planwalk_types::{Cell, FloorPlan, Plan, PlanError, Pt2, Seed, Wall};

use crate::error::{SimError, in_range};
use crate::world::wall_solids;

/// What a room is for; decides floor, light and what hangs on its walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoomKind {
    /// Desks and a carpet.
    Office,
    /// Where doors lead to: tiles, notice boards, signs.
    Corridor,
    /// A large room where people arrive: tiles.
    Hall,
    /// Shelves and bare walls.
    Store,
}

/// An axis-parallel rectangle of floor between centre lines of walls.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// What it is for.
    pub kind: RoomKind,
    /// Lower left corner, metres.
    pub low: Pt2<Plan>,
    /// Upper right corner, metres.
    pub high: Pt2<Plan>,
}

impl Room {
    /// The middle of the room.
    pub fn centre(&self) -> Pt2<Plan> {
        Pt2::new(0.5 * (self.low.x + self.high.x), 0.5 * (self.low.y + self.high.y))
    }

    /// Whether a point lies in it.
    pub fn holds(&self, point: Pt2<Plan>) -> bool {
        point.x >= self.low.x && point.x <= self.high.x && point.y >= self.low.y && point.y <= self.high.y
    }

    /// Floor area, m².
    pub fn area_m2(&self) -> f64 {
        (self.high.x - self.low.x) * (self.high.y - self.low.y)
    }
}

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

/// Options of [`Building::office`].
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct BuildingOptions {
    /// Width of the building, metres; drawn ± 5 % around it.
    pub width_m: f64,
    /// Depth of the building, metres; drawn ± 5 % around it.
    pub depth_m: f64,
    /// Probability that a door which need not be open is open, 0..=1.
    pub open_doors: f64,
}

impl Default for BuildingOptions {
    /// A small office of about 20 m × 14 m with two thirds of its doors open.
    fn default() -> Self {
        Self { width_m: 20.0, depth_m: 14.0, open_doors: 0.65 }
    }
}

impl BuildingOptions {
    fn check(&self) -> Result<(), SimError> {
        in_range("the building's width in metres", self.width_m, 17.0, 40.0)?;
        in_range("the building's depth in metres", self.depth_m, 12.0, 30.0)?;
        in_range("the probability of an open door", self.open_doors, 0.0, 1.0)
    }
}

/// Walls, doors and rooms of one floor.
#[derive(Debug, Clone, PartialEq)]
pub struct Building {
    /// Centre lines of the walls, cut at every opening, metres.
    pub walls: Vec<Wall>,
    /// The openings.
    pub doors: Vec<Door>,
    /// The rooms; a corridor with a bend is two of them.
    pub rooms: Vec<Room>,
    /// Thickness of the walls, metres.
    pub thickness_m: f64,
    /// From floor to ceiling, metres.
    pub height_m: f64,
    /// Clear height of the doors, metres.
    pub door_height_m: f64,
}

impl Building {
    /// A small office: a corridor with a bend and a dead end, eight or nine rooms of different sizes, some of their doors shut,
    /// mirrored by chance. The same seed gives the same building.
    ///
    /// # Errors
    /// [`SimError::Option`] for a size that no such office has.
    pub fn office(options: &BuildingOptions, seed: Seed) -> Result<Self, SimError> {
        options.check()?;
        Ok(generate::office(options, seed))
    }

    /// The plan as it is drawn: walls as thick as they are, every door an opening, nothing of the furniture.
    ///
    /// # Errors
    /// As [`FloorPlan::new`].
    pub fn plan(&self, cell_m: f64, margin_m: f64) -> Result<FloorPlan, PlanError> {
        if self.walls.is_empty() {
            return Err(PlanError::NoWalls);
        }
        // Drawn from centre lines first: that gives the grid and checks the numbers. Then the walls get their thickness.
        let grid = FloorPlan::from_walls(&self.walls, cell_m, margin_m)?;
        let (width, height, origin) = (grid.width(), grid.height(), grid.origin());
        let mut cells = vec![Cell::Free; width * height];
        // Where cells are coarser than walls are thick, walls are as thick as cells: else they would have holes.
        let reach = (0.5 * (cell_m - self.thickness_m)).max(0.0) + 1e-9;
        let index = |v: f64, count: usize| ((v / cell_m).floor().max(0.0) as usize).min(count - 1);
        for solid in wall_solids(self) {
            let Wall { from, to } = solid.line;
            let around = solid.half_m + reach + cell_m;
            let (left, right) = (from.x.min(to.x) - around - origin.x, from.x.max(to.x) + around - origin.x);
            let (low, high) = (from.y.min(to.y) - around - origin.y, from.y.max(to.y) + around - origin.y);
            for row in index(low, height)..=index(high, height) {
                for column in index(left, width)..=index(right, width) {
                    if solid.distance(grid.centre(column, row)) <= reach {
                        cells[row * width + column] = Cell::Wall;
                    }
                }
            }
        }
        FloorPlan::new(origin, cell_m, width, height, cells)
    }

    /// The room that holds this point.
    pub fn room_at(&self, point: Pt2<Plan>) -> Option<usize> {
        self.rooms.iter().position(|room| room.holds(point))
    }

    /// Lower left and upper right corner of everything built; both at the origin where nothing is.
    pub fn bounds(&self) -> (Pt2<Plan>, Pt2<Plan>) {
        let ends = || self.walls.iter().flat_map(|w| [w.from, w.to]);
        if self.walls.is_empty() {
            return (Pt2::new(0.0, 0.0), Pt2::new(0.0, 0.0));
        }
        let low = ends().fold((f64::INFINITY, f64::INFINITY), |l, p| (l.0.min(p.x), l.1.min(p.y)));
        let high = ends().fold((f64::NEG_INFINITY, f64::NEG_INFINITY), |h, p| (h.0.max(p.x), h.1.max(p.y)));
        (Pt2::new(low.0, low.1), Pt2::new(high.0, high.1))
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
    use super::*;

    fn office(seed: u64) -> Building {
        Building::office(&BuildingOptions::default(), Seed(seed)).unwrap()
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
            Building::office(&options, Seed(5)).unwrap().doors.iter().filter(|d| d.open).count()
        };
        assert!(open(0.0) < open(1.0));
        // The hall's door to the corridor alone.
        assert_eq!(open(0.0), 1);
    }

    #[test]
    fn sizes_that_are_no_office_are_refused() {
        let odd = |width_m: f64, open_doors: f64| BuildingOptions { width_m, open_doors, ..Default::default() };
        assert!(matches!(Building::office(&odd(f64::NAN, 0.5), Seed(1)), Err(SimError::Option { .. })));
        assert!(matches!(Building::office(&odd(1e6, 0.5), Seed(1)), Err(SimError::Option { .. })));
        assert!(matches!(Building::office(&odd(20.0, 1.5), Seed(1)), Err(SimError::Option { .. })));
    }
}
