//! Where in an MP4/MOV file does each picture lie, and when is it shown? (ISO/IEC 14496-12, 14496-15; QuickTime.)
//!
//! file ─▶ `moov` box ─▶ first video track ─▶ sizes × chunks × times × edit list ─▶ [`Sample`]s in decoding order
//!
//! Hand-written because the file is not trusted: nothing is allocated from a number in the file before it is compared with
//! the bytes that are really there, and only the index is held in memory, never the pictures.
//! Pitfall: decoding order is not showing order (B-frames), and an edit list may shift or cut the beginning.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use planwalk_types::Stamp;

use super::rotate::Turn;
use super::{VideoError, fragments};

/// Largest index taken: ten hours of video have some 20 MB.
const INDEX_LIMIT: u64 = 256 << 20;
/// Most samples taken: 46 hours at 30 per second. Bounds the memory of tables that are given as "n times the same".
pub(super) const SAMPLE_LIMIT: usize = 5_000_000;

/// What to know of a file before decoding it.
pub(super) struct Index {
    pub codec: Codec,
    pub turn: Turn,
    pub samples: Vec<Sample>,
    pub file_len: u64,
    pub notes: Vec<String>,
}

/// How the pictures are coded.
#[derive(Debug, Clone)]
pub(super) enum Codec {
    H264(AvcConfig),
    Other(String),
}

/// The decoder's set-up (`avcC`).
#[derive(Debug, Clone, Default)]
pub(super) struct AvcConfig {
    pub profile: u8,
    /// Bytes of each length field: 1, 2 or 4.
    pub length_bytes: usize,
    /// Sequence and picture parameter sets.
    pub parameter_sets: Vec<Vec<u8>>,
}

impl AvcConfig {
    /// Baseline, main and high profile: 8 bit, 4:2:0. Zero stands for a track that keeps its set-up among the pictures.
    pub fn built_in_decodes(&self) -> bool {
        matches!(self.profile, 0 | 66 | 77 | 100)
    }
}

/// One coded picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub offset: u64,
    pub size: u32,
    /// Showing time in the track's ticks: orders the pictures.
    pub shown_tick: i64,
    /// When it is shown; `None` where the edit list cuts it away, but others may need it.
    pub stamp: Option<Stamp>,
}

impl Index {
    pub fn read(mut file: File) -> Result<Self, VideoError> {
        let file_len = file.metadata()?.len();
        let (moov, fragment_boxes) = top_level(&mut file, file_len)?;
        let movie_timescale = child(&moov, b"mvhd").and_then(timescale).unwrap_or(1000);
        let trak = Boxes(&moov).filter(|(name, _)| *name == b"trak").map(|(_, body)| body).find(|trak| is_video(trak));
        let trak = trak.ok_or(VideoError::NoVideoTrack)?;
        let mdia = child(trak, b"mdia").ok_or_else(|| damaged("the video track has no media"))?;
        let ticks_per_s = child(mdia, b"mdhd").and_then(timescale).ok_or_else(|| damaged("the video track has no clock"))?;
        let stbl = child(mdia, b"minf").and_then(|minf| child(minf, b"stbl")).ok_or_else(|| damaged("the video track has no tables"))?;
        let tkhd = child(trak, b"tkhd").unwrap_or(&[]);
        let (turn, mut notes) = turn_of(tkhd);
        let mut pictures = pictures(stbl, file_len)?;
        if let Some(track_id) = track_id(tkhd) {
            fragments::append(&mut pictures, track_id, &moov, &fragment_boxes)?;
        }
        let edits = Edits::read(trak, movie_timescale, ticks_per_s);
        if edits.0.len() > 1 {
            notes.push(format!("the clip is cut from {} pieces by its edit list", edits.0.len()));
        }
        let samples = pictures
            .iter()
            .map(|p| Sample { offset: p.offset, size: p.size, shown_tick: p.shown_tick, stamp: edits.stamp(p.shown_tick, ticks_per_s) })
            .collect();
        Ok(Self { codec: codec(stbl)?, turn, samples, file_len, notes })
    }
}

