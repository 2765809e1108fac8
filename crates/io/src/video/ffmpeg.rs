//! Any video that the `ffmpeg` program reads: luma comes over its standard output, stamps over its standard error.
//!
//! ffmpeg ─▶ stdout: raw luma, frame after frame
//!        └▶ stderr: `config in time_base: 1/90000` … `n: 0 pts: 3003 … s:1920x1080` (its `showinfo` filter)
//!
//! Stamps are whole ticks times the time base, exact for any frame rate (its decimal `pts_time` has six digits only).
//! It is told not to turn the picture (`-noautorotate`): the turn is applied here, as for the built-in decoder, once.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};

use planwalk_types::{GrayImage, Stamp, VideoFrame};

use super::rotate::Turn;
use super::{VideoBackend, VideoError, VideoInfo, VideoSource};

/// Layouts that hold luma as a plane of its own; ffmpeg converts all others to the nearest of these.
const LUMA_LAYOUTS: &str = "yuv420p|yuvj420p|yuv422p|yuvj422p|yuv444p|yuvj444p|gray|yuv420p10le|yuv422p10le|yuv444p10le|gray10le";
/// What its log says of a file that ends too early; it calls that a success.
const CUT_OFF: [&str; 2] = ["ended prematurely", "partial file"];
/// Last lines of its log that are kept to explain a failure.
const KEPT_LINES: usize = 6;
/// Largest frame taken, pixels.
const PIXEL_LIMIT: usize = 100_000_000;

/// First line of `ffmpeg -version`.
fn version() -> Option<String> {
    let output = Command::new("ffmpeg").arg("-version").stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    let line = String::from_utf8_lossy(&output.stdout).lines().next()?.to_owned();
    output.status.success().then_some(line)
}

/// Makes an MP4 of the frames of a folder (`000000.png`, …) where the `ffmpeg` program is there with an H.264 encoder; whether
/// it did. For players: its stamps are of an even rate.
pub fn encode_folder(folder: &Path, fps: f64, mp4: &Path) -> bool {
    let rate = format!("{fps}");
    let encode = Command::new("ffmpeg")
        .args(["-nostdin", "-loglevel", "error", "-y", "-framerate", &rate, "-i"])
        .arg(folder.join("%06d.png"))
        // Players want 4:2:0, and even sizes.
        .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "16", "-pix_fmt", "yuv420p", "-f", "mp4"])
        .arg(mp4)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    encode.is_ok_and(|status| status.success())
}

pub(super) struct Ffmpeg {
    child: Child,
    pixels: ChildStdout,
    said: Receiver<Said>,
    turn: Turn,
    /// Columns and rows as they come from ffmpeg.
    coded_size: (usize, usize),
    first: Option<VideoFrame>,
    last: Option<Stamp>,
    decoded: usize,
    finished: bool,
    log: Vec<String>,
    /// The first line of the log that says that the file ends too early.
    cut_off: Option<String>,
    /// How many frames there are, where an index says so.
    expected: Option<usize>,
    info: VideoInfo,
}

/// What ffmpeg's log says.
enum Said {
    Frame { stamp: Option<Stamp>, size: (usize, usize) },
    TurnedBy { clockwise_deg: f64 },
    Other(String),
}

impl Ffmpeg {
    pub fn open(path: &Path, codec: String, expected: Option<usize>, note: Option<String>) -> Result<Self, VideoError> {
        let Some(version) = version() else { return Err(VideoError::NeedsFfmpeg { codec }) };
        let mut child = command(path, &version).spawn()?;
        let (Some(pixels), Some(log)) = (child.stdout.take(), child.stderr.take()) else {
            return Err(VideoError::Io(std::io::Error::other("ffmpeg was started without pipes")));
        };
        let (sender, said) = channel();
        // Its log must be read while its pixels are, or it would wait for ever with a full pipe. The channel holds a few
        // stamps only: ffmpeg cannot get ahead of its pixels by more than the pipe.
        std::thread::spawn(move || listen(BufReader::new(log), &sender));
        let info = VideoInfo { backend: VideoBackend::Ffmpeg, codec, rotation_deg: 0, dropped: 0, notes: note.into_iter().collect() };
        let mut source = Self {
            child,
            pixels,
            said,
            turn: Turn::None,
            coded_size: (0, 0),
            first: None,
            last: None,
            decoded: 0,
            finished: false,
            log: Vec::new(),
            cut_off: None,
            expected,
            info,
        };
        match source.read_frame() {
            Some(Ok(frame)) => source.first = Some(frame),
            Some(Err(VideoError::Ffmpeg { message, .. })) => return Err(VideoError::NothingDecoded { reason: message }),
            Some(Err(e)) => return Err(e),
            None => return Err(VideoError::NothingDecoded { reason: source.log.join("; ") }),
        }
        source.info.rotation_deg = source.turn.degrees();
        Ok(source)
    }

