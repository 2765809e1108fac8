//! Where may a car drive? Roads of a map as areas as wide as the roads are.
//!
//! highway=* ─▶ width by `width`, `lanes` or class ─▶ a rectangle for every straight piece, an octagon at every joint
//!
//! Cars are followed on such ground as people are between walls (Brubaker, Geiger & Urtasun 2013 do so on the roads' middle lines).
//! Pitfall: crossings on bridges are crossings here.

use planwalk_types::{Element, ElementKind, Form};

use super::super::PlanFileError;
use super::ground::{self, Ends, Ground};
use super::map::{Map, Tags, Way};

/// Width of a lane, metres.
const LANE_M: f64 = 3.25;
/// Most lanes that are believed.
const MOST_LANES: f64 = 20.0;
/// Classes of roads for cars, and their usual width in metres; a motorway's is that of one direction, as they are drawn.
const FOR_CARS: [(&str, f64); 16] = [
    ("motorway", 11.0),
    ("motorway_link", 5.0),
    ("trunk", 8.0),
    ("trunk_link", 5.0),
    ("primary", 7.5),
    ("primary_link", 5.0),
    ("secondary", 7.0),
    ("secondary_link", 5.0),
    ("tertiary", 6.5),
    ("tertiary_link", 5.0),
    ("unclassified", 5.5),
    ("residential", 5.5),
    ("road", 5.5),
    ("living_street", 5.0),
    ("service", 4.0),
    ("track", 3.0),
];
/// Ways for people on foot or by bicycle, likewise.
const FOR_PEOPLE: [(&str, f64); 7] =
    [("pedestrian", 5.0), ("footway", 2.0), ("cycleway", 2.0), ("path", 1.5), ("steps", 2.0), ("bridleway", 2.0), ("corridor", 2.0)];
/// Keys that say whether cars may use a way; the first one that is there counts.
const CAR_ACCESS: [&str; 4] = ["motorcar", "motor_vehicle", "vehicle", "access"];

/// Roads that cars may use.
pub(super) fn for_cars(map: &Map) -> impl Iterator<Item = &Way> {
    let may = |tags: &Tags| CAR_ACCESS.iter().find_map(|key| tags.get(key)) != Some("no");
    map.ways.iter().filter(move |way| class_width_m(&FOR_CARS, &way.tags).is_some() && may(&way.tags))
}

fn class_width_m(classes: &[(&str, f64)], tags: &Tags) -> Option<f64> {
    let class = tags.get("highway")?;
    classes.iter().find(|(name, _)| *name == class).map(|(_, width_m)| *width_m)
}

fn width_m(tags: &Tags) -> Option<f64> {
    let lanes = || tags.get("lanes")?.parse::<f64>().ok().filter(|lanes| (1.0..=MOST_LANES).contains(lanes));
    let usual = || class_width_m(&FOR_CARS, tags).or_else(|| class_width_m(&FOR_PEOPLE, tags));
    ground::width_m(tags).or_else(|| lanes().map(|lanes| lanes * LANE_M)).or_else(usual)
}

/// Draws the roads for cars, or the ways for people where there are none.
pub(super) fn draw(ground: &mut Ground, notes: &mut Vec<String>) -> Result<Vec<Element>, PlanFileError> {
    let map = ground.map;
    let mut users = "cars";
    let mut roads: Vec<&Way> = for_cars(map).collect();
    if roads.is_empty() {
        users = "people on foot";
        roads = map.ways.iter().filter(|way| class_width_m(&FOR_PEOPLE, &way.tags).is_some()).collect();
    }
    let (mut elements, mut length_m) = (Vec::new(), 0.0);
    for way in &roads {
        let Some(width_m) = width_m(&way.tags) else { continue };
        let rings = if way.is_closed() && way.tags.says("area") {
            ground.ring(&way.nodes)?.into_iter().collect()
        } else {
            let (rings, road_m) = ground.ribbon(&way.nodes, width_m, Ends::Round)?;
            length_m += road_m;
            rings
        };
        let class = way.tags.get("highway").unwrap_or_default();
        for ring in rings {
            let source = Some(format!("way {}, highway={class}", way.id));
            elements.push(Element { name: way.tags.label(), source, ..Element::new(ElementKind::Floor, Form::Area(vec![ring])) });
        }
    }
    if !elements.is_empty() {
        let (count, length_km) = (roads.len(), length_m / 1000.0);
        notes.push(format!(
            "the OpenStreetMap file shows no rooms (indoor=*), so its roads were read: {count} ways for {users}, {length_km:.1} km, \
             as wide as they are tagged or as their class usually is"
        ));
    }
    Ok(elements)
}
