//! H.264 in MP4/MOV, decoded inside this program (OpenH264): pictures in the order in which they are shown, one at a time.
//!
//! samples in decoding order ─▶ decoder ─▶ pictures in showing order ─▶ paired with stamps in showing order
//!
//! The decoder does not tell which sample a picture came from. It gives them in showing order, so the earliest stamp that is
//! still waiting is the picture's. Where a sample fails, its stamp is taken out.
//! Pitfall: asked for what it holds back ("flush"), OpenH264 hands out pictures without returning them to its pool, runs out of
//! pictures some frames later, resets, and loses everything up to the next key frame. So it is never flushed but to be thrown
//! away: each IDR picture, with which H.264 begins anew, gets a fresh decoder. No miscount can outlive that either.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use openh264::OpenH264API;
use openh264::decoder::{DecodedYUV, Decoder, DecoderConfig, Flush};
use openh264::formats::YUVSource;
use planwalk_types::{GrayImage, Stamp, VideoFrame};

use super::mp4::{AvcConfig, Index, Sample};
use super::{VideoBackend, VideoError, VideoInfo, VideoSource};

/// Largest coded picture taken, bytes; an 8K picture at the highest rate has 5 MB.
const SAMPLE_LIMIT: u32 = 64 << 20;
/// H.264 holds back at most 16 pictures; more waiting stamps than this mean that pictures were lost.
const REORDER_LIMIT: usize = 18;

pub(super) struct H264 {
    file: File,
    index: Index,
    config: AvcConfig,
    decoder: Decoder,
    /// Index of the next sample to decode.
    next: usize,
    /// Samples whose pictures have not come yet, by showing time, the earliest last.
    waiting: Vec<Sample>,
    ready: VecDeque<VideoFrame>,
    /// Said once, after the frames that are ready.
    failure: Option<VideoError>,
    size: Option<(usize, usize)>,
    last: Option<Stamp>,
    decoded: usize,
    expected: usize,
    finished: bool,
    reason: Option<String>,
    info: VideoInfo,
}

impl H264 {
    pub fn open(path: &Path, index: Index, config: AvcConfig, note: Option<String>) -> Result<Self, VideoError> {
        let decoder = new_decoder()?;
        let notes = index.notes.iter().cloned().chain(note).collect();
        let info =
            VideoInfo { backend: VideoBackend::BuiltIn, codec: "H.264".to_owned(), rotation_deg: index.turn.degrees(), dropped: 0, notes };
        let mut source = Self {
            file: File::open(path)?,
            expected: index.shown(),
            index,
            config,
            decoder,
            next: 0,
            waiting: Vec::new(),
            ready: VecDeque::new(),
            failure: None,
            size: None,
            last: None,
            decoded: 0,
            finished: false,
            reason: None,
            info,
        };
        source.fill();
        if source.ready.is_empty() {
            let reason = source.reason.unwrap_or_else(|| "there are none in its index".to_owned());
            return Err(source.failure.unwrap_or(VideoError::NothingDecoded { reason }));
        }
        Ok(source)
    }

    /// Decodes until a frame is ready or the video is over.
    fn fill(&mut self) {
        while self.ready.is_empty() && !self.finished {
            let Some(sample) = self.index.samples.get(self.next).copied() else {
                return self.finish(None);
            };
            let fed = self.feed(sample);
            self.next += 1;
            if let Err(e) = fed {
                self.finish(Some(e));
            }
        }
    }

    fn finish(&mut self, failure: Option<VideoError>) {
        self.drain();
        self.finished = true;
        let counted = |e| match e {
            VideoError::Truncated { expected, .. } => VideoError::Truncated { decoded: self.decoded, expected },
            other => other,
        };
        self.failure = self.failure.take().or(failure).map(counted);
    }

    /// Decodes one sample and shows what the decoder gives for it; damage is noted and passed over.
    fn feed(&mut self, sample: Sample) -> Result<(), VideoError> {
        let end = sample.offset.saturating_add(u64::from(sample.size));
        if end > self.index.file_len {
            return Err(VideoError::Truncated { decoded: self.decoded, expected: self.expected });
        }
        let Some(coded) = self.read_annex_b(sample)?.filter(|coded| !coded.bytes.is_empty()) else {
            self.pass_over("the parts of a frame do not fit in it");
            return Ok(());
        };
        if coded.starts_anew && !self.waiting.is_empty() {
            self.drain();
            self.decoder = new_decoder()?;
        }
        match self.decoder.decode(&coded.bytes) {
            Ok(picture) => {
                let picture = picture.as_ref().map(luma);
                let at = self.waiting.partition_point(|s| s.shown_tick > sample.shown_tick);
                self.waiting.insert(at, sample);
                if let Some(picture) = picture {
                    self.show(picture);
                }
                if self.waiting.len() > REORDER_LIMIT {
                    self.waiting.pop();
                    self.pass_over("the decoder lost a picture");
                }
            }
            Err(e) => self.pass_over(&short(&e)),
        }
        Ok(())
    }

