//! Frames come out upright, in order, with their own stamps; and what is no video is told apart.

use std::path::Path;

use image::{GrayImage, Luma};
use planwalk_io::video::{self, VideoBackend, VideoError, VideoOptions};
use planwalk_types::{Stamp, VideoFrame};
use proptest::prelude::*;

use super::folder;
use crate::support::{Clip, data};

fn open(path: &Path) -> Result<Box<dyn video::VideoSource>, VideoError> {
    video::open(path, &VideoOptions::default())
}

fn open_error(path: &Path) -> VideoError {
    open(path).err().expect("this must not open")
}

fn frames(path: &Path) -> Vec<VideoFrame> {
    open(path).unwrap().map(Result::unwrap).collect()
}

fn stamps(frames: &[VideoFrame]) -> Vec<i64> {
    frames.iter().map(|f| f.stamp.0).collect()
}

/// Writes frames of 8 × 6 px whose brightness is their number.
fn image_folder(names: &[&str]) -> tempfile::TempDir {
    let dir = folder();
    for (name, i) in names.iter().zip(0..) {
        GrayImage::from_pixel(8, 6, Luma([i])).save(dir.path().join(name)).unwrap();
    }
    dir
}

// ---- video: folders of images

#[test]
fn images_come_in_the_order_people_count_and_at_the_given_rate() {
    let dir = image_folder(&["f1.png", "f2.pgm", "f10.png"]);
    std::fs::write(dir.path().join("notes.txt"), "not a frame").unwrap();
    std::fs::write(dir.path().join("._f1.png"), "a shadow that some systems leave").unwrap();
    let mut source = video::open(dir.path(), &VideoOptions { fps: Some(12.0) }).unwrap();
    assert_eq!((source.size(), source.frame_count()), ((8, 6), Some(3)));
    assert_eq!(source.info().backend, VideoBackend::Images);
    assert!(source.info().notes.is_empty());
    let frames: Vec<VideoFrame> = source.by_ref().map(Result::unwrap).collect();
    assert_eq!(frames.iter().map(|f| f.image.at(0, 0)).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(stamps(&frames), [0, 83_333_333, 166_666_667]);
}

#[test]
fn frames_that_are_written_are_read_back_with_their_times() {
    let dir = folder();
    let mut writer = video::FolderWriter::new(dir.path()).unwrap();
    let image = |i: usize| planwalk_types::GrayImage::from_fn(9, 5, |u, v| (20 * i + 10 * v + u) as u8);
    let stamps = [0, 66_666_667, 140_000_001];
    for (i, stamp) in stamps.iter().enumerate() {
        writer.push(&VideoFrame { stamp: Stamp(*stamp), image: image(i) }).unwrap();
    }
    writer.finish().unwrap();
    let read = frames(dir.path());
    assert_eq!(self::stamps(&read), stamps);
    assert!(read.iter().enumerate().all(|(i, frame)| frame.image == image(i)));
    std::fs::write(dir.path().join("times.txt"), "0\n1\n").unwrap();
    assert!(matches!(open_error(dir.path()), VideoError::TimesMismatch { times: 2, images: 3 }));
    std::fs::write(dir.path().join("times.txt"), "0\n1\n1\n").unwrap();
    assert!(matches!(open_error(dir.path()), VideoError::BadTime { line: 3, .. }));
    std::fs::write(dir.path().join("times.txt"), "0\nsoon\n2\n").unwrap();
    assert!(open_error(dir.path()).to_string().contains("soon"));
}

#[test]
fn a_rate_that_is_assumed_is_said_to_be() {
    let source = open(image_folder(&["a.png", "b.png"]).path()).unwrap();
    assert!(source.info().notes[0].contains("30 frames per second"), "{:?}", source.info().notes);
}

#[test]
fn an_odd_frame_is_named_and_ends_the_video() {
    let dir = image_folder(&["a.png", "b.png", "c.png"]);
    GrayImage::new(9, 6).save(dir.path().join("b.png")).unwrap();
    let mut source = open(dir.path()).unwrap();
    assert!(source.next().unwrap().is_ok());
    let error = source.next().unwrap().unwrap_err();
    assert!(error.to_string().starts_with("b.png has 9×6 px, but the first frame has 8×6 px"), "{error}");
    assert!(source.next().is_none());
    std::fs::write(dir.path().join("b.png"), "no image").unwrap();
    let error = open(dir.path()).unwrap().nth(1).unwrap().unwrap_err();
    assert!(matches!(&error, VideoError::Image { name, .. } if name == "b.png"), "{error}");
}

#[test]
fn folders_and_rates_that_make_no_video_are_refused() {
    assert!(matches!(open_error(folder().path()), VideoError::NoImages));
    assert!(matches!(open_error(Path::new("no such folder")), VideoError::NotFound));
    let dir = image_folder(&["a.png"]);
    for fps in [0.0, -3.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(video::open(dir.path(), &VideoOptions { fps: Some(fps) }), Err(VideoError::BadFps { .. })), "{fps}");
    }
}

