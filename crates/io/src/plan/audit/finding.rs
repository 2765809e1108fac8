//! What on a plan looks wrong? Each finding with its place, its size in numbers, and what to do about it.

use std::fmt;

use planwalk_types::{Plan, Pt2};

/// What a wrong scale shows itself by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ScaleSign {
    /// Median width of the doors, or of the openings where no doors are drawn, metres.
    Doors,
    /// Median thickness of the walls, metres.
    Walls,
    /// Floor inside of the building, m².
    Floor,
}

/// Something that looks wrong. Places are in metres of the plan.
#[derive(Debug, Clone, PartialEq)]
pub enum Finding {
    /// An outer wall has a hole through which outdoors leaks in.
    OutlineGap {
        /// Its middle.
        at: Pt2<Plan>,
        /// How wide it is, metres.
        width_m: f64,
        /// In how many places beside each other it is open.
        places: usize,
    },
    /// Nobody gets to this floor: no door and no opening leads there from the largest part of the building.
    Unreachable {
        /// A place in it.
        at: Pt2<Plan>,
        /// Its floor, m².
        area_m2: f64,
        /// The nearest place of what can be reached, through a wall: where, and how thick it is, metres.
        behind: Option<(Pt2<Plan>, f64)>,
    },
    /// A door that nobody fits through, or a gate.
    DoorWidth {
        /// Its middle.
        at: Pt2<Plan>,
        /// How wide it is, metres.
        width_m: f64,
    },
    /// Metres that are none.
    Scale {
        /// By what.
        sign: ScaleSign,
        /// What was measured, metres or m².
        measured: f64,
        /// Least and most of what is usual.
        usual: [f64; 2],
    },
    /// A wall that is shorter than walls are thick, and ends freely.
    ShortWall {
        /// Its middle.
        at: Pt2<Plan>,
        /// How long it is, metres.
        length_m: f64,
        /// How thick walls are on this storey, metres.
        thickness_m: f64,
    },
    /// A wall that is drawn twice.
    DoubledWall {
        /// Middle of what is drawn twice.
        at: Pt2<Plan>,
        /// How long it is, metres.
        length_m: f64,
    },
    /// Small things in a row that look like letters, and were taken for walls.
    Letters {
        /// Their middle.
        at: Pt2<Plan>,
        /// How many there are.
        count: usize,
        /// Their median size, metres.
        size_m: f64,
    },
    /// A storey in parts of like size that are nowhere joined: several storeys on one sheet, perhaps.
    SeveralDrawings {
        /// Middle of the part that this is about.
        at: Pt2<Plan>,
        /// Its width and height, metres.
        size_m: [f64; 2],
        /// How many such parts there are.
        count: usize,
    },
}

