//! Rooms are found where people see them, on real plans whose rooms somebody has drawn or listed.

use std::ops::Range;

use planwalk_io::plan::audit::{Audit, Room};
use planwalk_io::plan::{self, PlanOptions};
use planwalk_types::Form;

use crate::support::data;

/// Side of the squares that rooms are compared by, metres: a pixel of the maps.
const SQUARE_M: f64 = 0.05;

/// … and on the maps of malls, metres: a third of a pixel.
const MALL_SQUARE_M: f64 = 0.1;

/// An outline, metres.
type Ring = Vec<[f64; 2]>;
/// Outlines of an area and of what is left out of it.
type Rings = Vec<Ring>;

/// A grid of squares from (0, 0) up, with the number of a room in each, 0 for none.
struct Painted {
    width: usize,
    height: usize,
    square_m: f64,
    numbers: Vec<usize>,
}

impl Painted {
    fn new(width: usize, height: usize, square_m: f64) -> Self {
        Self { width, height, square_m, numbers: vec![0; width * height] }
    }

    /// Squares whose middles lie in rings, by the even-odd rule.
    fn squares(&self, rings: &[Ring]) -> Vec<Range<usize>> {
        let mut squares = Vec::new();
        for row in 0..self.height {
            let y = (row as f64 + 0.5) * self.square_m;
            let mut crossings: Vec<f64> = Vec::new();
            for (a, b) in rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1))) {
                if (a[1] > y) != (b[1] > y) {
                    crossings.push(a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
                }
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let [from, to] = [pair[0], pair[1]].map(|x| (x / self.square_m - 0.5).ceil().clamp(0.0, self.width as f64) as usize);
                squares.push(row * self.width + from..row * self.width + to);
            }
        }
        squares
    }

    fn paint(&mut self, rings: &[Ring], number: usize) {
        self.squares(rings).into_iter().for_each(|squares| self.numbers[squares].fill(number));
    }

    fn rooms(rooms: &[Room], width: usize, height: usize, square_m: f64) -> Self {
        let mut painted = Self::new(width, height, square_m);
        for (n, room) in rooms.iter().enumerate() {
            let Form::Area(rings) = &room.element.form else { continue };
            let rings: Rings = rings.iter().map(|ring| ring.iter().map(|p| [p.x, p.y]).collect()).collect();
            painted.paint(&rings, n + 1);
        }
        painted
    }

    /// How many areas have a room of their own: they share half of what the two cover. The best pairs first, each room and area once.
    fn matched(&self, areas: &[Rings]) -> usize {
        let mut sizes = vec![0usize; self.numbers.iter().max().unwrap() + 1];
        self.numbers.iter().for_each(|n| sizes[*n] += 1);
        let mut pairs = Vec::new();
        for (i, rings) in areas.iter().enumerate() {
            let mut common = vec![0usize; sizes.len()];
            self.squares(rings).into_iter().flatten().for_each(|square| common[self.numbers[square]] += 1);
            let size: usize = common.iter().sum();
            let share = |n: usize| common[n] as f64 / (size + sizes[n] - common[n]).max(1) as f64;
            pairs.extend((1..sizes.len()).map(|n| (share(n), i, n)).filter(|pair| pair.0 >= 0.5));
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut is_met, mut is_taken) = (vec![false; areas.len()], vec![false; sizes.len()]);
        pairs
            .iter()
            .filter(|(_, i, n)| {
                !is_met[*i] && !is_taken[*n] && {
                    (is_met[*i], is_taken[*n]) = (true, true);
                    true
                }
            })
            .count()
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
    let mut painted = Painted::new(width, height, SQUARE_M);
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
        let (recall, precision) = scores(&truth, &Painted::rooms(&rooms, truth.width, truth.height, SQUARE_M));
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
    let mut truth = Painted::new(800, 1300, SQUARE_M);
    let mut count = 0;
    for row in list.lines().map(|line| line.split_whitespace().filter_map(|cell| cell.parse().ok()).collect::<Vec<f64>>()) {
        let [_, x0, y0, x1, y1, ..] = row[..] else { continue };
        count += 1;
        truth.paint(&[vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]], count);
    }
    let rooms = rooms_of(&drawing, 0.1);
    let found = Painted::rooms(&rooms, truth.width, truth.height, SQUARE_M);
    let (recall, _) = scores(&truth, &found);
    say(&format!("Auburn: {} rooms found, {count} listed and 4 halls that are one, recall {recall:.3}", rooms.len()));
    // The halls are one, and behind its stairs is a landing.
    assert!((27..=28).contains(&rooms.len()) && count == 26 && recall > 0.95, "{} rooms found, recall {recall:.3}", rooms.len());
}

/// Shops of a mall's floor, metres from its lower left corner. The file is in degrees; the first feature is the whole floor.
fn shops(folder: &std::path::Path) -> (Vec<Rings>, [f64; 2]) {
    let json = |name: &str| serde_json::from_str::<serde_json::Value>(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap();
    let info = json("floor_info.json");
    let size_m = ["width", "height"].map(|side| info["map_info"][side].as_f64().unwrap());
    let list = |value: &serde_json::Value| value.as_array().unwrap().clone();
    let areas: Vec<Rings> = list(&json("geojson_map.json")["features"])
        .iter()
        .map(|feature| {
            let coordinates = list(&feature["geometry"]["coordinates"]);
            let is_one = feature["geometry"]["type"] == "Polygon";
            let rings = if is_one { coordinates } else { coordinates.iter().flat_map(list).collect() };
            rings.iter().map(|ring| list(ring).iter().map(|p| [0, 1].map(|k| p[k].as_f64().unwrap())).collect()).collect()
        })
        .collect();
    let whole = || areas[0].iter().flatten();
    let low = [0, 1].map(|k| whole().map(|p| p[k]).fold(f64::INFINITY, f64::min));
    let high = [0, 1].map(|k| whole().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max));
    let metres = |p: &[f64; 2]| [0, 1].map(|k| (p[k] - low[k]) / (high[k] - low[k]) * size_m[k]);
    let shops = areas[1..].iter().map(|rings| rings.iter().map(|ring| ring.iter().map(metres).collect()).collect());
    (shops.collect(), size_m)
}

#[test]
fn shops_of_real_malls_are_rooms_of_their_own_though_names_lie_across_their_outlines() {
    // Shops that have a room of their own, at least; shops that are drawn, some of them within others. The second mall's file has most
    // shapes twice.
    for (floor, least, drawn) in [("site1/F2", 100, 138), ("site2/F3", 108, 145)] {
        let Some(folder) = data("xyz10_indoor_location").map(|folder| folder.join(floor)) else { return };
        let (shops, size_m) = shops(&folder);
        let picture = folder.join("floor_image.png");
        let rooms = rooms_of(&picture, size_m[0] / f64::from(image::image_dimensions(&picture).unwrap().0));
        let [width, height] = size_m.map(|side| (side / MALL_SQUARE_M).ceil() as usize);
        let matched = Painted::rooms(&rooms, width, height, MALL_SQUARE_M).matched(&shops);
        let said = format!("{floor}: {} rooms found, {matched} of {drawn} shops have one of their own", rooms.len());
        say(&said);
        // Without the lines under words there are 50 and 80 rooms, for 38 and 63 shops: they run together there.
        // Aisles are rooms, too, and so may be what an outline and a letter enclose: a tenth more is not wrong.
        assert!(matched >= least && rooms.len() <= drawn + drawn / 10, "{said}");
    }
}
