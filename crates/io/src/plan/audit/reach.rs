//! Does outdoors leak in, and does anybody get everywhere? Both are asked of the ways between rooms.

use std::collections::BTreeMap;

use planwalk_types::{Groups, Plan, Pt2};

use super::finding::Finding;
use super::ground::{Ground, Place};
use super::passages::Way;
use super::regions::{NONE, OUTDOORS};
use super::spaces::Spaces;
use super::{End, Passage};

/// Openings without a door are entrances, where the drawing has no doors, if they are this wide, metres.
const ENTRANCE_M: std::ops::RangeInclusive<f64> = 0.6..=2.5;
/// Holes that are no farther from each other are one, metres.
const BESIDE_M: f64 = 1.0;
/// Holes of a group that another is compared with, the latest first.
const LOOKED_AT: usize = 16;
/// Floor that is smaller than this is missed by nobody, m².
const SMALLEST_M2: f64 = 1.5;
/// A wall that is thicker hides nothing, metres.
const THICKEST_M: f64 = 1.0;

/// Openings from rooms to outdoors that no door explains. Ground that is no room may be a terrace.
pub(super) fn gaps(passages: &[Passage]) -> Vec<Finding> {
    let has_doors = passages.iter().any(|way| way.is_door);
    let leads_out = |way: &Passage| way.ends.contains(&End::Outdoors) && way.ends.iter().any(|end| matches!(end, End::Room(_)));
    let is_gap = |way: &&Passage| !way.is_door && leads_out(way) && (has_doors || !ENTRANCE_M.contains(&way.width_m));
    let mut found: Vec<(Pt2<Plan>, f64, Vec<&Passage>)> = Vec::new();
    // Holes beside each other are one: so a facade looks whose glass is not drawn.
    for way in passages.iter().filter(is_gap) {
        let is_beside =
            |other: &&Passage| other.ends == way.ends && other.at.distance(way.at) - 0.5 * (other.width_m + way.width_m) <= BESIDE_M;
        let is_near = |(at, reach_m, group): &&mut (Pt2<Plan>, f64, Vec<&Passage>)| {
            at.distance(way.at) <= *reach_m + 0.5 * way.width_m + BESIDE_M && group.iter().rev().take(LOOKED_AT).any(is_beside)
        };
        match found.iter_mut().find(is_near) {
            Some((at, reach_m, group)) => {
                *reach_m = reach_m.max(at.distance(way.at) + 0.5 * way.width_m);
                group.push(way);
            }
            None => found.push((way.at, 0.5 * way.width_m, vec![way])),
        }
    }
    let middle = |group: &[&Passage], of: fn(&Passage) -> f64| group.iter().map(|way| of(way)).sum::<f64>() / group.len().max(1) as f64;
    let finding = |(_, _, group): (Pt2<Plan>, f64, Vec<&Passage>)| Finding::OutlineGap {
        at: Pt2::new(middle(&group, |way| way.at.x), middle(&group, |way| way.at.y)),
        width_m: group.iter().map(|way| way.width_m).sum(),
        places: group.len(),
    };
    found.into_iter().map(finding).collect()
}

/// Parts from which no way leads to the largest part.
pub(super) fn unreachable(ground: &Ground, spaces: &Spaces, ways: &[Way]) -> Vec<Finding> {
    let count = spaces.all.len();
    // One part a label, outdoors at 0.
    let mut parts = Groups::new(count + 1);
    let place = |side: u32| if side == OUTDOORS { 0 } else { (side as usize).min(count) };
    for way in ways {
        parts.join(place(way.sides[0]), place(way.sides[1]));
    }
    let cells = cells_of(spaces);
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for n in 0..=count {
        members.entry(parts.first(n)).or_default().push(n);
    }
    let cells_in = |part: &[usize]| part.iter().filter_map(|n| cells.get(n.checked_sub(1)?)).map(Vec::len).sum::<usize>();
    let mut all: Vec<(usize, Vec<usize>)> = members.into_values().map(|part| (cells_in(&part), part)).collect();
    // Stable: of parts of one size the first is the building.
    all.sort_by_key(|(size, _)| std::cmp::Reverse(*size));
    let mut reached = vec![false; count + 1];
    all.first().into_iter().flat_map(|(_, part)| part).for_each(|n| reached[*n] = true);
    let cut_off = all.iter().skip(1).filter(|(size, _)| *size as f64 * ground.cell_m2() >= SMALLEST_M2);
    let finding = |(size, part): &(usize, Vec<usize>)| {
        let spots = part.iter().filter_map(|n| n.checked_sub(1));
        let largest = spots.clone().max_by_key(|n| (cells[*n].len(), std::cmp::Reverse(*n)))?;
        let edge: Vec<usize> = spots.flat_map(|n| cells[n].iter().copied()).collect();
        let behind = through(ground, &spaces.labels, &reached, edge);
        Some(Finding::Unreachable { at: spaces.all[largest].at, area_m2: *size as f64 * ground.cell_m2(), behind })
    };
    cut_off.filter_map(finding).collect()
}

fn cells_of(spaces: &Spaces) -> Vec<Vec<usize>> {
    let mut cells = vec![Vec::new(); spaces.all.len()];
    for (i, label) in spaces.labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        if let Some(cells) = cells.get_mut(*label as usize - 1) {
            cells.push(i);
        }
    }
    cells
}

/// The nearest reached cell through what is built: its side of the wall, and how thick it is.
fn through(ground: &Ground, labels: &[u32], reached: &[bool], mut edge: Vec<usize>) -> Option<(Pt2<Plan>, f64)> {
    let mut seen: std::collections::BTreeSet<usize> = edge.iter().copied().collect();
    edge.retain(|i| ground.beside(*i).any(|k| !seen.contains(&k)));
    for step in 0..(THICKEST_M / ground.cell_m).ceil() as usize {
        let mut next = Vec::new();
        for i in edge {
            for k in ground.beside(i) {
                let is_goal = labels[k] != NONE && labels[k] != OUTDOORS && reached.get(labels[k] as usize).copied().unwrap_or(false);
                if is_goal {
                    return Some((ground.centre(k), step as f64 * ground.cell_m));
                }
                let is_wall = ground.places[k] != Place::Unknown && labels[k] == NONE;
                if is_wall && seen.insert(k) {
                    next.push(k);
                }
            }
        }
        edge = next;
    }
    None
}
