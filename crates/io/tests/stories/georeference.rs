//! Real plans are placed on the globe, and come back from there.

use planwalk_io::plan::georeference::{self, ControlPoint, Crs};
use planwalk_io::plan::native::PlanDocument;
use planwalk_io::plan::{self, PlanOptions, export, native};
use planwalk_types::{Building, Georeference, Plan, Pt2};

use super::folder;
use crate::support::data;

fn import(path: &std::path::Path) -> PlanDocument {
    plan::import(path, &PlanOptions::default()).unwrap()
}

fn points(building: &Building) -> Vec<Pt2<Plan>> {
    building.levels.iter().flat_map(|level| &level.elements).flat_map(|element| element.form.points().collect::<Vec<_>>()).collect()
}

/// Distance on the ground, metres, between two places that are near each other.
fn apart([lon_a, lat_a]: [f64; 2], [lon_b, lat_b]: [f64; 2]) -> f64 {
    // 40 008 km of meridian; the ellipsoid's 0.3 % are nothing of a centimetre.
    let (across, along) = ((lon_b - lon_a) * lat_a.to_radians().cos(), lat_b - lat_a);
    111_200.0 * across.hypot(along)
}

/// Exports a storey to the globe, reads that, and tells how far any point is from where it was.
fn round_trip_m(document: &PlanDocument) -> f64 {
    let place = document.building.georeference.unwrap();
    let level = document.building.levels.iter().max_by_key(|level| level.elements.len()).unwrap();
    let dir = folder();
    let file = dir.path().join("globe.geojson");
    std::fs::write(&file, export::geojson_on_globe(level, &place).unwrap()).unwrap();
    let again = import(&file).building;
    let there = again.georeference.unwrap();
    let before = points(&Building { levels: vec![level.clone()], georeference: None });
    let globe = |place: &Georeference, points: &[Pt2<Plan>]| points.iter().map(|p| georeference::degrees(place, *p)).collect::<Vec<_>>();
    let (before, after) = (globe(&place, &before), globe(&there, &points(&again)));
    // Rings may turn round, and do not repeat their first point: the nearest one is looked for.
    let nearest = |at: &[f64; 2]| after.iter().map(|other| apart(*at, *other)).fold(f64::INFINITY, f64::min);
    before.iter().map(nearest).fold(0.0, f64::max)
}

#[test]
fn a_real_plan_in_utm_metres_knows_its_place_and_comes_back() {
    let Some(path) = data("ipin21_hcu_hamburg/MapMaterial/PlanEG.geojson") else { return };
    let document = import(&path);
    let place = document.building.georeference.expect("its coordinate system says where it is");
    // HafenCity University stands at 53.540° N, 10.004° E.
    assert!(apart([place.longitude_deg, place.latitude_deg], [10.004, 53.540]) < 300.0, "{place:?}");
    let error_m = round_trip_m(&document);
    assert!(error_m < 0.05, "{error_m} m");
    // The place can be found from points as well, and kept.
    let corners = points(&document.building);
    let known: Vec<ControlPoint> = corners.iter().step_by(corners.len() / 5).map(|at| known(&place, *at)).collect();
    let fit = georeference::fit(&known).unwrap();
    let found = corners.iter().map(|at| apart(georeference::degrees(&place, *at), georeference::degrees(&fit.place, *at)));
    let worst = found.fold(0.0, f64::max);
    assert!(worst < 0.01, "{worst} m");
    let kept = PlanDocument { placed: Some(fit.kept("points".to_owned(), &known)), ..document };
    let dir = folder();
    let file = dir.path().join("kept.plan.json");
    std::fs::write(&file, native::write(&kept)).unwrap();
    let again = import(&file);
    assert_eq!(again.placed.map(|placed| placed.points.len()), Some(known.len()));
    let back = again.building.georeference.unwrap();
    let worst = corners.iter().map(|at| apart(georeference::degrees(&place, *at), georeference::degrees(&back, *at))).fold(0.0, f64::max);
    // Nine decimals of a degree and a radian: 0.1 mm, and at 300 m less than that.
    assert!(worst < 0.001, "{worst} m");
}

fn known(place: &Georeference, plan: Pt2<Plan>) -> ControlPoint {
    let [longitude_deg, latitude_deg] = georeference::degrees(place, plan);
    ControlPoint { plan, longitude_deg, latitude_deg }
}

#[test]
fn a_real_mall_comes_back_from_the_globe() {
    for site in ["xyz10_indoor_location/site1/F2/geojson_map.json", "xyz10_indoor_location/site1/F4/geojson_map.json"] {
        let Some(path) = data(site) else { continue };
        let document = import(&path);
        let error_m = round_trip_m(&document);
        assert!(error_m < 0.05, "{site}: {error_m} m");
    }
}

#[test]
fn metres_of_a_grid_are_placed_by_its_name() {
    let Some(path) = data("ipin21_hcu_hamburg/MapMaterial/PlanEG.geojson") else { return };
    let document = import(&path);
    let crs: Crs = "EPSG:25832".parse().unwrap();
    let place = georeference::on_grid(&document.building, crs).unwrap();
    assert_eq!(Some(place), document.building.georeference);
    assert!(georeference::on_grid(&Building::default(), crs).is_err());
}
