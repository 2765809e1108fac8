#![no_main]
//! Bare pictures: PNG, JPEG, TIFF, WebP, BMP, PGM.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "plan.png", planwalk_fuzz::is_picture(bytes)) });
