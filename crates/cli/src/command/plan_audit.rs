//! How is it said what a plan amounts to, and what on it looks wrong? Lines for people, entries for `plan_info.json`.

use std::collections::{BTreeMap, BTreeSet};

use planwalk::plan_info::{
    BuildingEntry, ConnectionEntry, FindingEntry, GeoreferenceEntry, PassageEntry, RoomEntry, SideEntry, SourceEntry, StoreyEntry,
    WidthsEntry,
};
use planwalk::types::{Connection, ElementKind, Level, connections};
use planwalk_io::plan::audit::{self, Audit, End, FOUND, Finding};
use planwalk_io::plan::native::PlanDocument;
use planwalk_io::plan::provenance;

/// Findings of one kind that are told; `plan_info.json` has all.
const TOLD: usize = 8;
/// Rooms whose names are told.
const ROOMS_TOLD: usize = 5;

/// The building as `plan_info.json` has it; `storey` is the one that is looked at closely.
pub fn entry(document: &PlanDocument, audits: &[Audit], storey: String) -> BuildingEntry {
    let building = &document.building;
    let connection = |c: Connection| ConnectionEntry {
        kind: c.kind.word().to_owned(),
        name: c.name.clone(),
        ordinals: c.ordinals,
        at_m: [c.at.x, c.at.y],
    };
    BuildingEntry {
        format: document.source.format.clone(),
        metres_per_unit: document.source.metres_per_unit,
        scale_from: document.source.scale_from.clone(),
        georeference: building.georeference.map(|place| GeoreferenceEntry {
            longitude_deg: place.longitude_deg,
            latitude_deg: place.latitude_deg,
            bearing_rad: place.bearing_rad,
            anchor_m: [place.anchor.x, place.anchor.y],
            scale: place.scale,
        }),
        storey,
        storeys: building.levels.iter().zip(audits).map(|(level, audit)| storey_entry(level, audit)).collect(),
        connections: connections(building).into_iter().map(connection).collect(),
        sources: provenance(building).into_iter().map(|(source, shapes)| SourceEntry { source, shapes }).collect(),
    }
}

fn storey_entry(level: &Level, audit: &Audit) -> StoreyEntry {
    let mut elements = BTreeMap::new();
    for element in level.elements.iter().filter(|e| e.source.as_deref() != Some(FOUND)) {
        *elements.entry(element.kind.word().to_owned()).or_insert(0) += 1;
    }
    let mut leads_to: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for passage in &audit.passages {
        if let [End::Room(a), End::Room(b)] = passage.ends {
            leads_to.entry(a).or_default().insert(b);
            leads_to.entry(b).or_default().insert(a);
        }
    }
    let room = |(n, room): (usize, &audit::Room)| RoomEntry {
        name: room.element.name.clone(),
        area_m2: room.area_m2,
        at_m: [room.at.x, room.at.y],
        found: room.element.source.as_deref() == Some(FOUND),
        leads_to: leads_to.get(&n).into_iter().flatten().copied().collect(),
    };
    let side = |end: End| match end {
        End::Room(n) => SideEntry::Room(n),
        End::Ground => SideEntry::Other("ground".to_owned()),
        End::Outdoors => SideEntry::Other("outdoors".to_owned()),
    };
    let passage =
        |p: &audit::Passage| PassageEntry { between: p.ends.map(side), at_m: [p.at.x, p.at.y], width_m: p.width_m, door: p.is_door };
    let finding = |finding: &Finding| FindingEntry {
        kind: finding.kind().to_owned(),
        at_m: finding.at().map(|at| [at.x, at.y]),
        figures: finding.figures().into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
        says: finding.to_string(),
        remedy: finding.remedy(),
    };
    StoreyEntry {
        ordinal: level.ordinal,
        name: level.name.clone(),
        elements,
        rooms: audit.rooms.iter().enumerate().map(room).collect(),
        passages: audit.passages.iter().map(passage).collect(),
        widths: audit.widths.map(|w| WidthsEntry {
            are_doors: w.are_doors,
            count: w.count,
            median_m: w.median_m,
            p10_m: w.p10_m,
            p90_m: w.p90_m,
        }),
        findings: audit.findings.iter().map(finding).collect(),
    }
}

/// The building in lines.
pub fn describe(building: &BuildingEntry) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(from) = &building.scale_from {
        let unit = building.metres_per_unit.map_or_else(String::new, |m| format!(", {m} m a unit"));
        lines.push(format!("scale from {from}{unit}"));
    }
    if let Some(place) = &building.georeference {
        let bearing = place.bearing_rad.to_degrees();
        lines.push(format!(
            "(0, 0) lies at {:.6}°, {:.6}° (longitude, latitude); up is {bearing:.1}° from north",
            place.longitude_deg, place.latitude_deg
        ));
    }
    for storey in &building.storeys {
        lines.extend(storey_lines(storey));
    }
    for connection in &building.connections {
        let ordinals: Vec<String> = connection.ordinals.iter().map(ToString::to_string).collect();
        let name = connection.name.as_deref().map_or_else(String::new, |name| format!(" {name}"));
        let joins = if ordinals.len() > 1 {
            format!("joins storeys {}", ordinals.join(", "))
        } else {
            format!("is on storey {} only", ordinals.join(""))
        };
        let [x, y] = connection.at_m;
        lines.push(format!("{}{name} at ({x:.1}, {y:.1}) m {joins}", connection.kind));
    }
    lines
}

