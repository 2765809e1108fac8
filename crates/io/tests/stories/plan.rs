//! Pictures and robots' maps become plans in metres.

use std::path::Path;

use image::{GrayImage, Luma};
use planwalk_io::plan::{self, PlanFileError, PlanOptions};
use planwalk_types::{Cell, PlanError, Pt2};

use super::folder;
use crate::support::data;

/// A room of 4 m × 3 m drawn at 5 cm, 100 × 80 px, with its bottom-left corner at (10, 5) px from the bottom left.
fn room() -> GrayImage {
    let on = |a: u32, b: u32, k: u32| k == a || k == b;
    let line = |u: u32, y: u32| (on(10, 90, u) && (5..=65).contains(&y)) || (on(5, 65, y) && (10..=90).contains(&u));
    GrayImage::from_fn(100, 80, |u, v| Luma([if line(u, 79 - v) { 0 } else { 254 }]))
}

fn read_plan(path: &Path, metres_per_pixel: Option<f64>) -> Result<plan::PlanFile, PlanFileError> {
    plan::read(path, &PlanOptions { metres_per_pixel, ..PlanOptions::default() })
}

#[test]
fn a_drawing_is_a_plan_with_its_origin_at_the_bottom_left() {
    let dir = folder();
    let path = dir.path().join("room.png");
    room().save(&path).unwrap();
    let plan = read_plan(&path, Some(0.05)).unwrap().plan;
    assert_eq!((plan.width(), plan.height(), plan.cell_m()), (100, 80, 0.05));
    assert_eq!(plan.at(Pt2::new(0.525, 1.0)), Cell::Wall);
    assert_eq!(plan.at(Pt2::new(2.0, 0.275)), Cell::Wall);
    assert_eq!(plan.at(Pt2::new(2.0, 2.0)), Cell::Free);
    // The same by a measure: 80 px are 4 m.
    let measured = |measures: &[&str]| {
        let measures = measures.iter().map(|measure| measure.parse().unwrap()).collect();
        plan::read(&path, &PlanOptions { measures, ..PlanOptions::default() }).unwrap()
    };
    assert_eq!(measured(&["10,14,90,14=4m"]).plan, plan);
    // Measured twice, across and down, which agree within 3 %; and a picture that is stretched by a tenth.
    let (good, bad) = (measured(&["10,14,90,14=4m", "10,14,10,74=3.05m"]), measured(&["10,14,90,14=4m", "10,14,10,74=3.3m"]));
    assert!(good.notes.iter().all(|note| !note.contains("disagree")) && (good.plan.cell_m() - 7.05 / 140.0).abs() < 1e-12);
    assert!(bad.notes.iter().any(|note| note.contains("disagree by 10 %") && note.contains("stretched")), "{:?}", bad.notes);
}

#[test]
fn a_fine_drawing_becomes_cells_of_five_centimetres_and_keeps_its_walls() {
    let dir = folder();
    let path = dir.path().join("room.png");
    room().save(&path).unwrap();
    let file = read_plan(&path, Some(0.01)).unwrap();
    assert_eq!((file.plan.width(), file.plan.height()), (20, 16));
    assert!((file.plan.cell_m() - 0.05).abs() < 1e-15);
    assert!(file.notes.iter().any(|n| n.contains("5×5 pixels")), "{:?}", file.notes);
    assert_eq!(file.plan.at(Pt2::new(0.105, 0.3)), Cell::Wall);
}

#[test]
fn a_picture_without_a_scale_names_both_ways_out() {
    let dir = folder();
    let path = dir.path().join("room.png");
    room().save(&path).unwrap();
    let message = read_plan(&path, None).unwrap_err().to_string();
    assert!(message.contains("--metres-per-pixel") && message.contains("--measure"), "{message}");
    for scale in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(matches!(read_plan(&path, Some(scale)), Err(PlanFileError::BadScale { .. })), "{scale}");
    }
    let measures = vec!["0,0,1,0=1m".parse().unwrap()];
    assert!(matches!(
        plan::read(&path, &PlanOptions { metres_per_pixel: Some(1.0), measures, ..PlanOptions::default() }),
        Err(PlanFileError::TwoScales)
    ));
}

