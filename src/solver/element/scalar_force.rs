//! Laws of SFORCE: the directions in which its force or torque acts. The caller evaluates the FUNCTION and passes its value as the magnitude.

use super::line::Line;
use super::{Degenerate, Law, LawEntry, Wrench};
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

pub(super) const LAWS: &[LawEntry] = &[
    LawEntry {
        name: "line_force",
        law: &ScalarForce::Line,
    },
    LawEntry {
        name: "axial_force",
        law: &ScalarForce::AlongZj,
    },
    LawEntry {
        name: "axial_torque",
        law: &ScalarForce::AboutZj,
    },
];

/// SFORCE: a force or torque of given magnitude.
///
/// The magnitude is the only parameter. The caller sets it to the value of the FUNCTION and adds `by_parameter` times the gradient of the
/// function.
///
/// Laws on I, with e the magnitude:
/// * `Line` (TRANSLATIONAL): `F = e n`, with n the direction from J to I; positive e pushes the markers apart. `by_motion` includes the
///   rotation of the line. Undefined where the origins coincide.
/// * `AlongZj` (TRANSLATIONAL, ACTIONONLY): `F = e zj` at the I origin. The caller applies no reaction to J.
/// * `AboutZj` (ROTATIONAL, with or without ACTIONONLY): `T = e zj`. zi must be parallel to zj and point the same way.
///
/// Source: Adams Solver help, `state_sforce`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum ScalarForce {
    /// Force along the line between the origins.
    Line,
    /// Force along the z axis of J.
    AlongZj,
    /// Torque about the z axis of J.
    AboutZj,
}

impl Law for ScalarForce {
    fn parameter_count(&self) -> usize {
        1
    }

    fn uses_angles(&self) -> bool {
        false
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let unit = match self {
            Self::Line => {
                let line = Line::of(motion)?;
                line.force(theta[0], 0.0, out);
                line.unit_wrench()
            }
            Self::AlongZj | Self::AboutZj => {
                let component = if *self == Self::AlongZj { 2 } else { 5 };
                out.value = Vec6::ith(component, theta[0]);
                out.by_motion = Mat6::zeros();
                Vec6::ith(component, 1.0)
            }
        };
        if with_parameters {
            out.parameter_columns(1)[0] = unit;
        }
        Ok(())
    }
}
