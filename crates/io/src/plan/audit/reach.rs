//! Does outdoors leak in, and does anybody get everywhere? Both are asked of the ways between rooms.

use super::finding::Finding;
use super::ground::{Ground, Place};
use super::passages::{OUTDOORS, Way};
use super::regions::NONE;
use super::spaces::Spaces;
use super::{End, Passage};

/// Openings without a door are entrances, where the drawing has no doors, if they are this wide, metres.
const ENTRANCE_M: std::ops::RangeInclusive<f64> = 0.6..=2.5;
/// Floor that is smaller than this is missed by nobody, m².
const SMALLEST_M2: f64 = 1.0;
/// A wall that is thicker hides nothing, metres.
const THICKEST_M: f64 = 1.0;

/// Openings to outdoors that no door explains.
pub(super) fn gaps(ways: &[Way], passages: &[Passage]) -> Vec<Finding> {
    let has_doors = ways.iter().any(|way| way.is_door);
    let is_gap = |way: &&Way| !way.is_door && way.sides.contains(&OUTDOORS) && (has_doors || !ENTRANCE_M.contains(&way.width_m));
    // An open-air site is all gaps, and none of them is a mistake.
    let is_site = passages.iter().all(|passage| passage.ends.contains(&End::Outdoors));
    let gaps = ways.iter().filter(is_gap).map(|way| Finding::OutlineGap { at: way.at, width_m: way.width_m });
    if is_site && !passages.is_empty() && passages.len() > 1 { Vec::new() } else { gaps.collect() }
}

/// Parts from which no way leads to the largest part.
pub(super) fn unreachable(ground: &Ground, spaces: &Spaces, ways: &[Way]) -> Vec<Finding> {
    let count = spaces.all.len();
    // One part a label, outdoors at 0.
    let mut parts: Vec<usize> = (0..=count).collect();
    let place = |side: u32| if side == OUTDOORS { 0 } else { (side as usize).min(count) };
    for way in ways {
        join(&mut parts, place(way.sides[0]), place(way.sides[1]));
    }
    let part_of: Vec<usize> = (0..=count).map(|n| root(&mut parts, n)).collect();
    let cells = cells_of(spaces);
    let area = |part: usize| (1..=count).filter(|n| part_of[*n] == part).map(|n| cells[n - 1].len()).sum::<usize>();
    let mut all: Vec<usize> = part_of.clone();
    all.sort_unstable();
    all.dedup();
    let areas: Vec<(usize, usize)> = all.into_iter().map(|part| (part, area(part))).collect();
    let Some(main) = areas.iter().max_by_key(|(part, area)| (*area, std::cmp::Reverse(*part))).map(|(part, _)| *part) else {
        return Vec::new();
    };
    let reached: Vec<bool> = part_of.iter().map(|part| *part == main).collect();
    let is_cut_off = |(part, area): &&(usize, usize)| *part != main && *area as f64 * ground.cell_m2() >= SMALLEST_M2;
    let finding = |(part, area): &(usize, usize)| {
        let members: Vec<usize> = (1..=count).filter(|n| part_of[*n] == *part).collect();
        let largest = members.iter().copied().max_by_key(|n| (cells[n - 1].len(), std::cmp::Reverse(*n)))?;
        let edge: Vec<usize> = members.iter().flat_map(|n| cells[n - 1].iter().copied()).collect();
        let behind = through(ground, &spaces.labels, &reached, edge);
        let at = spaces.all[largest - 1].at;
        Some(Finding::Unreachable { at, area_m2: *area as f64 * ground.cell_m2(), behind })
    };
    areas.iter().filter(is_cut_off).filter_map(finding).collect()
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
fn through(ground: &Ground, labels: &[u32], reached: &[bool], mut edge: Vec<usize>) -> Option<(planwalk_types::Pt2<planwalk_types::Plan>, f64)> {
    let mut seen: std::collections::BTreeSet<usize> = edge.iter().copied().collect();
    edge.retain(|i| ground.beside(*i).any(|k| !seen.contains(&k)));
    for step in 0..(THICKEST_M / ground.cell_m).ceil() as usize {
        let mut next = Vec::new();
        for i in edge {
            for k in ground.beside(i) {
                let is_goal = labels[k] != NONE && reached.get(labels[k] as usize).copied().unwrap_or(false);
                if is_goal {
                    return Some((ground.centre(k), step as f64 * ground.cell_m));
                }
                let is_wall = !matches!(ground.places[k], Place::Outdoors | Place::Unknown) && labels[k] == NONE;
                if is_wall && seen.insert(k) {
                    next.push(k);
                }
            }
        }
        edge = next;
    }
    None
}

fn root(parts: &mut [usize], of: usize) -> usize {
    let mut root = of;
    while parts[root] != root {
        parts[root] = parts[parts[root]];
        root = parts[root];
    }
    root
}

fn join(parts: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(parts, a), root(parts, b));
    parts[a.max(b)] = a.min(b);
}
