//! What does a reader of plans do with a hostile file? It reads or refuses it: in bounded time and memory, and without a panic.
//!
//! bytes ─▶ a file ─▶ [`plan::import`] ─▶ shapes ─▶ every export; `.plan.json` comes back the same; small floors become cells
//!
//! Readers know formats by content. A target turns away what is plainly of another one's, so that each learns its own.

use std::path::PathBuf;
use std::sync::OnceLock;

use libfuzzer_sys::Corpus;
use planwalk_io::plan::native::{self, PlanDocument};
use planwalk_io::plan::{self, PlanOptions, export};
use planwalk_types::{Building, Form, Level};

/// Bytes in which a format shows, as readers look at them.
const LOOKED_AT: usize = 4096;
/// Metres of a pixel of a picture, and of a unit of a drawing.
const METRES_PER_PIXEL: f64 = 0.05;
/// Floors up to this width are drawn as cells; wider ones take long, and do the same.
const DRAWN_M: f64 = 60.0;
/// A picture for maps that name one: 4 × 3 pixels of wall, unknown and free.
const MAP_PGM: &[u8] = b"P5\n4 3\n255\n\x50\x00\x00\x00\x00\xfe\xfe\x00\x00\xcd\xfe\x00";

/// Whether these words are in the beginning of the file.
pub fn holds(bytes: &[u8], words: &[u8]) -> bool {
    bytes.get(..LOOKED_AT).unwrap_or(bytes).windows(words.len()).any(|window| window == words)
}

/// Whether a file begins like a picture.
pub fn is_picture(bytes: &[u8]) -> bool {
    let begins: [&[u8]; 8] = [b"\x89PNG", b"\xff\xd8", b"II", b"MM", b"RIFF", b"BM", b"P", b"GIF"];
    begins.iter().any(|begin| bytes.starts_with(begin)) && !bytes.starts_with(b"PK")
}

/// Whether a file begins like a DXF.
pub fn is_dxf(bytes: &[u8]) -> bool {
    holds(bytes, b"SECTION") || bytes.starts_with(b"AutoCAD Binary DXF")
}

/// A folder of this process alone, with a picture for maps.
fn folder() -> &'static PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        // hayro's own panics are caught, and its file refused: they are no find. Those that get out still end the run.
        std::panic::set_hook(Box::new(|what| eprintln!("{what}")));
        let folder = std::env::temp_dir().join(format!("planwalk-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for the files");
        std::fs::write(folder.join("map.pgm"), MAP_PGM).expect("a picture for the maps");
        folder
    })
}

/// Reads bytes as a file of this name, and does with the plan what can be done with it.
pub fn read(bytes: &[u8], name: &str, mine: bool) -> Corpus {
    if !mine {
        return Corpus::Reject;
    }
    let path = folder().join(name);
    std::fs::write(&path, bytes).expect("the file is written");
    for metres_per_pixel in [None, Some(METRES_PER_PIXEL)] {
        let options = PlanOptions { metres_per_pixel, ..PlanOptions::default() };
        let Ok(document) = plan::import(&path, &options) else { continue };
        hand_on(&document);
        if width_m(&document.building) <= DRAWN_M {
            // A refusal is an answer, too.
            let _ = plan::read(&path, &options);
        }
        break;
    }
    Corpus::Keep
}

/// Every way out, and the native one back.
fn hand_on(document: &PlanDocument) {
    for level in &document.building.levels {
        let _ = (export::svg(level), export::geojson(level), export::csv(level));
        if let Some(place) = &document.building.georeference {
            let _ = export::geojson_on_globe(level, place);
        }
    }
    let text = native::write(document);
    let path = folder().join("again.plan.json");
    std::fs::write(&path, &text).expect("the plan is written");
    let again = plan::import(&path, &PlanOptions::default()).expect("what is written can be read");
    assert_eq!(native::write(&again), text, "what is read is written the same");
}

/// The longer side of all storeys, metres; infinite where a number is none.
fn width_m(building: &Building) -> f64 {
    let forms = || building.levels.iter().flat_map(|level: &Level| &level.elements).map(|element| &element.form);
    let side = |of: fn(&Form) -> Vec<f64>| {
        let (low, high) = forms().flat_map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if forms().flat_map(of).all(f64::is_finite) { (high - low).max(0.0) } else { f64::INFINITY }
    };
    side(|form| form.points().map(|p| p.x).collect()).max(side(|form| form.points().map(|p| p.y).collect()))
}
