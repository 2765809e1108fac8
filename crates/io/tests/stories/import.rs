//! Real plans of all formats become buildings, and leave in other formats as they came.

use std::path::{Path, PathBuf};

use planwalk_io::plan::{self, PlanOptions, export, native};
use planwalk_types::{Cell, Element, ElementKind, FloorPlan, Form, Plan, Pt2};

use super::folder;
use crate::support::data;

fn scaled(metres_per_pixel: f64) -> PlanOptions {
    PlanOptions { metres_per_pixel: Some(metres_per_pixel), ..PlanOptions::default() }
}

/// Files below a folder, in the order of their names.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    entries.into_iter().flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

#[test]
fn every_plan_at_hand_is_read_or_refused_with_a_remedy() {
    let Some(folder) = data("floorplans") else { return };
    let (mut read, mut refused) = (0, Vec::new());
    for path in files(&folder) {
        let name = path.strip_prefix(&folder).unwrap().display().to_string();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let has_own_scale = matches!(ending, "yaml" | "txt" | "csv");
        let options = if has_own_scale { PlanOptions::default() } else { scaled(0.05) };
        match plan::import(&path, &options) {
            Ok(document) => {
                let elements = document.building.levels.iter().map(|level| level.elements.len()).sum::<usize>();
                assert!(elements > 0, "{name} is read, and nothing is on it");
                read += 1;
            }
            Err(why) => refused.push((name, why.to_string())),
        }
    }
    // Licences, readmes, lists of nodes and of a walk are no plans.
    let is_plan = |name: &str| [".svg", ".dxf", ".png", ".jpg", ".jpeg", ".pdf", ".pgm", ".yaml"].iter().any(|e| name.ends_with(e));
    // A view in perspective is none either.
    let lost: Vec<_> = refused.iter().filter(|(name, _)| is_plan(name) && !name.ends_with("UD_Spencer.png")).collect();
    assert!(lost.is_empty() && read >= 34, "{read} read, {lost:?}");
    for (name, why) in &refused {
        assert!(why.len() > 30, "{name}: {why}");
    }
}

#[test]
fn real_towns_of_roads_are_read_and_their_blocks_are_no_ground() {
    // 2.0 × 2.1 km and 3.2 × 3.6 km: more than any floor.
    for name in ["kitti_odometry/osm/kitti_00.osm", "kitti_odometry/osm/kitti_09.osm"] {
        let Some(path) = data(name) else { return };
        let plan = plan::read(&path, &PlanOptions::default()).unwrap().plan;
        let [width, height] = [plan.width(), plan.height()];
        assert!(plan.cell_m() <= 1.6 && width * height <= 20_000_000, "{name}: {width} × {height} cells of {} m", plan.cell_m());
        let roads_m2 = plan.cells().iter().filter(|cell| **cell == Cell::Free).count() as f64 * plan.cell_m() * plan.cell_m();
        // 30 and 44 km of roads, 3 to 14 m wide.
        assert!((100_000.0..500_000.0).contains(&roads_m2), "{name}: {roads_m2} m² of road");
    }
}

/// Points every 5 cm along a chain.
fn along(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let count = ((to[0] - from[0]).hypot(to[1] - from[1]) / 0.05).ceil().max(1.0) as usize;
    (0..=count).map(move |i| [0, 1].map(|k| from[k] + (to[k] - from[k]) * i as f64 / count as f64))
}

fn sides(element: &Element) -> Vec<[[f64; 2]; 2]> {
    let closed = matches!(element.form, Form::Area(_));
    let of = |chain: &[Pt2<Plan>]| -> Vec<[[f64; 2]; 2]> {
        let ends = chain.iter().zip(chain.iter().cycle().skip(1)).take(if closed { chain.len() } else { chain.len().saturating_sub(1) });
        ends.map(|(a, b)| [[a.x, a.y], [b.x, b.y]]).collect()
    };
    element.form.chains().flat_map(of).collect()
}

