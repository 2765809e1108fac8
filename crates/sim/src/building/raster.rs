//! How do walls with their thickness look on a grid?

use planwalk_types::{Cell, FloorPlan, PlanError, Wall};

use crate::world::Solid;

/// Draws solids on the grid that holds `extent` and a margin.
///
/// # Errors
/// As [`FloorPlan::new`].
pub(crate) fn draw(extent: &[Wall], solids: &[Solid], cell_m: f64, margin_m: f64) -> Result<FloorPlan, PlanError> {
    // Drawn from centre lines first: that gives the grid and checks the numbers. Then the walls get their thickness.
    let grid = FloorPlan::from_walls(extent, cell_m, margin_m)?;
    let mut cells = vec![Cell::Free; grid.cells().len()];
    for solid in solids {
        fill(solid, &grid, &mut cells);
    }
    FloorPlan::new(grid.origin(), cell_m, grid.width(), grid.height(), cells)
}

/// Makes the cells under a solid walls.
pub(crate) fn fill(solid: &Solid, grid: &FloorPlan, cells: &mut [Cell]) {
    let (width, height, origin, cell_m) = (grid.width(), grid.height(), grid.origin(), grid.cell_m());
    let index = |v: f64, count: usize| ((v / cell_m).floor().max(0.0) as usize).min(count - 1);
    let Wall { from, to } = solid.line;
    // Where cells are coarser than walls are thick, walls are as thick as cells: else they would have holes.
    let reach = (0.5 * cell_m - solid.half_m).max(0.0) + 1e-9;
    let around = solid.half_m + reach + cell_m;
    let (left, right) = (from.x.min(to.x) - around - origin.x, from.x.max(to.x) + around - origin.x);
    let (low, high) = (from.y.min(to.y) - around - origin.y, from.y.max(to.y) + around - origin.y);
    for row in index(low, height)..=index(high, height) {
        for column in index(left, width)..=index(right, width) {
            if solid.distance(grid.centre(column, row)) <= reach {
                cells[row * width + column] = Cell::Wall;
            }
        }
    }
}
