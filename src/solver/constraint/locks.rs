//! Constraint that locks distances and scalar products, as most joints do. The module is independent of the joint names.

use super::{Constraint, Equations};
use crate::mechanics::{Mat3, RelativeMotion, Vec6};

/// Constraint that locks components of the distance vector along J axes and scalar products of an I axis with a J axis.
///
/// With d = `p_ij_j`, v an axis of I expressed in J axes and e an axis of J, the equations are:
/// - `d . e = 0`, with the Jacobian row `(e, 0)`;
/// - `v . e = 0`, with the Jacobian row `(0, v x e)`. A rotation `dtheta` changes this row by `(dtheta x v) x e = (v e' - (v . e) 1)
///   dtheta`.
///
/// The equations are valid for any motion. `v . e = 0` still holds after the axis v has flipped by 180 degrees. Source: Adams Solver help,
/// `state_joint`, `state_jprim`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Locks {
    /// Axes of J along which the two origins must coincide.
    pub(super) distances: &'static [usize],
    /// Pairs (axis of I, axis of J) that must stay perpendicular.
    pub(super) products: &'static [(usize, usize)],
}

const DISTANCE_NAMES: [&str; 3] = ["D.Xj", "D.Yj", "D.Zj"];
const PRODUCT_NAMES: [[&str; 3]; 3] = [
    ["Xi.Xj", "Xi.Yj", "Xi.Zj"],
    ["Yi.Xj", "Yi.Yj", "Yi.Zj"],
    ["Zi.Xj", "Zi.Yj", "Zi.Zj"],
];

impl Constraint for Locks {
    fn count(&self) -> usize {
        self.distances.len() + self.products.len()
    }

    fn equation_name(&self, k: usize) -> &'static str {
        if let Some(&axis) = self.distances.get(k) {
            return DISTANCE_NAMES[axis];
        }
        let (i, j) = self.products[k - self.distances.len()];
        PRODUCT_NAMES[i][j]
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        _theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        out.count = self.count();
        out.curvature = Mat3::zeros();
        let mut k = 0;
        for &axis in self.distances {
            out.residual[k] = motion.p_ij_j[axis];
            out.jacobian[k] = Vec6::zeros();
            out.jacobian[k][axis] = 1.0;
            k += 1;
        }
        for &(i, j) in self.products {
            out.residual[k] = motion.R_ji[(j, i)];
            out.jacobian[k] = Vec6::zeros();
            add_product(motion, i, j, 1.0, multipliers[k], k, out);
            k += 1;
        }
    }
}

/// Adds `scale` times the derivative of the scalar product of I axis `i` and J axis `j` to row `k` of the Jacobian in `out`. Adds the
/// corresponding curvature, multiplied by `multiplier`, to `out.curvature`.
pub(super) fn add_product(
    motion: &RelativeMotion,
    i: usize,
    j: usize,
    scale: f64,
    multiplier: f64,
    k: usize,
    out: &mut Equations,
) {
    let v = motion.R_ji.column(i);
    // v x e_j has components v_(j+2) along axis j+1 and -v_(j+1) along axis j+2.
    let (next, last) = ((j + 1) % 3, (j + 2) % 3);
    out.jacobian[k][3 + next] += scale * v[last];
    out.jacobian[k][3 + last] -= scale * v[next];
    let l = scale * multiplier;
    out.curvature[(next, j)] += l * v[next];
    out.curvature[(last, j)] += l * v[last];
    out.curvature[(next, next)] -= l * v[j];
    out.curvature[(last, last)] -= l * v[j];
}
