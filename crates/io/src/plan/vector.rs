//! How do drawn shapes become the plan's cells? Floors first, then walls and windows, then doors, which win.
//!
//! one storey's elements ─▶ grid of 5 cm, or coarser for large sites ─▶ cells ─▶ [`FloorPlan`]
//!
//! Everything takes every cell that it touches, so that no thin wall gets holes and no seam between two floors is a gap. Areas are filled by the even-odd rule: holes stay holes, whichever way rings run.
//! The plan's origin keeps the metres of the file, which may be millions (a projected map's easting and northing).

use planwalk_types::{Cell, Element, ElementKind, FloorPlan, Form, Plan, PlanError, Pt2};

use super::{PlanFileError, astray, audit};

/// Smallest side of a cell, as in [`super::cells`].
const FINEST_M: f64 = 0.05;
/// Cells are doubled in size until there are no more than this: a floor of 50,000 m² keeps 5 cm.
const CELLS_WANTED: f64 = 2e7;
/// Coarsest cell, metres: half a door.
const COARSEST_M: f64 = 0.4;
/// Coarsest cell of a map of roads, which has no doors: half of the narrowest road. A town of 50 km² is no more cells than a floor.
const COARSEST_ROADS_M: f64 = 1.6;
/// Nothing is drawn here, metres around the shapes: a wall at the rim has two sides.
const MARGIN_M: f64 = 1.0;
/// Most crossings of edges with rows of cells, and points on outlines, together: some seconds. A million vertices of a real plan
/// need a tenth of it.
const WORK_LIMIT: f64 = 1e8;
/// A door or window drawn as a line goes through the wall that it stands on, up to this far to either side, metres.
const THICKEST_WALL_M: f64 = 0.6;
/// Points, half a cell apart, at either end of such a line that leave the wall beside them alone.
const JAMB_POINTS: usize = 2;
/// A door given as a point is this wide in all, metres.
pub(super) const POINT_DOOR_M: f64 = 0.9;
/// Share of the enclosed ground that floors must cover for the rest to count as not drawn.
const FLOORS_ARE_ALL: f64 = 0.6;

/// A point of the grid: columns and rows from its corner.
type Point = [f64; 2];

/// Draws one storey.
pub(super) fn draw(elements: &[Element], notes: &mut Vec<String>) -> Result<FloorPlan, PlanFileError> {
    // A room that is only a name, or that was found between walls, is no ground that somebody drew.
    let mut elements: Vec<&Element> = elements.iter().filter(|e| !audit::is_remark(e)).collect();
    let count = |kind: ElementKind| elements.iter().filter(|e| e.kind == kind).count();
    let [walls, windows, doors] = [ElementKind::Wall, ElementKind::Window, ElementKind::Door].map(count);
    let floors = elements.iter().filter(|e| e.kind.is_ground()).count();
    notes.push(format!("drawn from {walls} walls, {windows} windows, {doors} doors and {floors} floor areas"));
    let mut canvas = Canvas::around(&elements, notes)?;
    // Stable: shapes of one kind stay in the file's order.
    elements.sort_by_key(|element| match element.kind {
        ElementKind::Wall => 1,
        ElementKind::Window => 2,
        ElementKind::Door => 3,
        _ => 0,
    });
    for element in &elements {
        match (element.kind, &element.form) {
            (ElementKind::Wall, form) => canvas.solid(form, Cell::Wall)?,
            (ElementKind::Window, form) => canvas.solid(form, Cell::Window)?,
            // After the outlines of rooms.
            (ElementKind::Door, _) => {}
            (_, form @ Form::Area(_)) => canvas.solid(form, Cell::Free)?,
            _ => {}
        }
    }
    if walls + windows == 0 && floors > 0 {
        canvas.wall_in(&elements, notes)?;
    }
    for element in elements.iter().filter(|e| e.kind == ElementKind::Door) {
        canvas.solid(&element.form, Cell::Door)?;
    }
    let only_floors = elements.iter().all(|element| element.kind == ElementKind::Floor);
    canvas.plan(floors > 0, only_floors, notes)
}

/// A grid that is being drawn on, row 0 at the bottom.
struct Canvas {
    origin: Point,
    cell_m: f64,
    width: usize,
    height: usize,
    cells: Vec<Cell>,
    work_left: f64,
}

