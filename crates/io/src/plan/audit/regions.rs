//! Where does one room end and the next begin, when only walls are drawn? At the narrow places of the free space.
//!
//! clearance of each cell ─▶ flooded from the highest down; where two floods meet at a doorway they stay apart ─▶ labels
//!
//! Source: the distance transform segmentation of Bormann, Jordan, Li, Hampp & Hägele 2016, "Room Segmentation: Survey,
//! Implementation, and Analysis" (ICRA). We depart from it where one threshold for a whole plan decides what is a doorway: here each
//! narrow place is judged by itself, by its own width and by how much wider both of its sides are (a watershed with merging by
//! saliency), so that a narrow corridor stays whole and a wide door between two halls still divides them. The borders lie in the
//! necks, because floods meet there.
//! Outdoors is flooded by itself; [`facade`] says where it ends.
//! Pitfall: clearance is known to a cell, so corridors have many maxima; they merge because nothing between them is narrower.

use std::collections::BTreeMap;

use planwalk_types::distance;

use super::facade;
use super::ground::{Ground, Place};

/// No room.
pub(super) const NONE: u32 = 0;
/// Outdoors.
pub(super) const OUTDOORS: u32 = u32::MAX;
/// Doorways without a door in them are at most this wide, metres: double doors. Wider ones are parts of one room.
const DOORWAY_M: f64 = 2.1;
/// A doorway is at most this much as wide as either of its sides; of a corridor as narrow as its doors nothing is cut off …
const NARROWER: f64 = 0.72;
/// … and a wide one must be much narrower than that: from this width on, metres …
const WIDE_M: f64 = 1.3;
/// … at most this much.
const MUCH_NARROWER: f64 = 0.5;
/// Clearance is rounded to so many parts of a cell, for sorting.
const PARTS: f32 = 8.0;
/// Smallest room, m², as in the paper. What is smaller belongs to the room beside it.
pub(super) const SMALLEST_M2: f64 = 1.5;
/// Nobody fits in where nothing is wider than this, metres.
const NARROWEST_M: f64 = 0.6;

/// Rooms as labels of cells, 1 and up; else [`NONE`] or [`OUTDOORS`].
pub(super) struct Regions {
    pub labels: Vec<u32>,
    pub count: u32,
}

/// Divides the open cells that have no label yet; numbers go on after `count`.
pub(super) fn divide(ground: &Ground, labels: Vec<u32>, count: u32) -> Regions {
    let mut regions = flood(ground, labels, count, &[]);
    let gone = facade::settle(ground, &mut regions, count);
    if gone.is_empty() {
        return regions;
    }
    // A court takes the rooms along that are open to it: what stands in their facades divides them after all.
    let numbered = regions.count;
    for i in gone {
        regions.labels[i] = NONE;
    }
    let mut regions = flood(ground, regions.labels, numbered, &ground.post_cells);
    facade::settle(ground, &mut regions, numbered);
    regions
}

fn flood(ground: &Ground, labels: Vec<u32>, count: u32, posts: &[usize]) -> Regions {
    let mut obstacles: Vec<bool> = (0..labels.len()).map(|i| ground.places[i] != Place::Open || labels[i] != NONE).collect();
    posts.iter().for_each(|i| obstacles[*i] = true);
    let far = obstacles.len() as f32;
    let clearance = distance::to_nearest(obstacles, ground.width, far, |cells| cells as f32);
    let mut flood = Flood { ground, clearance: &clearance, basin: vec![NONE; labels.len()], basins: Basins::default() };
    for i in highest_first(&clearance) {
        flood.visit(i);
    }
    let Flood { basin, mut basins, .. } = flood;
    join_small(ground, &clearance, &basin, &mut basins);
    number(ground, basin, &mut basins, labels, count)
}

/// Open cells by falling clearance; those of equal clearance in the order of rows.
fn highest_first(clearance: &[f32]) -> Vec<usize> {
    let key = |d: f32| (d * PARTS) as usize;
    let highest = clearance.iter().copied().fold(0.0, f32::max);
    let mut starts = vec![0usize; key(highest) + 2];
    for d in clearance.iter().filter(|d| **d > 0.0) {
        starts[key(highest) - key(*d) + 1] += 1;
    }
    for k in 1..starts.len() {
        starts[k] += starts[k - 1];
    }
    let mut order = vec![0; starts.last().copied().unwrap_or(0)];
    for (i, d) in clearance.iter().enumerate().filter(|(_, d)| **d > 0.0) {
        let slot = &mut starts[key(highest) - key(*d)];
        order[*slot] = i;
        *slot += 1;
    }
    order
}

/// Basins that may have become one, with what is known of each.
#[derive(Default)]
struct Basins {
    /// Each one's parent, itself where it stands for all; basin 1 is at 0.
    parents: Vec<u32>,
    /// Greatest clearance, cells.
    peaks: Vec<f32>,
    /// Cells.
    sizes: Vec<usize>,
    /// Whether walls are around where it is widest.
    are_indoors: Vec<bool>,
}

impl Basins {
    fn add(&mut self, peak: f32, is_indoors: bool) -> u32 {
        let basin = self.parents.len() as u32 + 1;
        self.parents.push(basin);
        self.peaks.push(peak);
        self.sizes.push(0);
        self.are_indoors.push(is_indoors);
        basin
    }

