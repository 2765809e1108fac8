//! A plan on paper is the same plan when it is photographed by a desk lamp, or lies askew on the scanner.

use image::{GrayImage, Luma};
use planwalk_io::plan::{self, PlanFile, PlanOptions};
use planwalk_sim::{Building, BuildingKind, BuildingOptions};
use planwalk_types::{Cell, FloorPlan, Plan, Pt2, Seed};

use super::folder;

const METRES_PER_PIXEL: f64 = 0.02;
/// What a wall may be off, metres: what is asked of scans.
const NEAR_M: f64 = 0.15;

/// An office on paper, walls 12 cm thick.
fn drawn(seed: u64) -> GrayImage {
    let building = Building::generate(&BuildingOptions { kind: BuildingKind::Office, ..BuildingOptions::default() }, Seed(seed)).unwrap();
    let plan = building.plan(METRES_PER_PIXEL, 1.5).unwrap();
    let shade = |u: u32, v: u32| {
        let place = (plan.height() - 1 - v as usize) * plan.width() + u as usize;
        if plan.cells()[place] == Cell::Wall { 25 } else { 245 }
    };
    GrayImage::from_fn(plan.width() as u32, plan.height() as u32, |u, v| Luma([shade(u, v)]))
}

/// The sheet as a scanner or a camera sees it: turned anticlockwise about its middle, lit by `light` (shares of both sides), with the
/// grain of a sensor, of uniform steps up to ±8.
fn seen(sheet: &GrayImage, deg: f64, light: impl Fn(f64, f64) -> f64) -> GrayImage {
    let (w, h) = (f64::from(sheet.width()), f64::from(sheet.height()));
    let (s, c) = deg.to_radians().sin_cos();
    let at = |u: i64, v: i64| {
        let inside = u >= 0 && v >= 0 && u < i64::from(sheet.width()) && v < i64::from(sheet.height());
        if inside { f64::from(sheet.get_pixel(u as u32, v as u32).0[0]) } else { 245.0 }
    };
    GrayImage::from_fn(sheet.width(), sheet.height(), |u, v| {
        let (x, y) = (f64::from(u) - w / 2.0, f64::from(v) - h / 2.0);
        let (x, y) = (c * x - s * y + w / 2.0, s * x + c * y + h / 2.0);
        let (u0, v0) = (x.floor(), y.floor());
        let row = |v: f64| at(u0 as i64, v as i64) * (1.0 - (x - u0)) + at(u0 as i64 + 1, v as i64) * (x - u0);
        let ink = row(v0) * (1.0 - (y - v0)) + row(v0 + 1.0) * (y - v0);
        let hash = (u.wrapping_mul(0x9e37_79b1) ^ v.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
        let grain = f64::from(hash >> 28) - 7.5;
        Luma([(ink * light(f64::from(u) / w, f64::from(v) / h) + grain).clamp(0.0, 255.0) as u8])
    })
}

fn read(picture: &GrayImage) -> PlanFile {
    let dir = folder();
    let path = dir.path().join("sheet.png");
    picture.save(&path).unwrap();
    plan::read(&path, &PlanOptions { metres_per_pixel: Some(METRES_PER_PIXEL), ..PlanOptions::default() }).unwrap()
}

fn walls(plan: &FloorPlan) -> Vec<Pt2<Plan>> {
    let centre = |i: usize| {
        let cells = [(i % plan.width()) as f64 + 0.5, (i / plan.width()) as f64 + 0.5];
        Pt2::new(plan.origin().x + cells[0] * plan.cell_m(), plan.origin().y + cells[1] * plan.cell_m())
    };
    (0..plan.cells().len()).filter(|i| plan.cells()[*i] == Cell::Wall).map(centre).collect()
}

/// Share of some places that are near a wall of a plan.
fn near(places: impl Iterator<Item = Pt2<Plan>>, plan: &FloorPlan) -> f64 {
    let steps: Vec<f64> = (-5..=5).map(|k| f64::from(k) * NEAR_M / 5.0).collect();
    let offsets: Vec<(f64, f64)> =
        steps.iter().flat_map(|x| steps.iter().map(|y| (*x, *y))).filter(|(x, y)| x.hypot(*y) <= NEAR_M).collect();
    let is_near = |at: Pt2<Plan>| offsets.iter().any(|(x, y)| plan.at(Pt2::new(at.x + x, at.y + y)) == Cell::Wall);
    let found: Vec<bool> = places.map(is_near).collect();
    found.iter().filter(|is| **is).count() as f64 / found.len().max(1) as f64
}

/// Recall and precision of the walls that were read from a turned sheet, against those of the sheet itself.
fn compare(read: &FloorPlan, deg: f64, clean: &FloorPlan, sheet: &GrayImage) -> [f64; 2] {
    let middle = [sheet.width(), sheet.height()].map(|px| f64::from(px) * METRES_PER_PIXEL / 2.0);
    let turned = |deg: f64| {
        let (s, c) = deg.to_radians().sin_cos();
        move |at: Pt2<Plan>| {
            let (x, y) = (at.x - middle[0], at.y - middle[1]);
            Pt2::new(c * x - s * y + middle[0], s * x + c * y + middle[1])
        }
    };
    [near(walls(clean).into_iter().map(turned(deg)), read), near(walls(read).into_iter().map(turned(-deg)), clean)]
}

#[test]
fn walls_of_a_sheet_in_uneven_light_and_askew_are_those_of_the_clean_one() {
    for (seed, deg) in [(1, 0.0), (2, 3.0), (3, -10.0)] {
        let sheet = drawn(seed);
        let clean = read(&sheet);
        assert!(clean.notes.iter().all(|note| !note.contains("light is uneven") && !note.contains("askew")), "{:?}", clean.notes);
        let lit = read(&seen(&sheet, deg, |x, y| 1.0 - 0.65 * (0.7 * x + 0.3 * y)));
        let [recall, precision] = compare(&lit.plan, deg, &clean.plan, &sheet);
        assert!(recall >= 0.99 && precision >= 0.99, "seed {seed}, {deg}°: recall {recall:.4}, precision {precision:.4}");
        assert!(lit.notes.iter().any(|note| note.contains("light is uneven")), "{:?}", lit.notes);
        let askew = lit.notes.iter().find(|note| note.contains("askew"));
        let said = format!("{:.1}° {}", f64::abs(deg), if deg > 0.0 { "anticlockwise" } else { "clockwise" });
        assert_eq!(askew.is_some_and(|note| note.contains(&said)), deg != 0.0, "{deg}°: {:?}", lit.notes);
    }
}

#[test]
fn in_half_a_shadow_as_dark_as_grey_a_sheet_keeps_its_walls() {
    let sheet = drawn(4);
    let clean = read(&sheet);
    // The edge of a shadow, 1.5 m of the plan wide: paper beyond it is darker than mid-grey.
    let shadow = |x: f64, _: f64| 1.0 - 0.55 / (1.0 + f64::exp(-(x - 0.6) / 0.04));
    let read = read(&seen(&sheet, 0.0, shadow));
    let [recall, precision] = compare(&read.plan, 0.0, &clean.plan, &sheet);
    assert!(recall >= 0.99 && precision >= 0.99, "recall {recall:.4}, precision {precision:.4}");
}