    /// The next frame whose stamp comes after the one before.
    fn read_frame(&mut self) -> Option<Result<VideoFrame, VideoError>> {
        while !self.finished {
            match self.read_any_frame() {
                Ok(None) => self.finished = true,
                Ok(Some((Some(stamp), image))) if self.last.is_none_or(|last| stamp > last) => {
                    self.last = Some(stamp);
                    self.decoded += 1;
                    return Some(Ok(VideoFrame { stamp, image }));
                }
                Ok(Some(_)) => self.info.dropped += 1,
                Err(e) => {
                    self.finished = true;
                    return Some(Err(e));
                }
            }
        }
        None
    }

    fn read_any_frame(&mut self) -> Result<Option<(Option<Stamp>, GrayImage)>, VideoError> {
        let Some((stamp, size)) = self.next_announced() else { return self.end() };
        if self.coded_size == (0, 0) {
            self.coded_size = size;
        }
        if size != self.coded_size {
            return Err(VideoError::SizeChanged { from: self.coded_size, to: size, decoded: self.decoded });
        }
        let count = size.0.checked_mul(size.1).filter(|count| (1..=PIXEL_LIMIT).contains(count));
        let count = count.ok_or_else(|| self.stopped(&format!("it announces frames of {}×{} px", size.0, size.1)))?;
        let mut pixels = vec![0; count];
        match self.pixels.read_exact(&mut pixels) {
            Ok(()) => {}
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => return self.end(),
            Err(e) => return Err(e.into()),
        }
        let (width, height, pixels) = self.turn.apply(size.0, size.1, pixels);
        let image = GrayImage::new(width, height, pixels);
        Ok(image.map(|image| (stamp, image)))
    }

    /// The next frame's stamp and size; `None` when ffmpeg has said its last word.
    fn next_announced(&mut self) -> Option<(Option<Stamp>, (usize, usize))> {
        loop {
            match self.said.recv().ok()? {
                Said::Frame { stamp, size } => return Some((stamp, size)),
                // Said before the first frame and again with each; one clip has one turn.
                Said::TurnedBy { clockwise_deg } if self.decoded == 0 => self.turn = Turn::from_clockwise_deg(clockwise_deg),
                Said::TurnedBy { .. } => {}
                Said::Other(line) => {
                    if self.cut_off.is_none() && CUT_OFF.iter().any(|words| line.contains(words)) {
                        self.cut_off = Some(line.clone());
                    }
                    if self.log.len() == KEPT_LINES {
                        self.log.remove(0);
                    }
                    self.log.push(line);
                }
            }
        }
    }

    fn end(&mut self) -> Result<Option<(Option<Stamp>, GrayImage)>, VideoError> {
        while self.next_announced().is_some() {}
        let status = self.child.wait()?;
        match self.cut_off.take() {
            Some(line) => Err(self.stopped(&format!("the video is cut off ({line}); copy it again to have the rest"))),
            None if status.success() => Ok(None),
            None => Err(self.stopped(&self.log.join("; "))),
        }
    }

    fn stopped(&self, message: &str) -> VideoError {
        VideoError::Ffmpeg { decoded: self.decoded, message: message.to_owned() }
    }
}

