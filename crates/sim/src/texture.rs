//! How bright is this piece of surface? Procedural textures, averaged over what one pixel sees of them.
//!
//! Every function takes the footprint of the pixel, metres along each axis of the surface, and answers with the mean over it:
//! edges by the exact share of a box, random cells by the shares of the cells under the box, smooth noise by fading out
//! as its grain falls under the footprint. So far away surfaces are smooth, not alive with aliases that a tracker would follow.
//!
//! Only `+ − × ÷ √` and rounding: the same bits on every machine. Brightness is 0..=1, as the picture shows it in full light.

use crate::building::RoomKind;
use crate::world::{Decor, DecorKind, Face, SolidKind};

/// A place on a surface with the size of the pixel's footprint there, metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub u: f32,
    pub v: f32,
    pub fu: f32,
    pub fv: f32,
}

impl Spot {
    /// The same spot in units of `du` × `dv`, counted from (u0, v0).
    pub fn scaled(self, u0: f32, v0: f32, du: f32, dv: f32) -> Self {
        Self { u: (self.u - u0) / du, v: (self.v - v0) / dv, fu: self.fu / du, fv: self.fv / dv }
    }
}

/// Well-mixed bits of a counter (the finaliser of MurmurHash3, twice over two words).
#[inline]
pub(crate) fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let mut h = x.wrapping_mul(0x85eb_ca6b) ^ y.wrapping_mul(0xc2b2_ae35).rotate_left(15) ^ seed.wrapping_mul(0x9e37_79b9);
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// A number in 0..1 for each cell.
#[inline]
pub(crate) fn cell(x: i32, y: i32, seed: u32) -> f32 {
    (hash(x as u32, y as u32, seed) >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The largest whole number not above `x`. `f32::floor` is a call into the C library on processors without SSE 4.1.
#[inline]
fn floor_of(x: f32) -> i32 {
    let cut = x as i32;
    cut.wrapping_sub(i32::from((cut as f32) > x))
}

/// Smooth noise, −1..=1, one grain a unit; fades out where the footprint is larger than half a grain.
#[inline]
pub(crate) fn noise(u: f32, v: f32, footprint: f32, seed: u32) -> f32 {
    let fade = (2.0 - 2.0 * footprint).clamp(0.0, 1.0);
    if fade == 0.0 {
        return 0.0;
    }
    let (i, j) = (floor_of(u), floor_of(v));
    let (a, b) = (u - i as f32, v - j as f32);
    let (a, b) = (a * a * (3.0 - 2.0 * a), b * b * (3.0 - 2.0 * b));
    let low = cell(i, j, seed) * (1.0 - a) + cell(i.wrapping_add(1), j, seed) * a;
    let high = cell(i, j.wrapping_add(1), seed) * (1.0 - a) + cell(i.wrapping_add(1), j.wrapping_add(1), seed) * a;
    fade * (2.0 * (low * (1.0 - b) + high * b) - 1.0)
}

/// Share of the footprint around `x` that lies between `low` and `high`.
#[inline]
pub(crate) fn band(x: f32, low: f32, high: f32, footprint: f32) -> f32 {
    let f = footprint.max(1e-5);
    ((x - low) / f + 0.5).clamp(0.0, 1.0) - ((x - high) / f + 0.5).clamp(0.0, 1.0)
}

/// Share of the footprint covered by lines of `width` at every whole number; all in units of the lines' distance.
#[inline]
pub(crate) fn lines(x: f32, width: f32, footprint: f32) -> f32 {
    // Integral of the pattern from 0 to x: whole lines passed, and the part of the present one.
    let integral = |x: f32| {
        let y = x + 0.5 * width;
        let whole = floor_of(y) as f32;
        whole * width + (y - whole).min(width)
    };
    let f = footprint.max(1e-5);
    ((integral(x + 0.5 * f) - integral(x - 0.5 * f)) / f).clamp(0.0, 1.0)
}

/// Cells of one random brightness each, 0..1, exact under footprints up to one cell, then fading to the mean.
#[inline]
pub(crate) fn mosaic(spot: Spot, seed: u32) -> f32 {
    let split = |x: f32, footprint: f32| {
        let f = footprint.clamp(1e-5, 1.0);
        let low = floor_of(x - 0.5 * f);
        // The share of the footprint in the second cell.
        (low, ((x + 0.5 * f - low as f32 - 1.0) / f).clamp(0.0, 1.0))
    };
    let (i, a) = split(spot.u, spot.fu);
    let (j, b) = split(spot.v, spot.fv);
    let row = |j: i32| if a > 0.0 { cell(i, j, seed) * (1.0 - a) + cell(i.wrapping_add(1), j, seed) * a } else { cell(i, j, seed) };
    let value = if b > 0.0 { row(j) * (1.0 - b) + row(j.wrapping_add(1)) * b } else { row(j) };
    0.5 + (value - 0.5) / (spot.fu.max(1.0) * spot.fv.max(1.0))
}

/// Brightness of an upright face.
pub(crate) fn face(face: &Face, spot: Spot) -> f32 {
    let mut value = match face.kind {
        SolidKind::Wall | SolidKind::Lintel => plaster(face, spot),
        SolidKind::Leaf => leaf(face, spot),
        SolidKind::Cupboard => cupboard(face, spot),
        SolidKind::Desk => desk(face, spot),
        SolidKind::Shelf => shelf(face, spot),
        SolidKind::Plant => plant(face, spot),
        SolidKind::Bin => 0.22 + 0.3 * cell(1, 1, face.seed) + 0.25 * band(spot.v, face.z[1] as f32 - 0.05, 9.0, spot.fv),
        SolidKind::Crate => crate_side(face, spot),
        SolidKind::Whiteboard => whiteboard(face, spot),
        SolidKind::Soft => soft(face, spot),
        SolidKind::Counter => counter(face, spot),
    };
    for decor in &face.decor {
        let margin_u = 0.5 * spot.fu;
        let margin_v = 0.5 * spot.fv;
        let (s, z) = (decor.s.map(|v| v as f32), decor.z.map(|v| v as f32));
        if spot.u < s[0] - margin_u || spot.u > s[1] + margin_u || spot.v < z[0] - margin_v || spot.v > z[1] + margin_v {
            continue;
        }
        let share = band(spot.u, s[0], s[1], spot.fu) * band(spot.v, z[0], z[1], spot.fv);
        value += share * (hung(decor, s, z, spot) - value);
    }
    value
}

/// Painted plaster: brush, roller and stains, and a skirting board.
fn plaster(face: &Face, spot: Spot) -> f32 {
    // All walls of a room have one paint.
    let tone = 0.70 + 0.12 * cell(face.room.map_or(-1, |room| room as i32), 0, 17);
    // A jamb or a short end is a painted board.
    let rough = if face.length < 0.2 { 0.2 } else { face.roughness };
    let f = spot.fu.max(spot.fv);
    let grain = 0.030 * noise(spot.u * 55.0, spot.v * 55.0, 55.0 * f, face.seed)
        + 0.030 * noise(spot.u * 17.0, spot.v * 17.0, 17.0 * f, face.seed ^ 0x51)
        + 0.035 * noise(spot.u * 3.1, spot.v * 2.3, 3.1 * f, face.seed ^ 0x52);
    let wall = tone + rough * grain;
    if face.z[0] > 0.0 || spot.v > 0.2 {
        return wall;
    }
    let skirting = band(spot.v, -1.0, 0.09, spot.fv);
    wall + skirting * (0.34 - wall)
}

/// A door: veneer, two panels, a handle with its plate, a kick plate.
fn leaf(face: &Face, spot: Spot) -> f32 {
    let veneer = 0.46 + 0.05 * noise(spot.u * 40.0, spot.v * 2.5, 40.0 * spot.fu, 7) + 0.02 * noise(spot.u * 6.0, spot.v, 6.0 * spot.fu, 8);
    if face.length < 0.2 {
        return veneer;
    }
    let width = face.length as f32;
    let mut value = veneer;
    for (low, high) in [(0.30, 0.95), (1.12, 1.95)] {
        let outer = band(spot.u, 0.14, width - 0.14, spot.fu) * band(spot.v, low, high, spot.fv);
        let inner = band(spot.u, 0.17, width - 0.17, spot.fu) * band(spot.v, low + 0.03, high - 0.03, spot.fv);
        value -= 0.16 * (outer - inner);
    }
    let handle = band(spot.u, 0.05, 0.19, spot.fu) * band(spot.v, 1.03, 1.055, spot.fv);
    let plate = band(spot.u, 0.055, 0.095, spot.fu) * band(spot.v, 0.93, 1.10, spot.fv);
    let kick = band(spot.v, -1.0, 0.16, spot.fv);
    value += (0.85 - value) * plate;
    value += (0.15 - value) * handle;
    value + (0.62 - value) * kick
}

/// Doors of half a metre with dark gaps, and things behind glass in the upper part of some.
fn cupboard(face: &Face, spot: Spot) -> f32 {
    let tone = 0.30 + 0.4 * cell(3, 1, face.seed);
    let height = face.z[1] as f32;
    let gap = lines(spot.u / 0.45, 0.03, spot.fu / 0.45).max(lines(spot.v / 0.42, 0.03, spot.fv / 0.42));
    let books = cell(4, 2, face.seed) < 0.5 && spot.v > 0.45 && spot.v < height - 0.05;
    let front = if books { 0.1 + 0.8 * mosaic(spot.scaled(0.0, 0.0, 0.045, 0.42), face.seed) } else { tone };
    front + gap * (0.12 - front)
}

/// A panel under a light board.
fn desk(face: &Face, spot: Spot) -> f32 {
    let panel = 0.42 + 0.03 * noise(spot.u * 30.0, spot.v * 3.0, 30.0 * spot.fu, face.seed);
    let board = band(spot.v, face.z[1] as f32 - 0.04, 9.0, spot.fv);
    panel + board * (0.72 - panel)
}

/// Boards every 35 cm, books of any height and some gaps between them.
fn shelf(face: &Face, spot: Spot) -> f32 {
    let (width, height) = (face.length as f32, face.z[1] as f32);
    let books = mosaic(spot.scaled(0.0, 0.0, 0.04, 0.35), face.seed);
    let groups = mosaic(spot.scaled(0.0, 0.0, 0.27, 0.35), face.seed ^ 0x61);
    // Where a group is missing one looks at the shadowed back.
    let full = ((groups - 0.25) * 12.0).clamp(0.0, 1.0);
    let inside = 0.10 + full * (0.05 + 0.75 * books);
    let board = lines(spot.v / 0.35, 0.07, spot.fv / 0.35).max(1.0 - band(spot.u, 0.025, width - 0.025, spot.fu)).max(band(
        spot.v,
        height - 0.03,
        9.0,
        spot.fv,
    ));
    inside + board * (0.58 - inside)
}

/// Leaves over a pot.
fn plant(face: &Face, spot: Spot) -> f32 {
    let f = spot.fu.max(spot.fv);
    let leaves = 0.26
        + 0.16 * noise(spot.u * 14.0, spot.v * 9.0, 14.0 * f, face.seed)
        + 0.10 * noise(spot.u * 34.0, spot.v * 25.0, 34.0 * f, face.seed ^ 0x33);
    let pot = band(spot.v, -1.0, 0.34, spot.fv);
    leaves + pot * (0.62 - leaves)
}

/// Cardboard with tape and a label.
fn crate_side(face: &Face, spot: Spot) -> f32 {
    let (width, height) = (face.length as f32, face.z[1] as f32);
    let board = 0.50 + 0.03 * noise(spot.u * 60.0, spot.v * 4.0, 60.0 * spot.fu, face.seed);
    let tape = band(spot.u, 0.5 * width - 0.03, 0.5 * width + 0.03, spot.fu) * band(spot.v, 0.6 * height, 9.0, spot.fv);
    let label = band(spot.u, 0.08, 0.2, spot.fu) * band(spot.v, 0.15 * height, 0.15 * height + 0.09, spot.fv);
    let taped = board + 0.18 * tape;
    taped + label * (0.92 - taped)
}

/// White, with what was written last and a frame.
fn whiteboard(face: &Face, spot: Spot) -> f32 {
    let (width, low, high) = (face.length as f32, face.z[0] as f32, face.z[1] as f32);
    if width < 0.4 {
        return 0.55;
    }
    let inner = band(spot.u, 0.03, width - 0.03, spot.fu) * band(spot.v, low + 0.03, high - 0.03, spot.fv);
    let words = mosaic(spot.scaled(0.0, low, 0.05, 0.07), face.seed);
    let drawn = mosaic(spot.scaled(0.0, low, 0.31, 0.28), face.seed ^ 0x19);
    let ink =
        lines((spot.v - low) / 0.07, 0.4, spot.fv / 0.07) * (words * 2.4 - 0.9).clamp(0.0, 1.0) * ((drawn - 0.55) * 8.0).clamp(0.0, 1.0);
    let frame = 0.50;
    frame + inner * (0.88 - 0.45 * ink - frame)
}

/// Cloth with a seam every 70 cm, dark under its edge.
fn soft(face: &Face, spot: Spot) -> f32 {
    let f = spot.fu.max(spot.fv);
    let tone = 0.25 + 0.4 * cell(5, 3, face.seed);
    let cloth =
        tone + 0.05 * noise(spot.u * 80.0, spot.v * 80.0, 80.0 * f, face.seed) + 0.05 * noise(spot.u * 7.0, spot.v * 7.0, 7.0 * f, 71);
    let seam = lines(spot.u / 0.7, 0.03, spot.fu / 0.7).max(band(spot.v, 0.40, 0.42, spot.fv));
    let foot = band(spot.v, -1.0, 0.10, spot.fv);
    let cloth = cloth - 0.12 * seam;
    cloth + foot * (0.10 - cloth)
}

/// Doors of 60 cm with handles under a worktop, a dark plinth.
fn counter(face: &Face, spot: Spot) -> f32 {
    let height = face.z[1] as f32;
    let front = 0.74 - 0.35 * lines(spot.u / 0.6, 0.02, spot.fu / 0.6);
    let handle = band(spot.v, height - 0.14, height - 0.115, spot.fv) * (1.0 - lines(spot.u / 0.6, 0.6, spot.fu / 0.6));
    let top = band(spot.v, height - 0.045, 9.0, spot.fv);
    let plinth = band(spot.v, -1.0, 0.10, spot.fv);
    let value = front - 0.4 * handle;
    let value = value + top * (0.34 - value);
    value + plinth * (0.14 - value)
}

/// What a rectangle on the wall shows at a spot inside of it.
fn hung(decor: &Decor, s: [f32; 2], z: [f32; 2], spot: Spot) -> f32 {
    let (width, height) = (s[1] - s[0], z[1] - z[0]);
    let inside = |inset: f32| band(spot.u, s[0] + inset, s[1] - inset, spot.fu) * band(spot.v, z[0] + inset, z[1] - inset, spot.fv);
    match decor.kind {
        DecorKind::Trim => 0.42,
        DecorKind::Switch => 0.95 - 0.35 * (inside(0.012) - inside(0.020)),
        DecorKind::Poster => {
            let (mat, picture) = (inside(0.025), inside(0.06));
            let coarse = mosaic(spot.scaled(s[0], z[0], width / 4.0, height / 5.0), decor.seed);
            let fine = mosaic(spot.scaled(s[0], z[0], width / 15.0, height / 17.0), decor.seed ^ 0x77);
            let image = 0.12 + 0.5 * coarse + 0.32 * fine;
            let framed = 0.10 + mat * (0.90 - 0.10);
            framed + picture * (image - framed)
        }
        DecorKind::Notice => {
            // A heading, lines of text broken into words, and a box.
            let text = inside(0.03);
            let words = mosaic(spot.scaled(s[0], z[0], 0.018, 0.022), decor.seed);
            let ink = lines((spot.v - z[0]) / 0.022, 0.55, spot.fv / 0.022) * (words * 2.2 - 0.5).clamp(0.0, 1.0);
            let heading = band(spot.u, s[0] + 0.03, s[1] - 0.06, spot.fu) * band(spot.v, z[1] - 0.075, z[1] - 0.035, spot.fv);
            let paper = 0.93 - 0.62 * text * ink;
            paper + (0.12 - paper) * heading
        }
        DecorKind::Plate => {
            let mark = mosaic(spot.scaled(s[0], z[0], width / 7.0, height / 4.0), decor.seed);
            0.16 + inside(0.02) * 0.75 * (3.0 * mark - 1.2).clamp(0.0, 1.0)
        }
        DecorKind::Window => window(decor, s, z, spot, inside(0.06)),
        DecorKind::Glass => {
            // Panes of 1.1 m between dark bars, a frosted band at the height of the eyes, dim furniture behind.
            let bars = lines((spot.u - s[0]) / 1.1, 0.05, spot.fu / 1.1).max(1.0 - inside(0.05));
            let f = spot.fu.max(spot.fv);
            let behind =
                0.52 + 0.12 * noise(spot.u * 1.7, spot.v * 2.3, 2.3 * f, decor.seed) + 0.05 * noise(spot.u * 9.0, spot.v * 5.0, 9.0 * f, 5);
            let frosted = band(spot.v, 1.25, 1.55, spot.fv) * (0.6 + 0.4 * lines(spot.v / 0.05, 0.5, spot.fv / 0.05));
            let pane = behind + frosted * (0.90 - behind);
            pane + bars * (0.16 - pane)
        }
    }
}

/// Bright outdoors, soft, behind a frame with a cross bar.
fn window(decor: &Decor, s: [f32; 2], z: [f32; 2], spot: Spot, pane: f32) -> f32 {
    let middle = 0.5 * (s[0] + s[1]);
    let bar = band(spot.u, middle - 0.03, middle + 0.03, spot.fu).max(band(spot.v, z[1] - 0.40, z[1] - 0.35, spot.fv));
    let f = spot.fu.max(spot.fv);
    let trees = 0.10 * noise(spot.u * 4.0, spot.v * 4.0, 4.0 * f, decor.seed) + 0.06 * noise(spot.u * 11.0, spot.v * 11.0, 11.0 * f, 3);
    let sky = ((spot.v - z[0]) / (z[1] - z[0])).clamp(0.0, 1.0);
    let view = 0.80 + 0.25 * sky + trees * (1.2 - sky);
    let frame = 0.88;
    frame + pane * (1.0 - bar) * (view - frame)
}

/// Brightness of the top (or bottom) of a box.
pub(crate) fn lid(kind: SolidKind, spot: Spot) -> f32 {
    let f = spot.fu.max(spot.fv);
    match kind {
        SolidKind::Desk => {
            // Papers lie about.
            let papers = mosaic(spot.scaled(0.0, 0.0, 0.31, 0.24), 91);
            let ink = mosaic(spot.scaled(0.0, 0.0, 0.02, 0.03), 92);
            0.66 + if papers > 0.7 { 0.27 - 0.25 * ink } else { 0.03 * noise(spot.u * 30.0, spot.v * 4.0, 30.0 * f, 93) }
        }
        SolidKind::Lintel => 0.42,
        SolidKind::Counter => 0.36 + 0.05 * noise(spot.u * 60.0, spot.v * 60.0, 60.0 * f, 94),
        SolidKind::Soft => {
            0.45 + 0.06 * noise(spot.u * 80.0, spot.v * 80.0, 80.0 * f, 95) + 0.06 * noise(spot.u * 5.0, spot.v * 5.0, 5.0 * f, 96)
        }
        SolidKind::Plant => 0.24 + 0.2 * noise(spot.u * 16.0, spot.v * 16.0, 16.0 * f, 97),
        SolidKind::Bin => 0.15,
        SolidKind::Crate => 0.55 + 0.2 * lines(spot.u / 0.5, 0.1, spot.fu / 0.5),
        SolidKind::Wall | SolidKind::Leaf | SolidKind::Cupboard | SolidKind::Shelf | SolidKind::Whiteboard => 0.5,
    }
}

/// Brightness of the floor of a kind of room.
pub(crate) fn floor(kind: RoomKind, spot: Spot) -> f32 {
    let f = spot.fu.max(spot.fv);
    match kind {
        RoomKind::Living | RoomKind::Bedroom => {
            // Boards of 14 cm, each of its own tone, joints between them.
            let tone = mosaic(spot.scaled(0.0, 0.0, 1.9, 0.14), 61);
            let wood = 0.46
                + 0.14 * (tone - 0.5)
                + 0.05 * noise(spot.u * 5.0, spot.v * 60.0, 60.0 * f, 62)
                + 0.03 * noise(spot.u * 40.0, spot.v * 90.0, 90.0 * f, 63);
            let joint = lines(spot.v / 0.14, 0.03, spot.fv / 0.14);
            wood + joint * (0.26 - wood)
        }
        RoomKind::Kitchen | RoomKind::Bath => {
            let side = if kind == RoomKind::Bath { 0.15 } else { 0.33 };
            let tone = mosaic(spot.scaled(0.0, 0.0, side, side), 64);
            let tile = 0.58 + 0.12 * (tone - 0.5) + 0.05 * noise(spot.u * 30.0, spot.v * 30.0, 30.0 * f, 65);
            let joint = lines(spot.u / side, 0.03, spot.fu / side).max(lines(spot.v / side, 0.03, spot.fv / side));
            tile + joint * (0.32 - tile)
        }
        RoomKind::Corridor | RoomKind::Hall => {
            // Stone tiles of different tone, with joints, worn.
            let side = if kind == RoomKind::Hall { 0.6 } else { 0.4 };
            let tone = mosaic(spot.scaled(0.0, 0.0, side, side), 21);
            let stone = 0.44
                + 0.16 * (tone - 0.5)
                + 0.05 * noise(spot.u * 23.0, spot.v * 23.0, 23.0 * f, 22)
                + 0.05 * noise(spot.u * 70.0, spot.v * 70.0, 70.0 * f, 23);
            let joint = lines(spot.u / side, 0.016, spot.fu / side).max(lines(spot.v / side, 0.016, spot.fv / side));
            stone + joint * (0.20 - stone)
        }
        RoomKind::Open => {
            // Carpet in squares of 50 cm, laid in turns.
            let tone = mosaic(spot.scaled(0.0, 0.0, 0.5, 0.5), 34);
            0.34 + 0.07 * (tone - 0.5)
                + 0.06 * noise(spot.u * 85.0, spot.v * 85.0, 85.0 * f, 35)
                + 0.05 * noise(spot.u * 26.0, spot.v * 26.0, 26.0 * f, 36)
        }
        RoomKind::Office | RoomKind::Meeting => {
            // Carpet: specks of wool, and wear.
            0.33 + 0.06 * noise(spot.u * 90.0, spot.v * 90.0, 90.0 * f, 31)
                + 0.05 * noise(spot.u * 28.0, spot.v * 28.0, 28.0 * f, 32)
                + 0.04 * noise(spot.u * 2.2, spot.v * 2.2, 2.2 * f, 33)
        }
        RoomKind::Store => {
            0.40 + 0.05 * noise(spot.u * 40.0, spot.v * 40.0, 40.0 * f, 41) + 0.06 * noise(spot.u * 5.0, spot.v * 5.0, 5.0 * f, 42)
        }
    }
}

/// Brightness of the ceiling between the lamps: tiles in a metal grid, with pores.
pub(crate) fn ceiling(spot: Spot) -> f32 {
    let side = 0.6;
    let f = spot.fu.max(spot.fv);
    let tone = mosaic(spot.scaled(0.0, 0.0, side, side), 51);
    let tile = 0.80 + 0.05 * (tone - 0.5) + 0.05 * noise(spot.u * 45.0, spot.v * 45.0, 45.0 * f, 52);
    let bar = lines(spot.u / side, 0.03, spot.fu / side).max(lines(spot.v / side, 0.03, spot.fv / side));
    tile + bar * (0.58 - tile)
}

/// Share of a spot that lies in a rectangle.
pub(crate) fn share_in(spot: Spot, low: [f64; 2], high: [f64; 2]) -> f32 {
    band(spot.u, low[0] as f32, high[0] as f32, spot.fu) * band(spot.v, low[1] as f32, high[1] as f32, spot.fv)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(u: f32, footprint: f32) -> Spot {
        Spot { u, v: 0.3, fu: footprint, fv: footprint }
    }

    #[test]
    fn a_band_is_the_share_of_the_footprint_inside_it() {
        assert_eq!(band(0.5, 0.0, 1.0, 0.1), 1.0);
        assert_eq!(band(0.0, 0.0, 1.0, 0.1), 0.5);
        assert_eq!(band(2.0, 0.0, 1.0, 0.1), 0.0);
        // A footprint four times as wide as the band.
        assert!((band(0.5, 0.0, 1.0, 4.0) - 0.25).abs() < 1e-6);
    }

    #[test]
    fn far_lines_are_a_grey_of_the_same_mean() {
        for i in 0..100 {
            let share = lines(0.07 * i as f32, 0.1, 30.0);
            // A footprint of 30 lines holds 30 ± 1 of them.
            assert!((share - 0.1).abs() < 0.1 / 30.0 + 1e-4, "{share}");
        }
    }

    #[test]
    fn a_mosaic_is_continuous_in_the_place_and_flat_from_afar() {
        for i in 0..1000 {
            let (a, b) = (mosaic(spot(0.01 * i as f32, 0.2), 5), mosaic(spot(0.01 * i as f32 + 1e-4, 0.2), 5));
            // The slope is at most 1 per footprint: 1e-4 / 0.2.
            assert!((a - b).abs() < 2.0 * 1e-4 / 0.2, "{a} {b} at {i}");
            assert!((mosaic(spot(0.37 * i as f32, 100.0), 5) - 0.5).abs() < 1e-3);
        }
    }

    #[test]
    fn noise_is_centred_and_fades_with_distance() {
        let n = 4000;
        let mean = (0..n).map(|i| noise(0.73 * i as f32, 1.9 * i as f32, 0.0, 9)).sum::<f32>() / n as f32;
        // Values lie in −1..1 with a deviation of under 0.58 (uniform): 4 standard errors.
        assert!(mean.abs() < 4.0 * 0.58 / (n as f32).sqrt(), "{mean}");
        assert_eq!(noise(0.3, 0.4, 1.0, 9), 0.0);
    }
}
