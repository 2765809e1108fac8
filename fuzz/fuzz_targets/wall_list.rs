#![no_main]
//! Lists of walls, CSV.

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus { planwalk_fuzz::read(bytes, "walls.csv", !bytes.starts_with(b"{") && !bytes.starts_with(b"<")) });