    fn pass_over(&mut self, reason: &str) {
        self.info.dropped += 1;
        self.reason.get_or_insert_with(|| reason.to_owned());
    }

    /// Shows every picture that the decoder still holds. It must not be used after this.
    fn drain(&mut self) {
        let pictures: Vec<Picture> = match self.decoder.flush_remaining() {
            Ok(pictures) => pictures.iter().map(luma).collect(),
            Err(_) => Vec::new(),
        };
        for picture in pictures {
            self.show(picture);
        }
        self.info.dropped += self.waiting.len();
        self.waiting.clear();
    }

    fn show(&mut self, (width, height, pixels): Picture) {
        let Some(sample) = self.waiting.pop() else {
            return self.pass_over("the decoder gave a picture too many");
        };
        // Without a stamp it is cut away by the edit list.
        let Some(stamp) = sample.stamp else { return };
        if self.failure.is_some() || self.last.is_some_and(|last| stamp <= last) {
            return self.pass_over("its stamp does not come after the one before");
        }
        let (width, height, pixels) = self.index.turn.apply(width, height, pixels);
        let size = *self.size.get_or_insert((width, height));
        if size != (width, height) {
            self.failure = Some(VideoError::SizeChanged { from: size, to: (width, height), decoded: self.decoded });
            self.finished = true;
        } else if let Some(image) = GrayImage::new(width, height, pixels) {
            self.last = Some(stamp);
            self.decoded += 1;
            self.ready.push_back(VideoFrame { stamp, image });
        }
    }

    /// The sample with start codes in place of lengths; `None` where the lengths make no sense.
    fn read_annex_b(&mut self, sample: Sample) -> Result<Option<Coded>, VideoError> {
        if sample.size > SAMPLE_LIMIT {
            return Ok(None);
        }
        let mut bytes = vec![0; sample.size as usize];
        self.file.seek(SeekFrom::Start(sample.offset))?;
        self.file.read_exact(&mut bytes)?;
        // The first sample gets the parameter sets whatever it is.
        Ok(annex_b(&bytes, &self.config, self.next == 0))
    }
}

/// Columns, rows, luma.
type Picture = (usize, usize, Vec<u8>);

fn new_decoder() -> Result<Decoder, VideoError> {
    let setup = DecoderConfig::new().flush_after_decode(Flush::NoFlush);
    Decoder::with_api_config(OpenH264API::from_source(), setup).map_err(|e| VideoError::NothingDecoded { reason: short(&e) })
}

/// What the decoder says, without where in its sources.
fn short(error: &openh264::Error) -> String {
    let said = error.to_string();
    said.split(". User Message").next().unwrap_or(&said).to_owned()
}

/// A sample as the decoder wants it.
struct Coded {
    bytes: Vec<u8>,
    /// It is an IDR picture: nothing before it is needed after it.
    starts_anew: bool,
}

/// NAL units behind length fields → NAL units behind start codes; parameter sets go before each IDR picture.
fn annex_b(sample: &[u8], config: &AvcConfig, is_first: bool) -> Option<Coded> {
    const START: [u8; 4] = [0, 0, 0, 1];
    let mut coded = Coded { bytes: Vec::with_capacity(sample.len() + 64), starts_anew: false };
    let mut set_up = false;
    let mut rest = sample;
    while !rest.is_empty() {
        let (length, tail) = rest.split_at_checked(config.length_bytes)?;
        let length = length.iter().fold(0usize, |sum, b| sum << 8 | usize::from(*b));
        let (unit, tail) = tail.split_at_checked(length)?;
        rest = tail;
        let Some(first) = unit.first() else { continue };
        let is_idr = first & 0x1f == 5;
        coded.starts_anew |= is_idr;
        if (is_idr || is_first) && !set_up {
            set_up = true;
            config.parameter_sets.iter().for_each(|set| coded.bytes.extend(START.iter().chain(set)));
        }
        coded.bytes.extend(START.iter().chain(unit));
    }
    Some(coded)
}

/// Columns, rows and luma of a decoded picture, without the padding of its rows.
fn luma(yuv: &DecodedYUV<'_>) -> Picture {
    let ((width, height), (stride, _, _)) = (yuv.dimensions(), yuv.strides());
    let mut pixels = Vec::with_capacity(width * height);
    for row in yuv.y().chunks(stride.max(1)).take(height) {
        pixels.extend_from_slice(row.get(..width).unwrap_or(row));
    }
    (width, height, pixels)
}

impl Iterator for H264 {
    type Item = Result<VideoFrame, VideoError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.fill();
        self.ready.pop_front().map(Ok).or_else(|| self.failure.take().map(Err))
    }
}

impl VideoSource for H264 {
    fn size(&self) -> (usize, usize) {
        // Opened only with a frame in hand.
        self.size.unwrap_or((0, 0))
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.expected)
    }

    fn info(&self) -> &VideoInfo {
        &self.info
    }
}
