//! What kind of building, how large, and how far does its plan lie?

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::{SimError, in_range};

/// How a building is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BuildingKind {
    /// Corridors with rooms on both sides.
    #[default]
    Office,
    /// A large hall with columns, a core, and a few glazed rooms at its rim.
    OpenPlan,
    /// A home: narrow doors, small rooms.
    Flat,
    /// A ring of corridors with rooms at nearly regular distances: turned by 180° it looks almost the same.
    Loop,
    /// A rotunda with oblique walls, and a wing at an odd angle.
    Round,
}

impl BuildingKind {
    /// Every kind, in the order in which they are listed to people.
    pub const ALL: [Self; 5] = [Self::Office, Self::OpenPlan, Self::Flat, Self::Loop, Self::Round];

    fn name(self) -> &'static str {
        match self {
            Self::Office => "office",
            Self::OpenPlan => "open_plan",
            Self::Flat => "flat",
            Self::Loop => "loop",
            Self::Round => "round",
        }
    }
}

impl fmt::Display for BuildingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for BuildingKind {
    type Err = SimError;

    /// By name; a hyphen is as good as an underscore.
    fn from_str(name: &str) -> Result<Self, SimError> {
        let wanted = name.replace('-', "_");
        Self::ALL.into_iter().find(|kind| kind.name() == wanted).ok_or_else(|| SimError::NoSuchKind { name: name.to_owned() })
    }
}

/// How far what is drawn and what is built differ.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lies {
    /// Share of the inner walls between rooms that are drawn but were never built, 0..=1.
    pub missing_share: f64,
    /// Walls that were built but are not drawn, where there is room for so many.
    pub extra_count: usize,
}

impl Lies {
    pub(crate) fn check(&self) -> Result<(), SimError> {
        in_range("the share of walls that are drawn but not built", self.missing_share, 0.0, 1.0)?;
        in_range("the number of walls that are built but not drawn", self.extra_count as f64, 0.0, 500.0)
    }
}

/// Options of [`Building::generate`](super::Building::generate).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BuildingOptions {
    /// How it is laid out.
    pub kind: BuildingKind,
    /// Width of the building, metres; what the kind usually has where none is given. Of a round building: its diameter.
    pub width_m: Option<f64>,
    /// Depth of the building, metres, likewise. Of a round building: its diameter and the wing's length.
    pub depth_m: Option<f64>,
    /// Probability that a door which need not be open is open, 0..=1.
    pub open_doors: f64,
    /// Where the plan and the building differ.
    pub lies: Lies,
}

impl Default for BuildingOptions {
    /// A small office of about 20 m × 14 m with two thirds of its doors open and an honest plan.
    fn default() -> Self {
        Self { kind: BuildingKind::Office, width_m: None, depth_m: None, open_doors: 0.65, lies: Lies::default() }
    }
}

impl BuildingOptions {
    /// Checks the ranges and gives width and depth, metres.
    pub(super) fn size_m(&self) -> Result<(f64, f64), SimError> {
        in_range("the probability of an open door", self.open_doors, 0.0, 1.0)?;
        self.lies.check()?;
        // Usual width and depth, and the ranges of both.
        let (usual, widths, depths) = match self.kind {
            BuildingKind::Office => ((20.0, 14.0), (17.0, 120.0), (12.0, 80.0)),
            BuildingKind::OpenPlan => ((42.0, 26.0), (24.0, 120.0), (18.0, 80.0)),
            BuildingKind::Flat => ((11.5, 9.0), (8.5, 16.0), (7.0, 12.0)),
            BuildingKind::Loop => ((60.0, 25.0), (30.0, 120.0), (19.0, 80.0)),
            BuildingKind::Round => ((30.0, 46.0), (24.0, 70.0), (32.0, 110.0)),
        };
        let (width, depth) = (self.width_m.unwrap_or(usual.0), self.depth_m.unwrap_or(usual.1));
        in_range("the building's width in metres", width, widths.0, widths.1)?;
        let least = if self.kind == BuildingKind::Round { width + 8.0 } else { depths.0 };
        let depth = if self.kind == BuildingKind::Round && self.depth_m.is_none() { width + 16.0 } else { depth };
        in_range("the building's depth in metres", depth, least, depths.1)?;
        if self.kind == BuildingKind::Flat {
            in_range("the floor area of the flat in m²", width * depth, 60.0, 150.0)?;
        }
        Ok((width, depth))
    }
}

/// Options of [`Building::from_plan`](super::Building::from_plan).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanWorldOptions {
    /// From floor to ceiling, metres.
    pub height_m: f64,
    /// Where the plan and the building differ.
    pub lies: Lies,
}

impl Default for PlanWorldOptions {
    /// An ordinary storey, built as it is drawn.
    fn default() -> Self {
        Self { height_m: 2.7, lies: Lies::default() }
    }
}

impl PlanWorldOptions {
    pub(super) fn check(&self) -> Result<(), SimError> {
        in_range("the height of the storey in metres", self.height_m, 2.3, 20.0)?;
        self.lies.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_come_back_from_their_names() {
        for kind in BuildingKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        assert_eq!("open-plan".parse(), Ok(BuildingKind::OpenPlan));
        let error = "castle".parse::<BuildingKind>().unwrap_err().to_string();
        assert!(error.contains("castle") && error.contains("open_plan"), "{error}");
    }

    #[test]
    fn sizes_that_no_such_building_has_are_refused() {
        let size = |kind, width_m, depth_m| BuildingOptions { kind, width_m, depth_m, ..Default::default() }.size_m();
        for kind in BuildingKind::ALL {
            assert!(size(kind, None, None).is_ok(), "{kind}");
            for odd in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e6] {
                assert!(size(kind, Some(odd), None).is_err(), "{kind} {odd} m wide");
                assert!(size(kind, None, Some(odd)).is_err(), "{kind} {odd} m deep");
            }
        }
        // Each fits, but not together.
        assert!(size(BuildingKind::Flat, Some(16.0), Some(12.0)).is_err());
    }
}