impl Index {
    /// How many pictures are shown.
    pub fn shown(&self) -> usize {
        self.samples.iter().filter(|s| s.stamp.is_some()).count()
    }
}

pub(super) fn damaged(reason: &str) -> VideoError {
    VideoError::Damaged { reason: reason.to_owned() }
}

/// A coded picture before the edit list is applied.
#[derive(Debug, Clone, Copy)]
pub(super) struct Picture {
    pub offset: u64,
    pub size: u32,
    pub shown_tick: i64,
}

/// Bodies of fragments (`moof`) with the position of their boxes.
pub(super) type FragmentBoxes = Vec<(u64, Vec<u8>)>;

/// The body of the `moov` box, and those of the fragments.
fn top_level(file: &mut File, file_len: u64) -> Result<(Vec<u8>, FragmentBoxes), VideoError> {
    let (mut moov, mut fragments, mut held) = (None, Vec::new(), 0);
    let mut at = 0;
    while let Some((name, header, size)) = box_header(file, at, file_len)? {
        if name == *b"moov" || name == *b"moof" {
            held += size;
            if held > INDEX_LIMIT {
                return Err(damaged(&format!("its index has over {} MB", INDEX_LIMIT >> 20)));
            }
            if at + size > file_len {
                // A fragment that was being written when the recording stopped: those before it are good.
                break;
            }
            let mut body = vec![0; (size - header) as usize];
            file.seek(SeekFrom::Start(at + header))?;
            file.read_exact(&mut body)?;
            if name == *b"moov" {
                moov = Some(body);
            } else {
                fragments.push((at, body));
            }
        }
        at = at.saturating_add(size);
    }
    Ok((moov.ok_or(VideoError::NoIndex)?, fragments))
}

/// Name, length of the header and of the whole box at this position; `None` where the file ends.
fn box_header(file: &mut File, at: u64, file_len: u64) -> Result<Option<([u8; 4], u64, u64)>, VideoError> {
    if at.saturating_add(8) > file_len {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(at))?;
    let mut head = Vec::with_capacity(16);
    file.take(16).read_to_end(&mut head)?;
    let (Some(size), Some(name)) = (u32_at(&head, 0), head.get(4..8)) else { return Ok(None) };
    let name = [name[0], name[1], name[2], name[3]];
    let (header, size) = match size {
        0 => (8, file_len - at),
        1 => match u64_at(&head, 8) {
            Some(size) => (16, size),
            None => return Ok(None),
        },
        size => (8, u64::from(size)),
    };
    if size < header {
        return Err(damaged(&format!("the box at byte {at} says it is {size} bytes long")));
    }
    Ok(Some((name, header, size)))
}

/// The boxes inside a box: name and body. Ends at the first one that does not fit.
pub(super) struct Boxes<'a>(pub &'a [u8]);

impl<'a> Iterator for Boxes<'a> {
    type Item = (&'a [u8; 4], &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let size = u32_at(self.0, 0)? as usize;
        let name = self.0.get(4..8)?.try_into().ok()?;
        let (header, size) = match size {
            0 => (8, self.0.len()),
            1 => (16, usize::try_from(u64_at(self.0, 8)?).ok()?),
            size => (8, size),
        };
        let body = self.0.get(header..size)?;
        self.0 = &self.0[size..];
        Some((name, body))
    }
}

/// The first box of this name.
pub(super) fn child<'a>(body: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    Boxes(body).find(|(n, _)| *n == name).map(|(_, body)| body)
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_be_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

fn i32_at(bytes: &[u8], at: usize) -> Option<i32> {
    u32_at(bytes, at).map(u32::cast_signed)
}

