//! What is near this place? Things on the floor by the squares that they touch.

use planwalk_types::{Plan, Pt2};

/// Numbers of things by square.
#[derive(Debug, Clone)]
pub(crate) struct Index {
    origin: [f64; 2],
    cell_m: f64,
    size: [usize; 2],
    /// Where each square's numbers begin in `items`.
    starts: Vec<u32>,
    items: Vec<u32>,
    count: usize,
}

impl Index {
    /// Squares of `cell_m` over `bounds`; `touches(thing, centre, radius)` says whether a thing comes within a radius of a place, and
    /// `span(thing)` the rectangle around it.
    pub fn new(
        (low, high): ([f64; 2], [f64; 2]),
        cell_m: f64,
        count: usize,
        span: impl Fn(usize) -> ([f64; 2], [f64; 2]),
        touches: impl Fn(usize, Pt2<Plan>, f64) -> bool,
    ) -> Self {
        let squares = |axis: usize| (((high[axis] - low[axis]) / cell_m).floor().max(0.0) as usize) + 1;
        let mut index = Self { origin: low, cell_m, size: [squares(0), squares(1)], starts: Vec::new(), items: Vec::new(), count };
        let radius = cell_m * std::f64::consts::FRAC_1_SQRT_2 + 1e-9;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for thing in 0..count {
            let (from, to) = span(thing);
            let (first, last) = (index.square(from), index.square(to));
            for j in first[1]..=last[1] {
                for i in first[0]..=last[0] {
                    let centre = Pt2::new(low[0] + (i as f64 + 0.5) * cell_m, low[1] + (j as f64 + 0.5) * cell_m);
                    if touches(thing, centre, radius) {
                        pairs.push(((j * index.size[0] + i) as u32, thing as u32));
                    }
                }
            }
        }
        index.starts = vec![0; index.size[0] * index.size[1] + 1];
        for (square, _) in &pairs {
            index.starts[*square as usize + 1] += 1;
        }
        for k in 1..index.starts.len() {
            index.starts[k] += index.starts[k - 1];
        }
        // Things in order within each square: a counting sort.
        let mut next = index.starts.clone();
        index.items = vec![0; pairs.len()];
        for (square, thing) in pairs {
            index.items[next[square as usize] as usize] = thing;
            next[square as usize] += 1;
        }
        index
    }

    /// The square that holds a place, or the nearest one.
    fn square(&self, p: [f64; 2]) -> [usize; 2] {
        let along = |axis: usize| (((p[axis] - self.origin[axis]) / self.cell_m).max(0.0) as usize).min(self.size[axis] - 1);
        [along(0), along(1)]
    }

    /// How many things it was made of.
    pub fn count(&self) -> usize {
        self.count
    }

    fn of(&self, i: usize, j: usize) -> &[u32] {
        let k = j * self.size[0] + i;
        &self.items[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    /// The things in the squares that touch a rectangle, each once, in order.
    pub fn around(&self, low: [f64; 2], high: [f64; 2]) -> Vec<u32> {
        let (first, last) = (self.square(low), self.square(high));
        let mut found: Vec<u32> =
            (first[1]..=last[1]).flat_map(|j| (first[0]..=last[0]).flat_map(move |i| self.of(i, j))).copied().collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The least of `distance2` over all things, or `limit_m²` where none is nearer than `limit_m`.
    ///
    /// Squares are looked at in rings around the place, until the next ring is farther than the best. Exact for places inside the
    /// bounds; outside of them, too, because there the rings are counted from the nearest square.
    pub fn nearest2(&self, point: Pt2<Plan>, limit_m: f64, distance2: impl Fn(usize) -> f64) -> f64 {
        let p = [point.x, point.y];
        let [ci, cj] = self.square(p);
        let mut best = limit_m * limit_m;
        // How far the place is inside its square: the next ring begins there. Negative outside of the bounds.
        let margin = |axis: usize, c: usize| {
            let off = p[axis] - self.origin[axis] - c as f64 * self.cell_m;
            off.min(self.cell_m - off)
        };
        let inset = margin(0, ci).min(margin(1, cj));
        let most = self.size[0].max(self.size[1]);
        for ring in 0..=most {
            if ring > 0 {
                let gap = (ring - 1) as f64 * self.cell_m + inset;
                if gap > 0.0 && gap * gap > best {
                    break;
                }
            }
            let (low_j, high_j) = (cj.saturating_sub(ring), (cj + ring).min(self.size[1] - 1));
            for j in low_j..=high_j {
                let rim = j.abs_diff(cj) == ring;
                let (low_i, high_i) = (ci.checked_sub(ring), Some(ci + ring).filter(|i| *i < self.size[0]));
                let mut look = |i: usize| {
                    for thing in self.of(i, j) {
                        best = best.min(distance2(*thing as usize));
                    }
                };
                if rim {
                    (low_i.unwrap_or(0)..=high_i.unwrap_or(self.size[0] - 1)).for_each(look);
                } else {
                    low_i.into_iter().chain(high_i).for_each(&mut look);
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Seed;
    use rand::RngExt;

    #[test]
    fn the_nearest_thing_is_that_of_a_search_through_all() {
        let mut rng = Seed(3).derive("points", 0);
        let points: Vec<[f64; 2]> = (0..200).map(|_| [rng.random_range(0.0..20.0), rng.random_range(0.0..9.0)]).collect();
        let distance2 = |k: usize, p: Pt2<Plan>| (points[k][0] - p.x).powi(2) + (points[k][1] - p.y).powi(2);
        let index =
            Index::new(([0.0, 0.0], [20.0, 9.0]), 0.5, points.len(), |k| (points[k], points[k]), |k, c, r| distance2(k, c) <= r * r);
        for _ in 0..2000 {
            let p = Pt2::new(rng.random_range(-5.0..25.0), rng.random_range(-6.0..15.0));
            let truth = (0..points.len()).map(|k| distance2(k, p)).fold(f64::INFINITY, f64::min);
            assert_eq!(index.nearest2(p, f64::INFINITY, |k| distance2(k, p)), truth, "{p:?}");
            assert_eq!(index.nearest2(p, 0.7, |k| distance2(k, p)), truth.min(0.7 * 0.7), "{p:?}");
        }
        assert_eq!(index.around([-1.0, -1.0], [30.0, 30.0]).len(), points.len());
    }
}
