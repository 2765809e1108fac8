#![no_main]
//! The native format, .plan.json.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "a.plan.json", planwalk_fuzz::holds(bytes, b"planwalk-plan/")) });
