//! Things that tests need: data folders, and MP4 files made from scratch.

use std::path::{Path, PathBuf};

use openh264::OpenH264API;
use openh264::encoder::{Encoder, EncoderConfig, RateControlMode};
use openh264::formats::YUVBuffer;

/// A file of the real data; `None`, said on stderr, where there is none on this machine.
pub fn data(name: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let root = std::env::var_os("PLANWALK_DATA").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    let required = std::env::var("PLANWALK_REQUIRE_DATA").is_ok_and(|v| v == "1");
    assert!(!required, "PLANWALK_REQUIRE_DATA=1, but there is no {name} in {}", root.display());
    std::io::Write::write_all(&mut std::io::stderr(), format!("skipped: no {name}\n").as_bytes()).unwrap();
    None
}

/// What to write into an MP4.
pub struct Clip {
    pub width: usize,
    pub height: usize,
    /// Ticks for which each frame is shown.
    pub durations: Vec<u32>,
    pub ticks_per_s: u32,
    /// a, b, c, d of the display matrix.
    pub matrix: [i32; 4],
    /// Media time at which the edit begins, and pause before it in movie ticks of 1 ms.
    pub edit: Option<(i32, u32)>,
    /// Index before the pictures.
    pub index_first: bool,
}

impl Clip {
    pub fn of(width: usize, height: usize, durations: Vec<u32>) -> Self {
        Self { width, height, durations, ticks_per_s: 90_000, matrix: [1, 0, 0, 1], edit: None, index_first: true }
    }

    /// Brightness of frame `i` at a pixel: a bright block in the top left corner, and a ground that tells the frames apart.
    pub fn brightness(&self, i: usize, u: usize, v: usize) -> u8 {
        if u < self.width / 4 && v < self.height / 4 { 230 } else { 30 + 8 * (i % 16) as u8 }
    }

    pub fn write(&self, path: &Path) {
        let samples = self.encode();
        let ftyp = boxed(b"ftyp", &[b"isom\0\0\0\0isom"]);
        let mdat = boxed(b"mdat", &[&samples.iter().flat_map(|s| s.bytes.clone()).collect::<Vec<u8>>()]);
        let moov_len = self.moov(&samples, 0).len();
        let first_sample = ftyp.len() + 8 + if self.index_first { moov_len } else { 0 };
        let moov = self.moov(&samples, first_sample as u32);
        let parts = if self.index_first { [ftyp, moov, mdat] } else { [ftyp, mdat, moov] };
        std::fs::write(path, parts.concat()).unwrap();
    }

    fn encode(&self) -> Vec<Coded> {
        let config = EncoderConfig::new().skip_frames(false).rate_control_mode(RateControlMode::Off);
        let mut encoder = Encoder::with_api_config(OpenH264API::from_source(), config).unwrap();
        let chroma = vec![128; self.width * self.height / 2];
        let frame = |i: usize| {
            let luma = (0..self.width * self.height).map(|k| self.brightness(i, k % self.width, k / self.width));
            YUVBuffer::from_vec(luma.chain(chroma.iter().copied()).collect(), self.width, self.height)
        };
        (0..self.durations.len()).map(|i| Coded::from_annex_b(&encoder.encode(&frame(i)).unwrap().to_vec())).collect()
    }

    fn moov(&self, samples: &[Coded], first_sample: u32) -> Vec<u8> {
        let total: u32 = self.durations.iter().sum();
        let total_ms = (u64::from(total) * 1000 / u64::from(self.ticks_per_s)) as u32;
        let mvhd = boxed(b"mvhd", &[&[0; 12], &be(&[1000, total_ms]), &[0; 80]]);
        let [a, b, c, d] = self.matrix.map(|v| (v << 16).cast_unsigned());
        let size = [(self.width as u32) << 16, (self.height as u32) << 16];
        let matrix = [be(&[a, b, 0, c, d, 0, 0, 0, 1 << 30]), be(&size)].concat();
        let tkhd = boxed(b"tkhd", &[&be(&[3, 0, 0, 1, 0, total_ms, 0, 0, 0, 0]), &matrix]);
        let edits = self.edit.map_or(Vec::new(), |(from, pause_ms)| {
            let rows = [be(&[pause_ms, u32::MAX, 1 << 16]), be(&[total_ms, from.cast_unsigned(), 1 << 16])];
            boxed(b"edts", &[&boxed(b"elst", &[&be(&[0, 2]), &rows.concat()])])
        });
        let mdhd = boxed(b"mdhd", &[&be(&[0, 0, 0, self.ticks_per_s, total, 0])]);
        let hdlr = boxed(b"hdlr", &[&[0; 8], b"vide", &[0; 13]]);
        let stts: Vec<u8> = self.durations.iter().flat_map(|d| be(&[1, *d])).collect();
        let sizes: Vec<u32> = samples.iter().map(|s| s.bytes.len() as u32).collect();
        let count = samples.len() as u32;
        let stbl = boxed(
            b"stbl",
            &[
                &boxed(b"stsd", &[&be(&[0, 1]), &self.sample_entry(&samples[0])]),
                &boxed(b"stts", &[&be(&[0, count]), &stts]),
                &boxed(b"stsc", &[&be(&[0, 1, 1, count, 1])]),
                &boxed(b"stsz", &[&be(&[0, 0, count]), &be(&sizes)]),
                &boxed(b"stco", &[&be(&[0, 1, first_sample])]),
            ],
        );
        let mdia = boxed(b"mdia", &[&mdhd, &hdlr, &boxed(b"minf", &[&stbl])]);
        boxed(b"moov", &[&mvhd, &boxed(b"trak", &[&tkhd, &edits, &mdia])])
    }

    fn sample_entry(&self, first: &Coded) -> Vec<u8> {
        let set = |bytes: &[u8]| [&(bytes.len() as u16).to_be_bytes(), bytes].concat();
        let (sps, pps) = (&first.sps, &first.pps);
        let avcc = boxed(b"avcC", &[&[1, sps[1], sps[2], sps[3], 0xff, 0xe1], &set(sps), &[1], &set(pps)]);
        let size = [(self.width as u16).to_be_bytes(), (self.height as u16).to_be_bytes()].concat();
        boxed(b"avc1", &[&[0; 24], &size, &[0; 50], &avcc])
    }
}

struct Coded {
    bytes: Vec<u8>,
    sps: Vec<u8>,
    pps: Vec<u8>,
}

impl Coded {
    /// Start codes → lengths; parameter sets apart.
    fn from_annex_b(stream: &[u8]) -> Self {
        let mut coded = Self { bytes: Vec::new(), sps: Vec::new(), pps: Vec::new() };
        for unit in openh264::nal_units(stream) {
            let start = unit.iter().position(|b| *b == 1).unwrap() + 1;
            let unit = &unit[start..];
            match unit[0] & 0x1f {
                7 => coded.sps = unit.to_vec(),
                8 => coded.pps = unit.to_vec(),
                _ => coded.bytes.extend([&(unit.len() as u32).to_be_bytes(), unit].concat()),
            }
        }
        coded
    }
}

fn be(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_be_bytes()).collect()
}

fn boxed(name: &[u8; 4], parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    [&(body.len() as u32 + 8).to_be_bytes(), &name[..], &body].concat()
}
