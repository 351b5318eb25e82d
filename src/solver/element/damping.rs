//! Damping of a force element: the part of the wrench that depends on the velocity of I relative to J. The module contains no stiffness.

use super::line::Line;
use super::{Degenerate, Wrench};
use crate::mechanics::{Mat3, Mat6, RelativeMotion, Vec3, Vec6};

/// Damping of an element, in J axes. u holds the rates of `p_ij_j` and of the rotation of I in J.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Damping {
    /// Damping matrix C with `(F, T) = -C u`. Used by BUSHING, FIELD and BEAM.
    Matrix(Box<Mat6>),
    /// Damping coefficient c with `F = -c (n . u) n` along the line between the origins. Used by SPRINGDAMPER, TRANSLATIONAL.
    Line(f64),
    /// Damping coefficient c with `T = -c dAZ/dt` about zj. Used by SPRINGDAMPER, ROTATIONAL.
    Turn(f64),
}

impl Damping {
    /// Adds the damping to `value` and `by_motion` of a wrench that the force law has already filled, and sets `by_rate`.
    ///
    /// For `Line`, with r = |d| and s = n . u: `dF/dd = -c [ n u' + s 1 ] (1 - n n') / r`. For `Turn`, the rate of AZ is `g . u_t`, where g
    /// is the Jacobian row of AZ and u_t is the rotational half of u. Where the direction or the angle is undefined, nothing is added.
    pub(crate) fn add(&self, motion: &RelativeMotion, u: &Vec6, out: &mut Wrench) {
        out.by_rate = Mat6::zeros();
        match self {
            Self::Matrix(C) => {
                out.value -= **C * u;
                out.by_rate = -**C;
            }
            Self::Line(c) => {
                if let Ok(line) = Line::of(motion) {
                    let (n, v) = (line.direction, Vec3::new(u[0], u[1], u[2]));
                    let s = n.dot(&v);
                    let across = (Mat3::identity() - n * n.transpose()) / line.length;
                    out.value -= line.unit_wrench() * (c * s);
                    let by_p = (n * v.transpose() + Mat3::from_diagonal_element(s)) * across * -*c;
                    let mut block = out.by_motion.fixed_view_mut::<3, 3>(0, 0);
                    block += by_p;
                    let by_v = n * n.transpose() * -*c;
                    out.by_rate.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_v);
                }
            }
            Self::Turn(c) => {
                if let Ok((g, by_turn)) = turning(motion) {
                    let w = Vec3::new(u[3], u[4], u[5]);
                    out.value[5] -= c * g.dot(&w);
                    for k in 0..3 {
                        out.by_rate[(5, 3 + k)] = -c * g[k];
                        out.by_motion[(5, 3 + k)] -= c * by_turn.column(k).dot(&w);
                    }
                }
            }
        }
    }
}

/// Returns the Jacobian row g of AZ and its derivative with respect to a rotation `dtheta` in J axes. The row is `g = e_z - x_z w / (w .
/// w)`, where x is the axis xi, w is x without its z component, and `dx = dtheta x x`.
fn turning(motion: &RelativeMotion) -> Result<(Vec3, Mat3), Degenerate> {
    let x: Vec3 = motion.R_ji.column(0).into();
    let w = Vec3::new(x.x, x.y, 0.0);
    let s = w.norm_squared();
    if s < 1e-20 {
        return Err(Degenerate::UndefinedAngle { axis: 2 });
    }
    let g = Vec3::z() - w * (x.z / s);
    let flat = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, 0.0));
    let by_x = (w * Vec3::z().transpose() + flat * x.z) * (-1.0 / s)
        + w * w.transpose() * (2.0 * x.z / (s * s));
    Ok((g, -by_x * crate::mechanics::skew(&x)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::testing::{advanced, direction, general_pair, number};

    #[test]
    fn derivatives_agree_with_central_differences() {
        let C = Mat6::from_fn(|a, b| number(6 * a + b));
        let all = [
            Damping::Matrix(Box::new(C)),
            Damping::Line(1.7),
            Damping::Turn(0.8),
        ];
        for damping in all {
            for tilt in [0.0, 0.1, 0.9] {
                let (i, j) = general_pair(tilt);
                let motion = RelativeMotion::between(&i, &j, &Vec3::zeros());
                let u = direction(3);
                let at = |motion: &RelativeMotion, u: &Vec6| {
                    let mut out = Wrench::default();
                    damping.add(motion, u, &mut out);
                    out
                };
                let exact = at(&motion, &u);
                for k in 0..6 {
                    let h = 1e-6;
                    let step = Vec6::ith(k, h);
                    let by_motion = (at(&advanced(&motion, &step), &u).value
                        - at(&advanced(&motion, &-step), &u).value)
                        / (2.0 * h);
                    let by_rate = (at(&motion, &(u + step)).value - at(&motion, &(u - step)).value)
                        / (2.0 * h);
                    let (a, b) = (exact.by_motion.column(k), exact.by_rate.column(k));
                    assert!((by_motion - a).norm() < 1e-8, "{damping:?} {k}");
                    assert!((by_rate - b).norm() < 1e-8, "{damping:?} {k}");
                }
                // The damping dissipates energy.
                if !matches!(damping, Damping::Matrix(_)) {
                    assert!(exact.value.dot(&u) < 0.0);
                }
            }
        }
    }
}