impl Canvas {
    /// A grid that holds the shapes, its corner at a whole number of cells of the file's own metres.
    fn around(elements: &[&Element], notes: &mut Vec<String>) -> Result<Self, PlanFileError> {
        let points = || elements.iter().flat_map(|e| e.form.points());
        let low = points().fold([f64::INFINITY; 2], |l, p| [l[0].min(p.x), l[1].min(p.y)]);
        let high = points().fold([f64::NEG_INFINITY; 2], |h, p| [h[0].max(p.x), h[1].max(p.y)]);
        let size_m = [0, 1].map(|k| high[k] - low[k] + 2.0 * MARGIN_M);
        if low[0] > high[0] {
            return Err(PlanError::NoWalls.into());
        }
        let coarsest_m = if elements.iter().all(|e| e.kind == ElementKind::Floor) { COARSEST_ROADS_M } else { COARSEST_M };
        let mut cell_m = FINEST_M;
        while size_m[0] * size_m[1] > CELLS_WANTED * cell_m * cell_m && cell_m < coarsest_m {
            cell_m *= 2.0;
        }
        // Written so that what is not finite is refused too.
        let fits = size_m[0] * size_m[1] <= CELLS_WANTED * cell_m * cell_m && low.iter().chain(&high).all(|v| v.abs() < 1e9);
        if !fits {
            let far = astray::farthest(elements.iter().copied()).map_or(Pt2::new(0.0, 0.0), |(_, at)| at);
            let limit_km2 = CELLS_WANTED * coarsest_m * coarsest_m / 1e6;
            return Err(PlanFileError::TooWide { width_m: size_m[0], height_m: size_m[1], limit_km2, x: far.x, y: far.y });
        }
        if cell_m > FINEST_M {
            notes.push(format!("the site is large: cells are {cell_m} m wide instead of {FINEST_M} m"));
        }
        let origin = low.map(|v| ((v - MARGIN_M) / cell_m).floor() * cell_m);
        let [width, height] = [0, 1].map(|k| ((high[k] + MARGIN_M - origin[k]) / cell_m).ceil().max(1.0) as usize);
        Ok(Self { origin, cell_m, width, height, cells: vec![Cell::Unknown; width * height], work_left: WORK_LIMIT })
    }

    /// In cells from the corner.
    fn to_grid(&self, point: Pt2<Plan>) -> Point {
        [(point.x - self.origin[0]) / self.cell_m, (point.y - self.origin[1]) / self.cell_m]
    }

    fn index(&self, at: Point) -> Option<usize> {
        let held = at[0] >= 0.0 && at[1] >= 0.0 && at[0] < self.width as f64 && at[1] < self.height as f64;
        held.then(|| at[1] as usize * self.width + at[0] as usize)
    }

    fn spend(&mut self, work: f64) -> Result<(), PlanFileError> {
        self.work_left -= work;
        if self.work_left < 0.0 { Err(PlanFileError::TooIntricate { limit: WORK_LIMIT as u64 }) } else { Ok(()) }
    }

    /// All cells that the form touches; what is drawn as a line goes through the wall that it stands on.
    fn solid(&mut self, form: &Form, cell: Cell) -> Result<(), PlanFileError> {
        match form {
            Form::Area(rings) => {
                self.fill(rings, cell)?;
                self.outline(form, cell)
            }
            Form::Line(line) if cell == Cell::Wall => self.chain(line, cell),
            Form::Line(line) => line.windows(2).try_for_each(|ends| self.through(ends[0], ends[1], cell)),
            Form::Spot(at) if cell == Cell::Door => self.spot(*at),
            Form::Spot(_) => Ok(()),
        }
    }

    fn outline(&mut self, form: &Form, cell: Cell) -> Result<(), PlanFileError> {
        let Form::Area(rings) = form else { return Ok(()) };
        for ring in rings {
            self.chain(ring, cell)?;
            if let (Some(first), Some(last)) = (ring.first(), ring.last()) {
                self.chain(&[*last, *first], cell)?;
            }
        }
        Ok(())
    }

    fn chain(&mut self, line: &[Pt2<Plan>], cell: Cell) -> Result<(), PlanFileError> {
        for ends in line.windows(2) {
            for at in self.points(ends[0], ends[1])? {
                if let Some(i) = self.index(at) {
                    self.cells[i] = cell;
                }
            }
        }
        Ok(())
    }

