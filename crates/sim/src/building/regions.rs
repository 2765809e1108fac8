//! Which pieces of a plan's floor are rooms? Floor that is wide, grown until it meets the next one, usually in a doorway.

use std::collections::VecDeque;

/// Floor at least this far from every wall is the middle of a room, metres: doors of up to 1.3 m part two rooms.
const MIDDLE_M: f64 = 0.65;
/// A smaller middle makes no room of its own, m².
const LEAST_M2: f64 = 0.6;
/// Narrow floor that nothing reaches is a room from here on, m²: niches between the piers of an outer wall are outdoors.
const LEAST_NARROW_M2: f64 = 2.5;
/// No region.
pub(super) const NONE: u16 = u16::MAX;

/// Distance from each cell to the nearest set one, in cells; within 8 % (a chamfer of 1 and √2 in two passes).
pub(super) fn distance_to(set: impl Fn(usize) -> bool, width: usize, height: usize) -> Vec<f32> {
    const DIAGONAL: f32 = std::f32::consts::SQRT_2;
    let far = (width + height) as f32 * 2.0;
    let mut distance: Vec<f32> = (0..width * height).map(|i| if set(i) { 0.0 } else { far }).collect();
    for y in 0..height {
        for x in 0..width {
            let i = y * width + x;
            let mut best = distance[i];
            if x > 0 {
                best = best.min(distance[i - 1] + 1.0);
            }
            if y > 0 {
                best = best.min(distance[i - width] + 1.0);
                if x > 0 {
                    best = best.min(distance[i - width - 1] + DIAGONAL);
                }
                if x + 1 < width {
                    best = best.min(distance[i - width + 1] + DIAGONAL);
                }
            }
            distance[i] = best;
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            let i = y * width + x;
            let mut best = distance[i];
            if x + 1 < width {
                best = best.min(distance[i + 1] + 1.0);
            }
            if y + 1 < height {
                best = best.min(distance[i + width] + 1.0);
                if x + 1 < width {
                    best = best.min(distance[i + width + 1] + DIAGONAL);
                }
                if x > 0 {
                    best = best.min(distance[i + width - 1] + DIAGONAL);
                }
            }
            distance[i] = best;
        }
    }
    distance
}

/// The region of each cell of floor, [`NONE`] elsewhere, and the number of regions. `clear` is the distance to what is no floor.
pub(super) fn split(floor: &[bool], clear: &[f32], width: usize, cell_m: f64) -> (Vec<u16>, usize) {
    let mut labels = vec![NONE; floor.len()];
    let cells = |m2: f64| (m2 / (cell_m * cell_m)).ceil() as usize;
    let mut count = 0;
    let middle = (MIDDLE_M / cell_m) as f32;
    let mut queue = VecDeque::new();
    grow_components(&mut labels, width, cells(LEAST_M2), &mut count, |i| floor[i] && clear[i] >= middle);
    queue.extend((0..floor.len()).filter(|i| labels[*i] != NONE));
    // All middles grow at the same pace.
    while let Some(i) = queue.pop_front() {
        for next in neighbours(i, width, floor.len()) {
            if floor[next] && labels[next] == NONE {
                labels[next] = labels[i];
                queue.push_back(next);
            }
        }
    }
    // Narrow floor that no middle reaches.
    grow_components(&mut labels, width, cells(LEAST_NARROW_M2), &mut count, |i| floor[i]);
    (labels, count)
}

/// Labels each component of the unlabelled cells that `belongs` holds for, if it has at least `least` cells.
fn grow_components(labels: &mut [u16], width: usize, least: usize, count: &mut usize, belongs: impl Fn(usize) -> bool) {
    let mut seen = vec![false; labels.len()];
    for start in 0..labels.len() {
        if seen[start] || labels[start] != NONE || !belongs(start) {
            continue;
        }
        let mut component = vec![start];
        seen[start] = true;
        let mut next = 0;
        while next < component.len() {
            for cell in neighbours(component[next], width, labels.len()) {
                if !seen[cell] && labels[cell] == NONE && belongs(cell) {
                    seen[cell] = true;
                    component.push(cell);
                }
            }
            next += 1;
        }
        if component.len() >= least && *count < usize::from(NONE) {
            component.iter().for_each(|cell| labels[*cell] = *count as u16);
            *count += 1;
        }
    }
}

/// The four cells beside a cell.
pub(super) fn neighbours(i: usize, width: usize, count: usize) -> impl Iterator<Item = usize> {
    let x = i % width;
    let beside = [(x > 0).then(|| i - 1), (x + 1 < width).then(|| i + 1), i.checked_sub(width), (i + width < count).then(|| i + width)];
    beside.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_rooms_with_a_door_between_them_are_two_regions() {
        // 8 m × 4 m of 10 cm cells; a wall in the middle with a door of 0.9 m.
        let (width, height) = (80, 40);
        let floor: Vec<bool> = (0..width * height).map(|i| i % width != 40 || (15..24).contains(&(i / width))).collect();
        let clear = distance_to(|i| !floor[i] || i % width == 0 || i / width == 0 || i % width == 79 || i / width == 39, width, height);
        let (labels, count) = split(&floor, &clear, width, 0.1);
        assert_eq!(count, 2);
        let at = |x: usize, y: usize| labels[y * width + x];
        assert_eq!(at(10, 10), at(30, 35));
        assert_ne!(at(10, 10), at(70, 10));
        assert!((0..width * height).all(|i| (labels[i] != NONE) == floor[i]), "all floor belongs to some room");
    }

    #[test]
    fn distances_are_within_a_tenth_of_the_true_ones() {
        let (width, height) = (50, 40);
        let distance = distance_to(|i| i == 20 * width + 10, width, height);
        for (i, got) in distance.iter().enumerate() {
            let truth = (((i % width) as f32 - 10.0).powi(2) + ((i / width) as f32 - 20.0).powi(2)).sqrt();
            assert!((got - truth).abs() <= 0.09 * truth, "{got} for {truth}");
        }
    }
}
