//! Where does a room end whose outer wall is missing? On the line between the ends of what is there of the wall.
//!
//! What is indoors is told by how much of the horizon is walls; before a hole in a facade that ends in an arc, inside of the room. The
//! arc stands on the wall's two ends: what lies between it and its chord is given back to the room. What is open along more of its rim
//! than any room, a corner between two wings, is outdoors.

use std::collections::BTreeMap;

use planwalk_types::{Plan, Pt2};

use super::ground::{Ground, Place};
use super::passages::{necks, tips};
use super::regions::{NONE, OUTDOORS, Regions};

/// A room's wall is missing over at most this, metres; a court that is open wider is outdoors.
const WIDEST_M: f64 = 12.0;
/// … and over at most this share of its rim: a room that is twice as wide as deep, and open over all of its width, has a third.
const OPEN_SHARE: f64 = 0.38;

/// An arc stands at most this far before the ends of its walls, metres: what indoors is known to.
const MOST_OUT_M: f64 = 0.6;

/// Gives arcs back, and corners to outdoors; says which cells these were. Numbers up to `drawn` are those of areas that end where they
/// end.
pub(super) fn settle(ground: &Ground, regions: &mut Regions, drawn: u32) -> Vec<usize> {
    let is_found = |label: u32| label > drawn && label != OUTDOORS;
    let mut rims: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for i in (0..regions.labels.len()).filter(|i| is_found(regions.labels[*i])) {
        if ground.beside(i).any(|k| regions.labels[k] == OUTDOORS) {
            rims.entry(regions.labels[i]).or_default().push(i);
        }
    }
    let mut too_wide = vec![false; regions.count as usize + 1];
    for (label, rim) in rims {
        for neck in necks(ground, rim) {
            let (a, b) = tips(ground, &neck);
            if a.distance(b) > WIDEST_M {
                too_wide[label as usize] = true;
            } else {
                fill_arc(ground, &mut regions.labels, label, &neck, a, b);
            }
        }
    }
    let (all, open) = rim_lengths(ground, regions);
    let is_outdoors = |n: usize| n > drawn as usize && (too_wide[n] || open[n] as f64 > OPEN_SHARE * all[n] as f64);
    let mut numbers: Vec<u32> = vec![NONE];
    let mut count = 0;
    for n in 1..=regions.count as usize {
        let goes = is_outdoors(n);
        count += u32::from(!goes);
        numbers.push(if goes { OUTDOORS } else { count });
    }
    let mut gone = Vec::new();
    for (i, label) in regions.labels.iter_mut().enumerate().filter(|(_, label)| **label != OUTDOORS) {
        *label = numbers[*label as usize];
        if *label == OUTDOORS {
            gone.push(i);
        }
    }
    regions.count = count;
    gone
}

/// Gives a room what lies outdoors between the arc in which it ends and the arc's chord.
fn fill_arc(ground: &Ground, labels: &mut [u32], label: u32, neck: &[usize], a: Pt2<Plan>, b: Pt2<Plan>) {
    let chord = a.distance(b);
    if chord < 2.0 * ground.cell_m {
        return;
    }
    let (c, s) = ((b.x - a.x) / chord, (b.y - a.y) / chord);
    // Along the chord, and to its left.
    let seen = |i: usize| {
        let at = ground.centre(i);
        let (x, y) = (at.x - a.x, at.y - a.y);
        (c * x + s * y, c * y - s * x)
    };
    let side = if neck.iter().map(|i| seen(*i).1).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
    // The arc stands a little before the ends of the walls: the chord moves out as long as both of its ends are at one.
    let is_at_wall = |end: Pt2<Plan>, out_m: f64| {
        let at = Pt2::new(end.x + side * s * out_m, end.y - side * c * out_m);
        ground.index(at).is_some_and(|i| ground.around(i, 2).any(|k| matches!(ground.places[k], Place::Built | Place::Door)))
    };
    let steps = (1..=(MOST_OUT_M / ground.cell_m) as usize).map(|step| step as f64 * ground.cell_m);
    let out_m = steps.take_while(|out_m| is_at_wall(a, *out_m) && is_at_wall(b, *out_m)).last().unwrap_or(0.0);
    let is_between = |i: usize| {
        let (along, left) = seen(i);
        // The chord's own cells belong to the room.
        along > -ground.cell_m && along < chord + ground.cell_m && left * side > -out_m - 0.5 * ground.cell_m && left.abs() <= 0.5 * chord
    };
    let mut open: Vec<usize> = neck.to_vec();
    while let Some(i) = open.pop() {
        for k in ground.beside(i) {
            if labels[k] == OUTDOORS && ground.places[k] == Place::Open && is_between(k) {
                labels[k] = label;
                open.push(k);
            }
        }
    }
}

/// For each label the sides of its cells at which it ends, and those of them beyond which is outdoors.
fn rim_lengths(ground: &Ground, regions: &Regions) -> (Vec<usize>, Vec<usize>) {
    let mut all = vec![0; regions.count as usize + 1];
    let mut open = all.clone();
    for (i, label) in regions.labels.iter().enumerate().filter(|(_, label)| **label != NONE && **label != OUTDOORS) {
        for k in ground.beside(i).filter(|k| regions.labels[*k] != *label) {
            all[*label as usize] += 1;
            open[*label as usize] += usize::from(regions.labels[k] == OUTDOORS);
        }
    }
    (all, open)
}
