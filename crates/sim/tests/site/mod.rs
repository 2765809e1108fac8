//! Stories of buildings: each kind is one that a person could walk through, and any plan becomes a world.

use std::path::PathBuf;

use planwalk_sim::{
    Building, BuildingKind, BuildingOptions, CameraOptions, Lies, Look, PlanWorldOptions, Scene, SceneOptions, WalkOptions,
};
use planwalk_types::{Cell, FloorPlan, Plan, Pt2, Seed, Wall};

fn building(kind: BuildingKind, seed: u64) -> Building {
    Building::generate(&BuildingOptions { kind, ..Default::default() }, Seed(seed)).unwrap()
}

/// A scene whose pictures nobody looks at.
fn tiny(seed: u64) -> SceneOptions {
    SceneOptions { seed: Seed(seed), camera: CameraOptions { width: 64, height: 48, ..Default::default() }, ..Default::default() }
}

fn lasting(duration_s: f64) -> WalkOptions {
    WalkOptions { duration_s, ..Default::default() }
}

/// What can be reached over free cells from the grid's corner, which lies outdoors.
fn outdoors(plan: &FloorPlan) -> Vec<bool> {
    let (width, height) = (plan.width(), plan.height());
    let mut reached = vec![false; width * height];
    let mut open = vec![0];
    reached[0] = true;
    while let Some(i) = open.pop() {
        let (x, y) = (i % width, i / width);
        let beside =
            [(x > 0).then(|| i - 1), (x + 1 < width).then(|| i + 1), (y > 0).then(|| i - width), (y + 1 < height).then(|| i + width)];
        for next in beside.into_iter().flatten() {
            if !reached[next] && plan.cells()[next] != Cell::Wall {
                reached[next] = true;
                open.push(next);
            }
        }
    }
    reached
}

/// Whether a cell of this kind lies within one cell of a place.
fn near(plan: &FloorPlan, p: Pt2<Plan>, is: impl Fn(Cell) -> bool) -> bool {
    let cell_m = plan.cell_m();
    (-1..=1).any(|dy| (-1..=1).any(|dx| is(plan.at(Pt2::new(p.x + f64::from(dx) * cell_m, p.y + f64::from(dy) * cell_m)))))
}

/// Places every 5 cm along a wall.
fn along(wall: &Wall) -> impl Iterator<Item = Pt2<Plan>> + '_ {
    let count = (wall.from.distance(wall.to) / 0.05).ceil().max(1.0) as usize;
    (0..=count).map(move |i| {
        let t = i as f64 / count as f64;
        Pt2::new(wall.from.x + t * (wall.to.x - wall.from.x), wall.from.y + t * (wall.to.y - wall.from.y))
    })
}

fn check_kind(kind: BuildingKind, sizes: &[(f64, f64)]) {
    for seed in 0..20 {
        let size = sizes[seed as usize % sizes.len()];
        let options = BuildingOptions { kind, width_m: Some(size.0), depth_m: Some(size.1), ..Default::default() };
        let building = Building::generate(&options, Seed(seed)).unwrap();
        assert_eq!(building, Building::generate(&options, Seed(seed)).unwrap(), "the same seed is the same building");
        let plan = building.plan(0.05, 1.0).unwrap();
        let out = outdoors(&plan);
        for (i, room) in building.rooms.iter().enumerate() {
            let centre = room.centre();
            assert!(room.holds(centre) && building.room_at(centre) == Some(i), "{kind} {seed}: room {i} does not hold its middle");
            let (column, row) = plan.cell_at(centre).unwrap();
            assert!(!out[row * plan.width() + column], "{kind} {seed}: one gets from outdoors into room {i} of {size:?}");
        }
        // On a grid of odd spacing, so that no place falls on a wall's centre line but by chance.
        let (low, high) = building.bounds();
        let mut held = 0;
        for row in 0..((high.y - low.y) / 0.217) as usize {
            for column in 0..((high.x - low.x) / 0.217) as usize {
                let p = Pt2::new(low.x + 0.217 * column as f64, low.y + 0.217 * row as f64);
                let rooms = building.rooms.iter().filter(|r| r.holds(p)).count();
                assert!(rooms <= 1, "{kind} {seed}: {rooms} rooms at {p:?}");
                held += rooms;
                let (column, row) = plan.cell_at(p).unwrap();
                let is_out = out[row * plan.width() + column];
                // Within the walls' thickness either may be.
                assert!(!(is_out && rooms == 1) || near(&plan, p, |c| c == Cell::Wall), "{kind} {seed}: a room outdoors at {p:?}");
            }
        }
        let area: f64 = building.rooms.iter().map(|r| r.area_m2()).sum();
        // One sample stands for 0.217² m²; the rim of the floor is missed: up to one row and one column.
        assert!((held as f64 * 0.217 * 0.217 / area - 1.0).abs() < 0.06, "{kind} {seed}: {held} samples of {area} m²");
        let built = building.as_built(0.05, 1.0).unwrap();
        for door in &building.doors {
            assert_eq!(plan.at(door.centre()), Cell::Free, "{kind} {seed}: the plan shows every door as an opening");
            assert_eq!(near(&built, door.centre(), |c| c == Cell::Wall), !door.open, "{kind} {seed}: {door:?}");
        }
        assert!(building.doors.iter().any(|d| d.open), "{kind} {seed}");
        for wall in building.solid_lines() {
            for p in along(&wall) {
                assert!(near(&built, p, |c| c == Cell::Wall), "{kind} {seed}: a ray would meet nothing at {p:?}");
            }
        }
    }
}

