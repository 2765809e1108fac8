//! Frames that lie in a folder, one image file each, in the natural order of their names (`img2` before `img10`).

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use planwalk_types::{GrayImage, Stamp, VideoFrame};

use super::{VideoBackend, VideoError, VideoInfo, VideoSource};
use crate::raster::{self, SizeLimit};
use crate::text;

/// What frames without any time are taken to be, and a note says so.
const ASSUMED_FPS: f64 = 30.0;
/// Where a folder of frames says when each was taken.
const TIMES_FILE: &str = "times.txt";
const EXTENSIONS: [&str; 11] = ["png", "jpg", "jpeg", "pgm", "ppm", "pnm", "pbm", "bmp", "tif", "tiff", "webp"];

pub(super) struct Folder {
    files: Vec<PathBuf>,
    stamps: Stamps,
    next: usize,
    size: (usize, usize),
    /// The first image, decoded to know the size.
    first: Option<GrayImage>,
    info: VideoInfo,
}

enum Stamps {
    Rate(f64),
    Given(Vec<Stamp>),
}

impl Folder {
    pub fn open(path: &Path, fps: Option<f64>) -> Result<Self, VideoError> {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(path)? {
            let file = entry?.path();
            if is_image(&file) {
                files.push(file);
            }
        }
        files.sort_by(|a, b| natural_order(&name_of(a), &name_of(b)));
        let first_file = files.first().ok_or(VideoError::NoImages)?;
        let first = decode(first_file)?;
        let extension = first_file.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase());
        let (stamps, notes) = stamps(path, &files, fps)?;
        let info = VideoInfo { backend: VideoBackend::Images, codec: format!("{extension} images"), rotation_deg: 0, dropped: 0, notes };
        Ok(Self { stamps, next: 0, size: (first.width(), first.height()), first: Some(first), info, files })
    }

    fn frame(&mut self, i: usize) -> Result<VideoFrame, VideoError> {
        let image = match self.first.take() {
            Some(first) if i == 0 => first,
            _ => decode(&self.files[i])?,
        };
        if (image.width(), image.height()) != self.size {
            let (first_width, first_height) = self.size;
            let name = name_of(&self.files[i]);
            return Err(VideoError::ImageSize { name, width: image.width(), height: image.height(), first_width, first_height });
        }
        let stamp = match &self.stamps {
            // At most 1e5 frames a second of at most 2^64 files: always a stamp; zero would be caught as going back.
            Stamps::Rate(fps) => Stamp::from_secs(i as f64 / fps).unwrap_or(Stamp(0)),
            Stamps::Given(stamps) => stamps[i],
        };
        Ok(VideoFrame { stamp, image })
    }
}

impl Iterator for Folder {
    type Item = Result<VideoFrame, VideoError>;

    fn next(&mut self) -> Option<Self::Item> {
        let i = self.next;
        if i >= self.files.len() {
            return None;
        }
        let frame = self.frame(i);
        self.next = if frame.is_ok() { i + 1 } else { self.files.len() };
        Some(frame)
    }
}

impl VideoSource for Folder {
    fn size(&self) -> (usize, usize) {
        self.size
    }

    fn frame_count(&self) -> Option<usize> {
        Some(self.files.len())
    }

    fn info(&self) -> &VideoInfo {
        &self.info
    }
}

/// Stamps of the frames: by the given rate, else by `times.txt`, else by names that are times, else by the assumed rate.
fn stamps(folder: &Path, files: &[PathBuf], fps: Option<f64>) -> Result<(Stamps, Vec<String>), VideoError> {
    if let Some(fps) = fps {
        return Ok((Stamps::Rate(fps), Vec::new()));
    }
    let table = folder.join(TIMES_FILE);
    if table.is_file() {
        let stamps = stamps_in_table(&table, files.len())?;
        return Ok((Stamps::Given(stamps), vec![format!("the frames' times are those of {TIMES_FILE}")]));
    }
    if let Some(stamps) = stamps_in_names(files) {
        return Ok((Stamps::Given(stamps), vec!["the images' names are taken as their time stamps".to_owned()]));
    }
    let note = format!("the images carry no time: {ASSUMED_FPS} frames per second are assumed; say --fps if you know it");
    Ok((Stamps::Rate(ASSUMED_FPS), vec![note]))
}

/// One time a line, seconds, one for each image (KITTI's `times.txt`).
fn stamps_in_table(table: &Path, images: usize) -> Result<Vec<Stamp>, VideoError> {
    let text = text::read(table)?;
    let stamp = |(line, row): (usize, &str)| {
        let token = row.split_whitespace().next().unwrap_or_default();
        text::seconds(token).ok_or_else(|| VideoError::BadTime { line, value: token.to_owned() })
    };
    let stamps: Vec<Stamp> = text::data_lines(&text).map(stamp).collect::<Result<_, _>>()?;
    if stamps.len() != images {
        return Err(VideoError::TimesMismatch { times: stamps.len(), images });
    }
    match stamps.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(before) => Err(VideoError::BadTime { line: before + 2, value: text::decimal_seconds(stamps[before + 1]) }),
        None => Ok(stamps),
    }
}

/// Writes one picture as PNG.
///
/// # Errors
/// [`VideoError::Image`].
pub fn write_picture(path: &Path, picture: &GrayImage) -> Result<(), VideoError> {
    raster::write_png(path, picture).map_err(|source| VideoError::Image { name: name_of(path), source })
}

