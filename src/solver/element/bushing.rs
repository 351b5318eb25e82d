//! The elastic law of BUSHING. The module is independent of parts and files; the damping is in [`super::damping`].

use super::deflection::Deflection;
use super::{Degenerate, Law, LawEntry, Wrench};
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

pub(super) const LAWS: &[LawEntry] = &[LawEntry {
    name: "bushing",
    law: &BushingLaw,
}];

/// BUSHING: three translational and three rotational springs in the axes of J, with preload.
///
/// Law, in J axes, on I at the I origin, with (x, y, z) = `p_ij_j` and (a, b, c) = AX, AY, AZ:
/// `F = -K (x, y, z) + FORCE`, `T = -KT (a, b, c) + TORQUE`.
/// The reaction on J at its own origin is `-F` and `-T - d x F`, so swapping I and J gives a different element.
/// Parameters: K.1..3, KT.1..3 (per radian), FORCE.1..3, TORQUE.1..3.
/// Validity: ADAMS requires two of the three angles to stay below 10 degrees; only c may be large. The torque has no potential for finite
/// angles. Source: Adams Solver help, `state_bushing`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct BushingLaw;

impl Law for BushingLaw {
    fn parameter_count(&self) -> usize {
        12
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let d = Deflection::of(motion)?;
        out.by_motion = Mat6::zeros();
        for n in 0..3 {
            out.value[n] = -theta[n] * d.translation[n] + theta[6 + n];
            out.by_motion[(n, n)] = -theta[n];
            let kt = theta[3 + n];
            out.value[3 + n] = -kt * d.angles[n] + theta[9 + n];
            for m in 0..3 {
                out.by_motion[(3 + n, 3 + m)] = -kt * d.angle_rows[(n, m)];
            }
        }
        if with_parameters {
            let columns = out.parameter_columns(12);
            for n in 0..6 {
                columns[n][n] = -d.component(n);
                columns[6 + n] = Vec6::ith(n, 1.0);
            }
        }
        Ok(())
    }

    /// Returns the energy only if rotational stiffness and torque are zero: these torques have no potential for finite angles.
    #[cfg(test)]
    fn energy(&self, motion: &RelativeMotion, theta: &[f64]) -> Option<f64> {
        if theta[3..6].iter().chain(&theta[9..12]).any(|&x| x != 0.0) {
            return None;
        }
        let p = motion.p_ij_j;
        Some(
            (0..3)
                .map(|n| 0.5 * theta[n] * p[n] * p[n] - theta[6 + n] * p[n])
                .sum(),
        )
    }
}