#[test]
fn offices_are_sound() {
    check_kind(BuildingKind::Office, &[(20.0, 14.0), (38.0, 15.0), (30.0, 26.0), (60.0, 42.0)]);
}

#[test]
fn open_plans_are_sound() {
    check_kind(BuildingKind::OpenPlan, &[(24.0, 18.0), (42.0, 26.0), (60.0, 40.0)]);
}

#[test]
fn flats_are_sound() {
    check_kind(BuildingKind::Flat, &[(8.6, 7.0), (11.5, 9.0), (12.5, 12.0), (16.0, 8.0)]);
}

#[test]
fn loops_are_sound() {
    check_kind(BuildingKind::Loop, &[(30.0, 19.0), (60.0, 25.0)]);
}

#[test]
fn rotundas_are_sound() {
    check_kind(BuildingKind::Round, &[(24.0, 32.0), (30.0, 46.0), (44.0, 70.0)]);
}

#[test]
fn every_building_has_walks() {
    for kind in BuildingKind::ALL {
        for seed in 0..20 {
            let scene = Scene::new(building(kind, seed), &SceneOptions { walk: lasting(20.0), ..tiny(seed) });
            let scene = scene.unwrap_or_else(|error| panic!("{kind} {seed}: {error}"));
            assert!(scene.walk().length_m() > 7.0, "{kind} {seed}: {} m", scene.walk().length_m());
            for (_, pose) in scene.truth_on_floor() {
                assert!(scene.building().room_at(pose.origin()).is_some(), "{kind} {seed}: outdoors at {pose:?}");
            }
        }
    }
}

#[test]
fn a_loop_looks_nearly_the_same_from_its_other_end() {
    for seed in 0..5 {
        let building = building(BuildingKind::Loop, seed);
        let (low, high) = building.bounds();
        let plan = building.plan(0.05, 1.0).unwrap();
        let corridor = (0..plan.cells().len()).map(|i| plan.centre(i % plan.width(), i / plan.width()));
        let (mut same, mut all) = (0, 0);
        for p in corridor.filter(|p| plan.at(*p) == Cell::Wall) {
            let turned = Pt2::<Plan>::new(low.x + high.x - p.x, low.y + high.y - p.y);
            // Half of a wall's thickness and the walls' small shifts.
            let hit = (-6..=6).any(|dy| {
                (-6..=6).any(|dx| plan.at(Pt2::new(turned.x + 0.05 * f64::from(dx), turned.y + 0.05 * f64::from(dy))) == Cell::Wall)
            });
            (same, all) = (same + usize::from(hit), all + 1);
        }
        let share = same as f64 / all as f64;
        assert!(share > 0.9 && share < 1.0, "seed {seed}: {share} of the walls are where the turned plan has walls");
    }
}

