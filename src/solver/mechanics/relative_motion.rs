use super::{Mat3, Pose, Vec3, projected_angles, unwrap_near};

/// Position and orientation of marker I relative to marker J, on which force laws and constraints depend.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RelativeMotion {
    /// Position of the I origin relative to the J origin, in J axes.
    pub p_ij_j: Vec3,
    /// Rotation of I in J; the columns are the I axes in J axes.
    pub R_ji: Mat3,
    /// Projected angles AX, AY, AZ of I with respect to J, in radians, including full turns.
    pub angles: Vec3,
}

impl RelativeMotion {
    /// Computes the relative motion of two markers from their poses in ground. Each projected angle includes the number of full turns that
    /// brings it nearest to `angles_before` (radians).
    pub fn between(i: &Pose, j: &Pose, angles_before: &Vec3) -> Self {
        let R_jg = j.R.transpose();
        let R_ji = R_jg * i.R;
        Self {
            p_ij_j: R_jg * (i.p - j.p),
            R_ji,
            angles: projected_angles(&R_ji).zip_map(angles_before, unwrap_near),
        }
    }

    /// Returns the derivatives of AX, AY, AZ (rows) with respect to a rotation `dtheta` of I relative to J (columns), in J axes
    /// (`R_ji <- exp(dtheta) R_ji`).
    ///
    /// For z = zi in J axes, dz = dtheta x z. Hence d atan2(-z.y, z.z) = (-z.z dz.y + z.y dz.z) / (z.y^2 + z.z^2), and similarly for the
    /// other angles.
    pub(crate) fn angle_rows(&self) -> Mat3 {
        let (x, z) = (self.R_ji.column(0), self.R_ji.column(2));
        let yz = z[1] * z[1] + z[2] * z[2];
        let xz = z[0] * z[0] + z[2] * z[2];
        let xy = x[0] * x[0] + x[1] * x[1];
        // dz = (b z.z - c z.y, c z.x - a z.z, a z.y - b z.x) for dtheta = (a, b, c); likewise for x.
        Mat3::new(
            1.0,
            -z[0] * z[1] / yz,
            -z[0] * z[2] / yz,
            -z[0] * z[1] / xz,
            1.0,
            -z[1] * z[2] / xz,
            -x[0] * x[2] / xy,
            -x[1] * x[2] / xy,
            1.0,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::{Vec3, exp};

    #[test]
    fn angle_rows_are_the_derivative() {
        let j = Pose {
            p: Vec3::zeros(),
            R: exp(&Vec3::new(0.4, -0.9, 0.2)),
        };
        let R_ji = exp(&Vec3::new(0.2, -0.3, 0.9));
        let at = |dtheta: Vec3| {
            let i = Pose {
                p: Vec3::zeros(),
                R: j.R * exp(&dtheta) * R_ji,
            };
            RelativeMotion::between(&i, &j, &Vec3::zeros())
        };
        let rows = at(Vec3::zeros()).angle_rows();
        for k in 0..3 {
            let h = Vec3::ith(k, 1e-6);
            let difference = (at(h).angles - at(-h).angles) / 2e-6;
            assert!(
                (difference - rows.column(k)).norm() < 1e-8,
                "{k}: {difference} {}",
                rows.column(k)
            );
        }
    }
}
