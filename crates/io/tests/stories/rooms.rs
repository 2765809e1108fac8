//! Rooms are found where people see them, on real plans whose rooms somebody has drawn or listed.

use planwalk_io::plan::audit::{Audit, Room};
use planwalk_io::plan::{self, PlanOptions};
use planwalk_types::Form;

use crate::support::data;

/// Side of the squares that rooms are compared by, metres: a pixel of the maps.
const SQUARE_M: f64 = 0.05;

/// A grid of squares from (0, 0) up, with the number of a room in each, 0 for none.
struct Painted {
    width: usize,
    height: usize,
    numbers: Vec<usize>,
}

impl Painted {
    fn new(width: usize, height: usize) -> Self {
        Self { width, height, numbers: vec![0; width * height] }
    }

    /// Squares whose middles lie in rings, by the even-odd rule.
    fn paint(&mut self, rings: &[Vec<[f64; 2]>], number: usize) {
        for row in 0..self.height {
            let y = (row as f64 + 0.5) * SQUARE_M;
            let mut crossings: Vec<f64> = Vec::new();
            for (a, b) in rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1))) {
                if (a[1] > y) != (b[1] > y) {
                    crossings.push(a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
                }
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let [from, to] = [pair[0], pair[1]].map(|x| (x / SQUARE_M - 0.5).ceil().clamp(0.0, self.width as f64) as usize);
                self.numbers[row * self.width + from..row * self.width + to].fill(number);
            }
        }
    }

    fn rooms(rooms: &[Room], width: usize, height: usize) -> Self {
        let mut painted = Self::new(width, height);
        for (n, room) in rooms.iter().enumerate() {
            let Form::Area(rings) = &room.element.form else { continue };
            let rings: Vec<Vec<[f64; 2]>> = rings.iter().map(|ring| ring.iter().map(|p| [p.x, p.y]).collect()).collect();
            painted.paint(&rings, n + 1);
        }
        painted
    }
}

/// Recall and precision as Bormann et al. 2016 have them: the mean share of a true room that its best found one covers, and of a
/// found room that its best true one does.
fn scores(truth: &Painted, found: &Painted) -> (f64, f64) {
    let mean_best = |of: &Painted, by: &Painted| {
        let (count, others) = (of.numbers.iter().max().unwrap() + 1, by.numbers.iter().max().unwrap() + 1);
        let mut common = vec![0usize; count * others];
        let mut sizes = vec![0usize; count];
        for (a, b) in of.numbers.iter().zip(&by.numbers) {
            sizes[*a] += 1;
            common[a * others + b] += 1;
        }
        let present: Vec<usize> = (1..count).filter(|n| sizes[*n] > 0).collect();
        let best = |n: &usize| (1..others).map(|m| common[n * others + m]).max().unwrap_or(0) as f64 / sizes[*n] as f64;
        present.iter().map(best).sum::<f64>() / present.len() as f64
    };
    (mean_best(truth, found), mean_best(found, truth))
}

/// Rooms of a map by a drawing over it, in which bars shut the doors: what is white and hangs together.
fn segments(svg: &str) -> Painted {
    let picture = svg.split("base64,").nth(1).unwrap().split('"').next().unwrap();
    let picture = image::load_from_memory(&base64(picture)).unwrap().to_luma8();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let mut open: Vec<bool> = picture.pixels().map(|p| p.0[0] > 250).collect();
    for bar in svg.split("<rect").skip(1).map(|rest| rest.split("/>").next().unwrap()) {
        let number = |name: &str| {
            let text = bar.split_whitespace().find_map(|part| part.strip_prefix(&format!("{name}=\""))).unwrap_or("0");
            text.trim_end_matches("/>").trim_end_matches('"').parse::<f64>().unwrap()
        };
        let matrix: Vec<f64> = bar
            .split("matrix(")
            .nth(1)
            .map_or(vec![1.0, 0.0, 0.0, 1.0, 0.0, 0.0], |m| m.split(')').next().unwrap().split(',').map(|v| v.parse().unwrap()).collect());
        let [x, y, w, h] = ["x", "y", "width", "height"].map(number);
        // Along and across the bar by a quarter of a pixel: no pixel that it touches is missed.
        let (columns, rows) = ((4.0 * w).ceil().max(1.0) as usize, (4.0 * h).ceil().max(1.0) as usize);
        for i in 0..=columns {
            for k in 0..=rows {
                let (u, v) = (x + w * i as f64 / columns as f64, y + h * k as f64 / rows as f64);
                let at = [matrix[0] * u + matrix[2] * v + matrix[4], matrix[1] * u + matrix[3] * v + matrix[5]];
                if at[0] >= 0.0 && at[1] >= 0.0 && at[0] < width as f64 && at[1] < height as f64 {
                    open[at[1] as usize * width + at[0] as usize] = false;
                }
            }
        }
    }
    let mut painted = Painted::new(width, height);
    let mut number = 0;
    for start in 0..open.len() {
        if !std::mem::take(&mut open[start]) {
            continue;
        }
        let (mut group, mut next) = (vec![start], 0);
        while next < group.len() {
            let (column, row) = (group[next] % width, group[next] / width);
            next += 1;
            for (dc, dr) in [(0, 1), (2, 1), (1, 0), (1, 2)] {
                let (c, r) = ((column + dc).wrapping_sub(1), (row + dr).wrapping_sub(1));
                if c < width && r < height && std::mem::take(&mut open[r * width + c]) {
                    group.push(r * width + c);
                }
            }
        }
        // What is smaller than 1 m² lies between two bars, or is a ray that left through a window.
        if group.len() as f64 * SQUARE_M * SQUARE_M >= 1.0 {
            number += 1;
            for i in group {
                painted.numbers[(height - 1 - i / width) * width + i % width] = number;
            }
        }
    }
    painted
}