fn distance(at: [f64; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length_2 = (way[0] * way[0] + way[1] * way[1]).max(f64::MIN_POSITIVE);
    let t = (((at[0] - from[0]) * way[0] + (at[1] - from[1]) * way[1]) / length_2).clamp(0.0, 1.0);
    (at[0] - from[0] - t * way[0]).hypot(at[1] - from[1] - t * way[1])
}

/// Share of the points along some sides that are this near to others.
fn share_near(some: &[[[f64; 2]; 2]], others: &[[[f64; 2]; 2]], within_m: f64) -> f64 {
    let points: Vec<[f64; 2]> = some.iter().flat_map(|[from, to]| along(*from, *to)).collect();
    let near = points.iter().filter(|at| others.iter().any(|side| distance(**at, *side) <= within_m)).count();
    near as f64 / points.len().max(1) as f64
}

#[test]
fn walls_of_a_real_cad_drawing_are_those_of_its_list_of_rooms() {
    let (Some(drawing), Some(rooms)) = (data("floorplans/auburn_haley_dxf/floorplan.dxf"), data("floorplans/auburn_haley_dxf/room.txt"))
    else {
        return;
    };
    // It says millimetres and means decimetres.
    assert!(plan::import(&drawing, &PlanOptions::default()).unwrap_err().to_string().contains("--metres-per-pixel"));
    let building = plan::import(&drawing, &scaled(0.1)).unwrap().building;
    let walls: Vec<_> = building.levels[0].elements.iter().filter(|e| e.kind == ElementKind::Wall).flat_map(sides).collect();
    let text = std::fs::read_to_string(rooms).unwrap();
    let rows = text.lines().map(|line| line.split_whitespace().filter_map(|cell| cell.parse().ok()).collect::<Vec<f64>>());
    let outlines: Vec<_> = rows
        .filter(|row| row.len() >= 5)
        .flat_map(|row| {
            let corners = [[row[1], row[2]], [row[3], row[2]], [row[3], row[4]], [row[1], row[4]]];
            (0..4).map(move |i| [corners[i], corners[(i + 1) % 4]])
        })
        .collect();
    // The outlines of rooms go on across their doors, of 2 m each: 26 doors are 5 % of 1000 m.
    let (recall, precision) = (share_near(&outlines, &walls, 0.15), share_near(&walls, &outlines, 0.15));
    assert!(recall > 0.94 && precision > 0.95, "recall {recall:.3}, precision {precision:.3}");
}

#[test]
fn a_real_floor_leaves_in_every_format_and_comes_back() {
    let Some(path) = data("hilti_trimble_2026/floorplans/masks_with_windows/floor_2.png") else { return };
    let document = plan::import(&path, &scaled(0.01)).unwrap();
    let level = &document.building.levels[0];
    let before: Vec<_> = level.elements.iter().flat_map(sides).collect();
    let dir = folder();
    let ways: [(&str, String); 4] = [
        ("a.plan.json", native::write(&document)),
        ("a.geojson", export::geojson(level)),
        ("a.csv", export::csv(level)),
        ("a.svg", export::svg(level)),
    ];
    for (name, text) in ways {
        let written = dir.path().join(name);
        std::fs::write(&written, text).unwrap();
        let again = plan::import(&written, &PlanOptions::default()).unwrap();
        let after: Vec<_> = again.building.levels[0].elements.iter().flat_map(sides).collect();
        let (there, back) = (share_near(&before, &after, 0.05), share_near(&after, &before, 0.05));
        assert!(there > 0.999 && back > 0.999, "{name}: {there:.4} of the walls come back, {back:.4} of what comes back was there");
    }
    // As cells: the same walls, within a cell of 5 cm, whichever way they came.
    let direct = plan::read(&path, &scaled(0.01)).unwrap().plan;
    let kept = plan::read(&dir.path().join("a.plan.json"), &PlanOptions::default()).unwrap().plan;
    let (there, back) = (wall_share(&direct, &kept), wall_share(&kept, &direct));
    assert!(there > 0.999 && back > 0.999, "{there:.4}, {back:.4}");
}

/// Share of one plan's walls that have a wall of the other within a cell.
fn wall_share(one: &FloorPlan, other: &FloorPlan) -> f64 {
    let walls: Vec<usize> = (0..one.cells().len()).filter(|i| one.cells()[*i] == Cell::Wall).collect();
    let is_near = |i: &&usize| {
        let at = one.centre(**i % one.width(), **i / one.width());
        let near = |dx: i32, dy: i32| other.at(Pt2::new(at.x + 0.05 * f64::from(dx), at.y + 0.05 * f64::from(dy))) == Cell::Wall;
        (-1..=1).any(|dx| (-1..=1).any(|dy| near(dx, dy)))
    };
    walls.iter().filter(is_near).count() as f64 / walls.len().max(1) as f64
}

#[test]
fn real_drawings_without_a_scale_have_it_from_the_areas_written_in_their_rooms() {
    let Some(folder) = data("floorplans/aalto_otaniemi_svg") else { return };
    // Room 150 of the first floor is drawn 285.19 by 241.76 units, and "A: 65.948 m2" is written in it.
    let one_room = (65.948_f64 / (285.193 * 241.758)).sqrt();
    let document = plan::import(&folder.join("CS_floor1.svg"), &PlanOptions::default()).unwrap();
    let metres = document.source.metres_per_unit.unwrap();
    // Of one room alone: its outline is drawn to the faces of its walls, a finger's breadth or two.
    assert!((metres / one_room - 1.0).abs() < 0.01, "{metres} m a unit, by one room {one_room}");
    assert_eq!(document.source.scale_from.as_deref(), Some("areas written in rooms"));
    let names: Vec<&str> = document.building.levels[0].elements.iter().filter_map(|element| element.name.as_deref()).collect();
    assert!(names.contains(&"150"), "{names:?}");
    // What a person says is warned of where the rooms say otherwise.
    let given = plan::import(&folder.join("CS_floor1.svg"), &scaled(0.05)).unwrap();
    assert!(given.notes.iter().any(|note| note.starts_with("warning: ") && note.contains("areas written")), "{:?}", given.notes);
}

#[test]
fn windows_that_are_drawn_without_arcs_close_a_real_facade() {
    let Some(folder) = data("floorplans/aalto_otaniemi_svg") else { return };
    let document = plan::import(&folder.join("CS_floor1.svg"), &PlanOptions::default()).unwrap();
    let windows: Vec<_> = document.building.levels[0].elements.iter().filter(|e| e.kind == ElementKind::Window).collect();
    // So many groups of glass there are in its file.
    assert_eq!(windows.len(), 93);
}

#[test]
fn the_doors_of_a_real_floor_tell_its_size_where_nothing_else_does() {
    let Some(folder) = data("floorplans/aalto_otaniemi_svg") else { return };
    // One floor twice: with areas written in its rooms, and with nothing but doors.
    let [by_areas, by_doors] =
        ["CS_floor3.svg", "K1_floor3.svg"].map(|name| plan::import(&folder.join(name), &PlanOptions::default()).unwrap());
    assert_eq!(by_doors.source.scale_from.as_deref(), Some("widths of doors"));
    let width_m = |building: &planwalk_types::Building| {
        let xs = || building.levels[0].elements.iter().flat_map(|element| element.form.points()).map(|at| at.x);
        xs().fold(f64::NEG_INFINITY, f64::max) - xs().fold(f64::INFINITY, f64::min)
    };
    let off = width_m(&by_doors.building) / width_m(&by_areas.building) - 1.0;
    // Two standard deviations of what five widths of leaves say.
    assert!(off.abs() < 0.13, "{:.1} % off", 100.0 * off);
    let doors = by_doors.building.levels[0].elements.iter().filter(|element| element.kind == ElementKind::Door).count();
    assert!((65..95).contains(&doors), "{doors} doors");
}
