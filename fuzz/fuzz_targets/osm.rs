#![no_main]
//! Maps of OpenStreetMap.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "plan.osm", planwalk_fuzz::holds(bytes, b"<osm")) });