    /// Points of a straight piece, in cells. Half-cell steps leave no gap, not even diagonally.
    fn points(&mut self, from: Pt2<Plan>, to: Pt2<Plan>) -> Result<impl Iterator<Item = Point> + use<>, PlanFileError> {
        let (from, to) = (self.to_grid(from), self.to_grid(to));
        let way = [to[0] - from[0], to[1] - from[1]];
        let count = (2.0 * way[0].hypot(way[1])).ceil().max(1.0);
        self.spend(count)?;
        Ok((0..=count as usize).map(move |i| [from[0] + i as f64 / count * way[0], from[1] + i as f64 / count * way[1]]))
    }

    /// A door or window drawn as a line: its own cells, and the wall to either side of it.
    fn through(&mut self, from: Pt2<Plan>, to: Pt2<Plan>, cell: Cell) -> Result<(), PlanFileError> {
        let way = [to.x - from.x, to.y - from.y];
        let length = way[0].hypot(way[1]);
        let normal = if length > 0.0 { [-way[1] / length, way[0] / length] } else { [0.0, 0.0] };
        let reach = (2.0 * THICKEST_WALL_M / self.cell_m).ceil() as usize;
        let points: Vec<Point> = self.points(from, to)?.collect();
        self.spend(points.len() as f64 * 2.0 * reach as f64)?;
        // At its ends, other walls meet the one that it stands on; those stay.
        let jamb = if points.len() > 8 * JAMB_POINTS { JAMB_POINTS } else { 0 };
        let middle = jamb..points.len() - jamb;
        for (k, at) in points.into_iter().enumerate() {
            let reach = if middle.contains(&k) { reach } else { 0 };
            for side in [0.5, -0.5] {
                for step in 0..=reach {
                    let k = side * step as f64;
                    let Some(i) = self.index([at[0] + k * normal[0], at[1] + k * normal[1]]) else { break };
                    // The first two steps may lie beside a wall that is drawn along its other face.
                    if step > 2 && !self.cells[i].blocks() && self.cells[i] != cell {
                        break;
                    }
                    if step == 0 || self.cells[i].blocks() {
                        self.cells[i] = cell;
                    }
                }
            }
        }
        Ok(())
    }

