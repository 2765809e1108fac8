//! How rich, how cluttered and how noisy should the pictures be?

use crate::error::{SimError, in_range};

/// What surfaces and pictures look like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// How much there is to see on walls: 1 is an ordinary office, 0 has bare smooth walls.
    pub texture_density: f64,
    /// How much furniture stands in the rooms, on no plan: 1 is an ordinary office, 0 an empty one.
    pub furniture: f64,
    /// Standard deviation of the camera's noise, grey levels out of 255.
    pub noise_grey: f64,
    /// How far the exposure drifts up and down, as a share of it.
    pub exposure_drift: f64,
}

impl Default for Look {
    /// An ordinary office by an ordinary phone in good light.
    fn default() -> Self {
        Self { texture_density: 1.0, furniture: 1.0, noise_grey: 1.5, exposure_drift: 0.05 }
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
        in_range("the camera noise in grey levels", self.noise_grey, 0.0, 50.0)?;
        in_range("the exposure drift", self.exposure_drift, 0.0, 0.9)?;
        Ok(self)
    }
}