fn storey_lines(storey: &StoreyEntry) -> Vec<String> {
    let counts: Vec<String> =
        ElementKind::ALL.iter().filter_map(|kind| storey.elements.get(kind.word()).map(|count| plural(*count, kind.word()))).collect();
    let mut lines = vec![format!("storey {} ({}): {}", storey.name, storey.ordinal, counts.join(", "))];
    let areas: Vec<f64> = storey.rooms.iter().map(|room| room.area_m2).collect();
    lines.extend(rooms_line(
        &areas,
        &storey.rooms.iter().map(|room| room.name.as_deref()).collect::<Vec<_>>(),
        storey.rooms.iter().any(|r| r.found),
    ));
    let doors = storey.passages.iter().filter(|p| p.door).count();
    if !storey.passages.is_empty() {
        lines.push(format!("  {} and {} between rooms, or out", plural(doors, "door"), plural(storey.passages.len() - doors, "opening")));
    }
    lines.extend(storey.widths.map(|w| {
        let what = if w.are_doors { "door" } else { "opening between rooms" };
        format!("  {}: median {:.2} m, 10 to 90 % {:.2} to {:.2} m", plural(w.count, what), w.median_m, w.p10_m, w.p90_m)
    }));
    let findings: Vec<(&str, String)> = storey.findings.iter().map(|f| (f.kind.as_str(), format!("{}: {}", f.says, f.remedy))).collect();
    lines.extend(numbered(&findings));
    lines
}

/// How many rooms, how large, and what the largest are called.
fn rooms_line(areas: &[f64], names: &[Option<&str>], found: bool) -> Option<String> {
    let mut largest: Vec<usize> = (0..areas.len()).collect();
    largest.sort_by(|a, b| areas[*b].total_cmp(&areas[*a]));
    let median = areas.get(*largest.get(largest.len() / 2)?)?;
    let named = names.iter().flatten().count();
    let told: Vec<String> =
        largest.iter().take(ROOMS_TOLD).map(|n| format!("{} {:.1} m²", names[*n].unwrap_or("unnamed"), areas[*n])).collect();
    let how = if found { " found between the walls" } else { "" };
    Some(format!(
        "  {}{how}, {:.0} m² in all, median {median:.1} m², {named} named; the largest: {}",
        plural(areas.len(), "room"),
        areas.iter().sum::<f64>(),
        told.join(", ")
    ))
}

/// Findings with their numbers; of many of one kind the first.
fn numbered(findings: &[(&str, String)]) -> Vec<String> {
    let mut lines = Vec::new();
    let mut number = 0;
    for alike in findings.chunk_by(|a, b| a.0 == b.0) {
        for (kind, words) in alike.iter().take(TOLD) {
            number += 1;
            lines.push(format!("  finding {number} ({kind}) {words}"));
        }
        let more = alike.len().saturating_sub(TOLD);
        if more > 0 {
            number += more;
            lines.push(format!("  and {more} more of this kind; plan info --json lists all"));
        }
    }
    lines
}

/// What looks wrong on a storey.
pub fn findings(audit: &Audit) -> Vec<String> {
    let all: Vec<(&str, String)> = audit.findings.iter().map(|f| (f.kind(), format!("{f}: {}", f.remedy()))).collect();
    numbered(&all)
}

/// What `plan import` says of rooms and findings, storey by storey.
pub fn notes(document: &PlanDocument, audits: &[Audit]) -> Vec<String> {
    let mut notes = Vec::new();
    for (level, audit) in document.building.levels.iter().zip(audits) {
        let areas: Vec<f64> = audit.rooms.iter().map(|room| room.area_m2).collect();
        let names: Vec<Option<&str>> = audit.rooms.iter().map(|room| room.element.name.as_deref()).collect();
        let found = audit.rooms.iter().any(|room| room.element.source.as_deref() == Some(FOUND));
        let lines = rooms_line(&areas, &names, found).into_iter().chain(findings(audit));
        notes.extend(lines.map(|line| format!("storey {}: {}", level.name, line.trim_start())));
    }
    notes
}

fn plural(count: usize, word: &str) -> String {
    let (first, rest) = word.split_once(' ').map_or((word, String::new()), |(first, rest)| (first, format!(" {rest}")));
    let ending = if count == 1 || first.ends_with('s') { "" } else { "s" };
    format!("{count} {first}{ending}{rest}")
}