    /// A door given as a point: the walls around it.
    fn spot(&mut self, at: Pt2<Plan>) -> Result<(), PlanFileError> {
        let centre = self.to_grid(at);
        let radius = 0.5 * POINT_DOOR_M / self.cell_m;
        let reach = radius.ceil() as isize;
        self.spend((2 * reach + 1).pow(2) as f64)?;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (dx, dy) = (dx as f64, dy as f64);
                let near = self.index([centre[0] + dx, centre[1] + dy]).filter(|_| dx.hypot(dy) <= radius);
                if let Some(i) = near.filter(|i| self.cells[*i].blocks()) {
                    self.cells[i] = Cell::Door;
                }
            }
        }
        Ok(())
    }

    /// Walls where none are drawn: along the outlines of rooms; and where there are none of these either, as for streets, where the
    /// ground ends.
    fn wall_in(&mut self, elements: &[&Element], notes: &mut Vec<String>) -> Result<(), PlanFileError> {
        let rooms = || elements.iter().filter(|e| matches!(e.kind, ElementKind::Room | ElementKind::Stairs | ElementKind::Lift));
        if rooms().next().is_some() {
            notes.push("no walls are drawn: the outlines of rooms are taken as walls, except where a door crosses them".to_owned());
            return rooms().try_for_each(|room| self.outline(&room.form, Cell::Wall));
        }
        notes.push("no walls are drawn: where the ground ends there is taken to be one".to_owned());
        let ground: Vec<bool> = self.cells.iter().map(|cell| *cell == Cell::Free).collect();
        for (i, cell) in self.cells.iter_mut().enumerate() {
            let (x, y) = (i % self.width, i / self.width);
            let (columns, rows) = (x.saturating_sub(1)..(x + 2).min(self.width), y.saturating_sub(1)..(y + 2).min(self.height));
            if !ground[i] && rows.clone().any(|y| columns.clone().any(|x| ground[y * self.width + x])) {
                *cell = Cell::Wall;
            }
        }
        Ok(())
    }

    /// Cells whose centres lie inside, by the even-odd rule, row by row.
    fn fill(&mut self, rings: &[Vec<Pt2<Plan>>], cell: Cell) -> Result<(), PlanFileError> {
        let mut edges = self.edges(rings)?;
        edges.sort_by_key(|edge| edge.rows.start);
        let mut coming = edges.into_iter().peekable();
        let mut active: Vec<Edge> = Vec::new();
        let mut crossings: Vec<f64> = Vec::new();
        let mut row = coming.peek().map_or(0, |edge| edge.rows.start);
        while coming.peek().is_some() || !active.is_empty() {
            while let Some(edge) = coming.next_if(|edge| edge.rows.start <= row) {
                active.push(edge);
            }
            active.retain(|edge| edge.rows.end > row);
            crossings.clear();
            crossings.extend(active.iter().map(|edge| edge.at_zero + edge.slope * (row as f64 + 0.5)));
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                // Columns whose centres lie between; casts saturate.
                let (first, end) = ((pair[0] - 0.5).ceil().max(0.0) as usize, (pair[1] - 0.5).ceil().max(0.0) as usize);
                let (first, end) = (first.min(self.width), end.min(self.width));
                if first < end {
                    self.cells[row * self.width + first..row * self.width + end].fill(cell);
                }
            }
            row += 1;
            if active.is_empty() {
                row = coming.peek().map_or(row, |edge| edge.rows.start.max(row));
            }
        }
        Ok(())
    }

    fn edges(&mut self, rings: &[Vec<Pt2<Plan>>]) -> Result<Vec<Edge>, PlanFileError> {
        let mut edges = Vec::new();
        for ring in rings {
            for (k, from) in ring.iter().enumerate() {
                let (a, b) = (self.to_grid(*from), self.to_grid(ring[(k + 1) % ring.len()]));
                let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
                let row = |y: f64| ((y - 0.5).ceil().max(0.0) as usize).min(self.height);
                let rows = row(low[1])..row(high[1]);
                if rows.is_empty() {
                    continue;
                }
                let slope = (high[0] - low[0]) / (high[1] - low[1]);
                self.spend(rows.len() as f64)?;
                edges.push(Edge { rows, at_zero: low[0] - slope * low[1], slope });
            }
        }
        Ok(edges)
    }

    /// The plan: ground under no floor is free where floors are few, else not known. Where floors are all that is drawn, as of roads,
    /// what lies between them is not known either.
    fn plan(self, has_floors: bool, only_floors: bool, notes: &mut Vec<String>) -> Result<FloorPlan, PlanFileError> {
        let Self { origin: [x, y], cell_m, width, height, cells, .. } = self;
        if has_floors && only_floors {
            notes.push(NOT_KNOWN.to_owned());
            return Ok(FloorPlan::new(Pt2::new(x, y), cell_m, width, height, cells)?);
        }
        let bare: Vec<Cell> = cells.iter().map(|c| if *c == Cell::Unknown { Cell::Free } else { *c }).collect();
        let plan = FloorPlan::new(Pt2::new(x, y), cell_m, width, height, bare)?;
        if !has_floors {
            return Ok(plan);
        }
        let enclosed = || plan.inside().iter().zip(&cells).filter(|(inside, _)| **inside > 0.5);
        let floor = enclosed().filter(|(_, cell)| **cell != Cell::Unknown).count();
        let share = floor as f64 / enclosed().count().max(1) as f64;
        if share < FLOORS_ARE_ALL {
            let percent = 100.0 * share;
            notes.push(format!("the floor areas cover only {percent:.0} % of what walls enclose: what lies between counts as floor too"));
            return Ok(plan);
        }
        notes.push(NOT_KNOWN.to_owned());
        drop(plan);
        Ok(FloorPlan::new(Pt2::new(x, y), cell_m, width, height, cells)?)
    }
}

/// What is said of ground that is not drawn.
const NOT_KNOWN: &str = "what lies under no floor area counts as not known: one may walk there, but it is unlikely";

/// A piece of a ring: the rows whose centres it crosses, and where, in columns: `at_zero + slope · y`.
struct Edge {
    rows: std::ops::Range<usize>,
    at_zero: f64,
    slope: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(points: &[[f64; 2]]) -> Vec<Pt2<Plan>> {
        points.iter().map(|[x, y]| Pt2::new(*x, *y)).collect()
    }