impl Finding {
    /// One word, as files have it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::OutlineGap { .. } => "outline-gap",
            Self::Unreachable { .. } => "unreachable",
            Self::DoorWidth { .. } => "door-width",
            Self::Scale { .. } => "scale",
            Self::ShortWall { .. } => "short-wall",
            Self::DoubledWall { .. } => "doubled-wall",
            Self::Letters { .. } => "letters",
            Self::SeveralDrawings { .. } => "several-drawings",
        }
    }

    /// Where it is; a scale is nowhere.
    pub fn at(&self) -> Option<Pt2<Plan>> {
        match self {
            Self::OutlineGap { at, .. }
            | Self::Unreachable { at, .. }
            | Self::DoorWidth { at, .. }
            | Self::ShortWall { at, .. }
            | Self::DoubledWall { at, .. }
            | Self::Letters { at, .. }
            | Self::SeveralDrawings { at, .. } => Some(*at),
            Self::Scale { .. } => None,
        }
    }

    /// Its numbers, by name and unit.
    pub fn figures(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::OutlineGap { width_m, places, .. } => vec![("width_m", width_m), ("places", places as f64)],
            Self::DoorWidth { width_m, .. } => vec![("width_m", width_m)],
            Self::Unreachable { area_m2, behind, .. } => {
                let behind = behind.map(|(at, thick_m)| [("behind_x_m", at.x), ("behind_y_m", at.y), ("behind_thickness_m", thick_m)]);
                std::iter::once(("area_m2", area_m2)).chain(behind.into_iter().flatten()).collect()
            }
            Self::Scale { sign, measured, usual } => {
                let names = match sign {
                    ScaleSign::Doors => ["median_door_m", "usual_from_m", "usual_to_m"],
                    ScaleSign::Walls => ["median_wall_m", "usual_from_m", "usual_to_m"],
                    ScaleSign::Floor => ["floor_m2", "usual_from_m2", "usual_to_m2"],
                };
                names.into_iter().zip([measured, usual[0], usual[1]]).collect()
            }
            Self::ShortWall { length_m, thickness_m, .. } => vec![("length_m", length_m), ("thickness_m", thickness_m)],
            Self::DoubledWall { length_m, .. } => vec![("length_m", length_m)],
            Self::Letters { count, size_m, .. } => vec![("count", count as f64), ("size_m", size_m)],
            Self::SeveralDrawings { size_m, count, .. } => {
                vec![("width_m", size_m[0]), ("height_m", size_m[1]), ("count", count as f64)]
            }
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            Self::OutlineGap { .. } => "draw the missing wall, or the door if it is an entrance".to_owned(),
            Self::Unreachable { behind: Some((at, _)), .. } => {
                format!("draw the door that leads there, perhaps near ({:.2}, {:.2}) m; a shaft may stay as it is", at.x, at.y)
            }
            Self::Unreachable { behind: None, .. } => "draw the door that leads there, or leave the part away".to_owned(),
            Self::DoorWidth { .. } => "look whether it is a door, and how wide it is there".to_owned(),
            Self::Scale { sign: ScaleSign::Floor, .. } => {
                "check the scale by a length that is known: --measure u1,v1,u2,v2=3.6m".to_owned()
            }
            Self::Scale { measured, usual, .. } => {
                let factor = if measured < &usual[0] { usual[0] / measured.max(1e-9) } else { usual[1] / measured };
                format!("check the scale by a length that is known (--measure u1,v1,u2,v2=3.6m): it would be usual at ×{factor:.2}")
            }
            Self::ShortWall { .. } => "remove it if nothing is there: a stroke that was left over, or part of a letter".to_owned(),
            Self::DoubledWall { .. } => "remove one of the two".to_owned(),
            Self::Letters { .. } => "remove the text from the drawing, or put it on a layer of its own".to_owned(),
            Self::SeveralDrawings { .. } => {
                "keep each storey in a file of its own, cut to it, or name its layer or page (--level, --page)".to_owned()
            }
        }
    }

    /// How much it matters among those of its kind.
    fn weight(&self) -> f64 {
        match *self {
            Self::OutlineGap { width_m, .. } => width_m,
            Self::DoorWidth { width_m, .. } => (width_m.max(1e-3) / 1.0).ln().abs(),
            Self::Unreachable { area_m2, .. } => area_m2,
            Self::Scale { sign, .. } => -f64::from(sign as u8),
            Self::ShortWall { length_m, .. } => -length_m,
            Self::DoubledWall { length_m, .. } => length_m,
            Self::Letters { count, .. } => count as f64,
            Self::SeveralDrawings { size_m, .. } => size_m[0] * size_m[1],
        }
    }

    /// Those that spoil most come first.
    fn rank(&self) -> u8 {
        match self {
            Self::Scale { .. } => 0,
            Self::SeveralDrawings { .. } => 1,
            Self::OutlineGap { .. } => 2,
            Self::Unreachable { .. } => 3,
            Self::DoorWidth { .. } => 4,
            Self::Letters { .. } => 5,
            Self::DoubledWall { .. } => 6,
            Self::ShortWall { .. } => 7,
        }
    }
}

/// By kind, the weightiest first; stable, so equal ones stay as they were found.
pub(super) fn sort(findings: &mut [Finding]) {
    findings.sort_by(|a, b| a.rank().cmp(&b.rank()).then(b.weight().total_cmp(&a.weight())));
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(at) = self.at() {
            write!(f, "at ({:.2}, {:.2}) m ", at.x, at.y)?;
        }
        match self {
            Self::OutlineGap { width_m, places: 0 | 1, .. } => write!(f, "the outline is open over {width_m:.2} m"),
            Self::OutlineGap { width_m, places, .. } => {
                write!(f, "the outline is open over {width_m:.2} m in {places} places beside each other")
            }
            Self::Unreachable { area_m2, behind, .. } => {
                write!(f, "nobody gets to {area_m2:.1} m² of floor")?;
                behind.map_or(Ok(()), |(_, thick_m)| write!(f, ", behind {thick_m:.2} m of wall"))
            }
            Self::DoorWidth { width_m, .. } => write!(f, "a door is {width_m:.2} m wide"),
            Self::Scale { sign, measured, usual: [least, most] } => match sign {
                ScaleSign::Doors => write!(f, "half of the doors are wider than {measured:.2} m; {least} to {most} m is usual"),
                ScaleSign::Walls => write!(f, "walls are {measured:.2} m thick; {least} to {most} m is usual"),
                ScaleSign::Floor => write!(f, "the storey has {measured:.1} m² of floor; {least} to {most} m² is usual"),
            },
            Self::ShortWall { length_m, thickness_m, .. } => {
                write!(f, "a wall is {length_m:.3} m long and ends freely, where walls are {thickness_m:.2} m thick")
            }
            Self::DoubledWall { length_m, .. } => write!(f, "a wall is drawn twice over {length_m:.2} m"),
            Self::Letters { count, size_m, .. } => {
                write!(f, "{count} things of {size_m:.2} m in a row were taken for walls, and look like letters")
            }
            Self::SeveralDrawings { size_m: [width, height], count, .. } => {
                write!(f, "one of {count} parts of like size ({width:.1} m × {height:.1} m) that are nowhere joined")
            }
        }
    }
}
