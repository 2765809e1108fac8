//! Plans are placed on the globe, and leave for there.

use std::fs;
use std::path::Path;

use crate::support::{failure, folder, planwalk};

const ROOM: &str = "0,0,40,0\n40,0,40,30\n40,30,0,30\n0,30,0,0\n";

/// Runs it, and returns what is said.
fn georeference(dir: &Path, plan: &str, args: &[&str]) -> String {
    let output =
        planwalk().args(["plan", "georeference"]).arg(dir.join(plan)).args(args).arg("-o").arg(dir.join("out.plan.json")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    said
}

/// Longitude and latitude of the first corner of what is exported.
fn first_corner(dir: &Path) -> (f64, f64) {
    planwalk()
        .args(["plan", "export", "--quiet", "--force"])
        .arg(dir.join("out.plan.json"))
        .arg("-o")
        .arg(dir.join("out.geojson"))
        .assert()
        .success();
    let text = fs::read_to_string(dir.join("out.geojson")).unwrap();
    let numbers = text.split("\"coordinates\": [[").nth(1).and_then(|rest| rest.split(']').next()).unwrap();
    let (longitude, latitude) = numbers.trim_start_matches('[').split_once(',').unwrap();
    (longitude.parse().unwrap(), latitude.parse().unwrap())
}

#[test]
fn points_place_a_plan_and_the_one_that_lies_is_named() {
    let dir = folder();
    fs::write(dir.path().join("room.csv"), ROOM).unwrap();
    // At 53.5° north 1e-5° are 1.113 m of meridian and 0.664 m of parallel; the fourth point is 9 m off.
    let points = ["0,0=53.5,10", "40,0=53.5,10.000603", "40,30=53.50026955,10.000603", "0,30=53.500188,10", "20,15=53.50013478,10.0003015"];
    let args: Vec<&str> = points.iter().flat_map(|point| ["--point", point]).collect();
    let said = georeference(dir.path(), "room.csv", &args);
    assert!(said.contains("5 points, sigma") && said.contains("warning: point 4 is"), "{said}");
    let text = fs::read_to_string(dir.path().join("out.plan.json")).unwrap();
    assert!(text.contains("\"georeference\": {") && text.contains("\"from\": \"5 points, given\""), "{text}");
    // Without it the corner is where it was said to be, to 5 cm.
    let args: Vec<&str> = [0, 1, 2, 4].iter().flat_map(|i| ["--point", points[*i]]).chain(["--force"]).collect();
    georeference(dir.path(), "room.csv", &args);
    let (longitude, latitude) = first_corner(dir.path());
    assert!((longitude - 10.0).abs() * 66_400.0 < 0.05 && (latitude - 53.5).abs() * 111_300.0 < 0.05, "{longitude}, {latitude}");
    // Others can tell where it lies.
    let output = planwalk().args(["plan", "info"]).arg(dir.path().join("out.plan.json")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("latitude 53.5"), "{said}");
}

#[test]
fn a_picture_is_placed_by_its_pixels_or_its_world_file() {
    let dir = folder();
    let row =
        |y: usize| (0..80).map(|x| if [10, 49].contains(&y) || [10, 69].contains(&x) { "0" } else { "255" }).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..60).map(row).collect();
    fs::write(dir.path().join("a.pgm"), format!("P2\n80 60\n255\n{}\n", rows.join("\n"))).unwrap();
    // 10 cm a pixel on the grid of zone 32; top left corner at 566 600, 5 932 900.
    fs::write(dir.path().join("a.pgw"), "0.1\n0\n0\n-0.1\n566600.05\n5932899.95\n").unwrap();
    let world = dir.path().join("a.pgw");
    let said = georeference(dir.path(), "a.pgm", &["--world-file", world.to_str().unwrap(), "--crs", "EPSG:32632"]);
    // By the grid's scale, and turned by its convergence.
    assert!(said.contains("1.0000 m on the ground") && said.contains("0.81° clockwise"), "{said}");
    let (longitude, latitude) = first_corner(dir.path());
    let pixels = ["--pixel", "0,0=53.5405,10.0055", "--pixel", "80,0=53.5405,10.00562074", "--force", "--metres-per-pixel", "0.1"];
    let said = georeference(dir.path(), "a.pgm", &pixels);
    assert!(said.contains("two points always fit"), "{said}");
    assert!((longitude - 10.0055).abs() < 0.001 && (latitude - 53.5405).abs() < 0.001, "{longitude}, {latitude}");
}

#[test]
fn what_gives_no_place_is_refused() {
    let dir = folder();
    fs::write(dir.path().join("room.csv"), ROOM).unwrap();
    let run = |args: &[&str], code| {
        failure(
            planwalk()
                .args(["plan", "georeference"])
                .arg(dir.path().join("room.csv"))
                .args(args)
                .arg("-o")
                .arg(dir.path().join("no.plan.json")),
            code,
        )
    };
    for (args, code, told) in [
        (&[][..], 2, "--point"),
        (&["--point", "0,0=53.5,10"], 2, "at least 2"),
        (&["--point", "0,0"], 2, "latitude,longitude"),
        (&["--anchor", "53.5,10"], 2, "--bearing"),
        (&["--anchor", "95,10", "--bearing", "0"], 2, "latitude 95°"),
        (&["--pixel", "0,0=53.5,10", "--pixel", "9,0=53.5,10.1"], 2, "--pixel is for pictures"),
        (&["--crs", "EPSG:4326"], 2, "EPSG:326zz"),
        (&["--crs", "EPSG:31467"], 2, "GIS"),
        (&["--crs", "EPSG:32632"], 4, "not on the grid"),
    ] {
        let said = run(args, code);
        assert!(said.contains(told), "{args:?}: {said}");
    }
    assert!(!dir.path().join("no.plan.json").exists());
}
