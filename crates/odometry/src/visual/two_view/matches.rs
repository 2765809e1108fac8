//! How do the estimators see matches? As points of the plane at distance 1, each with its weight, the likeliest ones first.
//!
//! pairs of rays ─▶ points in lanes ─▶ weight: crowded ones count less ─▶ order: those that move as their neighbours do come first
//!
//! *Weight.* A poster or a person yields many matches, and all of them say one thing. Each counts by the room that it has in the
//! picture, so that what is agreed on is agreed on all over it.
//!
//! *Order.* What is sampled first should be right (PROSAC: Chum & Matas 2005). Matchers know how sure they are; trackers do not. But
//! wrong matches go anywhere, while right ones go nearly where their neighbours go (GMS: Bian et al. 2017). Cells of the picture take
//! turns, so that the first samples are spread over it.

use wide::f32x8;

use super::RayPair;

/// Numbers that are worked on at once.
const LANES: usize = 8;
/// Cells along the longer side of what the points cover, for weights and order.
const CELLS: usize = 10;
/// The least that a match counts.
const LEAST_WEIGHT: f64 = 0.15;
/// Rays are looked at up to this z, some 84° from where the camera looks: farther out the plane at distance 1 has no end.
const LEAST_Z: f64 = 0.1;

/// One match, on the planes at distance 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Match {
    pub a: [f64; 2],
    pub b: [f64; 2],
    /// How much it counts; at most 1.
    pub weight: f64,
    /// Which of the given pairs it is.
    pub pair: usize,
}

impl Match {
    fn flow(&self) -> [f64; 2] {
        [self.b[0] - self.a[0], self.b[1] - self.a[1]]
    }
}

/// [`LANES`] matches, coordinate by coordinate; lanes that are left over weigh nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes {
    pub a: [f32x8; 2],
    pub b: [f32x8; 2],
    pub weight: f32x8,
}

/// Matches, the likeliest first.
#[derive(Debug, Clone)]
pub(crate) struct Matches {
    pub list: Vec<Match>,
    pub lanes: Vec<Lanes>,
}

impl Matches {
    /// Of pairs of rays; those that look too far aside are left out.
    pub fn of(pairs: &[RayPair]) -> Self {
        let seen = |p: &RayPair| p.a.z > LEAST_Z && p.b.z > LEAST_Z && (p.a + p.b).iter().all(|v| v.is_finite());
        let point = |(pair, p): (usize, &RayPair)| {
            seen(p).then(|| Match { a: [p.a.x / p.a.z, p.a.y / p.a.z], b: [p.b.x / p.b.z, p.b.y / p.b.z], weight: 1.0, pair })
        };
        let mut list: Vec<Match> = pairs.iter().enumerate().filter_map(point).collect();
        let grid = Grid::of(&list);
        let weights: Vec<f64> = grid.room(&list);
        list.iter_mut().zip(weights).for_each(|(m, weight)| m.weight = weight);
        let order = grid.order(&list);
        let list: Vec<Match> = order.into_iter().map(|i| list[i]).collect();
        Self { lanes: list.chunks(LANES).map(lanes).collect(), list }
    }
}

fn lanes(list: &[Match]) -> Lanes {
    let lane = |of: &dyn Fn(&Match) -> f64| f32x8::new(std::array::from_fn(|i| list.get(i).map_or(0.0, |m| of(m) as f32)));
    Lanes { a: [0, 1].map(|k| lane(&|m| m.a[k])), b: [0, 1].map(|k| lane(&|m| m.b[k])), weight: lane(&|m| m.weight) }
}

/// Which matches are in which part of the first picture.
struct Grid {
    low: [f64; 2],
    cell: f64,
    columns: usize,
    rows: usize,
    members: Vec<Vec<usize>>,
}