#[test]
fn plans_without_walls_or_without_floor_are_refused() {
    let dir = folder();
    let path = dir.path().join("plan.png");
    GrayImage::from_pixel(50, 50, Luma([255])).save(&path).unwrap();
    assert!(matches!(read_plan(&path, Some(0.05)), Err(PlanFileError::Plan(PlanError::NoWalls))));
    GrayImage::from_pixel(50, 50, Luma([0])).save(&path).unwrap();
    assert!(matches!(read_plan(&path, Some(0.05)), Err(PlanFileError::Plan(PlanError::NoFreeSpace))));
    std::fs::write(&path, "no picture").unwrap();
    assert!(matches!(read_plan(&path, Some(0.05)), Err(PlanFileError::UnknownText { .. })));
    std::fs::write(&path, [0u8; 100]).unwrap();
    assert!(matches!(read_plan(&path, Some(0.05)), Err(PlanFileError::Raster(_))));
    assert!(matches!(read_plan(Path::new("no such plan.png"), Some(0.05)), Err(PlanFileError::Io(_))));
}

fn ros_map(dir: &Path, more: &str) -> Result<plan::PlanFile, PlanFileError> {
    room().save(dir.join("room.pgm")).unwrap();
    std::fs::write(dir.join("map.yaml"), format!("image: room.pgm\nresolution: 0.05\noccupied_thresh: 0.65\n{more}")).unwrap();
    read_plan(&dir.join("map.yaml"), None)
}

#[test]
fn what_makes_no_sense_for_a_plan_is_said_and_not_passed_over() {
    let dir = folder();
    let (picture, list) = (dir.path().join("room.png"), dir.path().join("room.csv"));
    room().save(&picture).unwrap();
    std::fs::write(&list, "0,0,4,0\n4,0,4,3\n").unwrap();
    let scaled = || PlanOptions { metres_per_pixel: Some(0.05), ..PlanOptions::default() };
    let refused = |path: &Path, options: PlanOptions| plan::read(path, &options).unwrap_err();
    let on_paper = || PlanOptions { drawing_scale: Some(100.0), ..PlanOptions::default() };
    assert!(matches!(refused(&picture, PlanOptions { drawing_scale: Some(100.0), ..scaled() }), PlanFileError::TwoScales));
    assert!(matches!(refused(&picture, on_paper()), PlanFileError::NotOnPaper));
    assert!(matches!(refused(&list, on_paper()), PlanFileError::ScaleNotNeeded));
    assert!(matches!(refused(&list, scaled()), PlanFileError::ScaleNotNeeded));
    assert!(matches!(refused(&picture, PlanOptions { page: Some(2), ..scaled() }), PlanFileError::NoPages { page: 2 }));
    let level = |name: &str| PlanOptions { level: Some(name.to_owned()), ..scaled() };
    assert!(matches!(refused(&picture, level("1")), PlanFileError::NoSuchLevel { .. }) && plan::read(&picture, &level("0")).is_ok());
}

#[test]
fn a_ros_map_lies_where_its_origin_says() {
    let dir = folder();
    let plan = ros_map(dir.path(), "free_thresh: 0.196\nnegate: 0\norigin: [-1.0, -2.0, 0.0]\n").unwrap().plan;
    assert_eq!(plan.at(Pt2::new(-1.0 + 0.525, -2.0 + 1.0)), Cell::Wall);
    assert_eq!(plan.at(Pt2::new(1.0, 0.0)), Cell::Free);
    // Turned by 30° about its lower-left corner: the same walls, seen from the turned axes.
    let turned = ros_map(dir.path(), "free_thresh: 0.196\nnegate: false\norigin: [-1.0, -2.0, 0.5235987755982988]\n").unwrap();
    let (s, c) = (0.5, 0.75f64.sqrt());
    for (x, y, cell) in [(0.525, 1.0, Cell::Wall), (2.0, 0.275, Cell::Wall), (2.0, 2.0, Cell::Free)] {
        assert_eq!(turned.plan.at(Pt2::new(-1.0 + c * x - s * y, -2.0 + s * x + c * y)), cell, "at {x}, {y} before the turn");
    }
    assert!(turned.notes.iter().any(|n| n.contains("30.00°")), "{:?}", turned.notes);
}