fn base64(text: &str) -> Vec<u8> {
    let letters = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bits: Vec<u32> = text.bytes().filter_map(|c| letters.iter().position(|l| *l == c)).map(|v| v as u32).collect();
    let bytes = |four: &[u32]| {
        let whole = four.iter().fold(0, |sum, v| sum << 6 | v) << (6 * (4 - four.len()));
        whole.to_be_bytes()[1..four.len()].to_vec()
    };
    bits.chunks(4).flat_map(bytes).collect()
}

/// The figures, for people who look at them with --nocapture.
fn say(words: &str) {
    std::io::Write::write_all(&mut std::io::stderr(), format!("{words}\n").as_bytes()).unwrap();
}

fn rooms_of(path: &std::path::Path, metres_per_pixel: f64) -> Vec<Room> {
    let document = plan::import(path, &PlanOptions { metres_per_pixel: Some(metres_per_pixel), ..PlanOptions::default() }).unwrap();
    Audit::of(&document.building.levels[0]).unwrap().rooms
}

#[test]
fn rooms_of_robots_maps_are_those_that_people_have_drawn_in_them() {
    // Found and true rooms; recall and precision at least. Bormann et al. report 0.94 to 0.96 and 0.84 to 0.9 for the four methods
    // that they compare, on 20 maps without furniture.
    for (name, at_most_off, recall_least, precision_least) in [("lab_ipa", 2, 0.85, 0.85), ("office_e", 2, 0.85, 0.85)] {
        let (Some(map), Some(truth)) =
            (data(&format!("floorplans/ipa_test_maps/{name}.png")), data(&format!("floorplans/ipa_test_maps/{name}_gt_segmentation.svg")))
        else {
            return;
        };
        let truth = segments(&std::fs::read_to_string(truth).unwrap());
        let rooms = rooms_of(&map, SQUARE_M);
        let count = *truth.numbers.iter().max().unwrap();
        let (recall, precision) = scores(&truth, &Painted::rooms(&rooms, truth.width, truth.height));
        let said = format!("{name}: {} rooms found, {count} drawn, recall {recall:.3}, precision {precision:.3}", rooms.len());
        say(&said);
        assert!(rooms.len().abs_diff(count) <= at_most_off && recall > recall_least && precision > precision_least, "{said}");
    }
}

#[test]
fn rooms_of_a_real_cad_drawing_are_those_of_its_list() {
    let (Some(drawing), Some(list)) = (data("floorplans/auburn_haley_dxf/floorplan.dxf"), data("floorplans/auburn_haley_dxf/room.txt"))
    else {
        return;
    };
    let list = std::fs::read_to_string(list).unwrap();
    let mut truth = Painted::new(800, 1300);
    let mut count = 0;
    for row in list.lines().map(|line| line.split_whitespace().filter_map(|cell| cell.parse().ok()).collect::<Vec<f64>>()) {
        let [_, x0, y0, x1, y1, ..] = row[..] else { continue };
        count += 1;
        truth.paint(&[vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]], count);
    }
    let rooms = rooms_of(&drawing, 0.1);
    let found = Painted::rooms(&rooms, truth.width, truth.height);
    let (recall, _) = scores(&truth, &found);
    say(&format!("Auburn: {} rooms found, {count} listed and 4 halls that are one, recall {recall:.3}", rooms.len()));
    // The halls are one, and behind its stairs is a landing.
    assert!((27..=28).contains(&rooms.len()) && count == 26 && recall > 0.95, "{} rooms found, recall {recall:.3}", rooms.len());
}

#[test]
fn shops_of_real_malls_are_rooms_of_their_own_though_names_lie_across_their_outlines() {
    // Shops that are drawn, some of them within others; rooms that are to be found at least; metres of a pixel.
    for (floor, drawn, least, metres_per_pixel) in [("site1/F2", 138, 120, 0.29977), ("site2/F3", 145, 125, 0.29589)] {
        let Some(folder) = data("xyz10_indoor_location") else { return };
        let count = rooms_of(&folder.join(floor).join("floor_image.png"), metres_per_pixel).len();
        say(&format!("{floor}: {count} rooms found, {drawn} shops drawn"));
        // Without the lines under words there are 50 and 80: rooms run together there.
        // Aisles are rooms, too, and so may be what an outline and a letter enclose: a tenth more is not wrong.
        assert!((least..=drawn + drawn / 10).contains(&count), "{floor}: {count} rooms of {drawn} shops");
    }
}
