//! A clean plan has no findings, and each finding comes of one thing that is broken.

use planwalk_sim::{Building, BuildingKind, BuildingOptions};
use planwalk_types::{Element, ElementKind, Form, Level, Plan, Pt2, Seed};

use super::*;

fn line(from: Pt2<Plan>, to: Pt2<Plan>) -> Form {
    Form::Line(vec![from, to])
}

fn ring(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<Pt2<Plan>> {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Pt2::new(x, y)).to_vec()
}

fn of_kind(kind: BuildingKind, seed: u64) -> (Building, Level) {
    let building = Building::generate(&BuildingOptions { kind, ..BuildingOptions::default() }, Seed(seed)).unwrap();
    let walls = building.drawn.iter().map(|wall| Element::new(ElementKind::Wall, line(wall.from, wall.to)));
    let doors = building.doors.iter().map(|door| Element::new(ElementKind::Door, line(door.opening.from, door.opening.to)));
    let elements = walls.chain(doors).collect();
    let level = Level { elements, ..Level::default() };
    (building, level)
}

fn office() -> (Building, Level) {
    of_kind(BuildingKind::Office, 5)
}

fn findings(level: &Level) -> Vec<Finding> {
    Audit::of(level).unwrap().findings
}

/// The kinds of findings, each once.
fn kinds(level: &Level) -> Vec<&'static str> {
    let mut kinds: Vec<&str> = findings(level).iter().map(Finding::kind).collect();
    kinds.dedup();
    kinds
}

fn all_kinds() -> [BuildingKind; 4] {
    [BuildingKind::Office, BuildingKind::OpenPlan, BuildingKind::Flat, BuildingKind::Loop]
}

#[test]
fn a_clean_plan_has_no_findings() {
    for kind in all_kinds() {
        for seed in 0..3 {
            let (_, level) = of_kind(kind, seed);
            let found = findings(&level);
            assert!(found.is_empty(), "{kind:?}, seed {seed}: {found:?}");
        }
    }
}

#[test]
fn rooms_of_a_clean_plan_are_those_that_were_built() {
    for seed in 0..3 {
        let (building, level) = of_kind(BuildingKind::Flat, seed);
        let rooms = Audit::of(&level).unwrap().rooms;
        // Every room found has its heart in one that was built, and no two in the same.
        let mut built: Vec<usize> = rooms.iter().map(|room| building.room_at(room.at).unwrap()).collect();
        built.sort_unstable();
        built.dedup();
        assert_eq!((built.len(), rooms.len()), (building.rooms.len(), building.rooms.len()), "seed {seed}");
    }
}

/// Nothing is left out of the rooms but walls: their areas and outlines say the same.
#[test]
fn an_outline_is_as_large_as_its_room() {
    let square = |x: f64| Element::new(ElementKind::Wall, Form::Area(vec![ring(x, 0.0, x + 4.2, 3.2), ring(x + 0.1, 0.1, x + 4.1, 3.1)]));
    let level = Level { elements: vec![square(0.0), square(4.2)], ..Level::default() };
    let rooms = Audit::of(&level).unwrap().rooms;
    assert_eq!(rooms.len(), 2);
    for room in rooms {
        // 4 m × 3 m, on cells of 5 cm: half a cell all around.
        assert!((room.area_m2 - 12.0).abs() < 14.0 * 0.05, "{}", room.area_m2);
        assert_eq!(room.element.source.as_deref(), Some(FOUND));
    }
}

