//! How far is it to the nearest obstacle? The exact Euclidean distance of every cell.
//!
//! Source: Felzenszwalb & Huttenlocher 2012, "Distance Transforms of Sampled Functions": lower envelopes of parabolas, first along
//! the columns, then along the rows; linear in the cells.

/// Distance from each cell's centre to that of the nearest obstacle, in cells; the number of cells where there is none.
pub(super) fn to_nearest(is_obstacle: &[bool], width: usize) -> Vec<f32> {
    if width == 0 || is_obstacle.is_empty() {
        return Vec::new();
    }
    let height = is_obstacle.len() / width;
    let far = is_obstacle.len() as f32;
    // Squared distance to the nearest obstacle of the same column, from above and from below.
    let mut squared: Vec<f32> = is_obstacle.iter().map(|o| if *o { 0.0 } else { far }).collect();
    for i in width..squared.len() {
        squared[i] = squared[i].min(squared[i - width] + 1.0);
    }
    for i in (0..squared.len().saturating_sub(width)).rev() {
        squared[i] = squared[i].min(squared[i + width] + 1.0);
    }
    let mut envelope = Envelope::with_capacity(width);
    for row in squared.chunks_exact_mut(width).take(height) {
        envelope.sweep(row);
    }
    squared
}

/// The parabolas of a row that are lowest somewhere: their vertices, heights, and where each begins to be the lowest.
struct Envelope {
    parabolas: Vec<(f32, f32, f32)>,
}

impl Envelope {
    fn with_capacity(width: usize) -> Self {
        Self { parabolas: Vec::with_capacity(width) }
    }

    /// Distances down the columns become distances in the plane.
    fn sweep(&mut self, row: &mut [f32]) {
        self.parabolas.clear();
        for (x, down) in row.iter().enumerate() {
            let (x, height) = (x as f32, down * down);
            let mut begins = f32::NEG_INFINITY;
            while let Some((vertex, lower, began)) = self.parabolas.last().copied() {
                begins = ((height + x * x) - (lower + vertex * vertex)) / (2.0 * (x - vertex));
                if begins > began {
                    break;
                }
                self.parabolas.pop();
                begins = f32::NEG_INFINITY;
            }
            self.parabolas.push((x, height, begins));
        }
        let mut k = 0;
        for (x, out) in row.iter_mut().enumerate() {
            let x = x as f32;
            while self.parabolas.get(k + 1).is_some_and(|next| next.2 < x) {
                k += 1;
            }
            if let Some((vertex, height, _)) = self.parabolas.get(k) {
                *out = ((x - vertex) * (x - vertex) + height).sqrt();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distances_are_those_of_trying_all_obstacles(width in 1usize..12, cells in prop::collection::vec(prop::bool::weighted(0.2), 1..150)) {
            let cells = &cells[..cells.len() / width * width];
            prop_assume!(cells.contains(&true));
            let at = |i: usize| ((i % width) as f32, (i / width) as f32);
            let obstacles = || (0..cells.len()).filter(|j| cells[*j]);
            for (i, found) in to_nearest(cells, width).into_iter().enumerate() {
                let nearest = obstacles().map(|j| (at(i).0 - at(j).0).hypot(at(i).1 - at(j).1)).fold(f32::INFINITY, f32::min);
                // Round-off of single precision at some hundred cells.
                prop_assert!((found - nearest).abs() < 1e-3, "cell {i}: {found} for {nearest}");
            }
        }
    }

    #[test]
    fn where_there_is_no_obstacle_everything_is_far() {
        assert!(to_nearest(&[false; 6], 3).iter().all(|d| *d >= 6.0));
        assert!(to_nearest(&[], 3).is_empty());
    }
}
