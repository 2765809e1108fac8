//! What did the camera see, and when? Frame by frame from a folder of images, an H.264 file, or whatever ffmpeg reads.
//!
//! path ─▶ folder of images ────────▶ one file a frame
//!      ├▶ MP4/MOV with H.264 ──────▶ built-in reader and decoder
//!      └▶ any other video ─────────▶ the `ffmpeg` program, where it is installed
//!
//! Frames come upright (rotation metadata applied, once), as luma, in the order in which they are shown, with the container's
//! own stamps, strictly increasing. Memory does not grow with the clip.

mod ffmpeg;
mod folder;
mod fragments;
mod h264;
mod mp4;
mod rotate;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use planwalk_types::VideoFrame;

use crate::raster::RasterError;

pub use ffmpeg::encode_folder;
pub use folder::{FolderWriter, write_picture};

/// Options of [`open`].
#[derive(Debug, Clone, Copy, Default)]
pub struct VideoOptions {
    /// Frames per second of a folder of images. Video files carry their own stamps, and say so in [`VideoInfo::notes`].
    pub fps: Option<f64>,
}

/// Who decodes a video.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VideoBackend {
    /// A folder of image files.
    Images,
    /// The reader and decoder inside this program.
    BuiltIn,
    /// The `ffmpeg` program.
    Ffmpeg,
}

/// What is known of a video beside its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct VideoInfo {
    /// Who decodes it.
    pub backend: VideoBackend,
    /// What it is, for people: `H.264`, `HEVC`, `png images`.
    pub codec: String,
    /// Clockwise turn that was applied to make frames upright, degrees: 0, 90, 180 or 270.
    pub rotation_deg: u32,
    /// Frames that were passed over so far: damaged, or with a stamp that does not come after the one before.
    pub dropped: usize,
    /// What a user should be told.
    pub notes: Vec<String>,
}

/// A video that is read frame by frame. After an error there are no more frames.
pub trait VideoSource: Iterator<Item = Result<VideoFrame, VideoError>> + Send {
    /// Columns and rows of every frame, upright.
    fn size(&self) -> (usize, usize);
    /// How many frames there are, where that is known beforehand; damage may make it fewer.
    fn frame_count(&self) -> Option<usize>;
    /// What else is known so far.
    fn info(&self) -> &VideoInfo;
}

/// Why a video cannot be read, or not on.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    /// Nothing there.
    #[error("there is no such file or folder")]
    NotFound,
    /// The file system refuses.
    #[error("the video cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// Zero bytes.
    #[error("the video file is empty (0 bytes): copy it again from where it was recorded")]
    EmptyFile,
    /// A folder without images.
    #[error("the folder holds no images (PNG, JPEG, PGM, BMP, TIFF or WebP): give the folder in which the frames lie")]
    NoImages,
    /// A frame rate that is none.
    #[error("{fps} frames per second is no frame rate: it must be above 0 and at most 100000")]
    BadFps {
        /// What was given.
        fps: f64,
    },
    /// A list of times of another length.
    #[error("times.txt has {times} times for {images} images: give one line an image, or --fps")]
    TimesMismatch {
        /// Lines in it.
        times: usize,
        /// Images in the folder.
        images: usize,
    },
    /// A time that is none.
    #[error("line {line} of times.txt: \"{value}\" is no time after the one before, in seconds")]
    BadTime {
        /// Line, counted from 1.
        line: usize,
        /// What stands there.
        value: String,
    },
    /// An image of a folder cannot be read.
    #[error("{name}: {source}")]
    Image {
        /// Its name in the folder.
        name: String,
        /// Why.
        source: RasterError,
    },
    /// An image of another size.
    #[error("{name} has {width}×{height} px, but the first frame has {first_width}×{first_height} px: all frames must have one size")]
    ImageSize {
        /// Its name in the folder.
        name: String,
        /// Its columns.
        width: usize,
        /// Its rows.
        height: usize,
        /// Columns of the first frame.
        first_width: usize,
        /// Rows of the first frame.
        first_height: usize,
    },
    /// Something else than a video.
    #[error("this is no video: {what}")]
    NotAVideo {
        /// What it is, and what to give instead.
        what: String,
    },
    /// An MP4 without its table of contents.
    #[error(
        "the file ends before its index (moov box): the recording or the copy was cut off, and without the index no frame can be \
         found; copy it again, or repair it with a tool such as untrunc"
    )]
    NoIndex,
    /// An MP4 whose tables contradict each other.
    #[error("the MP4 is damaged: {reason}; copy it again, or rewrite it with: ffmpeg -i IN -c copy OUT.mp4")]
    Damaged {
        /// What is wrong.
        reason: String,
    },
    /// No pictures in it.
    #[error("the file holds no video track: it is audio, or data, only")]
    NoVideoTrack,
    /// Only ffmpeg could do it, and there is none.
    #[error(
        "this video is {codec}, which needs the ffmpeg program, and there is none on the PATH: install it (apt install ffmpeg, \
         brew install ffmpeg, winget install ffmpeg), or convert where it is: \
         ffmpeg -i IN -c:v libx264 -pix_fmt yuv420p -an OUT.mp4"
    )]
    NeedsFfmpeg {
        /// What the video is.
        codec: String,
    },
    /// The end of the file comes too early.
    #[error(
        "the video is cut off: {decoded} of {expected} frames are there; copy it again to have the rest \
         (what was decoded is good)"
    )]
    Truncated {
        /// Frames given.
        decoded: usize,
        /// Frames that the index promises.
        expected: usize,
    },
    /// Frames of several sizes.
    #[error("the frames change from {from:?} to {to:?} px after {decoded} frames: cut the clip there")]
    SizeChanged {
        /// Columns and rows before.
        from: (usize, usize),
        /// Columns and rows after.
        to: (usize, usize),
        /// Frames given.
        decoded: usize,
    },
    /// Not one picture came out.
    #[error("no frame of the video could be decoded ({reason}): re-encode it with: ffmpeg -i IN -c:v libx264 -pix_fmt yuv420p -an OUT.mp4")]
    NothingDecoded {
        /// What the decoder says.
        reason: String,
    },
    /// ffmpeg gave up.
    #[error("ffmpeg stopped after {decoded} frames: {message}")]
    Ffmpeg {
        /// Frames given.
        decoded: usize,
        /// Its last words.
        message: String,
    },
}

