//! Bushing deflections from part poses: equations 4 to 6 of the paper by Meissonnier et al. (see guide page `paper`).

use admire_solver::mechanics::{Mat3, Pose, RelativeMotion, Vec3, Vec6};

/// Interpretation of equations 5 and 6 of the paper.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum DeflectionForm {
    /// Equations as printed. The last row of equation 5 contains a13 in place of a31, so the y rotation of equation 6 has the wrong sign. The
    /// arctangents cover only -pi/2 to pi/2. This form serves only to demonstrate the misprint.
    Printed,
    /// Corrected equations. The last row of equation 5 is a31 a32 a33, and the arctangents cover all four quadrants. The angles are exactly AX,
    /// AY and AZ of ADAMS, the angles of the BUSHING law.
    #[default]
    Corrected,
}

/// Returns the deflection of a bushing, `[delta_Tx, delta_Ty, delta_Tz, delta_Rx, delta_Ry, delta_Rz]`: displacement and rotation of I relative
/// to J in J axes. Rotations are in radians.
///
/// This is equation 4, `D = B2^-1 A2^-1 A1 B1`; part 1 carries I and part 2 carries J. `part_i` and `part_j` are the part frames in ground (A1,
/// A2). `marker_i` and `marker_j` are the markers in their part frames (B1, B2).
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

/// Returns the motion of marker I relative to marker J for these part poses, with angles in (-pi, pi].
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
        // Marker I is placed at a known small displacement from J.
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