    fn root(&mut self, basin: u32) -> u32 {
        let mut root = basin;
        while self.parents[root as usize - 1] != root {
            let above = self.parents[root as usize - 1];
            self.parents[root as usize - 1] = self.parents[above as usize - 1];
            root = above;
        }
        root
    }

    /// The higher one stands for both; the older one of equals.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        let (keeps, goes) = if (self.peaks[b as usize - 1], a) > (self.peaks[a as usize - 1], b) { (b, a) } else { (a, b) };
        if keeps != goes {
            self.parents[goes as usize - 1] = keeps;
            self.sizes[keeps as usize - 1] += self.sizes[goes as usize - 1];
        }
    }
}

struct Flood<'a> {
    ground: &'a Ground,
    clearance: &'a [f32],
    basin: Vec<u32>,
    basins: Basins,
}

impl Flood<'_> {
    /// A cell goes to the highest of its neighbours, which were all there before it; where several floods meet, they are judged.
    fn visit(&mut self, i: usize) {
        let mut highest: Option<usize> = None;
        let is_indoors = self.ground.is_indoors[i];
        let is_alike = |k: &usize, basin: &[u32]| basin[*k] != NONE && self.ground.is_indoors[*k] == is_indoors;
        for k in self.ground.around(i, 1).filter(|k| is_alike(k, &self.basin)) {
            if highest.is_none_or(|h| self.clearance[k] > self.clearance[h]) {
                highest = Some(k);
            }
        }
        let own = match highest {
            Some(k) => self.basins.root(self.basin[k]),
            None => self.basins.add(self.clearance[i], is_indoors),
        };
        self.basin[i] = own;
        self.basins.sizes[own as usize - 1] += 1;
        for k in self.ground.around(i, 1) {
            if !is_alike(&k, &self.basin) {
                continue;
            }
            let (own, other) = (self.basins.root(own), self.basins.root(self.basin[k]));
            if own != other && !self.is_doorway(self.clearance[i], own, other) {
                self.basins.join(own, other);
            }
        }
    }

    /// Whether a neck of this clearance is one between rooms.
    fn is_doorway(&self, clearance: f32, a: u32, b: u32) -> bool {
        let lower = self.basins.peaks[a as usize - 1].min(self.basins.peaks[b as usize - 1]);
        // From the middle of a cell to that of the first obstacle is half a cell too much at either side.
        let width_m = (2.0 * f64::from(clearance) - 1.0) * self.ground.cell_m;
        let lower_m = (2.0 * f64::from(lower) - 1.0) * self.ground.cell_m;
        let narrower = if width_m < WIDE_M { NARROWER } else { MUCH_NARROWER };
        width_m <= DOORWAY_M && width_m <= narrower * lower_m
    }
}

/// What is too small for a room goes to the neighbour that it is most open to.
fn join_small(ground: &Ground, clearance: &[f32], basin: &[u32], basins: &mut Basins) {
    let mut necks: BTreeMap<(u32, u32), f32> = BTreeMap::new();
    for i in (0..basin.len()).filter(|i| basin[*i] != NONE) {
        for k in ground.beside(i).filter(|k| basin[*k] != NONE) {
            let (a, b) = (basins.root(basin[i]), basins.root(basin[k]));
            if a < b {
                let neck = necks.entry((a, b)).or_insert(0.0);
                *neck = neck.max(clearance[i].min(clearance[k]));
            }
        }
    }
    let smallest = SMALLEST_M2 / ground.cell_m2();
    let mut by_width: Vec<((u32, u32), f32)> = necks.into_iter().collect();
    // Stable: necks of equal width stay in the order of their basins.
    by_width.sort_by(|a, b| b.1.total_cmp(&a.1));
    // Once is enough: what is joined only grows, so no neck that was passed over becomes one to join at.
    for ((a, b), _) in by_width {
        let (a, b) = (basins.root(a), basins.root(b));
        let is_small = |basin: u32| {
            let at = basin as usize - 1;
            (basins.sizes[at] as f64) < smallest || f64::from(2.0 * basins.peaks[at]) * ground.cell_m < NARROWEST_M
        };
        if is_small(a) || is_small(b) {
            basins.join(a, b);
        }
    }
}

/// Basins that are rooms get numbers, from the bottom up; what is smaller gets none.
fn number(ground: &Ground, basin: Vec<u32>, basins: &mut Basins, mut labels: Vec<u32>, mut count: u32) -> Regions {
    let mut numbers: BTreeMap<u32, u32> = BTreeMap::new();
    for (label, basin) in labels.iter_mut().zip(&basin).filter(|(_, basin)| **basin != NONE) {
        let root = basins.root(*basin);
        if !basins.are_indoors[root as usize - 1] {
            *label = OUTDOORS;
            continue;
        }
        *label = *numbers.entry(root).or_insert_with(|| {
            let [size, peak] = [basins.sizes[root as usize - 1] as f64, f64::from(2.0 * basins.peaks[root as usize - 1])];
            if size * ground.cell_m2() < SMALLEST_M2 || peak * ground.cell_m < NARROWEST_M {
                return NONE;
            }
            count += 1;
            count
        });
    }
    Regions { labels, count }
}
