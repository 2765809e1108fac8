//! What are the outlines of what a picture shows? Areas of wall, and of the ground that a robot knows, as rings in metres.
//!
//! pixels ─▶ [`border`]: loops along the cracks between pixels, exact ─▶ [`side`]: straight sides ─▶ [`contact`]: sides that would
//! meet stay as the pixels have them ─▶ [`Element`]s
//!
//! Frame: origin at the picture's bottom-left corner, x right, y **up**; outlines run counter-clockwise, holes clockwise. Inside, points
//! are in pixels with y **down**, as [`Pixels`] are.
//! Pitfall: where pixels touch at a corner only, two rings, or a ring and itself, may share that one point; they never cross.

mod border;
mod contact;
mod side;

use planwalk_types::{Cell, Element, ElementKind, Form, Plan, Pt2};

use self::border::{Border, Joined};
use self::side::Ring;
use super::PlanFileError;
use super::cells::Pixels;

/// What is smaller than this in both directions is noise of a scan, where pixels are fine (see [`THINNEST_POST_M`]).
const SPECK_PX: i32 = 3;
/// The thinnest thing that counts as built. Pictures in which it is narrower than [`SPECK_PX`] have no specks: a pixel of a robot's
/// map is a post that was measured.
const THINNEST_POST_M: f64 = 0.05;
/// No outline is farther from the pixels' border than this, in pixels: the border of any straight line, drawn pixel by pixel, is within
/// √½ of it.
const SLACK_PX: f64 = 0.75;
/// Where pixels are fine, bumps along a straight wall may be this far off it: scans are wrong by a pixel.
const FINE_SLACK_PX: f64 = 1.5;
/// … but no more than this.
const FINE_SLACK_M: f64 = 0.015;
/// Times that sides are given back to the pixels because they meet others, before the whole area is.
const ROUNDS: usize = 16;

/// What a picture shows.
pub(super) struct Outlines {
    /// Areas of wall and known ground, from the top of the picture to its bottom.
    pub elements: Vec<Element>,
    /// Areas and holes that were left out because they are no larger than noise.
    pub specks: usize,
}

/// Outlines of the walls and, where the picture tells known ground from unknown, of the known ground.
///
/// Walls that touch at a corner are one piece; ground that does is two. Every point of a pixels' border is within 0.75 px of an outline,
/// or within 1.5 px where that is at most 1.5 cm.
///
/// # Errors
/// [`PlanFileError::TooRagged`] for photographs and dithered pictures.
pub(super) fn trace(pixels: &Pixels, metres_per_pixel: f64) -> Result<Outlines, PlanFileError> {
    let mut outlines = Outlines { elements: Vec::new(), specks: 0 };
    outlines.add(ElementKind::Wall, Joined::AtCorners, |cell| cell == Cell::Wall, pixels, metres_per_pixel)?;
    if pixels.cells.contains(&Cell::Door) {
        outlines.add(ElementKind::Door, Joined::AtCorners, |cell| cell == Cell::Door, pixels, metres_per_pixel)?;
    }
    if pixels.cells.contains(&Cell::Unknown) && pixels.cells.contains(&Cell::Free) {
        outlines.add(ElementKind::Floor, Joined::AtSides, |cell| cell == Cell::Free, pixels, metres_per_pixel)?;
    }
    Ok(outlines)
}

impl Outlines {
    fn add(
        &mut self,
        kind: ElementKind,
        joined: Joined,
        is_in: impl Fn(Cell) -> bool,
        pixels: &Pixels,
        metres_per_pixel: f64,
    ) -> Result<(), PlanFileError> {
        let found = border::borders(pixels, is_in, joined, smallest_px(metres_per_pixel))?;
        self.specks += found.specks;
        let slack_px = slack_px(metres_per_pixel);
        let metres = |[u, v]: side::Point| Pt2::<Plan>::new(u * metres_per_pixel, (pixels.height as f64 - v) * metres_per_pixel);
        for area in found.areas {
            let rings = rings(&area, slack_px);
            let form = Form::Area(rings.iter().map(|ring| ring.iter().map(|at| metres(*at)).collect()).collect());
            self.elements.push(Element::new(kind, form));
        }
        Ok(())
    }
}