/// Opens a video file or a folder of images and decodes as much as it takes to know that it can be read.
///
/// # Errors
/// [`VideoError`], with the remedy.
pub fn open(path: &Path, options: &VideoOptions) -> Result<Box<dyn VideoSource>, VideoError> {
    let meta =
        std::fs::metadata(path).map_err(|e| if e.kind() == std::io::ErrorKind::NotFound { VideoError::NotFound } else { e.into() })?;
    if let Some(fps) = options.fps.filter(|fps| !(*fps > 0.0 && *fps <= 1e5)) {
        return Err(VideoError::BadFps { fps });
    }
    if meta.is_dir() {
        return Ok(Box::new(folder::Folder::open(path, options.fps)?));
    }
    let note = options.fps.map(|fps| format!("the frame rate of {fps} is not used: a video file carries its own stamps"));
    open_file(path, note)
}

fn open_file(path: &Path, note: Option<String>) -> Result<Box<dyn VideoSource>, VideoError> {
    let mut head = Vec::new();
    File::open(path)?.take(4096).read_to_end(&mut head)?;
    let mut expected = None;
    let codec = match sniff(&head)? {
        Container::Mp4 => {
            let index = mp4::Index::read(File::open(path)?)?;
            expected = Some(index.shown());
            match index.codec.clone() {
                mp4::Codec::H264(config) if config.built_in_decodes() => match h264::H264::open(path, index, config, note.clone()) {
                    Ok(source) => return Ok(Box::new(source)),
                    // Interlaced or otherwise exotic: perhaps ffmpeg can.
                    Err(VideoError::NothingDecoded { reason }) => format!("H.264 that the built-in decoder cannot read ({reason})"),
                    Err(e) => return Err(e),
                },
                mp4::Codec::H264(config) => format!("H.264 of profile {} (10 bit or 4:2:2)", config.profile),
                mp4::Codec::Other(name) => name,
            }
        }
        Container::Other(name) => name.to_owned(),
    };
    Ok(Box::new(ffmpeg::Ffmpeg::open(path, codec, expected, note)?))
}

/// What a file is by its first bytes.
enum Container {
    Mp4,
    Other(&'static str),
}

fn sniff(head: &[u8]) -> Result<Container, VideoError> {
    if head.is_empty() {
        return Err(VideoError::EmptyFile);
    }
    let not = |what: &str| Err(VideoError::NotAVideo { what: what.to_owned() });
    if matches!(head.get(4..8), Some(b"ftyp" | b"moov" | b"mdat" | b"wide" | b"free" | b"skip" | b"pnot")) {
        return Ok(Container::Mp4);
    }
    if image::guess_format(head).is_ok() {
        return not("it is a single image; give the folder of images, or a video file");
    }
    // ffmpeg would "play" a text as letters on a screen.
    if std::str::from_utf8(head).map_or_else(|e| e.error_len().is_none() && e.valid_up_to() > 0, |_| true) && !head.contains(&0) {
        return not("it is a text file, whatever its name says; was a download page saved instead of the video?");
    }
    Ok(Container::Other(match head {
        [0x1a, 0x45, 0xdf, 0xa3, ..] => "Matroska or WebM",
        [b'R', b'I', b'F', b'F', ..] => "AVI",
        [0, 0, 0, 1, ..] | [0, 0, 1, ..] => "a raw or MPEG stream",
        [0x47, ..] => "an MPEG transport stream",
        _ => "of a format not known here",
    }))
}
