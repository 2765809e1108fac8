//! How rich and how cluttered is what the camera films?

use serde::{Deserialize, Serialize};

use crate::error::{SimError, in_range};

/// What surfaces look like, and what stands in the rooms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Look {
    /// How much there is to see on walls: 1 is an ordinary office, 0 has bare smooth walls.
    pub texture_density: f64,
    /// How much furniture stands in the rooms, on no plan: 1 is an ordinary office, 0 an empty one.
    pub furniture: f64,
}

impl Default for Look {
    /// An ordinary office.
    fn default() -> Self {
        Self { texture_density: 1.0, furniture: 1.0 }
    }
}

impl Look {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SimError::Option`] names what is outside its range.
    pub fn checked(self) -> Result<Self, SimError> {
        in_range("the texture density", self.texture_density, 0.0, 3.0)?;
        in_range("the amount of furniture", self.furniture, 0.0, 3.0)?;
        Ok(self)
    }
}