/// What is smaller in both directions, in pixels, is noise.
fn smallest_px(metres_per_pixel: f64) -> i32 {
    if f64::from(SPECK_PX) * metres_per_pixel <= THINNEST_POST_M { SPECK_PX } else { 0 }
}

/// How far from the border an outline may be.
fn slack_px(metres_per_pixel: f64) -> f64 {
    (FINE_SLACK_M / metres_per_pixel).clamp(SLACK_PX, FINE_SLACK_PX)
}

/// The rings of one area, its outline first: as straight as they can be without meeting.
fn rings(area: &[Border], slack_px: f64) -> Vec<Vec<side::Point>> {
    let mut rings: Vec<Ring> = area.iter().map(|border| Ring::straightened(&border.corners, slack_px)).collect();
    for round in 0.. {
        let vertices: Vec<_> = rings.iter().map(Ring::vertices).collect();
        let meeting = contact::meeting(&vertices);
        if meeting.is_empty() {
            break;
        }
        if round == ROUNDS {
            rings.iter_mut().for_each(Ring::give_all_back);
            break;
        }
        for (ring, sides) in meeting {
            rings[ring].give_back(&sides);
        }
    }
    rings.iter().map(Ring::points).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::ops::RangeInclusive;

    /// `#` is wall, `?` unknown, the rest free.
    fn picture(drawn: &str) -> Pixels {
        let rows: Vec<&str> = drawn.split_whitespace().collect();
        let cell = |c: char| match c {
            '#' => Cell::Wall,
            '?' => Cell::Unknown,
            _ => Cell::Free,
        };
        Pixels { width: rows[0].len(), height: rows.len(), cells: rows.iter().flat_map(|row| row.chars().map(cell)).collect() }
    }

    /// Wall where it `is`, at the centre of pixels, y up from the bottom, and free elsewhere.
    fn drawn(width: usize, height: usize, is: impl Fn(f64, f64) -> bool) -> Pixels {
        let at = |i: usize| ((i % width) as f64 + 0.5, (height - i / width) as f64 - 0.5);
        let cell = |i: usize| if is(at(i).0, at(i).1) { Cell::Wall } else { Cell::Free };
        Pixels { width, height, cells: (0..width * height).map(cell).collect() }
    }

    type Rings = Vec<Vec<[f64; 2]>>;

    /// Rings of the elements of one kind, metres.
    fn traced(pixels: &Pixels, metres_per_pixel: f64, kind: ElementKind) -> Vec<Rings> {
        let elements = trace(pixels, metres_per_pixel).unwrap().elements;
        let rings = |element: &Element| match &element.form {
            Form::Area(rings) => rings.iter().map(|ring| ring.iter().map(|p| [p.x, p.y]).collect()).collect(),
            other => panic!("{other:?}"),
        };
        elements.iter().filter(|element| element.kind == kind).map(rings).collect()
    }

    fn walls(pixels: &Pixels, metres_per_pixel: f64) -> Vec<Rings> {
        traced(pixels, metres_per_pixel, ElementKind::Wall)
    }

    /// Whether two rings have the same points in the same order, wherever they begin.
    fn is_same(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
        let near = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6;
        a.len() == b.len() && (0..a.len()).any(|k| a.iter().zip(b.iter().cycle().skip(k)).all(|(a, b)| near(a, b)))
    }

    /// Above zero for those that run counter-clockwise, y up.
    fn area(ring: &[[f64; 2]]) -> f64 {
        edges(ring).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
    }

    fn edges(ring: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + Clone {
        ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
    }

    fn off_edge(at: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
        let (way, to) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
        let along = ((way[0] * to[0] + way[1] * to[1]) / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0);
        (to[0] - along * way[0]).hypot(to[1] - along * way[1])
    }

    fn off_rings(at: [f64; 2], rings: &[Vec<[f64; 2]>]) -> f64 {
        rings.iter().flat_map(|ring| edges(ring)).map(|(a, b)| off_edge(at, a, b)).fold(f64::INFINITY, f64::min)
    }

    /// By the even-odd rule.
    fn is_inside(at: [f64; 2], rings: &[Vec<[f64; 2]>]) -> bool {
        let crosses = |(a, b): ([f64; 2], [f64; 2])| {
            (a[1] > at[1]) != (b[1] > at[1]) && at[0] < a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        rings.iter().flat_map(|ring| edges(ring)).filter(|edge| crosses(*edge)).count() % 2 == 1
    }

    /// Rasterises areas again: the share of pixels that are then as they were.
    fn agreement(areas: &[Rings], pixels: &Pixels, is_in: impl Fn(Cell) -> bool) -> f64 {
        let all: Rings = areas.iter().flatten().cloned().collect();
        let centre = |i: usize| [(i % pixels.width) as f64 + 0.5, (pixels.height - i / pixels.width) as f64 - 0.5];
        let same = (0..pixels.cells.len()).filter(|i| is_inside(centre(*i), &all) == is_in(pixels.cells[*i])).count();
        same as f64 / pixels.cells.len() as f64
    }

    /// The borders as they are, pixels, y up.
    fn unstraightened(pixels: &Pixels, is_in: impl Fn(Cell) -> bool, joined: Joined) -> Vec<Rings> {
        let point = |[u, v]: border::Corner| [f64::from(u), pixels.height as f64 - f64::from(v)];
        let found = border::borders(pixels, is_in, joined, 0).unwrap();
        let rings = |area: &Vec<Border>| area.iter().map(|border| border.corners.iter().map(|c| point(*c)).collect()).collect();
        found.areas.iter().map(rings).collect()
    }

    #[test]
    fn a_room_is_an_outline_and_a_hole_in_metres_from_the_bottom_left() {
        let pixels = picture(
            "......
             .####.
             .#..#.
             .####.",
        );
        let areas = walls(&pixels, 0.5);
        assert_eq!(areas.len(), 1);
        assert!(is_same(&areas[0][0], &[[0.5, 0.0], [2.5, 0.0], [2.5, 1.5], [0.5, 1.5]]), "{areas:?}");
        assert!(is_same(&areas[0][1], &[[1.0, 0.5], [1.0, 1.0], [2.0, 1.0], [2.0, 0.5]]), "{areas:?}");
    }

    #[test]
    fn holes_go_to_their_own_walls_though_these_are_met_late() {
        // A frame around a frame; the left arm of the U is joined to the rest at the bottom only.
        let pixels = picture(
            "#..######
             #..#....#
             #..#.##.#
             #..#.##.#
             #..#....#
             #########",
        );
        let areas = walls(&pixels, 0.05);
        let holes: Vec<usize> = areas.iter().map(Vec::len).collect();
        assert_eq!(holes, [2, 1]);
    }

    #[test]
    fn walls_that_touch_at_a_corner_are_one_and_ground_that_does_is_two() {
        let pixels = picture(
            "?????
             ?#..?
             ?.#.?
             ?..#?
             ?????",
        );
        assert_eq!(walls(&pixels, 0.05).len(), 1);
        assert_eq!(traced(&pixels, 0.05, ElementKind::Floor).len(), 2);
    }

    #[test]
    fn ground_is_outlined_only_where_some_is_not_known() {
        let drawing = "#..#";
        assert!(traced(&picture(drawing), 0.05, ElementKind::Floor).is_empty());
        assert!(traced(&picture("#??#"), 0.05, ElementKind::Floor).is_empty());
        let known = traced(&picture("#..#??"), 0.1, ElementKind::Floor);
        assert!(is_same(&known[0][0], &[[0.1, 0.0], [0.3, 0.0], [0.3, 0.1], [0.1, 0.1]]), "{known:?}");
    }

    #[test]
    fn specks_are_left_out_of_scans_but_posts_stay_in_maps() {
        let pixels = picture(
            "#....#####
             #....##.##
             .....#####
             ......##..
             ..##......
             ..##......",
        );
        let scanned = trace(&pixels, 0.01).unwrap();
        // The two bars and the square are noise, and so is the pinhole.
        assert_eq!((scanned.elements.len(), scanned.specks), (1, 3));
        let measured = trace(&pixels, 0.05).unwrap();
        assert_eq!((measured.elements.len(), measured.specks), (3, 0));
        assert_eq!(measured.elements[1].form.chains().filter(|ring| !ring.is_empty()).count(), 2);
        // A bar of three pixels is as long as what is built.
        assert_eq!(trace(&picture("#..\n#..\n#.."), 0.01).unwrap().specks, 0);
    }

    #[test]
    fn slanted_walls_get_straight_sides_and_sharp_corners() {
        for slope in [0.02, 0.1, 0.37, 0.75, 1.0, 1.6, 6.0] {
            // A bar, 120 × 6 px, turned about the middle.
            let (s, c) = f64::atan(slope).sin_cos();
            let turned = |x: f64, y: f64| [70.3 + c * x - s * y, 70.8 + s * x + c * y];
            let pixels = drawn(141, 141, |x, y| {
                let (x, y) = (x - 70.3, y - 70.8);
                (c * x + s * y).abs() < 60.0 && (c * y - s * x).abs() < 3.0
            });
            let areas = walls(&pixels, 1.0);
            let ring = &areas[0][0];
            let corners = [turned(60.0, 3.0), turned(-60.0, 3.0), turned(-60.0, -3.0), turned(60.0, -3.0)];
            assert!(ring.len() <= 10, "slope {slope}: {} points {ring:?}", ring.len());
            for at in ring {
                let off = off_rings(*at, &[corners.to_vec()]);
                assert!(off < 1.0, "slope {slope}: {at:?} is {off} px off");
            }
            for corner in corners {
                let near = ring.iter().map(|at| (at[0] - corner[0]).hypot(at[1] - corner[1])).fold(f64::INFINITY, f64::min);
                assert!(near < 1.5, "slope {slope}: the corner {corner:?} is {near} px from the nearest");
            }
        }
    }

    #[test]
    fn slanted_walls_of_enlarged_pictures_are_straight_too_where_pixels_are_fine() {
        // Enlarged by 4 to 3: steps are one or two pixels high, without order.
        let enlarged = |v: f64| (v * 0.75).floor() / 0.75;
        for slope in [0.3, 0.9, 1.3] {
            let (s, c) = f64::atan(slope).sin_cos();
            let pixels = drawn(281, 281, |x, y| {
                let (x, y) = (enlarged(x) - 140.3, enlarged(y) - 140.8);
                (c * x + s * y).abs() < 120.0 && (c * y - s * x).abs() < 9.0
            });
            let areas = walls(&pixels, 0.01);
            assert!(areas[0][0].len() <= 12, "slope {slope}: {} points {:?}", areas[0][0].len(), areas[0][0]);
        }
    }

    #[test]
    fn a_diagonal_wall_one_pixel_thick_is_a_strip() {
        let pixels = drawn(40, 40, |x, y| x == y && (5.0..35.0).contains(&x));
        let areas = walls(&pixels, 0.05);
        assert_eq!((areas.len(), areas[0].len()), (1, 1));
        assert!(areas[0][0].len() <= 8, "{:?}", areas[0][0]);
        // As much wall as pixels, but for the ends.
        let share = area(&areas[0][0]) / (30.0 * 0.05 * 0.05);
        assert!((share - 1.0).abs() < 0.05, "{share}");
    }

    #[test]
    fn a_step_between_long_walls_stays_and_a_bump_on_one_goes_where_pixels_are_fine() {
        let step = drawn(140, 30, |x, y| (10.0..130.0).contains(&x) && y > 5.0 && y < if x < 70.0 { 20.0 } else { 21.0 });
        let bump = drawn(140, 30, |x, y| (10.0..130.0).contains(&x) && y > 5.0 && y < if (60.0..64.0).contains(&x) { 21.0 } else { 20.0 });
        let bar = [[10.0, 5.0], [130.0, 5.0], [130.0, 20.0], [10.0, 20.0]];
        let with_step = [[10.0, 5.0], [130.0, 5.0], [130.0, 21.0], [70.0, 21.0], [70.0, 20.0], [10.0, 20.0]];
        let in_px = |pixels: &Pixels, m: f64| walls(pixels, m)[0][0].iter().map(|at| at.map(|v| v / m)).collect::<Vec<_>>();
        for metres_per_pixel in [0.01, 0.05] {
            assert!(is_same(&in_px(&step, metres_per_pixel), &with_step), "{:?}", in_px(&step, metres_per_pixel));
        }
        assert!(is_same(&in_px(&bump, 0.01), &bar), "{:?}", in_px(&bump, 0.01));
        assert_eq!(in_px(&bump, 0.05).len(), 8);
    }

    #[test]
    fn round_walls_are_polygons_close_by() {
        let pixels = drawn(120, 120, |x, y| (40.0..50.0).contains(&(x - 60.0).hypot(y - 60.0)));
        let areas = walls(&pixels, 1.0);
        for (ring, radius) in areas[0].iter().zip([50.0, 40.0]) {
            assert!(ring.len() < 60, "{} points", ring.len());
            for at in ring {
                let off = ((at[0] - 60.0).hypot(at[1] - 60.0) - radius).abs();
                assert!(off < 1.5, "{at:?} is {off} px off");
            }
        }
    }

    #[test]
    fn dithered_pictures_are_refused_and_empty_ones_are_empty() {
        let chessboard = drawn(2001, 2001, |x, y| (x.floor() + y.floor()) % 2.0 == 0.0);
        let error = trace(&chessboard, 0.05).err().unwrap();
        assert!(matches!(error, PlanFileError::TooRagged { limit: border::CORNER_LIMIT }), "{error}");
        assert!(trace(&picture("..."), 0.01).unwrap().elements.is_empty());
        assert!(trace(&Pixels { width: 0, height: 0, cells: Vec::new() }, 0.01).unwrap().elements.is_empty());
        assert_eq!(walls(&picture("#"), 0.05)[0][0].len(), 4);
    }

    /// A picture that a failing law can show, as [`picture`] takes it.
    struct Shown(Pixels);

    impl std::fmt::Debug for Shown {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            for row in self.0.cells.chunks(self.0.width) {
                let sign = |cell: &Cell| match cell {
                    Cell::Wall => '#',
                    Cell::Unknown => '?',
                    _ => '.',
                };
                writeln!(f, "{}", row.iter().map(sign).collect::<String>())?;
            }
            Ok(())
        }
    }

    /// Bars of any thickness and direction, some of wall and some of what is not known.
    fn bars() -> impl Strategy<Value = Shown> {
        let bar = (prop::array::uniform4(-5.0..50.0f64), 0.3..4.0f64, 0..3usize);
        (sides(4..=44), prop::collection::vec(bar, 1..8)).prop_map(|((width, height), bars)| {
            let mut cells = vec![Cell::Free; width * height];
            for ([x0, y0, x1, y1], half, kind) in bars {
                for (i, cell) in cells.iter_mut().enumerate() {
                    let at = [(i % width) as f64 + 0.5, (i / width) as f64 + 0.5];
                    if off_edge(at, [x0, y0], [x1, y1]) < half {
                        *cell = [Cell::Wall, Cell::Wall, Cell::Unknown][kind];
                    }
                }
            }
            Shown(Pixels { width, height, cells })
        })
    }

    /// Each pixel by chance.
    fn noise() -> impl Strategy<Value = Shown> {
        sides(1..=14).prop_flat_map(|(width, height)| {
            let cell = prop::sample::select(vec![Cell::Wall, Cell::Wall, Cell::Free, Cell::Unknown]);
            prop::collection::vec(cell, width * height).prop_map(move |cells| Shown(Pixels { width, height, cells }))
        })
    }

    fn sides(range: RangeInclusive<usize>) -> impl Strategy<Value = (usize, usize)> {
        (range.clone(), range)
    }

    fn pictures() -> impl Strategy<Value = Shown> {
        prop_oneof![bars(), noise()]
    }

    /// Counter-clockwise, as who looks at it sees it.
    fn turned(pixels: &Pixels) -> Pixels {
        let (width, height) = (pixels.height, pixels.width);
        let cell = |i: usize| pixels.cells[(i % width) * pixels.width + pixels.width - 1 - i / width];
        Pixels { width, height, cells: (0..width * height).map(cell).collect() }
    }

    const KINDS: [(ElementKind, Cell, Joined); 2] =
        [(ElementKind::Wall, Cell::Wall, Joined::AtCorners), (ElementKind::Floor, Cell::Free, Joined::AtSides)];

    proptest! {
        #[test]
        fn borders_hold_their_pixels_and_nothing_else(Shown(pixels) in pictures()) {
            for (_, kind, joined) in KINDS {
                let areas = unstraightened(&pixels, |cell| cell == kind, joined);
                let held: f64 = areas.iter().flatten().map(|ring| area(ring)).sum();
                prop_assert_eq!(held, pixels.cells.iter().filter(|cell| **cell == kind).count() as f64);
                prop_assert_eq!(agreement(&areas, &pixels, |cell| cell == kind), 1.0);
                for rings in &areas {
                    prop_assert!(area(&rings[0]) > 0.0);
                    prop_assert!(rings[1..].iter().all(|hole| area(hole) < 0.0));
                }
            }
        }

        #[test]
        fn sides_are_near_the_border_and_the_border_near_them(Shown(pixels) in pictures(), fine in any::<bool>()) {
            let metres_per_pixel = if fine { 0.01 } else { 0.05 };
            let slack_px = if fine { FINE_SLACK_PX } else { SLACK_PX };
            for (kind, cell, joined) in KINDS {
                let exact = border::borders(&pixels, |c| c == cell, joined, smallest_px(metres_per_pixel)).unwrap().areas;
                let found = traced(&pixels, metres_per_pixel, kind);
                // Ground is not outlined where all is known.
                if kind == ElementKind::Floor && !pixels.cells.contains(&Cell::Unknown) {
                    continue;
                }
                prop_assert_eq!(exact.len(), found.len());
                for (borders, rings) in exact.iter().zip(found) {
                    prop_assert_eq!(borders.len(), rings.len());
                    let rings: Rings = rings.iter().map(|ring| ring.iter().map(|at| at.map(|v| v / metres_per_pixel)).collect()).collect();
                    for (border, ring) in borders.iter().zip(&rings) {
                        let point = |[u, v]: border::Corner| [f64::from(u), pixels.height as f64 - f64::from(v)];
                        let border: Vec<[f64; 2]> = border.corners.iter().map(|corner| point(*corner)).collect();
                        for (a, b) in edges(&border) {
                            // Ends and middles of cracks.
                            let halves = 2.0 * (b[0] - a[0] + b[1] - a[1]).abs();
                            for i in 0..=halves as usize {
                                let t = i as f64 / halves;
                                let off = off_rings([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])], std::slice::from_ref(ring));
                                prop_assert!(off <= slack_px + 1e-6, "{:?} is {} px off {:?}", a, off, ring);
                            }
                        }
                        for at in ring {
                            let off = off_rings(*at, std::slice::from_ref(&border));
                            prop_assert!(off <= slack_px + 1e-6, "{:?} is {} px off the border", at, off);
                        }
                    }
                }
            }
        }

        #[test]
        fn rings_do_not_cross_and_holes_stay_inside(Shown(pixels) in pictures(), fine in any::<bool>()) {
            let metres_per_pixel = if fine { 0.01 } else { 0.05 };
            for rings in KINDS.iter().flat_map(|(kind, ..)| traced(&pixels, metres_per_pixel, *kind)) {
                let all: Vec<_> = rings.iter().flat_map(|ring| edges(ring)).collect();
                for (i, (a, b)) in all.iter().enumerate() {
                    for (c, d) in &all[..i] {
                        let side = |a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]| {
                            let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                            if twice.abs() < 1e-12 { 0.0 } else { twice }
                        };
                        let crosses = side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
                        prop_assert!(!crosses, "{:?} crosses {:?}", (a, b), (c, d));
                    }
                }
                prop_assert!(area(&rings[0]) > 0.0);
                for hole in &rings[1..] {
                    prop_assert!(area(hole) < 0.0);
                    for at in hole {
                        let touches = off_rings(*at, &rings[..1]) < 1e-9;
                        prop_assert!(touches || is_inside(*at, &rings[..1]), "{:?} of a hole is outside", at);
                    }
                }
            }
        }

        #[test]
        fn a_turned_picture_has_turned_outlines(Shown(pixels) in pictures()) {
            let turned_pixels = turned(&pixels);
            for (kind, ..) in KINDS {
                let expected: Vec<Rings> = traced(&pixels, 1.0, kind);
                let found: Rings = traced(&turned_pixels, 1.0, kind).into_iter().flatten().collect();
                let expected: Rings = expected.into_iter().flatten().collect();
                prop_assert_eq!(found.len(), expected.len());
                for ring in expected {
                    let ring: Vec<[f64; 2]> = ring.iter().map(|[x, y]| [pixels.height as f64 - y, *x]).collect();
                    prop_assert!(found.iter().any(|other| is_same(other, &ring)), "{:?} is not among {:?}", ring, found);
                }
            }
        }
    }
}
