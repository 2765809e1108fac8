//! What does an OpenStreetMap file show? The rooms of a building, storey by storey; or, where there are none, the roads.
//!
//! OSM XML ─▶ nodes, ways, multipolygons ─┬─▶ `indoor=*`: walls, doors, rooms, stairs by `level` ─┬─▶ metres ─▶ [`Building`]
//!                                        └─▶ else `highway=*`: ground as wide as the roads ───────┘
//!
//! Frame: the plane that touches the earth at the first point drawn; x east, y north.

mod ground;
mod indoor;
pub(super) mod levels;
mod map;
mod roads;

use std::collections::{BTreeMap, BTreeSet};

use planwalk_types::{Building, Element, ElementKind};
use quick_xml::Reader;
use quick_xml::events::Event;

use self::ground::Ground;
use self::levels::Level;
use self::map::Map;
use super::{PlanFileError, storeys};

/// Levels named in the note on what was read.
const LEVELS_TOLD: usize = 20;

/// Whether a text that begins like this is an OpenStreetMap file.
pub(super) fn is_one(head: &str) -> bool {
    let mut reader = Reader::from_str(head.trim_start_matches('\u{feff}').trim_start());
    loop {
        match reader.read_event() {
            Ok(Event::Start(tag) | Event::Empty(tag)) => {
                let name = tag.name();
                let name: &str = name.as_ref();
                return name == "osm";
            }
            Ok(Event::Decl(_) | Event::PI(_) | Event::Comment(_) | Event::DocType(_)) => {}
            Ok(Event::Text(text)) if text.trim().is_empty() => {}
            _ => return false,
        }
    }
}

/// Reads the building or the roads of an OpenStreetMap file.
pub(super) fn read(text: &str, notes: &mut Vec<String>) -> Result<Building, PlanFileError> {
    let map = Map::parse(text)?;
    let mut ground = Ground::new(&map);
    let mut building = Building::default();
    if indoor::is_indoors(&map) {
        let storeys = indoor::draw(&mut ground, notes)?;
        building = stacked(storeys, &indoor::level_names(&mut ground)?);
    }
    if building.levels.is_empty() {
        let elements = roads::draw(&mut ground, notes)?;
        if elements.is_empty() {
            return Err(PlanFileError::OsmNothingDrawn { found: map.found() });
        }
        building = Building::of_one_level(elements);
    } else {
        tell_indoors(&building, roads::for_cars(&map).count(), notes);
    }
    building.georeference = ground.finish(notes);
    Ok(building)
}

/// Storeys in their order and with their names.
fn stacked(storeys: indoor::Storeys, names: &BTreeMap<Level, String>) -> Building {
    let numbers: Vec<f64> = storeys.keys().map(|level| level.number()).collect();
    let ordinals: BTreeMap<Level, i32> = storeys.keys().copied().zip(storeys::ordinals(&numbers)).collect();
    let name = |level: Level| names.get(&level).cloned().unwrap_or_else(|| level.name());
    let levels = storeys.into_iter().map(|(level, elements)| {
        let joined = |(element, joins): (Element, BTreeSet<Level>)| {
            let joins = joins.iter().filter_map(|level| ordinals.get(level).copied()).collect();
            Element { joins, ..element }
        };
        let elements = elements.into_iter().map(joined).collect();
        planwalk_types::Level { ordinal: ordinals.get(&level).copied().unwrap_or_default(), name: name(level), elements }
    });
    Building { levels: levels.collect(), georeference: None }
}

