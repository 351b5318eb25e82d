//! The law of linear FIELDs. NONLINEAR fields and fields with a user subroutine are rejected before they reach this file.

use super::deflection::Deflection;
use super::{Degenerate, Law, LawEntry, Wrench};
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

pub(super) const LAWS: &[LawEntry] = &[LawEntry {
    name: "field",
    law: &Field,
}];

/// FIELD, linear: a full 6 by 6 spring in the axes of J, with a free position (LENGTH) and a preload (FORCE).
///
/// Law, in J axes, on I at the I origin, with q = (x, y, z, AX, AY, AZ): `(F, T) = -K (q - LENGTH) + FORCE`. The reaction on J at its own
/// origin is `-F` and `-T - d x F`. K need not be symmetric. Parameters: KMATRIX.1..36 column by column (as written in the dataset),
/// LENGTH.1..6, FORCE.1..6. Validity: angles as for BUSHING. Source: Adams Solver help, `state_field`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Field;

impl Law for Field {
    fn parameter_count(&self) -> usize {
        48
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        theta: &[f64],
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let d = Deflection::of(motion)?;
        let K = Mat6::from_column_slice(&theta[..36]);
        let relaxed = Vec6::from_column_slice(&theta[36..42]);
        let preload = Vec6::from_column_slice(&theta[42..48]);
        let q = d.coordinates() - relaxed;
        linear(&K, &q, &preload, &d, out);
        if with_parameters {
            let columns = out.parameter_columns(48);
            for j in 0..6 {
                for i in 0..6 {
                    columns[6 * j + i][i] = -q[j];
                }
                columns[36 + j] = K.column(j).into_owned();
                columns[42 + j][j] = 1.0;
            }
        }
        Ok(())
    }

    /// Returns the energy only for a symmetric K without rotational terms and without preload torque: torques of finite projected angles
    /// have no potential.
    #[cfg(test)]
    fn energy(&self, motion: &RelativeMotion, theta: &[f64]) -> Option<f64> {
        let K = Mat6::from_column_slice(&theta[..36]);
        let rotational = |a: usize| {
            theta[45 + a] != 0.0 || (0..6).any(|b| K[(3 + a, b)] != 0.0 || K[(b, 3 + a)] != 0.0)
        };
        if K != K.transpose() || (0..3).any(rotational) {
            return None;
        }
        let mut q = -Vec6::from_column_slice(&theta[36..42]);
        for n in 0..3 {
            q[n] += motion.p_ij_j[n];
        }
        let preload = Vec6::from_column_slice(&theta[42..48]);
        Some(0.5 * q.dot(&(K * q)) - preload.dot(&q))
    }
}

/// Sets `out` to the wrench `preload - K q` and its derivative. `q` equals the coordinates of the deflection `d` minus a constant free
/// position.
pub(super) fn linear(K: &Mat6, q: &Vec6, preload: &Vec6, d: &Deflection, out: &mut Wrench) {
    out.value = preload - K * q;
    out.by_motion = -K;
    let by_angles = -K.fixed_columns::<3>(3) * d.angle_rows;
    out.by_motion
        .fixed_columns_mut::<3>(3)
        .copy_from(&by_angles);
}