#[test]
fn unknown_that_is_read_as_free_is_told() {
    let dir = folder();
    let path = dir.path().join("map.yaml");
    let mut grey = room();
    grey.put_pixel(50, 40, Luma([205]));
    let read = |free_thresh: &str| {
        ros_map(dir.path(), &format!("free_thresh: {free_thresh}\norigin: [0, 0, 0]\n")).unwrap();
        grey.save(dir.path().join("room.pgm")).unwrap();
        read_plan(&path, None).unwrap()
    };
    let at = Pt2::new(50.5 * 0.05, 39.5 * 0.05);
    let told = |file: &plan::PlanFile| file.notes.iter().any(|n| n.contains("205"));
    let (lax, strict) = (read("0.25"), read("0.196"));
    assert_eq!((lax.plan.at(at), told(&lax)), (Cell::Free, true));
    assert_eq!((strict.plan.at(at), told(&strict)), (Cell::Unknown, false));
}

#[test]
fn broken_map_files_are_named_by_their_key() {
    let dir = folder();
    let message = |more: &str| ros_map(dir.path(), more).unwrap_err().to_string();
    assert!(message("free_thresh: 0.2\n").contains("\"origin\""));
    assert!(message("free_thresh: 0.2\norigin: [0, .nan, 0]\n").contains("\"origin\""));
    assert!(message("origin: [0, 0, 0]\n").contains("\"free_thresh\""));
    assert!(message("free_thresh: 0.2\norigin: [0, 0, 0]\nmode: odd\n").contains("\"mode\""));
    std::fs::write(
        dir.path().join("map.yaml"),
        "image: gone.pgm\nresolution: 0.05\norigin: [0,0,0]\nfree_thresh: 0.2\noccupied_thresh: 0.6\n",
    )
    .unwrap();
    let error = read_plan(&dir.path().join("map.yaml"), None).unwrap_err();
    assert!(matches!(&error, PlanFileError::MapImage { name, .. } if name == "gone.pgm"), "{error}");
}

#[test]
fn real_plans_are_read() {
    for (name, scale, size_m) in [
        ("hilti_trimble_2026/floorplans/masks_with_windows/floor_2.png", Some(0.01), (73.5, 42.1)),
        ("piethein_walks_gt_on_plan/binnenkaart_copy.png", Some(1.0 / 90.0), (25.0, 36.0)),
        ("icsl_square3_corridor_walk/derived/map_walls.yaml", None, (13.1, 14.0)),
        ("robots_radish_carmen/derived_maps/intel.yaml", None, (0.0, 0.0)),
    ] {
        let Some(path) = data(name) else { return };
        let plan = read_plan(&path, scale).unwrap().plan;
        let (width, height) = plan.size_m();
        let expected = size_m.0 == 0.0 || (width - size_m.0).abs() < 1.0 && (height - size_m.1).abs() < 1.0;
        assert!(expected, "{name}: {width} m × {height} m");
        let walls = plan.cells().iter().filter(|c| **c == Cell::Wall).count() as f64 / plan.cells().len() as f64;
        assert!(walls > 0.005 && walls < 0.3, "{name}: {:.1} % wall", 100.0 * walls);
    }
}

