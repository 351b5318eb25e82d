//! The elastic law of NFORCE. The module is independent of parts and contains no damping.

use super::Degenerate;
use super::deflection::Deflection;
use crate::mechanics::{Mat6, RelativeMotion, Vec6};

/// NFORCE, linear: one stiffness matrix that couples n I markers with a reference marker J.
///
/// Let q be the stacked deflections (x, y, z, AX, AY, AZ) of each I marker relative to J, in J axes. The stacked wrenches on the I markers,
/// each at the origin of its marker, are `-K (q - LENGTH) + FORCE`. The reaction of each wrench acts on J at the origin of the respective I
/// marker. Parameters: KMATRIX.1..(6n)^2 column by column, LENGTH.1..6n, FORCE.1..6n. Validity: angles as for BUSHING. Source: the law of
/// FIELD extended to several markers, as described in the Adams Solver help, `state_nforce`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct MultiPoint {
    /// Number of I markers.
    pub markers: usize,
}

/// Wrenches of a multi-point force with their derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MultiWrench {
    /// Wrench (force, torque) on each I marker at its origin, in J axes.
    pub value: Vec<Vec6>,
    /// Block `a * markers + b` is the derivative of wrench a with respect to the motion of marker b relative to J. The motion has the six
    /// components described in [`super::Wrench`].
    pub by_motion: Vec<Mat6>,
    /// Stacked deflections `q - LENGTH`, kept for [`MultiPoint::by_parameter`].
    pub deflection: Vec<f64>,
}

impl MultiPoint {
    /// Computes the wrenches and their derivatives. `motions` holds the relative motion of each I marker. Allocates only the first time
    /// `out` is used.
    ///
    /// # Errors
    /// Returns [`Degenerate`] where an angle is undefined.
    pub(crate) fn evaluate(
        self,
        motions: &[RelativeMotion],
        theta: &[f64],
        out: &mut MultiWrench,
    ) -> Result<(), Degenerate> {
        let n = 6 * self.markers;
        let (K, rest) = theta.split_at(n * n);
        let (relaxed, preload) = rest.split_at(n);
        out.deflection.clear();
        out.value.clear();
        out.by_motion.clear();
        out.by_motion
            .resize(self.markers * self.markers, Mat6::zeros());
        for (b, motion) in motions.iter().enumerate() {
            let d = Deflection::of(motion)?;
            out.deflection
                .extend((0..6).map(|k| d.component(k) - relaxed[6 * b + k]));
            for a in 0..self.markers {
                let block = Mat6::from_fn(|i, j| -K[(6 * b + j) * n + 6 * a + i]);
                let target = &mut out.by_motion[a * self.markers + b];
                *target = block;
                target
                    .fixed_columns_mut::<3>(3)
                    .copy_from(&(block.fixed_columns::<3>(3) * d.angle_rows));
            }
        }
        for a in 0..self.markers {
            out.value.push(Vec6::from_fn(|i, _| {
                let row = 6 * a + i;
                let elastic: f64 = (0..n).map(|c| K[c * n + row] * out.deflection[c]).sum();
                preload[row] - elastic
            }));
        }
        Ok(())
    }

    /// Writes the derivatives of all wrenches with respect to parameter `p` into `columns`, one column per I marker. Must be called after
    /// [`Self::evaluate`].
    pub(crate) fn by_parameter(
        self,
        theta: &[f64],
        p: usize,
        out: &MultiWrench,
        columns: &mut [Vec6],
    ) {
        let n = 6 * self.markers;
        columns.fill(Vec6::zeros());
        if p < n * n {
            columns[p % n / 6][p % 6] = -out.deflection[p / n];
        } else if p < n * n + n {
            let c = p - n * n;
            for (row, &k) in theta[c * n..(c + 1) * n].iter().enumerate() {
                columns[row / 6][row % 6] = k;
            }
        } else {
            let row = p - n * n - n;
            columns[row / 6][row % 6] = 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::field::Field;
    use crate::element::{Law, Wrench};
    use crate::mechanics::Vec3;
    use crate::mechanics::testing::{advanced, general_pair, number};

    fn motions() -> [RelativeMotion; 2] {
        [0.1, 0.5].map(|tilt| {
            let (i, j) = general_pair(tilt);
            RelativeMotion::between(&i, &j, &Vec3::zeros())
        })
    }

    fn at(motions: &[RelativeMotion], theta: &[f64]) -> MultiWrench {
        let mut out = MultiWrench::default();
        MultiPoint {
            markers: motions.len(),
        }
        .evaluate(motions, theta, &mut out)
        .expect("regular");
        out
    }

    #[test]
    fn with_one_marker_it_is_a_field() {
        let theta: Vec<f64> = (0..48).map(number).collect();
        let motion = motions()[1];
        let mut field = Wrench::default();
        Field
            .evaluate(&motion, &theta, true, &mut field)
            .expect("regular");
        let out = at(&[motion], &theta);
        assert!((out.value[0] - field.value).norm() < 1e-13);
        assert!((out.by_motion[0] - field.by_motion).norm() < 1e-13);
        let mut column = [Vec6::zeros()];
        for p in 0..48 {
            MultiPoint { markers: 1 }.by_parameter(&theta, p, &out, &mut column);
            assert!((column[0] - field.by_parameter[p]).norm() < 1e-13, "{p}");
        }
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let law = MultiPoint { markers: 2 };
        let n = 6 * law.markers;
        let theta: Vec<f64> = (0..n * n + 2 * n).map(number).collect();
        let exact = at(&motions(), &theta);
        let h = 1e-5;
        for b in 0..2 {
            for k in 0..6 {
                let moved = |h: f64| {
                    let mut motions = motions();
                    motions[b] = advanced(&motions[b], &Vec6::ith(k, h));
                    at(&motions, &theta).value
                };
                for a in 0..2 {
                    let difference = (moved(h)[a] - moved(-h)[a]) / (2.0 * h);
                    let column = exact.by_motion[2 * a + b].column(k);
                    assert!((difference - column).norm() < 1e-8, "{a} {b} {k}");
                }
            }
        }
        let mut columns = [Vec6::zeros(); 2];
        for p in (0..theta.len()).step_by(7) {
            law.by_parameter(&theta, p, &exact, &mut columns);
            let moved = |h: f64| {
                let mut theta = theta.clone();
                theta[p] += h;
                at(&motions(), &theta).value
            };
            for a in 0..2 {
                let difference = (moved(h)[a] - moved(-h)[a]) / (2.0 * h);
                assert!((difference - columns[a]).norm() < 1e-8, "{p} {a}");
            }
        }
    }
}
