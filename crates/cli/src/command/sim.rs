//! `planwalk sim`: a walk with known truth, as pictures or as odometry.

use std::path::PathBuf;

use planwalk::tables;
use planwalk::types::{FloorPlan, GrayImage, Seed, Stamp, VideoFrame};
use planwalk_sim::{CameraOptions, OdometryNoise, Scene, SceneOptions, SimError, SimulatedOdometry, Walk, WalkStatistics, walk_statistics};
use rayon::prelude::*;
use serde::Serialize;

use crate::args::{SimArgs, SimKind};
use crate::failure::Failure;
use crate::output::Output;
use crate::say::{self, Voice};
use crate::simulate::{SceneFile, Site, walk_along};

/// Frames on the contact sheet, in rows of this many.
const SHEET: (usize, usize) = (16, 4);
/// Width of each, pixels.
const SHEET_PX: usize = 320;
/// Cell and margin of the plans, metres: the scene's own.
const PLAN_M: (f64, f64) = (0.05, 1.0);

/// What `result.json` says of a simulation.
#[derive(Serialize)]
struct Summary<'a> {
    schema: &'a str,
    version: &'a str,
    command: &'a str,
    seed: u64,
    walks: u64,
    frames: usize,
    length_m: f64,
    doors_passed: usize,
    /// Of the truth; comparable with those of any other path.
    statistics: Option<WalkStatistics>,
    notes: &'a [String],
}

/// Simulates.
pub fn run(args: &SimArgs) -> Result<(), Failure> {
    let voice = Voice { quiet: args.common.quiet };
    let file = SceneFile::of(args)?;
    if !(args.odometry_hz > 0.0 && args.odometry_hz <= 1000.0) {
        return Err(Failure::usage(format!("{} poses a second is no rate: give more than 0 and at most 1000", args.odometry_hz)));
    }
    let site = Site::of(args, &file)?;
    let output = Output::open(&args.common.output, args.common.force)?;
    if let Some(threads) = args.common.threads {
        // Built once a process; a second build can only fail in tests that call commands in one process.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global();
    }
    if args.what == SimKind::Video && args.walks > 1 {
        return Err(Failure::usage(format!("{} walks are for odometry: planwalk sim odometry --walks {}", args.walks, args.walks)));
    }
    let said = toml::to_string(&file).map_err(|why| Failure::output(why, &output.path("scene.toml")))?;
    output.write("scene.toml", format!("# {}\n{said}", again(args)))?;
    match args.what {
        SimKind::Video => video(args, &file, &site, &output, voice),
        SimKind::Odometry => odometry(args, &file, &site, &output, voice),
    }
}

/// What makes the same once more: the scene's options are in the file, what it is about and what was given are not.
fn again(args: &SimArgs) -> String {
    let mut command = "planwalk sim".to_owned();
    let mut add = |option: &str, value: Option<String>| {
        if let Some(value) = value {
            command.push_str(&format!(" {option}{value}"));
        }
    };
    let path = |path: &Option<PathBuf>| path.as_ref().map(|path| format!("{:?}", path.display().to_string()));
    add("", (args.what == SimKind::Odometry).then(|| format!("odometry --walks {}", args.walks)));
    add("--scene ", Some("scene.toml".to_owned()));
    add("--plan ", path(&args.plan));
    for (name, value) in args.reading.said() {
        add(&format!("--{name} "), Some(value));
    }
    add("--path ", path(&args.path));
    add("--path-frame ", args.path.as_ref().map(|_| format!("{:?}", args.path_frame).to_lowercase()));
    add("--mount ", args.mount.map(|[x, y, z]| format!("{x},{y},{z}")));
    add("--odometry-hz ", Some(args.odometry_hz.to_string()));
    command + " -o DIR"
}

/// A scene that cannot be: an option out of its range, or no way to walk.
fn refused(why: SimError) -> Failure {
    match why {
        SimError::NoWalk { .. } => Failure::no_answer(why),
        other => Failure::usage(other),
    }
}

/// A walker's scene, or one along a given path.
fn scene_of(site: &Site, given: Option<&Walk>, building: Seed, options: &SceneOptions) -> Result<Scene, Failure> {
    let scene = match given {
        Some(walk) => site.building(building).and_then(|building| Scene::along(building, walk.clone(), options)),
        None => site.scene(building, options),
    };
    scene.map_err(refused)
}