#[test]
fn a_real_vector_plan_has_its_walk_on_floor_and_doors() {
    let (Some(path), Some(truth)) = (data("ipin21_hcu_hamburg/MapMaterial/Plan4OG.geojson"), data("ipin21_hcu_hamburg/eight_truth.tum"))
    else {
        return;
    };
    let plan = read_plan(&path, None).unwrap().plan;
    let truth = planwalk_io::trajectory::read(&truth, &planwalk_io::trajectory::PosesOptions::default()).unwrap().trajectory;
    let cells: Vec<Cell> =
        truth.poses().iter().map(|(_, pose)| plan.at(Pt2::new(pose.iso.translation.x, pose.iso.translation.y))).collect();
    let on_floor = cells.iter().filter(|cell| cell.is_floor()).count() as f64 / cells.len() as f64;
    assert!(on_floor >= 0.98, "{:.1} % of {} moments", 100.0 * on_floor, cells.len());
}

#[test]
fn every_storey_of_a_real_vector_plan_has_walls_doors_and_rooms() {
    for (name, floor_m2) in [("PlanEG", 4500.0), ("Plan1OG", 5000.0), ("Plan4OG", 4600.0)] {
        let Some(path) = data(&format!("ipin21_hcu_hamburg/MapMaterial/{name}.geojson")) else { return };
        let file = read_plan(&path, None).unwrap();
        let area = |kind: Cell| file.plan.cells().iter().filter(|c| **c == kind).count() as f64 * 0.05 * 0.05;
        assert_eq!(file.plan.cell_m(), 0.05);
        // Polygons overlap, walls stand on floors: areas by the file's own polygons, within a tenth.
        assert!((area(Cell::Free) / floor_m2 - 1.0).abs() < 0.1, "{name}: {:.0} m² of floor", area(Cell::Free));
        assert!((300.0..900.0).contains(&area(Cell::Wall)), "{name}: {:.0} m² of wall", area(Cell::Wall));
        assert!((30.0..80.0).contains(&area(Cell::Door)), "{name}: {:.0} m² of doors", area(Cell::Door));
        assert!(file.notes.iter().any(|n| n.contains("no geometry")) && file.notes.iter().any(|n| n.contains("EPSG::32632")), "{name}");
    }
}

#[test]
fn vector_plans_are_told_by_their_content_and_need_no_scale() {
    let dir = folder();
    let path = dir.path().join("plan");
    std::fs::write(&path, "\u{feff}x0,y0,x1,y1,kind\n0,0,4,0,wall\n1,0,2,0,door\n").unwrap();
    assert_eq!(read_plan(&path, None).unwrap().plan.at(Pt2::new(1.5, 0.01)), Cell::Door);
    assert!(matches!(read_plan(&path, Some(0.1)), Err(PlanFileError::ScaleNotNeeded)));
    let geojson = "{\"type\":\"Feature\",\"properties\":null,\"geometry\":{\"type\":\"LineString\",\"coordinates\":[[0,0],[4,0]]}}";
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, geojson.as_bytes()).unwrap();
    std::fs::write(&path, packed.finish().unwrap()).unwrap();
    assert_eq!(read_plan(&path, None).unwrap().plan.at(Pt2::new(1.5, 0.01)), Cell::Wall);
    std::fs::write(&path, "{\"no\": \"plan\"}").unwrap();
    assert!(matches!(read_plan(&path, None), Err(PlanFileError::GeoJson { .. })));
}

#[test]
fn numbers_between_blanks_are_walls_and_other_texts_are_no_pictures() {
    let dir = folder();
    let path = dir.path().join("walls.txt");
    std::fs::write(&path, "0 0 4 0\n4 0 4 3\n4 3 0 3\n0 3 0 0\n1 0 2 0 door\n").unwrap();
    assert_eq!(read_plan(&path, None).unwrap().plan.at(Pt2::new(1.5, 0.01)), Cell::Door);
    std::fs::write(&path, "Dear owner,\nhere is your plan.\n").unwrap();
    for metres_per_pixel in [None, Some(0.05)] {
        let error = read_plan(&path, metres_per_pixel).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("Dear owner") && error.contains("x0,y0,x1,y1"), "{error}");
    }
}
