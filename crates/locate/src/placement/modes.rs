//! How many separate places are there? Placements heaped by half a metre and 10° of heading, neighbouring heaps joined.

use std::collections::BTreeMap;

use planwalk_types::{FloorPlan, PlanPose};

use super::PlacementMode;

/// Sectors of heading that cluster: 10°.
const SECTORS: i64 = 36;

/// Placements gathered by half a metre and heading, for clustering.
#[derive(Debug)]
pub(super) struct Heaps {
    block: usize,
    heaps: BTreeMap<(i64, i64, i64), Heap>,
}

/// Cells of one block, at one heading and scale: how many, the sums of their columns and rows, and the last of them.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    count: usize,
    columns: usize,
    rows: usize,
    last: (usize, usize),
}

impl Block {
    fn take(&mut self, column: usize, row: usize) {
        self.join(&Block { count: 1, columns: column, rows: row, last: (column, row) });
    }

    fn join(&mut self, other: &Block) {
        self.count += other.count;
        self.columns += other.columns;
        self.rows += other.rows;
        self.last = other.last;
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Heap {
    count: f64,
    column: f64,
    row: f64,
    sin: f64,
    cos: f64,
    scale: f64,
    example: Example,
}

/// A placement that was really found, and how many were found around it at its heading and scale.
#[derive(Debug, Clone, Copy, Default)]
struct Example {
    around: usize,
    column: usize,
    row: usize,
    heading: f64,
    scale: f64,
}

impl Heaps {
    /// No placements on this plan yet.
    pub(super) fn new(plan: &FloorPlan) -> Self {
        Self { block: (0.5 / plan.cell_m()).round().max(1.0) as usize, heaps: BTreeMap::new() }
    }

    /// Adds the cells (column, row) found for one heading and scale.
    pub(super) fn add(&mut self, cells: impl Iterator<Item = (usize, usize)>, heading: f64, scale: f64) {
        let turn = heading / std::f64::consts::TAU;
        let sector = ((turn - turn.floor()) * SECTORS as f64) as i64 % SECTORS;
        let mut blocks: BTreeMap<(i64, i64), Block> = BTreeMap::new();
        // Cells come row by row: neighbours are counted together before the map is asked.
        let mut run: Option<((i64, i64), Block)> = None;
        for (column, row) in cells {
            let key = ((column / self.block) as i64, (row / self.block) as i64);
            match &mut run {
                Some((at, block)) if *at == key => block.take(column, row),
                _ => {
                    let mut block = Block::default();
                    block.take(column, row);
                    if let Some((at, done)) = run.replace((key, block)) {
                        blocks.entry(at).or_default().join(&done);
                    }
                }
            }
        }
        if let Some((at, done)) = run {
            blocks.entry(at).or_default().join(&done);
        }
        let (s, c) = libm::sincos(heading);
        for ((block_column, block_row), Block { count, columns, rows, last: (column, row) }) in blocks {
            let heap = self.heaps.entry((block_column, block_row, sector)).or_default();
            let cells = count as f64;
            let example = Example { around: count, column, row, heading, scale };
            let sum = Heap {
                count: cells,
                column: columns as f64,
                row: rows as f64,
                sin: cells * s,
                cos: cells * c,
                scale: cells * scale,
                example,
            };
            *heap = heap.with(&sum);
        }
    }

    /// Adds all that another one gathered.
    pub(super) fn merge(&mut self, other: Heaps) {
        for (key, heap) in other.heaps {
            let here = self.heaps.entry(key).or_default();
            *here = here.with(&heap);
        }
    }

    /// Connected components of the heaps, largest first.
    pub(super) fn modes(mut self, plan: &FloorPlan) -> Vec<PlacementMode> {
        let total: f64 = self.heaps.values().map(|h| h.count).sum();
        let mut modes = Vec::new();
        while let Some((key, heap)) = self.heaps.pop_first() {
            let mut sum = Heap::default();
            let mut open = vec![(key, heap)];
            while let Some(((column, row, sector), heap)) = open.pop() {
                sum = sum.with(&heap);
                for (dc, dr, ds) in neighbours() {
                    let key = (column + dc, row + dr, (sector + ds).rem_euclid(SECTORS));
                    if let Some(heap) = self.heaps.remove(&key) {
                        open.push((key, heap));
                    }
                }
            }
            modes.push(sum.mode(plan, total));
        }
        modes.sort_by(|a, b| b.share.total_cmp(&a.share));
        modes
    }
}

fn neighbours() -> impl Iterator<Item = (i64, i64, i64)> {
    (0..27).map(|i| (i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
}

impl Heap {
    fn with(&self, other: &Heap) -> Heap {
        Heap {
            count: self.count + other.count,
            column: self.column + other.column,
            row: self.row + other.row,
            sin: self.sin + other.sin,
            cos: self.cos + other.cos,
            scale: self.scale + other.scale,
            example: if other.example.around > self.example.around { other.example } else { self.example },
        }
    }

    fn mode(&self, plan: &FloorPlan, total: f64) -> PlacementMode {
        let metres = |cells: f64| (cells + 0.5) * plan.cell_m();
        let pose =
            |column: f64, row: f64, heading: f64| PlanPose::new(plan.origin().x + metres(column), plan.origin().y + metres(row), heading);
        let example = &self.example;
        PlacementMode {
            pose: pose(self.column / self.count, self.row / self.count, libm::atan2(self.sin, self.cos)),
            scale: self.scale / self.count,
            share: self.count / total,
            example: pose(example.column as f64, example.row as f64, example.heading),
            example_scale: example.scale,
        }
    }
}