#[test]
fn a_hole_in_an_outer_wall_is_a_gap() {
    let (building, mut level) = office();
    let (low, _) = building.bounds();
    let is_outer =
        |e: &&mut Element| e.kind == ElementKind::Wall && e.form.points().all(|p| (p.y - low.y).abs() < 1e-6) && span(&e.form) > 2.0;
    let wall = level.elements.iter_mut().find(is_outer).unwrap();
    let (from, to) = ends(&wall.form);
    let way = (to.x - from.x) / (to.x - from.x).abs();
    let (left, right) = (Pt2::new(from.x + 0.5 * way, from.y), Pt2::new(from.x + 1.3 * way, from.y));
    wall.form = line(from, left);
    level.elements.push(Element::new(ElementKind::Wall, line(right, to)));
    let found = findings(&level);
    let [Finding::OutlineGap { at, width_m, places: 1 }] = found[..] else { panic!("{found:?}") };
    // A cell at either side.
    assert!((width_m - 0.8).abs() < 0.11 && at.distance(Pt2::new(from.x + 0.9 * way, from.y)) < 0.3, "{at:?}, {width_m}");
}

fn ends(form: &Form) -> (Pt2<Plan>, Pt2<Plan>) {
    let points: Vec<_> = form.points().collect();
    (points[0], points[points.len() - 1])
}

fn span(form: &Form) -> f64 {
    let (from, to) = ends(form);
    from.distance(to)
}

#[test]
fn a_room_without_its_outer_wall_ends_where_the_wall_would_stand() {
    // 5 m × 6 m, open over all of its right side, and a closed one to its left.
    let walls = [[0.0, 0.0, 10.0, 0.0], [0.0, 5.0, 10.0, 5.0], [0.0, 0.0, 0.0, 5.0], [4.0, 0.0, 4.0, 5.0]];
    let wall = |[x0, y0, x1, y1]: [f64; 4]| Element::new(ElementKind::Wall, line(Pt2::new(x0, y0), Pt2::new(x1, y1)));
    let door = Element::new(ElementKind::Door, line(Pt2::new(4.0, 2.0), Pt2::new(4.0, 2.9)));
    let level = Level { elements: walls.into_iter().map(wall).chain([door]).collect(), ..Level::default() };
    let audit = Audit::of(&level).unwrap();
    let mut areas: Vec<f64> = audit.rooms.iter().map(|room| room.area_m2).collect();
    areas.sort_by(f64::total_cmp);
    assert!(areas.len() == 2 && (areas[0] - 20.0).abs() < 1.0 && (areas[1] - 30.0).abs() < 1.5, "{areas:?}");
    let [Finding::OutlineGap { at, width_m, places: 1 }] = audit.findings[..] else { panic!("{:?}", audit.findings) };
    // The arc before it is known to coarse cells of 25 cm.
    assert!((width_m - 5.0).abs() < 0.3 && at.distance(Pt2::new(10.0, 2.5)) < 0.5, "{width_m}, {at:?}");
}

#[test]
fn a_corner_between_two_wings_is_no_room() {
    let corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 6.0), (6.0, 6.0), (6.0, 20.0), (0.0, 20.0)].map(|(x, y)| Pt2::new(x, y));
    let walls = Element::new(ElementKind::Wall, Form::Line(corners.iter().copied().chain([corners[0]]).collect()));
    let audit = Audit::of(&Level { elements: vec![walls], ..Level::default() }).unwrap();
    assert_eq!(audit.rooms.len(), 1, "{:?}", audit.rooms);
    assert!((audit.rooms[0].area_m2 - 204.0).abs() < 5.0 && audit.findings.is_empty(), "{:?}", audit.findings);
}

#[test]
fn a_room_whose_door_is_walled_up_is_not_reached() {
    let (building, mut level) = office();
    // A room with one door, which is not the way to any other.
    let doors = |room: usize| -> Vec<usize> {
        let leads = |d: &planwalk_sim::Door| {
            let c = d.centre();
            [(0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -0.3)]
                .iter()
                .any(|(x, y)| building.room_at(Pt2::new(c.x + x, c.y + y)) == Some(room))
        };
        (0..building.doors.len()).filter(|n| leads(&building.doors[*n])).collect()
    };
    let room = (0..building.rooms.len()).find(|room| doors(*room).len() == 1).unwrap();
    let door = building.doors[doors(room)[0]].opening;
    let drawn = line(door.from, door.to);
    level.elements.retain(|e| e.form != drawn);
    level.elements.push(Element::new(ElementKind::Wall, drawn));
    let found = findings(&level);
    let [Finding::Unreachable { at, area_m2, behind: Some((behind, thick_m)) }] = found[..] else { panic!("{found:?}") };
    assert_eq!(building.room_at(at), Some(room));
    assert!((area_m2 - building.rooms[room].area_m2()).abs() < 0.1 * area_m2, "{area_m2}");
    assert!(thick_m < 0.2 && building.room_at(behind) != Some(room), "{thick_m}, {behind:?}");
}

