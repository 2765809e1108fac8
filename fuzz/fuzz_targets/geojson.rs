#![no_main]
//! Features in GeoJSON.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus {
    planwalk_fuzz::read(bytes, "plan.geojson", bytes.starts_with(b"{") && !planwalk_fuzz::holds(bytes, b"planwalk-plan"))
});