#[test]
fn a_real_walk_of_images_is_read() {
    let Some(dir) = data("icsl_square3_corridor_walk/rgb") else { return };
    let mut source = video::open(&dir, &VideoOptions { fps: Some(12.0) }).unwrap();
    assert_eq!((source.size(), source.frame_count()), ((640, 480), Some(220)));
    assert_eq!(source.by_ref().take(3).filter(Result::is_ok).count(), 3);
}

// ---- video: MP4

#[test]
fn an_mp4_gives_its_pictures_with_its_own_uneven_stamps() {
    let dir = folder();
    let path = dir.path().join("clip.mp4");
    let clip = Clip::of(64, 48, vec![3000, 3003, 1500, 6000, 3000, 90_000, 3000, 3000, 3000, 3000]);
    clip.write(&path);
    let source = open(&path).unwrap();
    assert_eq!((source.size(), source.frame_count()), ((64, 48), Some(10)));
    assert_eq!((source.info().backend, source.info().rotation_deg), (VideoBackend::BuiltIn, 0));
    let frames: Vec<VideoFrame> = source.map(Result::unwrap).collect();
    let mut tick = 0;
    for (i, frame) in frames.iter().enumerate() {
        assert_eq!(frame.stamp, Stamp((f64::from(tick) / 90_000.0 * 1e9).round() as i64), "frame {i}");
        // Lossy coding of flat areas: a few grey levels; frames differ by 8.
        assert!(frame.image.at(50, 40).abs_diff(clip.brightness(i, 50, 40)) <= 3, "frame {i}");
        tick += clip.durations[i];
    }
    assert_eq!(frames.len(), 10);
}

#[test]
fn a_phones_turned_picture_is_put_upright_once() {
    let dir = folder();
    let path = dir.path().join("clip.mp4");
    // The bright block is in the sensor's top left corner; where it is after the turn is what the phone's screen shows.
    let turns = [([1, 0, 0, 1], 0, (64, 48), (2, 2)), ([0, 1, -1, 0], 90, (48, 64), (45, 2))];
    let more = [([-1, 0, 0, -1], 180, (64, 48), (61, 45)), ([0, -1, 1, 0], 270, (48, 64), (2, 61))];
    for (matrix, rotation_deg, size, (u, v)) in turns.into_iter().chain(more) {
        Clip { matrix, ..Clip::of(64, 48, vec![3000; 3]) }.write(&path);
        let mut source = open(&path).unwrap();
        assert_eq!((source.size(), source.info().rotation_deg), (size, rotation_deg));
        let frame = source.next().unwrap().unwrap();
        assert_eq!((frame.image.width(), frame.image.height()), size);
        assert!(frame.image.at(u, v) > 200, "turned by {rotation_deg}°, the corner's block is at {u}, {v}");
        assert!(frame.image.at(size.0 / 2, size.1 / 2) < 60);
    }
}

#[test]
fn an_edit_list_shifts_the_stamps_and_cuts_the_beginning() {
    let dir = folder();
    let path = dir.path().join("clip.mp4");
    // Starts with the third frame, after a pause of half a second.
    Clip { edit: Some((6000, 500)), ..Clip::of(64, 48, vec![3000; 6]) }.write(&path);
    let frames = frames(&path);
    assert_eq!(stamps(&frames), [500_000_000, 533_333_333, 566_666_667, 600_000_000]);
    assert!(frames[0].image.at(50, 40).abs_diff(30 + 16) <= 3, "the first one shown is the third");
}

