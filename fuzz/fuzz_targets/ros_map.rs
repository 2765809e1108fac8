#![no_main]
//! A robot's map.yaml beside a small picture.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "map.yaml", true) });