/// Ticks per second of an `mvhd` or `mdhd` box; never zero.
fn timescale(header: &[u8]) -> Option<u32> {
    let at = if *header.first()? == 1 { 20 } else { 12 };
    u32_at(header, at).filter(|ticks| *ticks > 0)
}

fn is_video(trak: &[u8]) -> bool {
    child(trak, b"mdia").and_then(|mdia| child(mdia, b"hdlr")).and_then(|hdlr| hdlr.get(8..12)) == Some(b"vide")
}

fn track_id(tkhd: &[u8]) -> Option<u32> {
    u32_at(tkhd, if *tkhd.first()? == 1 { 20 } else { 12 })
}

/// The turn that the display matrix asks for: x' = a·x + c·y, y' = b·x + d·y, y down.
fn turn_of(tkhd: &[u8]) -> (Turn, Vec<String>) {
    let at = if tkhd.first() == Some(&1) { 52 } else { 40 };
    let entry = |k: usize| i32_at(tkhd, at + 4 * k).map(|v| f64::from(v) / 65536.0);
    let (Some(a), Some(b), Some(c), Some(d)) = (entry(0), entry(1), entry(3), entry(4)) else { return (Turn::None, Vec::new()) };
    let turn = Turn::from_clockwise_deg(b.atan2(a).to_degrees());
    let mirrored = a * d - b * c < 0.0;
    let note = "the video is marked as mirrored; the mark is not applied, text in it should be readable".to_owned();
    (if mirrored { Turn::None } else { turn }, if mirrored { vec![note] } else { Vec::new() })
}

fn codec(stbl: &[u8]) -> Result<Codec, VideoError> {
    let stsd = child(stbl, b"stsd").ok_or_else(|| damaged("the video track does not say how it is coded"))?;
    let (name, entry) = Boxes(stsd.get(8..).unwrap_or(&[])).next().ok_or_else(|| damaged("the video track's coding is not described"))?;
    Ok(match name {
        b"avc1" | b"avc3" => {
            // 78 bytes of a visual sample entry stand before its boxes.
            let config = entry.get(78..).and_then(|boxes| child(boxes, b"avcC"));
            let config = config.and_then(avc_config).ok_or_else(|| damaged("the H.264 set-up (avcC) is missing or cut off"))?;
            Codec::H264(config)
        }
        b"hvc1" | b"hev1" | b"dvh1" | b"dvhe" => Codec::Other("HEVC (H.265)".to_owned()),
        b"av01" => Codec::Other("AV1".to_owned()),
        b"vp08" | b"vp09" => Codec::Other("VP8 or VP9".to_owned()),
        b"mp4v" => Codec::Other("MPEG-4 part 2".to_owned()),
        b"jpeg" | b"mjpa" | b"mjpb" => Codec::Other("Motion JPEG".to_owned()),
        b"apcn" | b"apch" | b"apcs" | b"apco" | b"ap4h" | b"ap4x" => Codec::Other("ProRes".to_owned()),
        b"encv" => Codec::Other("encrypted".to_owned()),
        other => Codec::Other(format!("coded as \"{}\"", other.escape_ascii())),
    })
}

fn avc_config(avcc: &[u8]) -> Option<AvcConfig> {
    let mut config = AvcConfig { profile: *avcc.get(1)?, length_bytes: usize::from(avcc.get(4)? & 3) + 1, ..AvcConfig::default() };
    let mut at = 5;
    for mask in [0x1f, 0xff] {
        let count = avcc.get(at)? & mask;
        at += 1;
        for _ in 0..count {
            let length = usize::from(u16::from_be_bytes(avcc.get(at..at + 2)?.try_into().ok()?));
            config.parameter_sets.push(avcc.get(at + 2..at + 2 + length)?.to_vec());
            at += 2 + length;
        }
    }
    if config.parameter_sets.is_empty() {
        config.profile = 0;
    }
    Some(config)
}

