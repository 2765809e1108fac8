#![no_main]
//! Venues in IMDF: a zip archive of GeoJSON files.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "venue.zip", bytes.starts_with(b"PK")) });