impl Grid {
    fn of(list: &[Match]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for m in list {
            for k in 0..2 {
                (low[k], high[k]) = (low[k].min(m.a[k]), high[k].max(m.a[k]));
            }
        }
        let size = [0, 1].map(|k| (high[k] - low[k]).max(0.0));
        let cell = (size[0].max(size[1]) / CELLS as f64).max(1e-9);
        let count = |k: usize| ((size[k] / cell).ceil() as usize).clamp(1, CELLS);
        let (columns, rows) = (count(0), count(1));
        let mut grid = Self { low, cell, columns, rows, members: vec![Vec::new(); columns * rows] };
        for (i, m) in list.iter().enumerate() {
            let (column, row) = grid.place(m);
            grid.members[row * columns + column].push(i);
        }
        grid
    }

    fn place(&self, m: &Match) -> (usize, usize) {
        let at = |k: usize, count: usize| (((m.a[k] - self.low[k]) / self.cell) as usize).min(count - 1);
        (at(0, self.columns), at(1, self.rows))
    }

    /// The cells around a match, its own among them.
    fn around(&self, m: &Match) -> impl Iterator<Item = &Vec<usize>> {
        let (column, row) = self.place(m);
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        near(row, self.rows).flat_map(move |r| near(column, self.columns).map(move |c| &self.members[r * self.columns + c]))
    }

    /// Weights: the area around each for each match there, compared with what most have.
    fn room(&self, list: &[Match]) -> Vec<f64> {
        let room = |m: &Match| {
            let (cells, count) = self.around(m).fold((0.0, 0.0), |(cells, count), members| (cells + 1.0, count + members.len() as f64));
            cells / f64::max(count, 1.0)
        };
        let rooms: Vec<f64> = list.iter().map(room).collect();
        let usual = super::rotation::median(rooms.clone()).max(f64::MIN_POSITIVE);
        rooms.into_iter().map(|room| (room / usual).clamp(LEAST_WEIGHT, 1.0)).collect()
    }

    /// Cell by cell in turns, in each first what moves most like its neighbours.
    fn order(&self, list: &[Match]) -> Vec<usize> {
        let oddities: Vec<f64> = list.iter().map(|m| self.oddity(m, list)).collect();
        let mut ranked: Vec<(usize, f64, usize)> = Vec::with_capacity(list.len());
        for members in &self.members {
            let mut members = members.clone();
            members.sort_by(|i, j| oddities[*i].total_cmp(&oddities[*j]).then(i.cmp(j)));
            ranked.extend(members.into_iter().enumerate().map(|(rank, i)| (rank, oddities[i], i)));
        }
        ranked.sort_by(|x, y| x.1.total_cmp(&y.1).then(x.2.cmp(&y.2)));
        // A cell's second best comes no sooner than the best of all others that are better than the worst half.
        let half = ranked.get(ranked.len() / 2).map_or(f64::INFINITY, |r| r.1);
        ranked.sort_by(|x, y| {
            let key = |r: &(usize, f64, usize)| (r.1 > half, r.0);
            key(x).cmp(&key(y)).then(x.1.total_cmp(&y.1)).then(x.2.cmp(&y.2))
        });
        ranked.into_iter().map(|r| r.2).collect()
    }

    /// How far a match's flow is from the third most alike of those around it.
    fn oddity(&self, m: &Match, list: &[Match]) -> f64 {
        let mut least = [f64::INFINITY; 3];
        let flow = m.flow();
        for other in self.around(m).flatten().map(|i| &list[*i]).filter(|other| other.pair != m.pair) {
            let theirs = other.flow();
            let apart = (theirs[0] - flow[0]).powi(2) + (theirs[1] - flow[1]).powi(2);
            if apart < least[2] {
                least[2] = apart;
                least.sort_by(f64::total_cmp);
            }
        }
        // Where there are few to compare with, those few must do.
        least.into_iter().rev().find(|apart| apart.is_finite()).unwrap_or(f64::INFINITY)
    }
}