/// A table of a full box: version and flags, a count, then rows of `N` numbers; as many as are really there.
fn rows<const N: usize>(table: &[u8]) -> impl Iterator<Item = [u32; N]> + '_ {
    let count = u32_at(table, 4).unwrap_or(0) as usize;
    table.get(8..).unwrap_or(&[]).chunks_exact(4 * N).take(count).map(|row| std::array::from_fn(|k| u32_at(row, 4 * k).unwrap_or(0)))
}

/// All pictures of the index, in decoding order.
fn pictures(stbl: &[u8], file_len: u64) -> Result<Vec<Picture>, VideoError> {
    let table = |name| child(stbl, name).unwrap_or(&[]);
    let sizes = sizes(table(b"stsz"), file_len);
    if sizes.len() > SAMPLE_LIMIT {
        return Err(damaged(&format!("its index lists over {SAMPLE_LIMIT} frames")));
    }
    let mut times = Times::new(table(b"stts"), table(b"ctts"));
    let mut offsets = Offsets::new(table(b"stsc"), table(b"stco"), table(b"co64"));
    let mut pictures = Vec::with_capacity(sizes.len());
    for (i, size) in sizes.iter().enumerate() {
        let short = |what: &str| damaged(&format!("its table of {what} ends after {i} of {} frames", sizes.len()));
        let offset = offsets.next(u64::from(*size)).ok_or_else(|| short("places"))?;
        let shown_tick = times.next().ok_or_else(|| short("times"))?;
        pictures.push(Picture { offset, size: *size, shown_tick });
    }
    Ok(pictures)
}

fn sizes(stsz: &[u8], file_len: u64) -> Vec<u32> {
    let (uniform, count) = (u32_at(stsz, 4).unwrap_or(0), u32_at(stsz, 8).unwrap_or(0) as usize);
    if uniform > 0 {
        // No more samples than the file has room for, and one more, so that a cut-off file is noticed.
        let room = usize::try_from(file_len / u64::from(uniform) + 1).unwrap_or(usize::MAX);
        return vec![uniform; count.min(room).min(SAMPLE_LIMIT + 1)];
    }
    stsz.get(12..).unwrap_or(&[]).chunks_exact(4).take(count.min(SAMPLE_LIMIT + 1)).map(|row| u32_at(row, 0).unwrap_or(0)).collect()
}

/// Showing times: decoding times are sums of durations, to which an offset is added.
struct Times {
    durations: Vec<[u32; 2]>,
    offsets: Vec<[u32; 2]>,
    decode_tick: i64,
}

impl Times {
    fn new(stts: &[u8], ctts: &[u8]) -> Self {
        // Reversed, so that the current run is popped from the end.
        let runs = |table| {
            let mut runs: Vec<[u32; 2]> = rows::<2>(table).filter(|run| run[0] > 0).collect();
            runs.reverse();
            runs
        };
        Self { durations: runs(stts), offsets: runs(ctts), decode_tick: 0 }
    }

    fn next(&mut self) -> Option<i64> {
        let duration = take_of_run(&mut self.durations)?;
        // Version 0 says unsigned, but writers put negative offsets there too; none is over 2^31 in earnest.
        let offset = take_of_run(&mut self.offsets).map_or(0, |v| i64::from(v.cast_signed()));
        let shown = self.decode_tick.saturating_add(offset);
        self.decode_tick = self.decode_tick.saturating_add(i64::from(duration));
        Some(shown)
    }
}

fn take_of_run(runs: &mut Vec<[u32; 2]>) -> Option<u32> {
    let run = runs.last_mut()?;
    let value = run[1];
    run[0] -= 1;
    if run[0] == 0 {
        runs.pop();
    }
    Some(value)
}

/// Places in the file: samples lie one after the other in chunks.
struct Offsets {
    /// (first chunk, samples per chunk), chunks counted from 1.
    runs: Vec<[u32; 3]>,
    chunks: Vec<u64>,
    run: usize,
    chunk: usize,
    left_in_chunk: u32,
    at: u64,
}

