#![no_main]
//! Drawings in DXF, as text or binary.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "plan.dxf", planwalk_fuzz::is_dxf(bytes)) });
