//! What is each cell of a storey to who asks for rooms? Built, a door, open, or nothing that the plan knows.
//!
//! [`FloorPlan`] ─▶ posts and clutter become floor ─▶ [`Ground`]

use planwalk_types::{Cell, FloorPlan, Plan, Pt2};

/// What stands alone and is no larger than this in either direction, metres, is furniture or a column: it divides no room.
const CLUTTER_M: f64 = 0.8;
/// How surely indoors begins, of [`FloorPlan::inside`].
const INDOORS: f32 = 0.5;
/// Indoors is known to a quarter of a metre: so wide a strip beside what is outdoors is outdoors too, metres.
const FRINGE_M: f64 = 0.3;

/// What a cell is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Built,
    Door,
    /// Nothing is in the way.
    Open,
    Unknown,
}

/// Something built that touches nothing else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Post {
    /// Its middle.
    pub at: Pt2<Plan>,
    /// Its larger extent, metres.
    pub size_m: f64,
}

/// A storey's cells, row 0 at the bottom.
#[derive(Debug, Clone)]
pub(super) struct Ground {
    pub width: usize,
    pub height: usize,
    pub cell_m: f64,
    pub origin: Pt2<Plan>,
    pub places: Vec<Place>,
    /// Whether an open cell is surrounded by walls as rooms are; so are some places outdoors, between two wings.
    pub is_indoors: Vec<bool>,
    /// What was small enough to be floor.
    pub posts: Vec<Post>,
    /// The cells of it.
    pub post_cells: Vec<usize>,
}

impl Ground {
    pub fn of(plan: &FloorPlan) -> Self {
        let places = plan.cells().iter().map(|cell| match cell {
            Cell::Wall | Cell::Window => Place::Built,
            Cell::Door => Place::Door,
            Cell::Unknown => Place::Unknown,
            Cell::Free => Place::Open,
        });
        let mut ground = Self {
            width: plan.width(),
            height: plan.height(),
            cell_m: plan.cell_m(),
            origin: plan.origin(),
            places: places.collect(),
            is_indoors: plan.inside().iter().map(|inside| *inside > INDOORS).collect(),
            posts: Vec::new(),
            post_cells: Vec::new(),
        };
        ground.clear_posts();
        ground.widen_outdoors();
        ground
    }

    /// Middle of a cell.
    pub fn centre(&self, i: usize) -> Pt2<Plan> {
        let (column, row) = (i % self.width, i / self.width);
        Pt2::new(self.origin.x + (column as f64 + 0.5) * self.cell_m, self.origin.y + (row as f64 + 0.5) * self.cell_m)
    }

    /// The cell that holds a point.
    pub fn index(&self, at: Pt2<Plan>) -> Option<usize> {
        let (x, y) = ((at.x - self.origin.x) / self.cell_m, (at.y - self.origin.y) / self.cell_m);
        let held = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        held.then(|| y as usize * self.width + x as usize)
    }

    pub fn cell_m2(&self) -> f64 {
        self.cell_m * self.cell_m
    }

    /// The cells around a cell, itself included, up to `reach` away.
    pub fn around(&self, i: usize, reach: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, column, row) = (self.width, i % self.width, i / self.width);
        let columns = column.saturating_sub(reach)..(column + reach + 1).min(width);
        let rows = row.saturating_sub(reach)..(row + reach + 1).min(self.height);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// The four cells beside a cell.
    pub fn beside(&self, i: usize) -> impl Iterator<Item = usize> + use<> {
        let column = i % self.width;
        let left = (column > 0).then(|| i - 1);
        let right = (column + 1 < self.width).then(|| i + 1);
        let below = i.checked_sub(self.width);
        let above = (i + self.width < self.places.len()).then_some(i + self.width);
        [left, right, below, above].into_iter().flatten()
    }

    /// Groups of cells that touch, corners included, in the order of their first cells.
    pub fn groups(&self, is_in: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
        let mut waiting: Vec<bool> = (0..self.places.len()).map(is_in).collect();
        let mut groups = Vec::new();
        for start in 0..waiting.len() {
            if !std::mem::take(&mut waiting[start]) {
                continue;
            }
            let mut group = vec![start];
            let mut next = 0;
            while let Some(i) = group.get(next).copied() {
                next += 1;
                group.extend(self.around(i, 1).filter(|k| std::mem::take(&mut waiting[*k])));
            }
            groups.push(group);
        }
        groups
    }

    /// Middle and larger extent, metres, of some cells.
    pub fn extent(&self, cells: &[usize]) -> (Pt2<Plan>, f64) {
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for i in cells {
            let at = [i % self.width, i / self.width];
            (low, high) = ([0, 1].map(|k| low[k].min(at[k])), [0, 1].map(|k| high[k].max(at[k])));
        }
        let [x, y] = [0, 1].map(|k| 0.5 * self.cell_m * (low[k].min(high[k]) + high[k] + 1) as f64);
        let size = [0, 1].map(|k| high[k].saturating_sub(low[k]) + 1).into_iter().max().unwrap_or(0);
        (Pt2::new(self.origin.x + x, self.origin.y + y), size as f64 * self.cell_m)
    }

    /// A wall between two doors stands alone too, unless doors count as built.
    fn clear_posts(&mut self) {
        let (mut posts, mut post_cells) = (Vec::new(), Vec::new());
        for group in self.groups(|i| matches!(self.places[i], Place::Built | Place::Door)) {
            let (at, size_m) = self.extent(&group);
            if size_m > CLUTTER_M || group.iter().any(|i| self.places[*i] == Place::Door) {
                continue;
            }
            let around = || group.iter().flat_map(|i| self.around(*i, 1));
            if !around().any(|k| self.places[k] == Place::Open) {
                continue;
            }
            let is_indoors = around().any(|k| self.is_indoors[k]);
            for i in &group {
                self.places[*i] = Place::Open;
                self.is_indoors[*i] = is_indoors;
            }
            post_cells.extend(group);
            posts.push(Post { at, size_m });
        }
        (self.posts, self.post_cells) = (posts, post_cells);
    }

    /// The strip along the outer walls sees one of them everywhere, and is no room.
    fn widen_outdoors(&mut self) {
        let is_out = |ground: &Self, i: usize| ground.places[i] == Place::Open && !ground.is_indoors[i];
        let is_in = |ground: &Self, i: usize| ground.places[i] == Place::Open && ground.is_indoors[i];
        let mut edge: Vec<usize> = (0..self.places.len()).filter(|i| is_out(self, *i)).collect();
        edge.retain(|i| self.beside(*i).any(|k| is_in(self, k)));
        for _ in 0..(FRINGE_M / self.cell_m).ceil() as usize {
            let mut next = Vec::new();
            for k in edge.iter().flat_map(|i| self.beside(*i)).collect::<Vec<_>>() {
                if is_in(self, k) {
                    self.is_indoors[k] = false;
                    next.push(k);
                }
            }
            edge = next;
        }
    }
}
