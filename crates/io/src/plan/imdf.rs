//! What is in an IMDF archive (OGC 20-094)? Rooms, doors and storeys, a GeoJSON file a type.
//!
//! archive ─▶ `unit`, `opening`, `level`, `relationship` (which storeys stairs and lifts join) ─▶ [`geojson::building`]
//!
//! Walls are not part of the format: the outlines of units less the openings are. Loose lines (`detail`), furniture (`fixture`,
//! `kiosk`) and what only names or groups others are left out.
//! Nothing is unpacked to disk, so that names that lead out of a folder lead nowhere; and no more than [`UNPACKED_MOST`] is unpacked.

use std::io::{Cursor, Read};

use geojson::{Feature, FeatureCollection};
use planwalk_types::Building;
use zip::ZipArchive;

use super::{PlanFileError, geojson as features};

/// Types that are read.
const TYPES: [&str; 4] = ["level", "unit", "opening", "relationship"];
/// Most bytes that all files together may unpack to: the largest airports have some 50 MB.
const UNPACKED_MOST: u64 = 256 << 20;

/// Whether a file that begins like this is an archive.
pub(super) fn is_one(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04")
}

/// Reads an archive.
pub(super) fn read(bytes: &[u8], notes: &mut Vec<String>) -> Result<Building, PlanFileError> {
    let refuse = |why: String| PlanFileError::Archive { why };
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|why| refuse(why.to_string()))?;
    let names: Vec<String> = archive.file_names().filter_map(|name| Some(name.ok()?.into_owned())).collect();
    let mut left = UNPACKED_MOST;
    let mut all: Vec<Feature> = Vec::new();
    for wanted in TYPES {
        let Some(name) = names.iter().find(|name| type_of(name) == Some(wanted)) else { continue };
        let entry = archive.by_name(name).map_err(|why| refuse(format!("{name}: {why}")))?;
        let mut text = String::new();
        // One byte more than there may be tells that there is more; what the archive says of sizes may be a lie.
        entry.take(left + 1).read_to_string(&mut text).map_err(|why| refuse(format!("{name}: {why}")))?;
        left = left.checked_sub(text.len() as u64).ok_or_else(|| refuse(format!("it unpacks to more than {} MB", UNPACKED_MOST >> 20)))?;
        features::check_size(&text)?;
        let collection: FeatureCollection =
            text.parse().map_err(|why: geojson::Error| PlanFileError::GeoJson { why: format!("{name}: {why}") })?;
        all.extend(collection.features);
    }
    if all.is_empty() {
        let some: Vec<&str> = names.iter().take(8).map(String::as_str).collect();
        let found = if some.is_empty() { "nothing".to_owned() } else { crate::text::short(&some.join(", ")) };
        return Err(refuse(format!("it holds no unit.geojson, opening.geojson or level.geojson, but {found}")));
    }
    // The format knows degrees only.
    features::building(&all, &features::Told { crs: Some("EPSG:4326".to_owned()), ..features::Told::default() }, notes)
}