/// The path of the camera, where one is given.
fn given_walk(args: &SimArgs) -> Result<Option<Walk>, Failure> {
    let mount_rad = args.mount.unwrap_or_default().map(f64::to_radians);
    let walk = |path: &PathBuf| walk_along(path, None, args.path_frame, mount_rad).map_err(|why| Failure::input("the path", why, path));
    args.path.as_ref().map(walk).transpose()
}

fn video(args: &SimArgs, file: &SceneFile, site: &Site, output: &Output, voice: Voice) -> Result<(), Failure> {
    let options = file.options();
    let scene = scene_of(site, given_walk(args)?.as_ref(), options.seed, &options)?;
    write_plans(output, &scene)?;
    output.write_by("camera.yaml", |path| planwalk_io::camera::write(path, scene.camera()))?;
    output.write_by("truth.tum", |path| planwalk_io::trajectory::write_tum(path, scene.truth()))?;
    let noise = file.noise.unwrap_or_else(OdometryNoise::none);
    write_odometry(output, &scene.odometry(&noise, args.odometry_hz))?;
    let mut notes = Vec::new();
    let frames = output.path("frames");
    let mut writer = planwalk_io::video::FolderWriter::new(&frames).map_err(|why| Failure::output(why, &frames))?;
    let count = scene.frame_count();
    let bar = voice.bar("filming", Some(count as u64));
    let mut sheet = Vec::new();
    for (index, frame) in scene.frames().enumerate() {
        writer.push(&frame).map_err(|why| Failure::output(why, &frames))?;
        if index * SHEET.0 / count.max(1) >= sheet.len() {
            sheet.push(small(&frame));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    writer.finish().map_err(|why| Failure::output(why, &frames))?;
    output.write_by("contact.png", |path| planwalk_io::video::write_picture(path, &contact_sheet(&sheet)))?;
    let mp4 = output.path("video.mp4");
    if !planwalk_io::video::encode_folder(&frames, scene.camera_options().fps, &mp4) {
        // Half a file is worse than none.
        let _ = std::fs::remove_file(&mp4);
        notes.push("no video.mp4: there is no ffmpeg program with an H.264 encoder on the PATH; frames/ is the video".to_owned());
    }
    let summary = Summary {
        schema: "planwalk-sim/1",
        version: env!("CARGO_PKG_VERSION"),
        command: "sim",
        seed: file.seed,
        walks: 1,
        frames: count,
        length_m: scene.walk().length_m(),
        doors_passed: scene.walk().doors_passed(),
        statistics: statistics(&scene),
        notes: &notes,
    };
    end(args, output, voice, &summary)?;
    voice.say(&format!("contact sheet: {}", output.path("contact.png").display()));
    let mut locate = format!("  planwalk locate {} --camera {}", frames.display(), output.path("camera.yaml").display());
    locate.push_str(&format!(" --plan {} -o OUT", output.path("plan.yaml").display()));
    voice.say(&format!("to find it again:\n{locate}"));
    Ok(())
}

/// Many walks through the same building, without a picture. `world.yaml` is that of the first: furniture moves from walk to walk.
fn odometry(args: &SimArgs, file: &SceneFile, site: &Site, output: &Output, voice: Voice) -> Result<(), Failure> {
    let noise = file.noise.unwrap_or_else(OdometryNoise::monocular);
    // Nobody looks at pictures: the least camera that is one.
    let camera = CameraOptions { width: 64, height: 48, calibration: None, ..file.camera.clone() };
    let base = SceneOptions { camera, ..file.options() };
    let given = given_walk(args)?;
    let first = scene_of(site, given.as_ref(), base.seed, &base)?;
    // Every walk is through the building whose plan is written; only what stands about in it moves.
    let site = Site::Built(Box::new(first.building().clone()));
    let another = |walk: u64| {
        let options = SceneOptions { seed: base.seed.child("walk", walk), ..base.clone() };
        scene_of(&site, given.as_ref(), base.seed, &options)
    };
    write_plans(output, &first)?;
    let (bar, top) = (voice.bar("walking", Some(args.walks)), output.path(""));
    (0..args.walks).into_par_iter().try_for_each(|walk| {
        let folder = Output::beside(&if args.walks == 1 { top.clone() } else { top.join(format!("{walk:05}")) })?;
        let scene = if walk == 0 { first.clone() } else { another(walk)? };
        let simulated = scene.odometry(&noise, args.odometry_hz);
        write_odometry(&folder, &simulated)?;
        let truth = simulated.truth.iter().map(|(stamp, pose)| (*stamp, tables::upright(pose)));
        folder.write_by("truth.tum", |path| planwalk_io::trajectory::write_tum(path, truth))?;
        bar.inc(1);
        Ok::<(), Failure>(())
    })?;
    bar.finish_and_clear();
    let summary = Summary {
        schema: "planwalk-sim/1",
        version: env!("CARGO_PKG_VERSION"),
        command: "sim odometry",
        seed: file.seed,
        walks: args.walks,
        frames: 0,
        length_m: first.walk().length_m(),
        doors_passed: first.walk().doors_passed(),
        statistics: statistics(&first),
        notes: &[],
    };
    end(args, output, voice, &summary)
}

/// How the walk was walked, whatever the frame rate: sampled finely enough for steps.
fn statistics(scene: &Scene) -> Option<WalkStatistics> {
    const HZ: f64 = 30.0;
    let count = (scene.walk().duration_s() * HZ) as usize + 1;
    let pose = |i: usize| {
        let stamp = Stamp((i as f64 / HZ * 1e9).round() as i64);
        (stamp, scene.walk().at(stamp.as_secs()).plan_from_camera)
    };
    walk_statistics(&(0..count).map(pose).collect::<Vec<_>>())
}

fn end(args: &SimArgs, output: &Output, voice: Voice, summary: &Summary) -> Result<(), Failure> {
    summary.notes.iter().for_each(|note| voice.say(&format!("note: {note}")));
    // Text and numbers always become JSON.
    let json = serde_json::to_string_pretty(summary).unwrap_or_default() + "\n";
    output.write("result.json", &json)?;
    if args.common.json {
        say::stdout_text(&json);
    }
    if let Some(s) = &summary.statistics {
        let [slow, usual, fast] = s.speed_mps;
        voice.say(&format!(
            "walked {:.1} m in {:.1} s, {} doors; speed {slow:.2}, {usual:.2}, {fast:.2} m/s (5, 50, 95 %), {:.2} steps/s, bobbing {:.0} mm",
            summary.length_m,
            s.duration_s,
            summary.doors_passed,
            s.gait_hz,
            1000.0 * s.bobbing_m
        ));
    }
    Ok(())
}

/// The plan as a localiser gets it, and the world as it was: walls as built, shut doors, furniture.
fn write_plans(output: &Output, scene: &Scene) -> Result<(), Failure> {
    let built = scene.as_built_plan(PLAN_M.0, PLAN_M.1).map_err(Failure::usage)?;
    let write = |name: &str, plan: &FloorPlan| {
        let image = format!("{name}.pgm");
        output.write(&image, planwalk_io::plan::ros_map_image(plan))?;
        output.write(&format!("{name}.yaml"), planwalk_io::plan::ros_map_yaml(plan, &image))
    };
    write("plan", &scene.plan())?;
    write("world", &built)
}

fn write_odometry(output: &Output, simulated: &SimulatedOdometry) -> Result<(), Failure> {
    let poses = simulated.path.poses();
    let steps = simulated.path.stamps().zip(&poses).map(|(stamp, pose)| (stamp, tables::upright(pose)));
    output.write_by("odometry.tum", |path| planwalk_io::trajectory::write_tum(path, steps))?;
    output.write_by("sightings.csv", |path| planwalk_io::sightings::write(path, &simulated.sightings))
}

/// A frame for the contact sheet: each pixel the mean of those that it stands for.
fn small(frame: &VideoFrame) -> GrayImage {
    let image = &frame.image;
    let by = image.width().div_ceil(SHEET_PX).max(1);
    GrayImage::from_fn(image.width() / by, image.height() / by, |u, v| {
        let sum: usize = (0..by * by).map(|k| usize::from(image.data()[(v * by + k / by) * image.width() + u * by + k % by])).sum();
        (sum / (by * by)) as u8
    })
}

/// Frames in rows, in reading order.
fn contact_sheet(frames: &[GrayImage]) -> GrayImage {
    let (width, height) = frames.first().map_or((1, 1), |f| (f.width(), f.height()));
    let rows = frames.len().div_ceil(SHEET.1).max(1);
    let gap = 4;
    GrayImage::from_fn(SHEET.1 * (width + gap) - gap, rows * (height + gap) - gap, |u, v| {
        let (column, row) = (u / (width + gap), v / (height + gap));
        let (x, y) = (u % (width + gap), v % (height + gap));
        match frames.get(row * SHEET.1 + column) {
            Some(frame) if x < width && y < height => frame.data()[y * width + x],
            _ => 255,
        }
    })
}