#[test]
fn a_door_that_nobody_fits_through_is_told() {
    let (_, mut level) = office();
    let door = level.elements.iter_mut().find(|e| e.kind == ElementKind::Door).unwrap();
    let (from, to) = ends(&door.form);
    // Its middle half; the wall goes on beside it.
    let at = |t: f64| Pt2::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
    door.form = line(at(0.25), at(0.75));
    level.elements.extend([(0.0, 0.25), (0.75, 1.0)].map(|(a, b)| Element::new(ElementKind::Wall, line(at(a), at(b)))));
    let found = findings(&level);
    let [Finding::DoorWidth { at: middle, width_m }] = found[..] else { panic!("{found:?}") };
    assert!((width_m - 0.5 * from.distance(to)).abs() < 1e-9 && middle.distance(at(0.5)) < 1e-9);
}

#[test]
fn metres_that_are_feet_show_in_the_doors() {
    let (_, mut level) = office();
    for point in level.elements.iter_mut().flat_map(|e| e.form.points_mut()) {
        *point = Pt2::new(point.x / 0.3048, point.y / 0.3048);
    }
    let found = findings(&level);
    assert!(matches!(found[0], Finding::Scale { sign: ScaleSign::Doors, measured, .. } if measured > 2.5), "{found:?}");
    assert!(found[0].remedy().contains("--measure") && found[1..].iter().all(|f| f.kind() == "door-width"), "{found:?}");
}

#[test]
fn letters_among_the_walls_are_told() {
    let (building, mut level) = office();
    let room = building.rooms.iter().max_by(|a, b| a.area_m2().total_cmp(&b.area_m2())).unwrap();
    let c = room.centre();
    for n in 0..5 {
        let x = c.x + 0.4 * f64::from(n) - 1.0;
        level.elements.push(Element::new(ElementKind::Wall, Form::Area(vec![ring(x, c.y, x + 0.2, c.y + 0.3)])));
    }
    let found = findings(&level);
    let [Finding::Letters { at, count: 5, .. }] = found[..] else { panic!("{found:?}") };
    assert!(at.distance(c) < 0.5, "{at:?}");
}

#[test]
fn a_wall_that_is_drawn_twice_is_told() {
    let (_, mut level) = office();
    let wall = level.elements.iter().find(|e| e.kind == ElementKind::Wall && span(&e.form) > 2.0).unwrap().clone();
    let (from, to) = ends(&wall.form);
    // The other way round, and only half of it.
    level.elements.push(Element::new(ElementKind::Wall, line(Pt2::new(0.5 * (from.x + to.x), 0.5 * (from.y + to.y)), from)));
    let found = findings(&level);
    let [Finding::DoubledWall { length_m, .. }] = found[..] else { panic!("{found:?}") };
    assert!((length_m - 0.5 * span(&wall.form)).abs() < 1e-9, "{length_m}");
}

#[test]
fn a_stroke_that_was_left_over_is_told() {
    let (building, mut level) = office();
    let c = building.rooms[0].centre();
    level.elements.push(Element::new(ElementKind::Wall, line(c, Pt2::new(c.x + 0.06, c.y))));
    let found = findings(&level);
    let [Finding::ShortWall { at, length_m, .. }] = found[..] else { panic!("{found:?}") };
    assert!((length_m - 0.06).abs() < 1e-9 && at.distance(c) < 0.1);
}