/// Which type of feature a file of the archive holds; it may lie in a folder.
fn type_of(name: &str) -> Option<&'static str> {
    let file = name.rsplit(['/', '\\']).next()?.to_ascii_lowercase();
    TYPES.into_iter().find(|wanted| file.strip_suffix(".geojson") == Some(wanted) || file.strip_suffix(".json") == Some(wanted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Cell, ElementKind, Pt2};
    use std::io::Write;
    use zip::write::SimpleFileOptions;

    fn archive(files: &[(&str, &str)]) -> Vec<u8> {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, text) in files {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(text.as_bytes()).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    fn collection(features: &[&str]) -> String {
        format!("{{\"type\":\"FeatureCollection\",\"features\":[{}]}}", features.join(","))
    }

    /// Two rooms of 11.1 m × 11.1 m at the equator, one above the other on the map, a door between them; a lift; a storey above.
    fn venue() -> Vec<(&'static str, String)> {
        let unit = |category: &str, level: &str, y: f64| {
            let (a, b) = (y * 1e-4, (y + 1.0) * 1e-4);
            format!(
                "{{\"type\":\"Feature\",\"id\":\"u\",\"feature_type\":\"unit\",\"properties\":{{\"category\":\"{category}\",\"level_id\":\"{level}\",\
                 \"name\":{{\"en\":\"No. {y}\"}}}},\"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[[[0,{a}],[1e-4,{a}],[1e-4,{b}],[0,{b}],[0,{a}]]]}}}}"
            )
        };
        let level = |id: &str, name: &str, ordinal: i32| {
            format!(
                "{{\"type\":\"Feature\",\"id\":\"{id}\",\"feature_type\":\"level\",\"properties\":{{\"ordinal\":{ordinal},\
                 \"short_name\":{{\"en\":\"{name}\"}}}},\"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[1e-4,0],[1e-4,2e-4],[0,0]]]}}}}"
            )
        };
        let door = "{\"type\":\"Feature\",\"id\":\"o\",\"feature_type\":\"opening\",\"properties\":{\"category\":\"pedestrian\",\"level_id\":\"b\"},\
                    \"geometry\":{\"type\":\"LineString\",\"coordinates\":[[4e-5,1e-4],[6e-5,1e-4]]}}";
        let units = [unit("office", "b", 0.0), unit("room", "b", 1.0), unit("opentobelow", "a", 1.0), unit("elevator", "a", 0.0)];
        vec![
            ("manifest.json", "{\"version\":\"1.0.0\"}".to_owned()),
            ("venue/unit.geojson", collection(&units.each_ref().map(String::as_str))),
            ("venue/opening.geojson", collection(&[door])),
            ("venue/level.geojson", collection(&[&level("a", "Upper", 1), &level("b", "Street", 0)])),
            ("../../etc/detail.geojson", "not read".to_owned()),
        ]
    }

    fn packed(files: &[(&str, String)]) -> Vec<u8> {
        let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
        archive(&files)
    }

    #[test]
    fn storeys_rooms_and_doors_are_read() {
        let mut notes = Vec::new();
        let building = read(&packed(&venue()), &mut notes).unwrap();
        let names: Vec<(i32, &str)> = building.levels.iter().map(|level| (level.ordinal, level.name.as_str())).collect();
        assert_eq!(names, [(0, "Street"), (1, "Upper")]);
        assert_eq!(building.levels[0].elements[0].name.as_deref(), Some("No. 0"));
        let kinds: Vec<ElementKind> = building.levels[1].elements.iter().map(|e| e.kind).collect();
        assert_eq!(kinds, [ElementKind::Lift], "one does not walk on what is open to below");
        assert!(building.georeference.is_some());
        let plan = super::super::vector::draw(&building.levels[0].elements, &mut notes).unwrap();
        let at = |x, y| plan.at(Pt2::new(x, y));
        // A degree of latitude at the equator is 110.574 km, one of longitude 111.320 km.
        assert_eq!([at(5.5, 11.06), at(2.0, 11.06), at(5.5, 5.0)], [Cell::Door, Cell::Wall, Cell::Free]);
    }

    #[test]
    fn what_is_no_venue_or_unpacks_without_end_is_refused() {
        let error = |bytes: &[u8]| read(bytes, &mut Vec::new()).unwrap_err().to_string();
        let whole = packed(&venue());
        assert!(error(&whole[..whole.len() / 2]).contains("archive"), "{}", error(&whole[..whole.len() / 2]));
        assert!(error(&archive(&[("a.txt", "x")])).contains("a.txt"));
        assert!(error(&archive(&[])).contains("nothing"));
        assert!(error(&archive(&[("unit.geojson", "{\"type\":")])).contains("unit.geojson"));
        // 300 MB of spaces pack to 300 kB.
        let bomb = archive(&[("unit.geojson", &" ".repeat(300 << 20))]);
        assert!(bomb.len() < 1 << 20 && error(&bomb).contains("256 MB"), "{}", error(&bomb));
    }
}
