#![no_main]
//! Drawings in SVG.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "plan.svg", planwalk_fuzz::holds(bytes, b"<svg")) });