fn command(path: &Path, version: &str) -> Command {
    // `file:` keeps a name with a colon or a leading dash from being anything but a file.
    let mut input = std::ffi::OsString::from("file:");
    input.push(path);
    let mut command = Command::new("ffmpeg");
    command.args([
        "-hide_banner",
        "-nostdin",
        "-nostats",
        "-loglevel",
        "info",
        "-protocol_whitelist",
        "file",
        "-noautorotate",
        "-copyts",
        "-i",
    ]);
    command.arg(input);
    command.args(["-map", "0:V:0", "-an", "-sn", "-dn"]);
    // Every frame once, none repeated to fill a constant rate. The option's name changed in 5.1.
    command.args(if is_before_5_1(version) { ["-vsync", "passthrough"] } else { ["-fps_mode", "passthrough"] });
    let filter = format!("showinfo=checksum=0,format=pix_fmts={LUMA_LAYOUTS},extractplanes=y,format=pix_fmts=gray");
    command.args(["-vf", &filter, "-f", "rawvideo", "-pix_fmt", "gray", "pipe:1"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Whether `ffmpeg version 4.4.2-0ubuntu…` is older than 5.1; builds named otherwise (nightly) are new.
fn is_before_5_1(version: &str) -> bool {
    let number = version.split_whitespace().nth(2).unwrap_or("").trim_start_matches('n');
    let mut parts = number.split(|c: char| !c.is_ascii_digit()).map(|part| part.parse::<u32>().ok());
    match (parts.next().flatten(), parts.next().flatten()) {
        (Some(major), minor) if major < 1000 => (major, minor.unwrap_or(0)) < (5, 1),
        _ => false,
    }
}

/// Turns the log into what matters, until it ends or nobody listens any more.
fn listen(log: impl BufRead, sender: &Sender<Said>) {
    let mut time_base = None;
    for line in log.split(b'\n') {
        let Ok(line) = line else { return };
        let line = String::from_utf8_lossy(&line);
        if let Some(base) = parse_time_base(&line) {
            time_base = Some(base);
        }
        if parse_line(&line, time_base).is_some_and(|said| sender.send(said).is_err()) {
            return;
        }
    }
}

fn parse_line(line: &str, time_base: Option<(i64, i64)>) -> Option<Said> {
    if let Some(angle) = line.split("displaymatrix: rotation of ").nth(1) {
        // ffmpeg counts anticlockwise.
        let deg: f64 = angle.split_whitespace().next()?.parse().ok()?;
        return Some(Said::TurnedBy { clockwise_deg: -deg });
    }
    if !line.contains("Parsed_showinfo") {
        // The listing of streams is indented; what is left are messages.
        let message = !line.trim().is_empty() && !line.starts_with(' ');
        return message.then(|| Said::Other(line.trim().to_owned()));
    }
    if !line.contains(" n:") {
        return None;
    }
    let (width, height) = field(line, " s:")?.split_once('x')?;
    let size = (width.parse().ok()?, height.parse().ok()?);
    let stamp = time_base.and_then(|base| ticks_to_stamp(field(line, " pts:")?.parse().ok()?, base));
    Some(Said::Frame { stamp, size })
}

/// The word after a key, which may stand apart from it (`pts:   3003`).
fn field<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    line.split(key).nth(1)?.split_whitespace().next()
}

fn parse_time_base(line: &str) -> Option<(i64, i64)> {
    let (num, den) =
        line.contains("Parsed_showinfo").then(|| field(line, "config in time_base:"))??.trim_end_matches(',').split_once('/')?;
    Some((num.parse().ok().filter(|n| *n > 0)?, den.parse().ok().filter(|d| *d > 0)?))
}

fn ticks_to_stamp(ticks: i64, (num, den): (i64, i64)) -> Option<Stamp> {
    let ns = i128::from(ticks) * i128::from(num) * 1_000_000_000 + i128::from(den) / 2;
    i64::try_from(ns.div_euclid(i128::from(den))).ok().map(Stamp)
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // Dropped before its end, ffmpeg would wait on a full pipe. Both fail only when it is gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Iterator for Ffmpeg {
    type Item = Result<VideoFrame, VideoError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.first.take().map(Ok).or_else(|| self.read_frame())
    }
}

impl VideoSource for Ffmpeg {
    fn size(&self) -> (usize, usize) {
        match self.turn {
            Turn::None | Turn::Half => self.coded_size,
            Turn::Left | Turn::Right => (self.coded_size.1, self.coded_size.0),
        }
    }

    fn frame_count(&self) -> Option<usize> {
        self.expected
    }

    fn info(&self) -> &VideoInfo {
        &self.info
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_exact_ticks() {
        let config = "[Parsed_showinfo_0 @ 0x55] config in time_base: 1001/30000, frame_rate: 30000/1001";
        let base = parse_time_base(config).unwrap();
        let line = "[Parsed_showinfo_0 @ 0x55] n: 107892 pts: 107892 pts_time:3599.99 pos:  48 fmt:yuv420p sar:1/1 s:1920x1080 i:P iskey:1";
        match parse_line(line, Some(base)) {
            Some(Said::Frame { stamp, size }) => {
                assert_eq!(size, (1920, 1080));
                // 107892 · 1001 / 30000 s
                assert_eq!(stamp, Some(Stamp(3_599_996_400_000)));
            }
            _ => panic!("a frame was announced"),
        }
    }

    #[test]
    fn the_rest_of_the_log_is_sorted() {
        assert!(matches!(
            parse_line("      displaymatrix: rotation of -90.00 degrees", None),
            Some(Said::TurnedBy { clockwise_deg }) if clockwise_deg == 90.0
        ));
        assert!(matches!(parse_line("in.webm: Invalid data found", None), Some(Said::Other(_))));
        assert!(parse_line("  Stream #0:0: Video: vp9", None).is_none());
        assert!(parse_line("[Parsed_showinfo_0 @ 0x55] color_range:tv", None).is_none());
    }

    #[test]
    fn old_versions_are_told_from_new_ones() {
        let before = |v: &str| is_before_5_1(&format!("ffmpeg version {v} Copyright (c) 2000"));
        assert!(before("4.4.2-0ubuntu0.22.04.1") && before("n5.0"));
        assert!(!before("5.1.6-0+deb12u1") && !before("7.1") && !before("n8.0") && !before("N-118000-g1234567") && !before("20260101-git"));
    }
}
