#![no_main]
//! Drawings and scans in PDF.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "plan.pdf", planwalk_fuzz::holds(bytes, b"%PDF-")) });
