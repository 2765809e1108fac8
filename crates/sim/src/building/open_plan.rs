//! How is an open floor laid out? One large room around a core, with columns, and glazed rooms in two of its corners.

use planwalk_types::{Plan, Pt2, StreamRng};
use rand::RngExt;

use super::office::{DOOR_M, place};
use super::sketch::{Line, Sketch};
use super::{Room, RoomKind};

/// Free way around the core and the columns, metres.
const WAY_M: f64 = 2.0;
/// From column to column, about, metres.
const COLUMNS_M: f64 = 7.2;

/// The layout, and its true size.
pub(super) fn layout((width, depth): (f64, f64), rng: &mut StreamRng) -> (Sketch, (f64, f64)) {
    let pt = Pt2::<Plan>::new;
    // Glazed rooms: a row from the upper left corner, another one from the lower right corner.
    let (upper, lower) = (cuts(0.42 * width, rng), cuts(0.42 * width, rng));
    let (up_m, low_m) = (rng.random_range(3.5..4.2), rng.random_range(3.5..4.2));
    let up_end = upper.last().copied().unwrap_or(0.0);
    let low_start = width - lower.last().copied().unwrap_or(0.0);
    // The core keeps clear of both.
    let core_depth = (0.24 * depth).clamp(4.8, 11.0).min(depth - up_m - low_m - 2.0 * WAY_M);
    let core_width = (0.3 * width).clamp(8.0, 26.0);
    let spare = depth - up_m - low_m - 2.0 * WAY_M - core_depth;
    let y0 = low_m + WAY_M + spare * rng.random_range(0.25..0.75);
    let x0 = (width - core_width) * rng.random_range(0.38..0.62);
    let core = [x0, y0, x0 + core_width, y0 + core_depth];

    let hall = [
        pt(0.0, 0.0),
        pt(low_start, 0.0),
        pt(low_start, low_m),
        pt(width, low_m),
        pt(width, depth),
        pt(up_end, depth),
        pt(up_end, depth - up_m),
        pt(0.0, depth - up_m),
    ];
    let hole = [pt(core[0], core[1]), pt(core[2], core[1]), pt(core[2], core[3]), pt(core[0], core[3])];
    let mut rooms = vec![Room::around(RoomKind::Open, &hall, &hole)];
    let mut lines = vec![
        Line::new(0.0, 0.0, width, 0.0, vec![]),
        Line::new(0.0, depth, width, depth, vec![]),
        Line::new(0.0, 0.0, 0.0, depth, vec![]),
        Line::new(width, 0.0, width, depth, vec![]),
    ];
    let upper: Vec<f64> = upper.into_iter().collect();
    let lower: Vec<f64> = lower.into_iter().rev().map(|x| width - x).collect();
    add_row(&upper, [depth - up_m, depth], depth - up_m, &mut rooms, &mut lines, rng);
    add_row(&lower, [0.0, low_m], low_m, &mut rooms, &mut lines, rng);
    lines.push(Line::new(up_end, depth - up_m, up_end, depth, vec![]));
    lines.push(Line::new(low_start, 0.0, low_start, low_m, vec![]));
    add_core(core, &mut rooms, &mut lines, rng);
    add_columns(&rooms[0], (width, depth), &mut lines, rng);
    (Sketch { rooms, lines, door_m: DOOR_M, always_open: |_, _| false, plain: false }, (width, depth))
}

/// Ends of two to five rooms side by side, from 0, no farther than `most_m`.
fn cuts(most_m: f64, rng: &mut StreamRng) -> Vec<f64> {
    let mut cuts = vec![0.0, rng.random_range(3.4..4.8)];
    let rooms = rng.random_range(2..6usize);
    while cuts.len() <= rooms {
        let next = cuts[cuts.len() - 1] + rng.random_range(3.0..5.2);
        if next > most_m {
            break;
        }
        cuts.push(next);
    }
    cuts
}

/// Meeting rooms side by side, with a glazed front and a door each.
fn add_row(cuts: &[f64], y: [f64; 2], front: f64, rooms: &mut Vec<Room>, lines: &mut Vec<Line>, rng: &mut StreamRng) {
    for (i, x) in cuts.windows(2).enumerate() {
        rooms.push(Room::rectangle(RoomKind::Meeting, Pt2::new(x[0], y[0]), Pt2::new(x[1], y[1])));
        if i > 0 {
            lines.push(Line::partition(x[0], y[0], x[0], y[1], vec![]));
        }
        lines.push(Line::new(x[0], front, x[1], front, vec![Pt2::new(place(x[0], x[1], rng), front)]));
    }
}

/// Toilets, stairs, lifts, stores: side by side, with doors below or above.
fn add_core([x0, y0, x1, y1]: [f64; 4], rooms: &mut Vec<Room>, lines: &mut Vec<Line>, rng: &mut StreamRng) {
    let count = ((x1 - x0) / rng.random_range(2.6..3.8)).floor().max(2.0) as usize;
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for k in 0..count {
        let at = |k: usize| x0 + (x1 - x0) * k as f64 / count as f64;
        let kind = if k % 3 == 0 { RoomKind::Bath } else { RoomKind::Store };
        rooms.push(Room::rectangle(kind, Pt2::new(at(k), y0), Pt2::new(at(k + 1), y1)));
        if k > 0 {
            lines.push(Line::new(at(k), y0, at(k), y1, vec![]));
        }
        let x = place(at(k), at(k + 1), rng);
        if rng.random_range(0.0..1.0) < 0.5 { below.push(Pt2::new(x, y0)) } else { above.push(Pt2::new(x, y1)) }
    }
    lines.push(Line::new(x0, y0, x1, y0, below));
    lines.push(Line::new(x0, y1, x1, y1, above));
    lines.push(Line::new(x0, y0, x0, y1, vec![]));
    lines.push(Line::new(x1, y0, x1, y1, vec![]));
}

/// Columns on a grid, square in some rows and round in others, where nothing else is near.
fn add_columns(hall: &Room, (width, depth): (f64, f64), lines: &mut Vec<Line>, rng: &mut StreamRng) {
    let count = |m: f64| ((m / COLUMNS_M).round() as usize).max(2);
    let (nx, ny) = (count(width), count(depth));
    let (radius, first_round) = (rng.random_range(0.2..0.3), rng.random_range(0..2usize));
    for j in 0..ny {
        // Corners on a circle: four make a square, twelve a round column.
        let corners = if (j + first_round) % 2 == 0 { 12 } else { 4 };
        for i in 0..nx {
            let (x, y) = (width * (i as f64 + 0.5) / nx as f64, depth * (j as f64 + 0.5) / ny as f64);
            let around = [(1.5, 0.0), (-1.5, 0.0), (0.0, 1.5), (0.0, -1.5), (1.1, 1.1), (-1.1, 1.1), (1.1, -1.1), (-1.1, -1.1)];
            if !around.iter().all(|(dx, dy)| hall.holds(Pt2::new(x + dx, y + dy))) {
                continue;
            }
            let corner = |k: usize| {
                let (s, c) = libm::sincos((k as f64 + 0.5) * std::f64::consts::TAU / corners as f64);
                Pt2::<Plan>::new(x + radius * c, y + radius * s)
            };
            lines.extend((0..corners).map(|k| Line::between(corner(k), corner((k + 1) % corners))));
        }
    }
}
