//! Where do the pictures of a fragmented MP4 lie? Recorders that may be stopped at any moment write `moof` boxes.
//!
//! Each fragment (`moof`) has track fragments (`traf`) with runs (`trun`) of samples; what a run leaves out is said by the
//! fragment's header (`tfhd`), and what that leaves out by the movie's defaults (`trex`). ISO/IEC 14496-12, §8.8.

use super::VideoError;
use super::mp4::{Boxes, FragmentBoxes, Picture, SAMPLE_LIMIT, child, damaged, u32_at, u64_at};

/// Appends the pictures of one track, in decoding order.
pub(super) fn append(pictures: &mut Vec<Picture>, track_id: u32, moov: &[u8], fragments: &FragmentBoxes) -> Result<(), VideoError> {
    let mvex = child(moov, b"mvex").unwrap_or(&[]);
    let trex = Boxes(mvex).filter(|(name, _)| *name == b"trex").map(|(_, body)| body).find(|trex| u32_at(trex, 4) == Some(track_id));
    let of_movie = trex.map_or(Defaults { duration: 0, size: 0 }, |trex| Defaults {
        duration: u32_at(trex, 12).unwrap_or(0),
        size: u32_at(trex, 16).unwrap_or(0),
    });
    let mut decode_tick = 0;
    for (moof_at, moof) in fragments {
        for (_, traf) in Boxes(moof).filter(|(name, _)| *name == b"traf") {
            let head = child(traf, b"tfhd").and_then(|tfhd| Head::read(tfhd, *moof_at, of_movie));
            let Some(head) = head.filter(|head| head.track_id == track_id) else { continue };
            if let Some(tick) = child(traf, b"tfdt").and_then(base_time) {
                decode_tick = tick;
            }
            let mut at = head.base;
            for (_, trun) in Boxes(traf).filter(|(name, _)| *name == b"trun") {
                (at, decode_tick) = run(pictures, trun, &head, at, decode_tick)
                    .ok_or_else(|| damaged("a fragment's table is cut off, or counts too many frames"))?;
            }
        }
    }
    Ok(())
}

#[derive(Clone, Copy)]
struct Defaults {
    duration: u32,
    size: u32,
}

struct Head {
    track_id: u32,
    base: u64,
    defaults: Defaults,
}

impl Head {
    fn read(tfhd: &[u8], moof_at: u64, of_movie: Defaults) -> Option<Self> {
        let flags = u32_at(tfhd, 0)?;
        let mut fields = Fields { bytes: tfhd, at: 8 };
        let base = if flags & 0x1 != 0 { fields.u64()? } else { moof_at };
        if flags & 0x2 != 0 {
            fields.u32()?;
        }
        let duration = if flags & 0x8 != 0 { fields.u32()? } else { of_movie.duration };
        let size = if flags & 0x10 != 0 { fields.u32()? } else { of_movie.size };
        Some(Self { track_id: u32_at(tfhd, 4)?, base, defaults: Defaults { duration, size } })
    }
}

fn base_time(tfdt: &[u8]) -> Option<i64> {
    let tick = if *tfdt.first()? == 1 { u64_at(tfdt, 4)? } else { u64::from(u32_at(tfdt, 4)?) };
    i64::try_from(tick).ok()
}

/// One run of samples; gives where the next one begins, in the file and in time.
fn run(pictures: &mut Vec<Picture>, trun: &[u8], head: &Head, at: u64, mut decode_tick: i64) -> Option<(u64, i64)> {
    let flags = u32_at(trun, 0)?;
    let count = u32_at(trun, 4)? as usize;
    let mut fields = Fields { bytes: trun, at: 8 };
    let mut at = if flags & 0x1 != 0 { head.base.checked_add_signed(i64::from(fields.u32()?.cast_signed()))? } else { at };
    if flags & 0x4 != 0 {
        fields.u32()?;
    }
    // A run whose samples say nothing of themselves costs no bytes, so its count alone must not fill the memory.
    if pictures.len().saturating_add(count) > SAMPLE_LIMIT {
        return None;
    }
    for _ in 0..count {
        let duration = if flags & 0x100 != 0 { fields.u32()? } else { head.defaults.duration };
        let size = if flags & 0x200 != 0 { fields.u32()? } else { head.defaults.size };
        if flags & 0x400 != 0 {
            fields.u32()?;
        }
        let shift = if flags & 0x800 != 0 { i64::from(fields.u32()?.cast_signed()) } else { 0 };
        pictures.push(Picture { offset: at, size, shown_tick: decode_tick.saturating_add(shift) });
        at = at.checked_add(u64::from(size))?;
        decode_tick = decode_tick.saturating_add(i64::from(duration));
    }
    Some((at, decode_tick))
}

struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Fields<'_> {
    fn u32(&mut self) -> Option<u32> {
        let value = u32_at(self.bytes, self.at)?;
        self.at += 4;
        Some(value)
    }

    fn u64(&mut self) -> Option<u64> {
        let value = u64_at(self.bytes, self.at)?;
        self.at += 8;
        Some(value)
    }
}
