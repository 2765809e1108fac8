//! How far is this landmark? Its inverse distance, sharpened by every frame that sees it (a scalar Kalman filter).

use nalgebra::Vector3;

use super::{MIN_RHO, Pose, Residual, direction};

/// The inverse distance and its standard deviation after a camera at `camera` saw the landmark along `seen`.
///
/// `sigma_rad` is the noise of the seen ray, the camera's own uncertainty included. A sight that contradicts the prior by
/// more than four standard deviations, or that is behind the camera, leaves it as it was: `None`.
pub fn update(
    anchor: &Pose,
    ray: &Vector3<f64>,
    prior: (f64, f64),
    camera: &Pose,
    seen: &Vector3<f64>,
    sigma_rad: f64,
) -> Option<(f64, f64)> {
    let information = prior.1.powi(-2);
    let (mut rho, mut sigma) = prior;
    // Two steps: the projection is not linear in the inverse distance for a point that comes close.
    for _ in 0..2 {
        let residual = Residual::new(direction(anchor, ray, rho, camera), seen)?;
        let slope = residual.by_rho(anchor, camera);
        let gain = slope.dot(&slope) / (sigma_rad * sigma_rad);
        let pull = -slope.dot(&residual.error) / (sigma_rad * sigma_rad) + information * (prior.0 - rho);
        rho = (rho + pull / (gain + information)).max(MIN_RHO);
        sigma = (gain + information).sqrt().recip();
    }
    let left = Residual::new(direction(anchor, ray, rho, camera), seen)?.error.norm_squared() / (sigma_rad * sigma_rad);
    let moved = ((rho - prior.0) / prior.1).powi(2);
    (left + moved < 16.0).then_some((rho, sigma))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bearing_gets_its_distance_from_a_sideways_step() {
        let camera = Pose::translation(0.5, 0.0, 0.0);
        let ray = Vector3::new(0.1, 0.0, 1.0).normalize();
        let seen = direction(&Pose::identity(), &ray, 1.0 / 4.0, &camera).normalize();
        let (rho, sigma) = update(&Pose::identity(), &ray, (0.4, 0.4), &camera, &seen, 2e-3).unwrap();
        // 2 mrad over a baseline of half a unit: σ(1/d) = 0.004; the prior pulls by less.
        assert!((rho - 0.25).abs() < 0.002 && (sigma - 0.004).abs() < 0.0005, "{rho} ± {sigma}");
    }

    #[test]
    fn a_turn_on_the_spot_says_nothing_and_a_lie_is_refused() {
        let ray = Vector3::z();
        let turned = Pose::rotation(Vector3::new(0.0, 0.1, 0.0));
        let seen = direction(&Pose::identity(), &ray, 0.3, &turned).normalize();
        let (rho, sigma) = update(&Pose::identity(), &ray, (0.4, 0.4), &turned, &seen, 2e-3).unwrap();
        assert!((rho - 0.4).abs() < 1e-9 && (sigma - 0.4).abs() < 1e-9);
        let up = Vector3::new(0.0, -0.3, 1.0).normalize();
        assert_eq!(update(&Pose::identity(), &ray, (0.4, 0.4), &turned, &up, 2e-3), None);
    }
}