#[test]
fn two_storeys_on_one_sheet_are_told() {
    let (building, mut level) = office();
    let (low, high) = building.bounds();
    let mut above = level.elements.clone();
    above.iter_mut().flat_map(|e| e.form.points_mut()).for_each(|p| *p = Pt2::new(p.x, p.y + high.y - low.y + 6.0));
    level.elements.extend(above);
    let several: Vec<_> = findings(&level).into_iter().filter(|f| f.kind() == "several-drawings").collect();
    let [Finding::SeveralDrawings { size_m, count: 2, .. }, _] = several[..] else { panic!("{several:?}") };
    // Squares of a metre.
    assert!((size_m[0] - (high.x - low.x)).abs() <= 2.0, "{size_m:?}");
}

#[test]
fn all_of_it_is_said_at_once() {
    let (building, mut level) = office();
    let c = building.rooms[0].centre();
    let wall = level.elements[0].clone();
    level.elements.push(wall);
    level.elements.push(Element::new(ElementKind::Wall, line(c, Pt2::new(c.x + 0.06, c.y))));
    assert_eq!(kinds(&level), ["doubled-wall", "short-wall"]);
    for finding in findings(&level) {
        assert!(finding.at().is_some() && !finding.figures().is_empty() && finding.to_string().contains(" m"), "{finding}");
    }
}

#[test]
fn drawn_rooms_are_kept_and_get_their_names_from_the_texts_in_them() {
    let room = |x: f64| Element::new(ElementKind::Room, Form::Area(vec![ring(x, 0.0, x + 5.0, 4.0)]));
    let label =
        |x: f64, text: &str| Element { name: Some(text.to_owned()), ..Element::new(ElementKind::Room, Form::Spot(Pt2::new(x, 2.0))) };
    let door = Element::new(ElementKind::Door, line(Pt2::new(5.0, 1.5), Pt2::new(5.0, 2.4)));
    let named = Element { name: Some("Lab".to_owned()), ..room(5.0) };
    let mut level =
        Level { elements: vec![room(0.0), named, door, label(2.0, "A135"), label(7.0, "other"), label(20.0, "far")], ..Level::default() };
    let audit = Audit::of(&level).unwrap();
    audit.complete(&mut level);
    let names: Vec<_> = level.elements.iter().map(|e| (e.kind, e.name.as_deref())).collect();
    assert_eq!(names, [(ElementKind::Room, Some("A135")), (ElementKind::Room, Some("Lab")), (ElementKind::Door, None)]);
    let [passage] = audit.passages[..] else { panic!("{:?}", audit.passages) };
    assert!(passage.is_door && passage.ends == [End::Room(0), End::Room(1)] && (passage.width_m - 0.9).abs() < 0.11, "{passage:?}");
    assert!((audit.rooms[0].area_m2 - 20.0).abs() < 1e-9);
}

#[test]
fn rooms_that_were_found_change_no_cell_and_are_kept_when_read_again() {
    let (_, mut level) = office();
    let before = vector::draw(&level.elements, &mut Vec::new()).unwrap();
    let audit = Audit::of(&level).unwrap();
    audit.complete(&mut level);
    assert!(level.elements.iter().any(is_remark) && !as_drawn(&level).elements.iter().any(is_remark));
    assert_eq!(vector::draw(&level.elements, &mut Vec::new()).unwrap(), before);
    let again = Audit::of(&level).unwrap();
    assert_eq!(again.rooms.len(), audit.rooms.len());
    assert!(again.findings.is_empty(), "{:?}", again.findings);
}

#[test]
fn a_turned_plan_has_the_same_rooms() {
    let (_, level) = office();
    let count = Audit::of(&level).unwrap().rooms.len();
    for degrees in [17.0f64, 45.0, 90.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let mut turned = level.clone();
        turned.elements.iter_mut().flat_map(|e| e.form.points_mut()).for_each(|p| *p = Pt2::new(c * p.x - s * p.y, s * p.x + c * p.y));
        let audit = Audit::of(&turned).unwrap();
        assert_eq!(audit.rooms.len(), count, "{degrees}°");
        assert!(audit.findings.is_empty(), "{degrees}°: {:?}", audit.findings);
    }
}