fn tell_indoors(building: &Building, roads: usize, notes: &mut Vec<String>) {
    let elements = || building.levels.iter().flat_map(|level| &level.elements);
    let count = |kind: ElementKind| elements().filter(|element| element.kind == kind).count();
    let counts = ElementKind::ALL.map(|kind| (count(kind), kind.word()));
    let counts: Vec<String> = counts.iter().filter(|(count, _)| *count > 0).map(|(count, word)| format!("{count} {word}")).collect();
    let names: Vec<&str> = building.levels.iter().take(LEVELS_TOLD).map(|level| level.name.as_str()).collect();
    let more = if building.levels.len() > names.len() { ", …" } else { "" };
    notes.push(format!(
        "an indoor map of OpenStreetMap: {}; {} levels: {}{more}",
        counts.join(", "),
        building.levels.len(),
        names.join(", ")
    ));
    if roads > 0 {
        notes.push(format!("{roads} roads around the building are left out"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Form;
    use proptest::prelude::*;

    /// Degrees of longitude and latitude in a metre where the equator meets the zero meridian.
    const DEGREES: [f64; 2] = [1.0 / 111_319.490_79, 1.0 / 110_574.275_82];

    fn tags(tags: &str) -> String {
        let pairs = tags.split(',').filter_map(|tag| tag.split_once('='));
        pairs.map(|(key, value)| format!("<tag k='{key}' v='{value}'/>")).collect()
    }

    fn node(id: i64, x: f64, y: f64, tagged: &str) -> String {
        format!("<node id='{id}' lat='{:.11}' lon='{:.11}'>{}</node>\n", y * DEGREES[1], x * DEGREES[0], tags(tagged))
    }

    fn way(id: i64, nodes: &[i64], tagged: &str) -> String {
        let nodes: String = nodes.iter().map(|node| format!("<nd ref='{node}'/>")).collect();
        format!("<way id='{id}'>{nodes}{}</way>\n", tags(tagged))
    }

    fn relation(id: i64, members: &[(i64, &str)], tagged: &str) -> String {
        let members: String = members.iter().map(|(way, role)| format!("<member type='way' ref='{way}' role='{role}'/>")).collect();
        format!("<relation id='{id}'>{members}{}{}</relation>\n", tags("type=multipolygon"), tags(tagged))
    }

    fn osm(parts: &[String]) -> String {
        format!("<?xml version='1.0' encoding='UTF-8'?>\n<osm version='0.6' generator='JOSM'>\n{}</osm>\n", parts.concat())
    }

    /// Nodes 1 to 6: two squares of 4 m beside each other, the wall between them from 2 to 5.
    fn corners() -> Vec<String> {
        let at = [(1, 0.0, 0.0), (2, 4.0, 0.0), (3, 8.0, 0.0), (4, 8.0, 4.0), (5, 4.0, 4.0), (6, 0.0, 4.0)];
        at.iter().map(|(id, x, y)| node(*id, *x, *y, "")).collect()
    }

    fn with_corners(more: &[String]) -> String {
        let mut parts = corners();
        parts.extend_from_slice(more);
        osm(&parts)
    }

    fn building(text: &str) -> (Building, Vec<String>) {
        let mut notes = Vec::new();
        let building = read(text, &mut notes).unwrap();
        (building, notes)
    }

    fn refusal(text: &str) -> String {
        match read(text, &mut Vec::new()) {
            Err(why) => why.to_string(),
            Ok(building) => panic!("{} levels are read", building.levels.len()),
        }
    }

    /// Every element of a level in short: kind and name.
    fn short(level: &planwalk_types::Level) -> Vec<(ElementKind, Option<&str>)> {
        level.elements.iter().map(|element| (element.kind, element.name.as_deref())).collect()
    }

    fn levels(building: &Building) -> Vec<(i32, &str)> {
        building.levels.iter().map(|level| (level.ordinal, level.name.as_str())).collect()
    }

    fn points(element: &Element) -> Vec<[f64; 2]> {
        element.form.points().map(|p| [p.x, p.y]).collect()
    }

    /// To a millimetre: eleven decimals of a degree are a micrometre.
    fn assert_points(element: &Element, wanted: &[[f64; 2]]) {
        let found = points(element);
        let near = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-3;
        assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(near), "{found:?}, wanted {wanted:?}");
    }

    #[test]
    fn rooms_are_on_their_levels_with_their_names() {
        let (building, notes) = building(&with_corners(&[
            way(-1, &[1, 2, 5, 6, 1], "indoor=room,level=0-1,ref=101,name=Office"),
            way(-2, &[2, 3, 4, 5, 2], "indoor=corridor,level=0,repeat_on=-1;0.5"),
            way(-3, &[2, 3, 4, 5, 2], "indoor=area,level=1"),
            way(-4, &[1, 3, 4, 6, 1], "indoor=level,level=0,level:ref=EG,name=Erdgeschoss"),
            way(-5, &[1, 3, 4, 6, 1], "indoor=level,level=-1,name=Keller"),
            way(-6, &[1, 3, 4, 6, 1], "building=yes"),
            way(-7, &[1, 3, 4, 6, 1], "indoor=level,level=7"),
        ]));
        assert_eq!(levels(&building), [(-1, "Keller"), (0, "EG"), (1, "0.5"), (2, "1")]);
        let office = (ElementKind::Room, Some("101 Office"));
        assert_eq!(short(&building.levels[0]), [(ElementKind::Room, None)]);
        assert_eq!(short(&building.levels[1]), [office, (ElementKind::Room, None)]);
        assert_eq!(short(&building.levels[3]), [office, (ElementKind::Floor, None)]);
        assert_points(&building.levels[1].elements[0], &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        assert_eq!(building.levels[1].elements[0].source.as_deref(), Some("way -1, indoor=room"));
        assert!(notes.iter().any(|n| n.contains("5 room") && n.contains("4 levels: Keller, EG, 0.5, 1")), "{notes:?}");
        let at = building.georeference.unwrap();
        assert_eq!((at.longitude_deg, at.latitude_deg, at.bearing_rad), (0.0, 0.0, 0.0));
    }

    #[test]
    fn walls_columns_and_open_ground_are_told_apart() {
        let (building, _) = building(&with_corners(&[
            node(7, 2.0, 2.0, "indoor=column,level=0,width=0.5"),
            way(1, &[1, 2, 3], "indoor=wall,level=0"),
            way(2, &[1, 2, 5, 6, 1], "indoor=wall,level=0"),
            way(3, &[1, 2, 5, 6, 1], "indoor=wall,area=yes,level=0"),
            way(4, &[2, 5], "indoor=wall,material=glass,level=0"),
            way(5, &[2, 3, 4, 5, 2], "indoor=column,level=0"),
            way(6, &[2, 5], "indoor=corridor,level=0,width=1"),
            way(7, &[2, 3, 4, 5, 2], "building:part=yes,level=0"),
            way(8, &[2, 3, 4, 5, 2], "building:part=yes"),
            way(9, &[1, 4], "indoor=room,level=0"),
        ]));
        let elements = &building.levels[0].elements;
        let is_line = |at: usize| matches!(elements[at].form, Form::Line(_));
        assert!(is_line(0) && is_line(1) && !is_line(2) && is_line(3) && !is_line(4));
        assert_eq!(points(&elements[1]).len(), 5, "a ring of walls is closed");
        let kinds: Vec<ElementKind> = elements.iter().map(|e| e.kind).collect();
        let (wall, floor) = (ElementKind::Wall, ElementKind::Floor);
        assert_eq!(kinds, [wall, wall, wall, ElementKind::Window, wall, floor, floor, floor, floor, wall]);
        assert_points(&elements[5], &[[4.5, 0.0], [4.5, 4.0], [3.5, 4.0], [3.5, 0.0]]);
        assert!(points(&elements[9]).iter().all(|[x, y]| ((x - 2.0).hypot(y - 2.0) - 0.27).abs() < 0.01), "an octagon");
    }

    #[test]
    fn stairs_and_lifts_belong_to_a_building_that_they_name_a_level_of() {
        let (building, _) = building(&with_corners(&[
            node(7, 6.0, 2.0, "highway=elevator,level=0;1"),
            node(8, 6.0, 2.0, "highway=elevator"),
            way(1, &[1, 2, 5, 6, 1], "indoor=room,level=0"),
            way(2, &[1, 2, 5, 6, 1], "indoor=room,stairs=yes,level=0-1"),
            way(3, &[1, 2, 5, 6, 1], "room=elevator,level=0"),
            way(4, &[1, 2], "highway=steps,level=0;1,width=1"),
            way(5, &[1, 2], "highway=steps"),
            way(6, &[1, 2, 5, 6, 1], "highway=steps,area=yes,indoor=yes,level=0"),
            way(7, &[1, 2, 5, 6, 1], "room=stairs,level=0"),
            way(8, &[3, 4], "highway=footway,indoor=yes,level=0"),
            way(9, &[2, 3, 4, 5, 2], "shop=books,door=yes,indoor=yes,level=0"),
            way(10, &[2, 3, 4, 5, 2], "highway=footway,indoor=yes,level=-1,width=1"),
        ]));
        let round_the_yard = &building.levels[0].elements;
        assert_eq!(round_the_yard.len(), 4 + 5, "a closed footway is a line");
        let building = Building { levels: building.levels[1..].to_vec(), ..building };
        let kinds: Vec<ElementKind> = building.levels[0].elements.iter().map(|e| e.kind).collect();
        let (stairs, lift, floor) = (ElementKind::Stairs, ElementKind::Lift, ElementKind::Floor);
        assert_eq!(kinds, [ElementKind::Room, stairs, lift, stairs, stairs, stairs, floor, floor, floor, floor, lift]);
        assert_points(&building.levels[0].elements[3], &[[0.0, -0.5], [4.0, -0.5], [4.0, 0.5], [0.0, 0.5]]);
        let above: Vec<ElementKind> = building.levels[1].elements.iter().map(|e| e.kind).collect();
        assert_eq!(above, [stairs, stairs, lift]);
        let joins = |at: usize| building.levels[0].elements[at].joins.as_slice();
        assert_eq!([joins(0), joins(1), joins(2), joins(3), joins(10)], [&[][..], &[0, 1], &[], &[0, 1], &[0, 1]]);
    }

    #[test]
    fn doors_lie_on_the_outline_that_they_are_part_of() {
        let (building, notes) = building(&with_corners(&[
            node(7, 4.0, 2.0, "door=hinged,width=0.9"),
            node(8, 2.0, 0.0, "entrance=main,level=0"),
            node(9, 3.9, 0.0, "door=no,width=1,level=1"),
            node(10, 6.0, 4.0, "window=yes,width=80 cm"),
            node(11, 20.0, 20.0, "door=yes,level=1"),
            node(12, 20.0, 20.0, "entrance=yes"),
            way(1, &[1, 8, 9, 2, 7, 5, 6, 1], "indoor=room,level=0-1"),
            way(2, &[7, 2, 3, 4, 10, 5, 7], "indoor=room,level=0"),
        ]));
        let ground = &building.levels[0].elements[2..];
        let kinds: Vec<ElementKind> = ground.iter().map(|e| e.kind).collect();
        assert_eq!(kinds, [ElementKind::Door, ElementKind::Door, ElementKind::Window], "one door in a wall of two rooms");
        assert_points(&ground[0], &[[2.0, 0.0]]);
        assert_points(&ground[1], &[[4.0, 1.55], [4.0, 2.0], [4.0, 2.45]]);
        assert_points(&ground[2], &[[6.4, 4.0], [6.0, 4.0], [5.6, 4.0]]);
        let above = &building.levels[1].elements[1..];
        assert_eq!(above.len(), 3, "{above:?}");
        // The door at the corner does not go round it.
        assert_points(&above[0], &[[3.4, 0.0], [3.9, 0.0], [4.0, 0.0]]);
        assert_points(&above[2], &[[20.0, 20.0]]);
        assert!(notes.iter().any(|n| n.contains("1 doors, entrances and windows")), "{notes:?}");
    }

    #[test]
    fn rings_of_several_ways_have_their_holes() {
        let hole = [(11, 1.0, 1.0), (12, 3.0, 1.0), (13, 3.0, 3.0)].map(|(id, x, y)| node(id, x, y, ""));
        let door = node(14, 3.0, 2.0, "door=yes");
        let (building, notes) = building(&with_corners(&[
            hole.concat(),
            door,
            way(1, &[1, 2, 5], ""),
            way(2, &[1, 6, 5], ""),
            way(3, &[11, 12, 14, 13, 11], ""),
            way(4, &[2, 3, 4, 5, 2], "indoor=area,level=2"),
            way(5, &[1, 3], ""),
            relation(9, &[(1, "outer"), (2, "outer"), (3, "inner"), (4, "outer"), (9, "inner")], "indoor=room,level=1,name=Atrium"),
            relation(10, &[(4, "outer")], ""),
            relation(11, &[(5, "outer"), (99, "outer")], "indoor=room"),
            "<relation id='12'><member type='relation' ref='12' role='outer'/><tag k='indoor' v='room'/></relation>".to_owned(),
        ]));
        assert_eq!(levels(&building), [(1, "1"), (2, "2")]);
        let [atrium, beside, door] = &building.levels[0].elements[..] else { panic!("{building:?}") };
        let Form::Area(rings) = &atrium.form else { panic!("{atrium:?}") };
        assert_eq!((rings.len(), rings[0].len(), rings[1].len()), (2, 4, 4));
        assert!(matches!(&beside.form, Form::Area(rings) if rings.len() == 1), "the hole is in one of them");
        assert_points(door, &[[3.0, 2.0]]);
        assert_eq!(short(&building.levels[1]), [(ElementKind::Floor, None)], "the way's tags count where a relation has none");
        assert!(notes.iter().any(|n| n.contains("not closed")), "{notes:?}");
    }

    #[test]
    fn what_is_deleted_or_missing_is_left_out_and_told() {
        let (building, notes) = building(&with_corners(&[
            "<node id='7' action='delete' lat='0' lon='0'><tag k='door' v='yes'/></node>".to_owned(),
            "<way id='1' visible='false'><nd ref='1'/><tag k='indoor' v='wall'/></way>".to_owned(),
            "<node id='77'/>".to_owned(),
            way(2, &[1, 77, 2, 5, 6, 78, 1], "indoor=room"),
            way(3, &[1, 2, 77, 5, 6], "indoor=wall,level=0"),
            way(4, &[1, 2], "indoor=wall,level=EG"),
        ]));
        assert_eq!(building.levels.len(), 1);
        let elements = &building.levels[0].elements;
        assert_eq!(elements.iter().map(|e| points(e).len()).collect::<Vec<_>>(), [4, 2, 2], "a wall is interrupted, a ring goes on");
        for told in ["2 nodes that are referred to", "1 objects name no level", "\"EG\""] {
            assert!(notes.iter().any(|note| note.contains(told)), "{told}: {notes:?}");
        }
    }

    #[test]
    fn roads_are_ground_where_there_are_no_rooms() {
        let roads = |more: &[String]| with_corners(&[corners_of_roads(), more.concat()]);
        let streets = [
            way(1, &[21, 22, 23], "highway=residential,lanes=2,name=Main Street"),
            way(2, &[22, 24], "highway=service,width=4"),
            way(3, &[21, 24], "highway=footway"),
            way(4, &[21, 24], "highway=residential,motor_vehicle=no"),
            way(5, &[1, 3, 4, 6, 1], "highway=service,area=yes"),
            way(6, &[1, 3, 4, 6, 1], "building=yes"),
        ];
        let (town, notes) = building(&roads(&streets));
        let elements = &town.levels[0].elements;
        // Two pieces and three joints, one piece and two joints, and a yard.
        assert_eq!(elements.len(), 5 + 3 + 1);
        assert!(elements.iter().all(|e| e.kind == ElementKind::Floor));
        assert_points(&elements[0], &[[0.0, -3.25], [100.0, -3.25], [100.0, 3.25], [0.0, 3.25]]);
        assert_eq!(elements[0].name.as_deref(), Some("Main Street"));
        assert!(notes.iter().any(|n| n.contains("3 ways for cars, 0.3 km")), "{notes:?}");
        let (park, notes) = building(&roads(&streets[2..3]));
        assert_eq!(park.levels[0].elements.len(), 3);
        assert!(notes.iter().any(|n| n.contains("on foot")), "{notes:?}");
        let (mall, notes) = building(&roads(&[streets.concat(), way(7, &[1, 2, 5, 6, 1], "indoor=room")]));
        assert_eq!(short(&mall.levels[0]), [(ElementKind::Room, None)]);
        assert!(notes.iter().any(|n| n.contains("3 roads around")), "{notes:?}");
    }

    fn corners_of_roads() -> String {
        [(21, 0.0, 0.0), (22, 100.0, 0.0), (23, 200.0, 0.0), (24, 100.0, 80.0)].map(|(id, x, y)| node(id, x, y, "")).concat()
    }

    #[test]
    fn the_date_line_is_no_edge() {
        let node = |id: i64, longitude: f64, latitude: f64| format!("<node id='{id}' lat='{latitude}' lon='{longitude}'/>");
        let (town, _) = building(&osm(&[node(1, 179.9999, 0.0), node(2, -179.9999, 0.0), way(1, &[1, 2], "highway=residential,width=2")]));
        assert_points(&town.levels[0].elements[0], &[[0.0, -1.0], [22.264, -1.0], [22.264, 1.0], [0.0, 1.0]]);
    }

    #[test]
    fn a_file_is_known_by_its_first_element() {
        for head in [
            "<osm>",
            "<osm/>",
            "\u{feff}<?xml version='1.0'?>\n<!-- an <html> comment -->\n<osm version=\"0.6\">\n <node",
            "<!DOCTYPE osm [<!ENTITY a 'b'>]><osm>",
        ] {
            assert!(is_one(head), "{head}");
        }
        for head in ["", "<", "<osm", "osm", "<osm-script>", "<svg><osm>", "<osmChange>", "{}", "<?xml version='1.0'?>", "<!-- <osm> "] {
            assert!(!is_one(head), "{head}");
        }
    }

    #[test]
    fn what_shows_nothing_is_refused_with_what_was_found() {
        let bare = with_corners(&[way(6, &[1, 3, 4, 6, 1], "building=yes"), way(7, &[1, 2], "indoor=room,level=x")]);
        let why = refusal(&bare);
        assert!(why.contains("6 nodes, 2 ways and 0 relations") && why.contains("building (1)"), "{why}");
        assert!(refusal("<osm/>").contains("nothing is tagged"));
    }

    #[test]
    fn what_is_broken_is_told_with_its_place() {
        let room = with_corners(&[way(1, &[1, 2, 5, 6, 1], "indoor=room")]);
        let inside = |part: &str| format!("<osm>\n  {part}</osm>");
        for (text, told) in [
            (room[..room.len() - 8].to_owned(), "too early"),
            (room[..room.len() - 25].to_owned(), "line 9, column"),
            (inside("<node id='1' lat='NaN' lon='0'/>"), "line 2, column 3: node 1"),
            (inside("<node id='1' lat='inf' lon='0'/>"), "no place"),
            (inside("<node id='1' lat='91' lon='0'/>"), "no place"),
            (inside("<node id='1' lon='0'/>"), "latitude nothing"),
            (inside("<node id='x' lat='0' lon='0'/>"), "no id"),
            (inside("<way id='1'><nd/></way>"), "no number"),
            (inside("<way id='1'><node id='2' lat='0' lon='0'/></way>"), "a node begins inside of object 1"),
            (inside("<node id='1' lat='0' lon='0'></way>"), "line 2"),
            (inside("<node id='1' lat=0 lon='0'/>"), "line 2"),
            (inside(&"<a>".repeat(100_000)), "33 deep"),
            ("<html><osm/></html>".to_owned(), "not <osm>"),
        ] {
            let why = refusal(&text);
            assert!(why.contains(told), "{told}: {why}");
        }
    }

    #[test]
    fn entities_of_the_file_are_not_expanded() {
        let bomb = "<!DOCTYPE osm [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;'>]>\n<osm>\n<way id='1'>\
                    <tag k='name' v='&b;'/></way></osm>";
        assert!(refusal(bomb).contains("line 3"), "{}", refusal(bomb));
        let (hall, _) = building(&with_corners(&[way(1, &[1, 2, 5, 6, 1], "indoor=room,name=A &amp; B")]));
        assert_eq!(hall.levels[0].elements[0].name.as_deref(), Some("A & B"));
    }

    #[test]
    fn a_room_on_too_many_levels_or_with_too_many_nodes_is_refused() {
        let long: Vec<i64> = (0..300_000).map(|k| 1 + k % 6).collect();
        let tower = with_corners(&[way(1, &[&long[..], &[1]].concat(), "indoor=room,level=0-199")]);
        assert!(refusal(&tower).contains("points to draw"), "{}", refusal(&tower));
        let spiral = with_corners(&[way(1, &long, "highway=service")]);
        assert!(refusal(&spiral).contains("points to draw"), "{}", refusal(&spiral));
    }

    proptest! {
        #[test]
        fn a_file_cut_off_or_garbled_is_read_or_refused(cut in 0usize..4000, at in 0usize..4000, byte in any::<u8>()) {
            let text = with_corners(&[
                node(7, 4.0, 2.0, "door=hinged,width=0.9"),
                way(1, &[1, 2, 7, 5, 6, 1], "indoor=room,level=0-1"),
                way(2, &[1, 3], "highway=steps,level=0"),
                relation(9, &[(1, "outer"), (1, "inner")], "indoor=room"),
            ]);
            let mut bytes = text.into_bytes();
            bytes.truncate(cut);
            let len = bytes.len().max(1);
            if let Some(garbled) = bytes.get_mut(at % len) {
                *garbled = byte;
            }
            let text = String::from_utf8_lossy(&bytes);
            if let Ok(building) = read(&text, &mut Vec::new()) {
                let mut points = building.levels.iter().flat_map(|l| &l.elements).flat_map(|e| e.form.points());
                prop_assert!(points.all(|p| p.x.is_finite() && p.y.is_finite()));
            }
        }
    }
}