#[test]
fn plans_lie_as_far_as_one_asks_for() {
    let differing = |a: &FloorPlan, b: &FloorPlan, cell: Cell| {
        assert_eq!((a.width(), a.height(), a.origin()), (b.width(), b.height(), b.origin()));
        a.cells().iter().zip(b.cells()).filter(|(p, q)| **p == cell && **q != cell).count()
    };
    for kind in BuildingKind::ALL {
        let (mut missing, mut extra) = (0, 0);
        for seed in 0..6 {
            let make = |lies: Lies| {
                Building::generate(&BuildingOptions { kind, open_doors: 1.0, lies, ..Default::default() }, Seed(seed)).unwrap()
            };
            let plans = |b: &Building| (b.plan(0.05, 1.0).unwrap(), b.as_built(0.05, 1.0).unwrap());
            let (honest, as_built) = plans(&make(Lies::default()));
            assert!(honest == as_built, "{kind} {seed}: an honest plan with open doors is what is built");
            let (drawn, built) = plans(&make(Lies { missing_share: 0.5, extra_count: 0 }));
            assert!(drawn == honest, "{kind} {seed}: the plan shows all walls");
            missing += differing(&drawn, &built, Cell::Wall);
            assert_eq!(differing(&built, &drawn, Cell::Wall), 0);
            let (drawn, built) = plans(&make(Lies { missing_share: 0.0, extra_count: 4 }));
            assert!(drawn == honest);
            extra += differing(&built, &drawn, Cell::Wall);
            // A stub's end may round a cell of the wall that it starts from.
            assert!(differing(&drawn, &built, Cell::Wall) < 4);
        }
        // A metre of wall is 40 cells and more at 5 cm.
        assert!(extra > 6 * 40, "{kind}: {extra} cells");
        assert!(missing > 6 * 40, "{kind}: {missing} cells");
    }
}

#[test]
fn furniture_stands_in_every_kind_of_building_and_on_no_plan() {
    let walls = |plan: &FloorPlan| plan.cells().iter().filter(|c| **c == Cell::Wall).count();
    for kind in BuildingKind::ALL {
        let scene = |furniture: f64| {
            let look = Look { furniture, ..Default::default() };
            Scene::new(building(kind, 3), &SceneOptions { look, walk: lasting(10.0), ..tiny(3) }).unwrap()
        };
        let (empty, full) = (scene(0.0), scene(1.0));
        assert!(empty.plan() == full.plan());
        let (bare, furnished) = (empty.as_built_plan(0.05, 1.0).unwrap(), full.as_built_plan(0.05, 1.0).unwrap());
        // At least two square metres of it.
        assert!(walls(&furnished) > walls(&bare) + 800, "{kind}: {} and {} cells", walls(&furnished), walls(&bare));
    }
}

/// A file of the shared data, if it is there.
pub fn data(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("PLANWALK_DATA")
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")), PathBuf::from);
    let file = root.join(path);
    if file.exists() {
        return Some(file);
    }
    assert!(std::env::var_os("PLANWALK_REQUIRE_DATA").is_none_or(|v| v != "1"), "{} is required", file.display());
    #[expect(clippy::print_stderr, reason = "a skipped test says so")]
    {
        eprintln!("skipped: there is no {}", file.display());
    }
    None
}

/// A plan drawn in black on white; grey is unknown.
pub fn read_plan(file: &std::path::Path, cell_m: f64) -> FloorPlan {
    let image = image::open(file).unwrap().to_luma8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let cell = |i: usize| match image.get_pixel((i % width) as u32, (height - 1 - i / width) as u32).0[0] {
        0..100 => Cell::Wall,
        100..240 => Cell::Unknown,
        _ => Cell::Free,
    };
    FloorPlan::new(Pt2::new(-3.0, 2.0), cell_m, width, height, (0..width * height).map(cell).collect()).unwrap()
}

/// The surfaces of the world lie where the plan's walls end, and the plan comes back.
fn check_world(plan: &FloorPlan, building: &Building) {
    // Of 5 cm cells: half a cell for a step, three quarters for straightening, and a wall's share of 20 % may lie at its far side.
    let reach = (2.1 * plan.cell_m().max(0.05) / plan.cell_m()).ceil() as i32;
    for wall in &building.walls {
        for p in along(wall) {
            // Every half cell, so that none is passed over, and a little off the borders, on which surfaces lie.
            let off = |d: i32| (0.5 * f64::from(d) + 0.01) * plan.cell_m();
            let any = |is: fn(Cell) -> bool| {
                let steps = || -2 * reach..=2 * reach;
                steps().any(|dy| steps().any(|dx| is(plan.at(Pt2::new(p.x + off(dx), p.y + off(dy))))))
            };
            assert!(any(|c| c == Cell::Wall), "the surface at {p:?} is far from the plan's walls");
            assert!(any(|c| c != Cell::Wall), "the surface at {p:?} is inside of the plan's walls");
        }
    }
    let cell_m = plan.cell_m().max(0.05);
    let built = building.as_built(cell_m, 1.0).unwrap();
    for (i, cell) in plan.cells().iter().enumerate().filter(|(i, _)| i % 7 == 0) {
        let p = plan.centre(i % plan.width(), i / plan.width());
        if *cell == Cell::Wall && plan.cell_m() >= 0.05 {
            assert!(near(&built, p, |c| c == Cell::Wall), "the wall at {p:?} was not built");
        }
    }
    for (i, cell) in built.cells().iter().enumerate().filter(|(_, cell)| **cell == Cell::Wall) {
        let p = built.centre(i % built.width(), i / built.width());
        let reach = (cell_m / plan.cell_m()).round() as i32;
        let found = (-reach..=reach).any(|dy| {
            (-reach..=reach)
                .any(|dx| plan.at(Pt2::new(p.x + f64::from(dx) * plan.cell_m(), p.y + f64::from(dy) * plan.cell_m())) == Cell::Wall)
        });
        assert!(found, "the wall at {p:?} is on no plan: {cell:?}");
    }
}

