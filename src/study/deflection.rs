//! Bushing deflections from part poses: equations 4 to 6 of the paper.

use admire_solver::mechanics::{Mat3, Pose, RelativeMotion, Vec3, Vec6};

/// Reading of equations 5 and 6.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum DeflectionForm {
    /// As printed. The last row of equation 5 has a13 in the place of a31, so equation 6 takes a13 from there and the y rotation has the wrong
    /// sign. The arctangents cover only -pi/2 to pi/2. This form only demonstrates the misprint.
    Printed,
    /// Corrected. The last row of equation 5 is a31 a32 a33 and the arctangents cover all four quadrants. The angles are exactly ADAMS' AX,
    /// AY, AZ, the angles of the BUSHING law.
    #[default]
    Corrected,
}

/// Returns `[delta_Tx, delta_Ty, delta_Tz, delta_Rx, delta_Ry, delta_Rz]`: the displacement of I from J in J axes, rotations in radians.
///
/// Equation 4 with part 1 carrying I and part 2 carrying J: `D = B2^-1 A2^-1 A1 B1`. `part_i` and `part_j` are part frames in ground (A1, A2),
/// `marker_i` and `marker_j` markers in their part frames (B1, B2).
pub fn deflection(
    part_i: &Pose,
    marker_i: &Pose,
    part_j: &Pose,
    marker_j: &Pose,
    form: DeflectionForm,
) -> Vec6 {
    let motion = relative_motion(part_i, marker_i, part_j, marker_j);
    let angles = match form {
        DeflectionForm::Corrected => motion.angles,
        DeflectionForm::Printed => printed_angles(&motion.R_ji),
    };
    let (d, a) = (motion.p_ij_j, angles);
    Vec6::new(d.x, d.y, d.z, a.x, a.y, a.z)
}

/// Returns the relative motion of a marker pair whose parts are at these poses, with angles in (-pi, pi].
pub(crate) fn relative_motion(
    part_i: &Pose,
    marker_i: &Pose,
    part_j: &Pose,
    marker_j: &Pose,
) -> RelativeMotion {
    let i = part_i.compose(marker_i);
    let j = part_j.compose(marker_j);
    RelativeMotion::between(&i, &j, &Vec3::zeros())
}

fn printed_angles(R: &Mat3) -> Vec3 {
    Vec3::new(
        libm::atan(-R[(1, 2)] / R[(2, 2)]),
        libm::atan(R[(2, 0)] / R[(2, 2)]),
        libm::atan(R[(1, 0)] / R[(0, 0)]),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_solver::mechanics::{exp, projected_angles};

    fn poses() -> [Pose; 4] {
        let pose = |p: [f64; 3], a: [f64; 3]| Pose {
            p: Vec3::from(p),
            R: exp(&Vec3::from(a)),
        };
        let part_i = pose([10.0, -20.0, 5.0], [0.3, 0.1, -0.4]);
        let part_j = pose([-7.0, 3.0, 30.0], [-0.2, 0.6, 0.9]);
        let marker_j = pose([40.0, 50.0, 60.0], [1.0, -0.3, 0.2]);
        // I is placed at a known small displacement from J.
        let delta = pose([0.3, -0.2, 0.1], [0.02, -0.03, 0.05]);
        let i = part_j.compose(&marker_j).compose(&delta);
        let marker_i = part_i.inverse().compose(&i);
        [part_i, marker_i, part_j, marker_j]
    }

    #[test]
    fn equation_4_recovers_the_displacement_and_the_angles_of_the_bushing_law() {
        let [part_i, marker_i, part_j, marker_j] = poses();
        let d = deflection(
            &part_i,
            &marker_i,
            &part_j,
            &marker_j,
            DeflectionForm::Corrected,
        );
        let expected = projected_angles(&exp(&Vec3::new(0.02, -0.03, 0.05)));
        assert!((d.fixed_rows::<3>(0) - Vec3::new(0.3, -0.2, 0.1)).norm() < 1e-12);
        assert!((d.fixed_rows::<3>(3) - expected).norm() < 1e-12);
    }

    #[test]
    fn the_misprint_turns_the_sign_of_the_y_rotation() {
        let [part_i, marker_i, part_j, marker_j] = poses();
        let at = |form| deflection(&part_i, &marker_i, &part_j, &marker_j, form);
        let (printed, corrected) = (at(DeflectionForm::Printed), at(DeflectionForm::Corrected));
        for k in [0, 1, 2, 3, 5] {
            assert!((printed[k] - corrected[k]).abs() < 1e-12);
        }
        assert!(printed[4] * corrected[4] < 0.0);
    }
}