    fn ring(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<Pt2<Plan>> {
        chain(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    }

    fn drawn(elements: &[Element]) -> FloorPlan {
        draw(elements, &mut Vec::new()).unwrap()
    }

    /// A room of 4 m × 3 m inside walls 0.2 m thick, as one area with a hole, far from the origin.
    fn walls() -> Element {
        let at = |x0: f64, y0: f64, x1: f64, y1: f64| ring(566_600.0 + x0, 5_932_800.0 + y0, 566_600.0 + x1, 5_932_800.0 + y1);
        Element::new(ElementKind::Wall, Form::Area(vec![at(-0.2, -0.2, 4.2, 3.2), at(0.0, 0.0, 4.0, 3.0)]))
    }

    fn here(x: f64, y: f64) -> Pt2<Plan> {
        Pt2::new(566_600.0 + x, 5_932_800.0 + y)
    }

    #[test]
    fn walls_are_filled_and_their_holes_are_rooms() {
        let plan = drawn(&[walls()]);
        assert_eq!(plan.at(here(2.0, 1.5)), Cell::Free);
        assert_eq!(plan.at(here(-0.1, 1.5)), Cell::Wall);
        assert_eq!(plan.at(here(4.1, 3.1)), Cell::Wall);
        // Walls grow by less than a cell.
        assert_eq!(plan.at(here(0.06, 1.5)), Cell::Free);
        assert_eq!(plan.at(here(-0.26, 1.5)), Cell::Free);
    }

    #[test]
    fn a_door_wins_over_its_wall_whichever_way_it_is_drawn() {
        let [x, y] = [566_600.0, 5_932_800.0];
        for form in [
            Form::Area(vec![ring(x + 1.0, y - 0.2, x + 1.9, y)]),
            Form::Line(chain(&[[x + 1.0, y - 0.1], [x + 1.9, y - 0.1]])),
            // Along the inner face, and along the outer.
            Form::Line(chain(&[[x + 1.0, y], [x + 1.9, y]])),
            Form::Line(chain(&[[x + 1.0, y - 0.2], [x + 1.9, y - 0.2]])),
            Form::Spot(here(1.45, -0.1)),
        ] {
            let plan = drawn(&[Element::new(ElementKind::Door, form.clone()), walls()]);
            for depth in [-0.19, -0.1, -0.01] {
                assert_eq!(plan.at(here(1.45, depth)), Cell::Door, "{form:?} at {depth}");
            }
            assert_eq!(plan.at(here(0.8, -0.1)), Cell::Wall, "{form:?} beside");
            assert_eq!(plan.at(here(1.45, 3.1)), Cell::Wall, "{form:?} opposite");
        }
    }

    #[test]
    fn thin_slanted_walls_have_no_holes() {
        // 1 cm thick: few of its cells have their centre in it.
        let thin = Element::new(ElementKind::Wall, Form::Area(vec![chain(&[[0.0, 0.0], [10.0, 3.0], [10.0, 3.01], [0.0, 0.01]])]));
        let plan = drawn(&[thin]);
        for i in 0..1000 {
            let t = f64::from(i) / 1000.0;
            let (x, y) = (10.0 * t, 3.0 * t + 0.005);
            let near = [-0.025, 0.0, 0.025].iter().any(|d| plan.at(Pt2::new(x, y + d)) == Cell::Wall);
            assert!(near, "at {x}, {y}");
        }
    }

    #[test]
    fn rooms_without_walls_are_walled_and_what_is_around_is_not_known() {
        let rooms = [
            Element::new(ElementKind::Room, Form::Area(vec![ring(0.0, 0.0, 4.0, 3.0)])),
            Element::new(ElementKind::Room, Form::Area(vec![ring(4.0, 0.0, 8.0, 3.0)])),
            Element::new(ElementKind::Door, Form::Line(chain(&[[4.0, 1.0], [4.0, 2.0]]))),
        ];
        let mut notes = Vec::new();
        let plan = draw(&rooms, &mut notes).unwrap();
        assert!(notes.iter().any(|n| n.contains("outlines of rooms")), "{notes:?}");
        let at = |x, y| plan.at(Pt2::new(x, y));
        assert_eq!([at(2.0, 1.5), at(4.01, 0.5), at(4.01, 1.5), at(-0.5, 1.5)], [Cell::Free, Cell::Wall, Cell::Door, Cell::Unknown]);
    }

    #[test]
    fn streets_end_where_their_ground_ends() {
        let street = |ring: Vec<Pt2<Plan>>| Element::new(ElementKind::Floor, Form::Area(vec![ring]));
        let plan = drawn(&[street(ring(0.0, 0.0, 20.0, 4.0)), street(ring(8.0, 0.0, 12.0, 20.0))]);
        let at = |x, y| plan.at(Pt2::new(x, y));
        // Where they meet there is no wall.
        assert_eq!([at(10.0, 4.0), at(8.02, 3.9), at(4.0, 4.09), at(4.0, 4.5)], [Cell::Free, Cell::Free, Cell::Wall, Cell::Unknown]);
    }

    #[test]
    fn roads_of_a_town_are_drawn_and_its_blocks_are_not_ground() {
        // Eleven streets each way, 4 km long and 6 m wide: blocks of 400 m that are enclosed on all sides.
        let street = |ring: Vec<Pt2<Plan>>| Element::new(ElementKind::Floor, Form::Area(vec![ring]));
        let of = |k: i32| 400.0 * f64::from(k);
        let across = (0..11).map(|k| street(ring(0.0, of(k), 4000.0, of(k) + 6.0)));
        let along = (0..11).map(|k| street(ring(of(k), 0.0, of(k) + 6.0, 4000.0)));
        let mut streets: Vec<Element> = across.chain(along).collect();
        let plan = drawn(&streets);
        let at = |x, y| plan.at(Pt2::new(x, y));
        assert_eq!([at(2000.0, 1603.0), at(1403.0, 803.0), at(1000.0, 1000.0)], [Cell::Free, Cell::Free, Cell::Unknown]);
        // 16 km² in cells of 1.6 m are 6 million; as a floor with walls they are too many.
        assert!(plan.cell_m() > 0.4 && plan.width() * plan.height() <= CELLS_WANTED as usize);
        streets.push(Element::new(ElementKind::Wall, Form::Line(chain(&[[0.0, 0.0], [5.0, 0.0]]))));
        assert!(matches!(draw(&streets, &mut Vec::new()), Err(PlanFileError::TooWide { .. })));
    }

    #[test]
    fn few_floor_areas_say_nothing_of_the_rest() {
        let stairs = Element::new(ElementKind::Room, Form::Area(vec![ring(566_600.5, 5_932_800.5, 566_601.0, 5_932_801.0)]));
        let mut notes = Vec::new();
        let plan = draw(&[walls(), stairs], &mut notes).unwrap();
        assert_eq!(plan.at(here(3.0, 2.0)), Cell::Free);
        assert!(notes.iter().any(|n| n.contains("cover only")), "{notes:?}");
    }

    #[test]
    fn hostile_shapes_are_refused_in_bounded_time() {
        let draw = |elements: &[Element]| draw(elements, &mut Vec::new());
        let refused = |form: Form| draw(&[Element::new(ElementKind::Wall, form)]).err().unwrap();
        for far in [1e7, 1e300, f64::INFINITY, f64::NAN] {
            let error = refused(Form::Line(chain(&[[0.0, 0.0], [far, far], [5.0, 5.0]])));
            assert!(matches!(error, PlanFileError::TooWide { .. } | PlanFileError::Plan(_)), "{far}: {error}");
        }
        // Up and down a million times over 200 m.
        let zigzag = (0..1_000_000).map(|i| Pt2::new(f64::from(i) * 1e-4, if i % 2 == 0 { 0.0 } else { 200.0 })).collect();
        assert!(matches!(refused(Form::Area(vec![zigzag])), PlanFileError::TooIntricate { .. }));
        assert!(matches!(refused(Form::Area(vec![vec![], vec![]])), PlanFileError::Plan(PlanError::NoWalls)));
        // One point is a wall of one cell.
        assert!(draw(&[Element::new(ElementKind::Wall, Form::Area(vec![chain(&[[1.0, 1.0]])]))]).is_ok());
        assert!(draw(&[]).is_err());
    }
}