#[test]
fn a_plan_becomes_a_world_with_its_walls_where_they_are_drawn() {
    for kind in BuildingKind::ALL {
        let plan = building(kind, 5).plan(0.05, 1.0).unwrap();
        let world = Building::from_plan(&plan, &PlanWorldOptions::default(), Seed(1)).unwrap();
        check_world(&plan, &world);
        assert!(world.rooms.len() > 1 && world.doors.is_empty(), "{kind}: {} rooms", world.rooms.len());
        // A straight wall is one surface, not one for each cell.
        assert!(world.walls.len() < 1500, "{kind}: {} surfaces", world.walls.len());
        let scene = Scene::new(world, &tiny(1)).unwrap();
        assert!(scene.truth_on_floor().iter().all(|(_, pose)| plan.at(pose.origin()) == Cell::Free), "{kind}");
    }
}

#[test]
fn lies_about_a_given_plan_change_the_world_and_not_the_plan() {
    let plan = building(BuildingKind::Office, 5).plan(0.05, 1.0).unwrap();
    let world = |lies: Lies| Building::from_plan(&plan, &PlanWorldOptions { lies, ..Default::default() }, Seed(1)).unwrap();
    let (honest, liar) = (world(Lies::default()), world(Lies { missing_share: 0.3, extra_count: 3 }));
    let drawn = honest.plan(0.05, 1.0).unwrap();
    assert!(drawn == liar.plan(0.05, 1.0).unwrap() && drawn == honest.as_built(0.05, 1.0).unwrap());
    let built = liar.as_built(0.05, 1.0).unwrap();
    let count = |from: &FloorPlan, to: &FloorPlan| {
        from.cells().iter().zip(to.cells()).filter(|(p, q)| **p == Cell::Wall && **q == Cell::Free).count()
    };
    // A piece is 2.4 m of wall of 3 cells; a screen at least 1 m.
    assert!(count(&drawn, &built) > 100 && count(&built, &drawn) > 60, "{} and {}", count(&drawn, &built), count(&built, &drawn));
    assert!(Scene::new(liar, &tiny(1)).is_ok());
}

#[test]
fn real_plans_become_worlds() {
    let plans = [
        ("hilti_trimble_2026/floorplans/masks_with_windows/floor_2.png", 0.01, 1000.0),
        ("robots_radish_carmen/derived_maps/intel.pgm", 0.1, 300.0),
    ];
    for (path, cell_m, least_m2) in plans {
        let Some(file) = data(path) else { continue };
        let plan = read_plan(&file, cell_m);
        let world = Building::from_plan(&plan, &PlanWorldOptions::default(), Seed(2)).unwrap();
        check_world(&plan, &world);
        let area: f64 = world.rooms.iter().map(|room| room.area_m2()).sum();
        assert!(area > least_m2, "{path}: {area} m² of rooms");
        let scene = Scene::new(world, &SceneOptions { walk: lasting(40.0), ..tiny(2) }).unwrap();
        for (_, pose) in scene.truth_on_floor() {
            assert_eq!(plan.at(pose.origin()), Cell::Free, "{path}: {pose:?}");
        }
        let picture = scene.frame(100).image;
        assert!(picture.data().iter().max() > picture.data().iter().min(), "{path}");
    }
}

#[test]
fn a_plan_without_an_inside_is_refused() {
    let wall = Wall { from: Pt2::new(0.0, 0.0), to: Pt2::new(0.2, 0.0) };
    let plan = FloorPlan::from_walls(&[wall], 0.05, 4.0).unwrap();
    let error = Building::from_plan(&plan, &PlanWorldOptions::default(), Seed(1)).unwrap_err().to_string();
    assert!(error.contains("inside"), "{error}");
    let low = PlanWorldOptions { height_m: 1.0, ..Default::default() };
    assert!(Building::from_plan(&plan, &low, Seed(1)).is_err());
}
