//! When, and from where, is each pixel seen? Rolling shutter and motion blur: many poses make one picture.
//!
//! pose at any time ─▶ stages (what can be met, set anew every millimetre of the eye's way) ─▶ a view for each line and each
//! part of its exposure ─▶ mean of the parts in linear light ─▶ grey levels

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Cam, GrayImage, Plan, Rigid3};
use rayon::prelude::*;

use crate::camera::Shutter;
use crate::exposure::Exposure;
use crate::render::{LIMB, Lines, Renderer, Stage, Surface, View};
use crate::world::{Crowd, Watch, World};

/// The eye's way for which one stage serves, metres. At arm's length half of it is under half a bin of direction, which is the
/// slack that bins have.
const STAGE_M: f64 = 1e-3;
/// Most stages of one frame: 10 cm of way, which nobody's eye goes within a frame.
const MAX_STAGES: usize = 96;
/// How far a pixel may move within one part of an exposure: under two pixels the parts run into one another.
const PART_PX: f64 = 1.5;
/// Most parts of an exposure; beyond 36 px of blur there is nothing left that anybody could follow.
const MAX_PARTS: usize = 24;
/// Blur below this is that of the lens.
const SHARP_PX: f64 = 0.6;
/// With as many parts each is shifted a little within the pixel, and outlines need no rays of their own.
const SMOOTH_PARTS: usize = 4;
/// Depth at which the blur by the eye's own way is judged, metres.
const NEAR_M: f64 = 1.2;

/// What is filmed.
pub(crate) struct Shot<'a> {
    pub world: &'a World,
    pub crowd: &'a Crowd,
    /// The camera at any time, seconds.
    pub pose_at: &'a (dyn Fn(f64) -> Rigid3<Plan, Cam> + Sync),
    /// The frame's stamp: its middle line at the middle of its exposure, seconds.
    pub time_s: f64,
}

/// Takes one picture.
pub(crate) fn film(renderer: &Renderer, shutter: &Shutter, shot: &Shot, exposure: Exposure) -> GrayImage {
    let camera = renderer.camera();
    let (width, height) = (camera.width, camera.height);
    let values = light(renderer, shutter, shot);
    let (middle_u, middle_v) = (0.5 * (width as f32 - 1.0), 0.5 * (height as f32 - 1.0));
    let scale = 1.0 / (middle_u * middle_u + middle_v * middle_v).max(1.0);
    let mut data = vec![0u8; width * height];
    data.par_chunks_mut(width).zip(values.par_chunks(width)).enumerate().for_each(|(v, (row, values))| {
        let up = v as f32 - middle_v;
        for (u, (out, value)) in row.iter_mut().zip(values).enumerate() {
            let left = u as f32 - middle_u;
            *out = exposure.grey(*value, (left * left + up * up) * scale, u as u32, v as u32);
        }
    });
    // The sizes are those of the camera, so the fallback is never taken; it keeps this function free of panics.
    GrayImage::new(width, height, data).unwrap_or_else(|| GrayImage::from_fn(width, height, |_, _| 0))
}

/// Mean brightness of the whole picture, as an exposure meter sees it: frozen, by the renderer's own few pixels.
pub(crate) fn meter(renderer: &Renderer, shot: &Shot) -> f32 {
    let pixels = frozen(renderer, shot);
    pixels.iter().map(|(value, _)| value.min(1.0)).sum::<f32>() / pixels.len().max(1) as f32
}

/// Share of the picture that people fill.
pub(crate) fn people_share(renderer: &Renderer, shot: &Shot) -> f64 {
    let pixels = frozen(renderer, shot);
    pixels.iter().filter(|(_, surface)| surface & LIMB != 0 && surface >> 31 == 0).count() as f64 / pixels.len().max(1) as f64
}

/// What is looked at, and how far walls let one see.
pub(crate) fn watch(renderer: &Renderer, shot: &Shot) -> Watch {
    let pose = (shot.pose_at)(shot.time_s);
    let stage = stage(shot, &pose, shot.time_s);
    let rays = renderer.sightlines(&View::new(shot.world, &stage, &pose, renderer.camera()));
    Watch { time_s: shot.time_s, plan_from_camera: pose.iso, rays }
}

fn frozen(renderer: &Renderer, shot: &Shot) -> Vec<(f32, Surface)> {
    let pose = (shot.pose_at)(shot.time_s);
    let stage = stage(shot, &pose, shot.time_s);
    renderer.shade(&Lines { views: vec![View::new(shot.world, &stage, &pose, renderer.camera())], step: [0, 0] })
}

fn stage(shot: &Shot, pose: &Rigid3<Plan, Cam>, time_s: f64) -> Stage {
    let eye = pose.iso.translation.vector;
    let cast = shot.crowd.cast(time_s, &pose.iso);
    Stage::new(shot.world, cast, [eye.x, eye.y])
}