#[test]
fn a_cut_off_mp4_gives_what_is_there_then_says_so() {
    let dir = folder();
    let path = dir.path().join("clip.mp4");
    Clip::of(64, 48, vec![3000; 20]).write(&path);
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() - 30]).unwrap();
    let items: Vec<_> = open(&path).unwrap().collect();
    let good = items.iter().filter(|item| item.is_ok()).count();
    assert!(good > 0 && good < 20, "{good} frames");
    assert!(items[..good].iter().all(Result::is_ok) && items.len() == good + 1);
    assert!(matches!(items[good], Err(VideoError::Truncated { decoded, expected: 20 }) if decoded == good), "{:?}", items[good]);
}

#[test]
fn a_recording_without_its_index_says_so() {
    let dir = folder();
    let path = dir.path().join("clip.mp4");
    Clip { index_first: false, ..Clip::of(64, 48, vec![3000; 20]) }.write(&path);
    assert_eq!(frames(&path).len(), 20);
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(matches!(open_error(&path), VideoError::NoIndex));
}

#[test]
fn files_that_only_claim_to_be_videos_are_told_apart() {
    let dir = folder();
    let path = dir.path().join("clip.mp4");
    std::fs::write(&path, "").unwrap();
    assert!(matches!(open_error(&path), VideoError::EmptyFile));
    std::fs::write(&path, "<html>please log in</html>").unwrap();
    let error = open_error(&path).to_string();
    assert!(error.contains("text file"), "{error}");
    GrayImage::new(4, 4).save(dir.path().join("one.png")).unwrap();
    let error = open_error(&dir.path().join("one.png")).to_string();
    assert!(error.contains("single image"), "{error}");
    Clip::of(64, 48, vec![3000; 2]).write(&path);
    let sound: Vec<u8> = std::fs::read(&path).unwrap();
    let at = sound.windows(4).position(|w| w == b"vide").unwrap();
    std::fs::write(&path, [&sound[..at], b"soun", &sound[at + 4..]].concat()).unwrap();
    assert!(matches!(open_error(&path), VideoError::NoVideoTrack));
    std::fs::write(&path, b"\0\0\0\x10ftypisom\0\0\0\0").unwrap();
    assert!(matches!(open_error(&path), VideoError::NoIndex));
    // Bytes of no format: with ffmpeg, it says that it knows none; without, that it would be needed.
    std::fs::write(&path, [0xfe, 0, 1, 0xff, 3].repeat(100)).unwrap();
    assert!(matches!(open_error(&path), VideoError::NeedsFfmpeg { .. } | VideoError::NothingDecoded { .. }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn no_damage_makes_the_reader_panic(hits in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..6), keep in 0.2..1.0f64) {
        use std::sync::OnceLock;
        static CLIP: OnceLock<Vec<u8>> = OnceLock::new();
        let clean = CLIP.get_or_init(|| {
            let dir = folder();
            let path = dir.path().join("clip.mp4");
            Clip { edit: Some((3000, 0)), ..Clip::of(32, 32, vec![3000; 4]) }.write(&path);
            std::fs::read(&path).unwrap()
        });
        let dir = folder();
        let path = dir.path().join("clip.mp4");
        let mut bytes = clean.clone();
        // The index is what is parsed here; the first bytes stay, so that it is parsed at all.
        let index = clean.windows(4).position(|w| w == b"mdat").unwrap() - 4;
        for (place, value) in hits {
            bytes[28 + (place * (index - 28) as f64) as usize] = value;
        }
        bytes.truncate((keep * 1.2 * clean.len() as f64) as usize);
        std::fs::write(&path, bytes).unwrap();
        if let Ok(source) = open(&path) {
            // Stops at the first error, and never gives more frames than a damaged count could ask for.
            prop_assert!(source.take(1000).count() < 1000);
        }
    }
}

#[test]
fn a_real_clip_with_b_frames_comes_complete_and_in_order() {
    let Some(path) = data("rendered_hilti/steady.mp4") else { return };
    let mut source = open(&path).unwrap();
    assert_eq!(source.size(), (640, 480));
    assert!(source.frame_count().unwrap() >= 3066);
    // 30 frames per second exactly; past the first key frame interval of 250 frames, where the decoder begins anew.
    for i in 0..300i64 {
        let frame = source.next().unwrap().unwrap();
        assert_eq!(frame.stamp, Stamp((i * 1_000_000_000 + 15) / 30), "frame {i}");
    }
    assert_eq!(source.info().dropped, 0);
    let dir = folder();
    let cut = dir.path().join("cut.mp4");
    std::fs::write(&cut, &std::fs::read(&path).unwrap()[..300_000]).unwrap();
    assert!(matches!(open_error(&cut), VideoError::NoIndex));
}

/// Runs ffmpeg to make a clip; false, said on stderr, where there is none.
fn ffmpeg(arguments: &[&str], out: &Path) -> bool {
    let run = std::process::Command::new("ffmpeg").args(["-loglevel", "error", "-y"]).args(arguments).arg(out).status();
    let made = run.is_ok_and(|status| status.success());
    if !made {
        std::io::Write::write_all(&mut std::io::stderr(), b"skipped: no ffmpeg that can make this clip\n").unwrap();
    }
    made
}

#[test]
fn built_in_decoder_and_ffmpeg_agree_on_b_frames_and_rotation() {
    let dir = folder();
    let (h264, hevc) = (dir.path().join("h264.mp4"), dir.path().join("hevc.mp4"));
    let source = ["-f", "lavfi", "-i", "testsrc2=size=128x96:rate=30:duration=2", "-pix_fmt", "yuv420p"];
    let with = |more: &[&'static str]| [&source[..], more].concat();
    let made = ffmpeg(&with(&["-c:v", "libx264", "-bf", "3", "-g", "20", "-crf", "10"]), &h264)
        && ffmpeg(&with(&["-c:v", "libx265", "-x265-params", "log-level=none:crf=10"]), &hevc);
    if !made {
        return;
    }
    let (ours, theirs) = (frames(&h264), frames(&hevc));
    assert_eq!((ours.len(), open(&h264).unwrap().info().backend), (60, VideoBackend::BuiltIn));
    assert_eq!((theirs.len(), open(&hevc).unwrap().info().backend), (60, VideoBackend::Ffmpeg));
    assert_eq!(stamps(&ours), stamps(&theirs));
    assert_eq!(open(&hevc).unwrap().frame_count(), Some(60));
    for (a, b) in ours.iter().zip(&theirs) {
        let off: u32 = a.image.data().iter().zip(b.image.data()).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        // Two lossy codings of one picture; neighbouring frames of this moving pattern are some 10 levels apart.
        assert!(f64::from(off) / a.image.data().len() as f64 <= 3.0, "at {:?}", a.stamp);
    }
}

#[test]
fn a_video_that_ffmpeg_reads_to_a_cut_off_end_says_so_too() {
    let dir = folder();
    let (path, turned) = (dir.path().join("clip.mp4"), dir.path().join("turned.mp4"));
    let source = ["-f", "lavfi", "-i", "testsrc2=size=128x96:rate=30:duration=2", "-pix_fmt", "yuv420p", "-c:v", "mpeg4"];
    if !ffmpeg(&[&source[..], &["-movflags", "+faststart"]].concat(), &path) {
        return;
    }
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let items: Vec<_> = open(&path).unwrap().collect();
    let good = items.iter().filter(|item| item.is_ok()).count();
    assert!(good > 5 && items.len() == good + 1, "{good} frames of {} items", items.len());
    assert!(matches!(items[good], Err(VideoError::Ffmpeg { decoded, .. }) if decoded == good), "{:?}", items[good]);
    // The display matrix is applied here too, once: the patch of the tests' own matrix, written into a whole file.
    let at = whole.windows(8).position(|w| w == [0, 1, 0, 0, 0, 0, 0, 0]).unwrap();
    let at = at + whole[at..].windows(4).position(|w| w == b"tkhd").unwrap() + 4 + 40;
    let mut bytes = whole.clone();
    for (k, value) in [0i32, 1 << 16, 0, -1 << 16, 0].into_iter().enumerate() {
        bytes[at + 4 * k..][..4].copy_from_slice(&value.to_be_bytes());
    }
    std::fs::write(&turned, &bytes).unwrap();
    std::fs::write(&path, &whole).unwrap();
    let (upright, turned) = (open(&path).unwrap().next().unwrap().unwrap(), open(&turned).unwrap());
    assert_eq!((turned.size(), turned.info().rotation_deg), ((96, 128), 90));
    let turned = turned.map(Result::unwrap).next().unwrap();
    assert_eq!(turned.image.at(95, 0), upright.image.at(0, 0));
    assert_eq!(turned.image.at(0, 127), upright.image.at(127, 95));
}