/// Writes frames into a folder as `000000.png`, …, and their times into `times.txt`: what [`super::open`] reads back.
#[derive(Debug)]
pub struct FolderWriter {
    folder: PathBuf,
    times: String,
    count: usize,
}

impl FolderWriter {
    /// Makes the folder; frames that an earlier writer left in it are removed, or they would follow these.
    ///
    /// # Errors
    /// [`VideoError::Io`].
    pub fn new(folder: &Path) -> Result<Self, VideoError> {
        std::fs::create_dir_all(folder)?;
        for entry in std::fs::read_dir(folder)? {
            let file = entry?.path();
            let numbered =
                file.file_stem().is_some_and(|stem| stem.len() == 6 && stem.to_string_lossy().bytes().all(|b| b.is_ascii_digit()));
            if numbered && file.extension().is_some_and(|e| e == "png") {
                std::fs::remove_file(file)?;
            }
        }
        Ok(Self { folder: folder.to_owned(), times: String::new(), count: 0 })
    }

    /// Writes one frame.
    ///
    /// # Errors
    /// [`VideoError::Io`], [`VideoError::Image`].
    pub fn push(&mut self, frame: &VideoFrame) -> Result<(), VideoError> {
        let name = format!("{:06}.png", self.count);
        write_picture(&self.folder.join(&name), &frame.image)?;
        self.times.push_str(&text::decimal_seconds(frame.stamp));
        self.times.push('\n');
        self.count += 1;
        Ok(())
    }

    /// Writes the times.
    ///
    /// # Errors
    /// [`VideoError::Io`].
    pub fn finish(self) -> Result<(), VideoError> {
        Ok(std::fs::write(self.folder.join(TIMES_FILE), self.times)?)
    }
}

/// Names that are all unix times, in nanoseconds (EuRoC: 16 to 19 digits) or in decimal seconds (TUM RGB-D), and increase.
fn stamps_in_names(files: &[PathBuf]) -> Option<Vec<Stamp>> {
    let stamp = |file: &PathBuf| {
        let stem = file.file_stem()?.to_str()?;
        let digits = stem.bytes().all(|b| b.is_ascii_digit());
        let (whole, fraction) = stem.split_once('.').unwrap_or((stem, ""));
        if digits && (16..=19).contains(&stem.len()) {
            stem.parse().ok().map(Stamp)
        } else if (9..=10).contains(&whole.len()) && fraction.len() >= 3 {
            text::seconds(stem)
        } else {
            None
        }
    };
    let stamps: Vec<Stamp> = files.iter().map(stamp).collect::<Option<_>>()?;
    stamps.windows(2).all(|pair| pair[0] < pair[1]).then_some(stamps)
}

fn is_image(file: &Path) -> bool {
    let hidden = name_of(file).starts_with('.');
    let known = file.extension().is_some_and(|e| EXTENSIONS.iter().any(|known| e.eq_ignore_ascii_case(known)));
    known && !hidden && file.is_file()
}

fn name_of(file: &Path) -> String {
    file.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned())
}

fn decode(file: &Path) -> Result<GrayImage, VideoError> {
    let refuse = |source| VideoError::Image { name: name_of(file), source };
    let luma = raster::open(file, SizeLimit::FRAME).map_err(refuse)?.into_luma8();
    let (width, height) = luma.dimensions();
    GrayImage::new(width as usize, height as usize, luma.into_raw()).ok_or_else(|| refuse(raster::RasterError::Empty { width, height }))
}

/// Names compared with runs of digits as numbers; equal numbers by their text, so that the order is total.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    while let (Some(first_a), Some(first_b)) = (rest_a.chars().next(), rest_b.chars().next()) {
        let order = if first_a.is_ascii_digit() && first_b.is_ascii_digit() {
            let (digits_a, tail_a) = split_digits(rest_a);
            let (digits_b, tail_b) = split_digits(rest_b);
            (rest_a, rest_b) = (tail_a, tail_b);
            let (a, b) = (digits_a.trim_start_matches('0'), digits_b.trim_start_matches('0'));
            a.len().cmp(&b.len()).then_with(|| a.cmp(b))
        } else {
            (rest_a, rest_b) = (&rest_a[first_a.len_utf8()..], &rest_b[first_b.len_utf8()..]);
            first_a.cmp(&first_b)
        };
        if order != Ordering::Equal {
            return order;
        }
    }
    rest_a.len().cmp(&rest_b.len()).then_with(|| a.cmp(b))
}

fn split_digits(text: &str) -> (&str, &str) {
    text.split_at(text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_order_people_count() {
        let mut names = ["img10.png", "img2.png", "img02.png", "img1.png", "a.png", "img2b.png", "0000000081.png"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["0000000081.png", "a.png", "img1.png", "img02.png", "img2.png", "img2b.png", "img10.png"]);
    }

    #[test]
    fn names_that_are_times_are_told_from_names_that_count() {
        let files = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let nanos = stamps_in_names(&files(&["1403636579763555584.png", "1403636579813555456.png"])).unwrap();
        assert_eq!(nanos, [Stamp(1_403_636_579_763_555_584), Stamp(1_403_636_579_813_555_456)]);
        let seconds = stamps_in_names(&files(&["1305031102.175304.png", "1305031102.211214.png"])).unwrap();
        assert_eq!(seconds[1].0 - seconds[0].0, 35_910_000);
        assert_eq!(stamps_in_names(&files(&["0000000081.png", "0000000082.png"])), None);
    }
}