/// Brightness of every pixel, over the whole exposure.
fn light(renderer: &Renderer, shutter: &Shutter, shot: &Shot) -> Vec<f32> {
    let half_s = 0.5 * (shutter.readout_s + shutter.exposure_s);
    let stages = Stages::new(shot, half_s);
    let parts = parts(renderer, shutter, shot);
    if parts == 1 {
        return renderer.draw(&lines(renderer, shutter, shot, &stages, 0.0, [0.0, 0.0]));
    }
    let mut sum = vec![0f32; renderer.camera().width * renderer.camera().height];
    for part in 0..parts {
        let offset_s = ((part as f64 + 0.5) / parts as f64 - 0.5) * shutter.exposure_s;
        let many = parts >= SMOOTH_PARTS;
        let lines = lines(renderer, shutter, shot, &stages, offset_s, if many { shift(part) } else { [0.0, 0.0] });
        // Brightness is as pictures show it; light adds up before that curve, which is close to a square root.
        if many {
            let drawn = renderer.shade(&lines);
            sum.par_iter_mut().zip(drawn.par_iter()).for_each(|(sum, (value, _))| *sum += value * value);
        } else {
            let drawn = renderer.draw(&lines);
            sum.par_iter_mut().zip(drawn.par_iter()).for_each(|(sum, value)| *sum += value * value);
        }
    }
    sum.par_iter_mut().for_each(|value| *value = (*value / parts as f32).sqrt());
    sum
}

/// Where in the pixel this part's ray goes, pixels from its middle: four places of a rotated square in turn.
fn shift(part: usize) -> [f64; 2] {
    [[-0.375, -0.125], [0.125, -0.375], [0.375, 0.125], [-0.125, 0.375]][part % 4]
}

/// The views of all lines, `offset_s` from the middle of each line's exposure, shifted by a part of a pixel.
fn lines<'a>(renderer: &Renderer, shutter: &Shutter, shot: &Shot<'a>, stages: &'a Stages, offset_s: f64, shift_px: [f64; 2]) -> Lines<'a> {
    let camera = renderer.camera();
    let turned = Vector3::new(-shift_px[1] / camera.fy, shift_px[0] / camera.fx, 0.0);
    let view = |delay_s: f64| {
        let time_s = shot.time_s + delay_s + offset_s;
        let mut pose = (shot.pose_at)(time_s);
        if turned != Vector3::zeros() {
            // A part of a pixel is a turn so small that sine and angle are the same.
            let twist = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(1.0, 0.5 * turned.x, 0.5 * turned.y, 0.0));
            pose.iso.rotation *= twist;
        }
        View::new(shot.world, stages.at(delay_s + offset_s), &pose, camera)
    };
    if shutter.readout_s <= 0.0 {
        return Lines { views: vec![view(0.0)], step: [0, 0] };
    }
    let (count, step) = if shutter.columns { (camera.width, [1, 0]) } else { (camera.height, [0, 1]) };
    let views = (0..count).map(|line| view(shutter.delay_s(camera, line as f64, line as f64))).collect();
    Lines { views, step }
}

/// Stages along the eye's way through a frame.
struct Stages {
    all: Vec<Stage>,
    half_s: f64,
}

impl Stages {
    fn new(shot: &Shot, half_s: f64) -> Self {
        let ends = [-half_s, half_s].map(|s| (shot.pose_at)(shot.time_s + s).iso.translation.vector);
        let count = (((ends[1] - ends[0]).norm() / STAGE_M).ceil() as usize).clamp(1, MAX_STAGES);
        let middle_s = |i: usize| ((2 * i + 1) as f64 / count as f64 - 1.0) * half_s;
        let all = (0..count)
            .into_par_iter()
            .map(|i| {
                let time_s = shot.time_s + middle_s(i);
                stage(shot, &(shot.pose_at)(time_s), time_s)
            })
            .collect();
        Self { all, half_s }
    }

    /// The stage for a moment, seconds from the frame's stamp.
    fn at(&self, delay_s: f64) -> &Stage {
        let place = if self.half_s > 0.0 { 0.5 * (delay_s / self.half_s + 1.0) * self.all.len() as f64 } else { 0.0 };
        &self.all[(place.max(0.0) as usize).min(self.all.len() - 1)]
    }
}

/// Parts of an exposure, by how far pixels move in it.
fn parts(renderer: &Renderer, shutter: &Shutter, shot: &Shot) -> usize {
    if shutter.exposure_s <= 0.0 {
        return 1;
    }
    let moved_px = |middle_s: f64| {
        let [a, b] = [-0.5, 0.5].map(|half| (shot.pose_at)(shot.time_s + middle_s + half * shutter.exposure_s).iso);
        let along = (b.translation.vector - a.translation.vector).norm();
        // The vector part of the turn between them is half its angle; roll moves the middle less, which is on the safe side.
        let turn_rad = 2.0 * (a.rotation.inverse() * b.rotation).coords.xyz().norm();
        renderer.camera().focal_px() * (turn_rad + along / NEAR_M)
    };
    let most_px = [-0.5, 0.0, 0.5].map(|end| moved_px(end * shutter.readout_s)).into_iter().fold(0.0, f64::max);
    if most_px < SHARP_PX { 1 } else { ((most_px / PART_PX).ceil() as usize).clamp(2, MAX_PARTS) }
}
