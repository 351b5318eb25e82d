use super::locks::add_product;
use super::{Constraint, Equations};
use crate::mechanics::{Mat3, RelativeMotion, Vec6};

/// CONVEL: constant-velocity joint, shafts along zi and zj.
///
/// d = 0, and for co-directed z axes `xi.yj - yi.xj = 0`, for opposed z axes (both pointing away from the joint)
/// `xi.yj + yi.xj = 0`. With the wrong sign the last equation holds for every twist and constrains nothing, so the sense is
/// fixed once from the design by [`Convel::for_design`]. Undefined when the shafts fold to 90 degrees. Source: ADAMS-FORMATS 2.4.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Convel {
    /// zi.zj > 0 in the design.
    CoDirected,
    /// zi.zj < 0 in the design.
    Opposed,
}

impl Convel {
    /// The sense that fits this motion.
    pub fn for_design(motion: &RelativeMotion) -> Self {
        if motion.R_ji[(2, 2)] >= 0.0 {
            Self::CoDirected
        } else {
            Self::Opposed
        }
    }
}

impl Constraint for Convel {
    fn count(&self) -> usize {
        4
    }

    fn equation_name(&self, k: usize) -> &'static str {
        match (self, k) {
            (_, 0) => "D.Xj",
            (_, 1) => "D.Yj",
            (_, 2) => "D.Zj",
            (Self::CoDirected, _) => "Xi.Yj-Yi.Xj",
            (Self::Opposed, _) => "Xi.Yj+Yi.Xj",
        }
    }

    fn evaluate(
        &self,
        motion: &RelativeMotion,
        _theta: &[f64],
        multipliers: &[f64],
        out: &mut Equations,
    ) {
        let sign = match self {
            Self::CoDirected => -1.0,
            Self::Opposed => 1.0,
        };
        out.count = 4;
        out.curvature = Mat3::zeros();
        for axis in 0..3 {
            out.residual[axis] = motion.p_ij_j[axis];
            out.jacobian[axis] = Vec6::ith(axis, 1.0);
        }
        out.residual[3] = motion.R_ji[(1, 0)] + sign * motion.R_ji[(0, 1)];
        out.jacobian[3] = Vec6::zeros();
        add_product(motion, 0, 1, 1.0, multipliers[3], 3, out);
        add_product(motion, 1, 0, sign, multipliers[3], 3, out);
    }
}