impl Offsets {
    fn new(stsc: &[u8], stco: &[u8], co64: &[u8]) -> Self {
        let mut chunks: Vec<u64> = rows::<1>(stco).map(|row| u64::from(row[0])).collect();
        if chunks.is_empty() {
            chunks = rows::<2>(co64).map(|row| u64::from(row[0]) << 32 | u64::from(row[1])).collect();
        }
        Self { runs: rows(stsc).collect(), chunks, run: 0, chunk: 0, left_in_chunk: 0, at: 0 }
    }

    fn next(&mut self, size: u64) -> Option<u64> {
        while self.left_in_chunk == 0 {
            self.at = *self.chunks.get(self.chunk)?;
            self.chunk += 1;
            while self.runs.get(self.run + 1).is_some_and(|run| run[0] as usize <= self.chunk) {
                self.run += 1;
            }
            self.left_in_chunk = self.runs.get(self.run)?[1];
        }
        self.left_in_chunk -= 1;
        let at = self.at;
        self.at = self.at.saturating_add(size);
        Some(at)
    }
}

/// Which stretch of the media is shown when (`elst`).
struct Edits(Vec<Edit>);

struct Edit {
    /// Where it begins in the presentation, seconds.
    start_s: f64,
    from_tick: i64,
    /// Tick after the last one; [`i64::MAX`] where the edit has no end.
    to_tick: i64,
}

impl Edits {
    fn read(trak: &[u8], movie_timescale: u32, ticks_per_s: u32) -> Self {
        let elst = child(trak, b"edts").and_then(|edts| child(edts, b"elst")).unwrap_or(&[]);
        let wide = elst.first() == Some(&1);
        let count = u32_at(elst, 4).unwrap_or(0) as usize;
        let (mut edits, mut start_s) = (Vec::new(), 0.0);
        for row in elst.get(8..).unwrap_or(&[]).chunks_exact(if wide { 20 } else { 12 }).take(count) {
            let (duration, from) = if wide {
                (u64_at(row, 0).unwrap_or(0), u64_at(row, 8).unwrap_or(0).cast_signed())
            } else {
                (u64::from(u32_at(row, 0).unwrap_or(0)), i64::from(i32_at(row, 4).unwrap_or(0)))
            };
            let duration_s = duration as f64 / f64::from(movie_timescale);
            if from >= 0 {
                // One movie tick more: the duration is rounded to that clock, and the last frame must not fall to it.
                let ticks = (duration_s + 1.0 / f64::from(movie_timescale)) * f64::from(ticks_per_s);
                let to_tick = if duration == 0 { i64::MAX } else { from.saturating_add(ticks as i64) };
                edits.push(Edit { start_s, from_tick: from, to_tick });
            }
            // A negative media time is a pause before the first picture.
            start_s += duration_s;
        }
        if edits.is_empty() {
            edits.push(Edit { start_s, from_tick: i64::MIN, to_tick: i64::MAX });
        }
        Self(edits)
    }

    /// When the picture of this tick is shown; `None` where it is cut away.
    fn stamp(&self, tick: i64, ticks_per_s: u32) -> Option<Stamp> {
        let edit = self.0.iter().find(|edit| tick >= edit.from_tick && tick < edit.to_tick)?;
        let shift = if edit.from_tick == i64::MIN { 0 } else { edit.from_tick };
        let start_ns = Stamp::from_secs(edit.start_s)?.0;
        // Integers throughout: 1/30000 s is no whole number of nanoseconds, and rounding must not add up.
        let ns = (i128::from(tick) - i128::from(shift)) * 1_000_000_000;
        let half = i128::from(ticks_per_s) / 2;
        let rounded = (ns + half).div_euclid(i128::from(ticks_per_s));
        i64::try_from(rounded + i128::from(start_ns)).ok().map(Stamp)
    }
}
