//! What goes into the tables that other programs read? `track.csv`, `filter.csv` and TUM lines.

use std::fmt::Write;

use planwalk_types::{Estimate, Rigid3};

/// Columns of `track.csv` and `filter.csv`.
pub const COLUMNS: &str = "t_s,x_m,y_m,yaw_rad,sxx_m2,sxy_m2,syy_m2,syaw_rad2,radius95_m,probability,status";

/// The estimates as CSV with [`COLUMNS`]; times with nine decimals, so that nanoseconds survive.
pub fn estimates_csv(estimates: &[Estimate]) -> String {
    let mut text = String::with_capacity(120 * (estimates.len() + 1));
    text.push_str(COLUMNS);
    text.push('\n');
    for e in estimates {
        let c = &e.covariance;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{:.9},{:.6},{:.6},{:.6},{:.9},{:.9},{:.9},{:.9},{:.4},{:.6},{}",
            e.stamp.as_secs(),
            e.pose.x,
            e.pose.y,
            e.pose.heading_rad,
            c[(0, 0)],
            c[(0, 1)],
            c[(1, 1)],
            c[(2, 2)],
            e.radius95_m,
            e.probability,
            e.status
        );
    }
    text
}

/// A pose on the floor as one in space, at height 0.
pub fn upright<A, B>(pose: &planwalk_types::Rigid2<A, B>) -> Rigid3<A, B> {
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), pose.heading_rad);
    Rigid3::from_parts(nalgebra::Vector3::new(pose.x, pose.y, 0.0), turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{PlanPose, Stamp, Status};

    #[test]
    fn a_row_has_the_columns_of_its_header() {
        let estimate = Estimate {
            stamp: Stamp(1_500_000_001),
            pose: PlanPose::new(1.0, -2.0, 0.5),
            covariance: nalgebra::Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.0, 0.0, 0.0, 0.002),
            radius95_m: 0.61,
            probability: 0.97,
            status: Status::Tracking,
        };
        let text = estimates_csv(&[estimate]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "t_s,x_m,y_m,yaw_rad,sxx_m2,sxy_m2,syy_m2,syaw_rad2,radius95_m,probability,status");
        assert_eq!(
            lines[1],
            "1.500000001,1.000000,-2.000000,0.500000,0.040000000,0.010000000,0.090000000,0.002000000,0.6100,0.970000,tracking"
        );
    }
}
