//! The elastic law of a FIELD that Adams/Car writes for a bushing. The module is independent of names and ids; the damping is in
//! [`super::damping`].

use super::deflection::Deflection;
use super::{Degenerate, Wrench};
use crate::function::Curves;
use crate::mechanics::{Mat6, RelativeMotion, Vec6};
use admire_syntax::car_field::CarAxis;

/// Radial deflection, relative to the range of the curve, below which round-off makes X(r)/r inaccurate. The slope of the curve is used
/// instead.
const ROUND_OFF_RELATIVE: f64 = 1e-12;

/// Bushing of Adams/Car: one curve per axis of J. The curves of x and y depend on the common radial deflection.
///
/// Law, in J axes, on I at the I origin, with the deflections d = (x, y, z, AX, AY, AZ). The array of axis k gives the scale V_k, the
/// preload P_k, the offset Q_k and the stretch H_k, and q_k = H_k d_k - Q_k:
/// ```text
/// r = sqrt(q_x^2 + q_y^2)
/// F_x = P_x - V_x X(r) q_x/r,  F_y = P_y - V_y Y(r) q_y/r
/// F_k = P_k - V_k C_k(q_k)  for z and the torques
/// ```
/// X and Y are odd, so X(r)/r has a limit at r = 0. The reaction on J is that of a BUSHING. Parameters: the eleven values of each array,
/// axis by axis; derivatives with respect to values that the law does not use are zero. Validity: angles as for BUSHING.
/// Source: 505 states of a real axle without offsets; offsets and scales as in the compatible bushings of MotionView (AutoBush).
#[derive(Debug)]
pub(crate) struct CarBushing {
    /// Index in [`Curves`] of the curve of each axis.
    curves: [usize; 6],
}

/// Parameters and curves that the law reads.
#[derive(Clone, Copy)]
pub(crate) struct CarNumbers<'a> {
    /// The eleven values of each array, axis by axis.
    pub(crate) theta: &'a [f64],
    /// Curves of the SPLINEs.
    pub(crate) curves: &'a Curves,
}

impl CarNumbers<'_> {
    /// Returns scale (0), preload (1), offset (2) or stretch (3) of an axis.
    fn of(&self, axis: usize, which: usize) -> f64 {
        self.theta[CarAxis::LENGTH * axis + CarAxis::PLACES[which]]
    }

    /// Returns the arguments of the curves, and the radial deflection.
    fn arguments(&self, deflection: &Deflection) -> (Vec6, f64) {
        let d = deflection.coordinates();
        let q = Vec6::from_fn(|k, _| self.of(k, 3) * d[k] - self.of(k, 2));
        (q, libm::hypot(q[0], q[1]))
    }
}

impl CarBushing {
    pub(crate) fn new(curves: [usize; 6]) -> Self {
        Self { curves }
    }

    /// Returns whether an axis reads a SPLINE, given by its index in the model.
    pub(crate) fn reads_spline(&self, curves: &Curves, spline: usize) -> bool {
        self.curves.iter().any(|curve| curves.is_of(*curve, spline))
    }

    /// Returns the derivative of the wrench on I, in J axes, with respect to the y value of a knot of a SPLINE.
    ///
    /// # Errors
    /// Returns [`Degenerate`] where the law is undefined at this motion.
    pub(crate) fn by_knot(
        &self,
        motion: &RelativeMotion,
        numbers: CarNumbers<'_>,
        (spline, knot): (usize, usize),
    ) -> Result<Vec6, Degenerate> {
        let d = Deflection::of(motion)?;
        let (q, r) = numbers.arguments(&d);
        let mut sum = Vec6::zeros();
        for (axis, &index) in self.curves.iter().enumerate() {
            if !numbers.curves.is_of(index, spline) {
                continue;
            }
            let curve = numbers.curves.get(index);
            let change = if axis >= 2 {
                curve.by_knot(knot, q[axis], 0)
            } else if r <= ROUND_OFF_RELATIVE * curve.reach() {
                curve.by_knot(knot, 0.0, 1) * q[axis]
            } else {
                (curve.by_knot(knot, r, 0) - curve.by_knot(knot, 0.0, 0)) / r * q[axis]
            };
            sum[axis] = -numbers.of(axis, 0) * change;
        }
        Ok(sum)
    }

    /// Returns X(r)/r and its derivative with respect to r, for a radial axis.
    fn secant(&self, curves: &Curves, axis: usize, r: f64) -> (f64, f64) {
        let curve = curves.get(self.curves[axis]);
        let (at_zero, [tangent, _]) = curve.at(0.0, 0.0, 0);
        if r <= ROUND_OFF_RELATIVE * curve.reach() {
            return (tangent, 0.0);
        }
        let (value, [slope, _]) = curve.at(r, 0.0, 0);
        // An odd curve is zero at r = 0, up to round-off.
        let secant = (value - at_zero) / r;
        (secant, (slope - secant) / r)
    }
}

impl CarBushing {
    /// Computes the wrench on I, in J axes, like [`super::Law::evaluate`].
    ///
    /// # Errors
    /// Returns [`Degenerate`] where the law is undefined at this motion; `out` is then unspecified.
    pub(crate) fn evaluate(
        &self,
        motion: &RelativeMotion,
        numbers: CarNumbers<'_>,
        with_parameters: bool,
        out: &mut Wrench,
    ) -> Result<(), Degenerate> {
        let d = Deflection::of(motion)?;
        let number = |axis: usize, which: usize| numbers.of(axis, which);
        let d6 = d.coordinates();
        let (q, r) = numbers.arguments(&d);
        // c contains the values of the curves, and by_q their derivatives with respect to q.
        let mut c = Vec6::zeros();
        let mut by_q = Mat6::zeros();
        for k in 0..2 {
            let (secant, change) = self.secant(numbers.curves, k, r);
            c[k] = secant * q[k];
            by_q[(k, k)] = secant;
            for m in 0..2 {
                if r > 0.0 {
                    by_q[(k, m)] += change * q[k] * q[m] / r;
                }
            }
        }
        for k in 2..6 {
            let (value, [slope, _]) = numbers.curves.get(self.curves[k]).at(q[k], 0.0, 0);
            c[k] = value;
            by_q[(k, k)] = slope;
        }
        let mut by_d = Mat6::zeros();
        for k in 0..6 {
            out.value[k] = number(k, 1) - number(k, 0) * c[k];
            for m in 0..6 {
                by_d[(k, m)] = -number(k, 0) * by_q[(k, m)] * number(m, 3);
            }
        }
        out.by_motion = by_d;
        let by_angles = by_d.fixed_columns::<3>(3) * d.angle_rows;
        out.by_motion
            .fixed_columns_mut::<3>(3)
            .copy_from(&by_angles);
        if with_parameters {
            let columns = out.parameter_columns(6 * CarAxis::LENGTH);
            for k in 0..6 {
                let [scale, preload, offset, stretch] =
                    CarAxis::PLACES.map(|place| CarAxis::LENGTH * k + place);
                columns[scale][k] = -c[k];
                columns[preload][k] = 1.0;
                for m in 0..6 {
                    let slope = number(m, 0) * by_q[(m, k)];
                    columns[offset][m] = slope;
                    columns[stretch][m] = -slope * d6[k];
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::testing::{advanced, number};
    use crate::mechanics::{Pose, Vec3, exp};
    use crate::model::{Header, Spline};

    /// Symmetric knots of the test curves, in round numbers.
    const X: [f64; 7] = [-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0];

    fn spline(y: impl Fn(f64) -> f64, unit: f64) -> Spline {
        Spline {
            header: Header::default(),
            x: X.iter().map(|x| x * unit).collect(),
            z: vec![0.0],
            y: vec![X.iter().map(|x| y(x * unit)).collect()],
            linear_extrapolate: false,
            is_of_file: false,
        }
    }

    /// Returns the curves of the test bushing, one SPLINE per axis.
    fn curves() -> Curves {
        Curves::of_bushing(&[
            spline(|x| 300.0 * x + 20.0 * x * x * x, 1.0),
            spline(|x| 500.0 * x + 5.0 * x * x * x, 1.0),
            spline(|x| 80.0 * x + 30.0 * x * x, 1.0),
            spline(|x| 9e4 * x + 1e6 * x * x * x, 0.05),
            spline(|x| 7e4 * x, 0.05),
            spline(|x| 2e4 * x + 3e6 * x * x * x, 0.05),
        ])
    }

    fn law() -> CarBushing {
        CarBushing::new([0, 1, 2, 3, 4, 5])
    }

    /// Returns the arrays of all axes, with the given scale, preload, offset and stretch of each axis.
    fn theta(of: impl Fn(usize) -> [f64; 4]) -> Vec<f64> {
        let mut theta = vec![0.0; 6 * CarAxis::LENGTH];
        for axis in 0..6 {
            for (place, value) in CarAxis::PLACES.into_iter().zip(of(axis)) {
                theta[CarAxis::LENGTH * axis + place] = value;
            }
        }
        theta
    }

    fn general() -> Vec<f64> {
        theta(|k| {
            let small = if k < 3 { 0.3 } else { 0.01 };
            [
                1.5 + 0.1 * number(k),
                100.0 * number(k + 7),
                small * number(k + 3),
                1.0 + 0.2 * number(k + 1),
            ]
        })
    }

    fn at(p: [f64; 3], turn: [f64; 3]) -> RelativeMotion {
        let frame = |p: Vec3, turn: Vec3| Pose { p, R: exp(&turn) };
        let ground = frame(Vec3::zeros(), Vec3::zeros());
        RelativeMotion::between(&frame(p.into(), turn.into()), &ground, &Vec3::zeros())
    }

    fn wrench_with(curves: &Curves, theta: &[f64], motion: &RelativeMotion) -> Wrench {
        let mut out = Wrench::default();
        law()
            .evaluate(motion, CarNumbers { theta, curves }, true, &mut out)
            .expect("regular");
        out
    }

    fn wrench(theta: &[f64], motion: &RelativeMotion) -> Wrench {
        wrench_with(&curves(), theta, motion)
    }

    /// Returns motions with deflections inside the curves, beyond them, near the origin, and on an axis.
    fn motions() -> Vec<RelativeMotion> {
        vec![
            at([1.1, -0.7, 0.4], [0.05, -0.03, 0.08]),
            at([5.5, 4.5, -9.0], [0.2, 0.1, -0.45]),
            at([1e-7, 2e-7, 0.0], [0.0, 0.0, 0.0]),
            at([0.0, 1.3, 0.3], [0.01, 0.0, 0.0]),
        ]
    }

    /// Returns whether the deflection of any axis is zero.
    fn at_rest(motion: &RelativeMotion) -> bool {
        let deflected = motion.p_ij_j.iter().chain(motion.angles.iter());
        deflected.into_iter().any(|d| *d == 0.0)
    }

    /// The law agrees with its closed form. Each radial deflection is a knot of the curves, and no radial deflection lies on an axis.
    #[test]
    fn radial_axes_share_the_radial_deflection() {
        let plain = theta(|k| [if k == 0 { 1.5 } else { 1.0 }, 10.0 * k as f64, 0.0, 1.0]);
        let x = |r: f64| 300.0 * r + 20.0 * r * r * r;
        let y = |r: f64| 500.0 * r + 5.0 * r * r * r;
        for (p, r) in [
            ([2.4, 3.2, 2.0], 4.0),
            ([-1.2, 1.6, -4.0], 2.0),
            ([3.6, -4.8, 6.0], 6.0),
        ] {
            let value = wrench(&plain, &at(p, [0.0; 3])).value;
            let expected = [
                -1.5 * x(r) * p[0] / r,
                10.0 - y(r) * p[1] / r,
                20.0 - (80.0 * p[2] + 30.0 * p[2] * p[2]),
            ];
            for k in 0..3 {
                assert!(
                    (value[k] - expected[k]).abs() < 1e-9,
                    "{p:?}: {value} {expected:?}"
                );
            }
        }
    }

    /// The argument of a curve is the scaled displacement minus the offset. At d = (knot + offset)/scale, it is therefore a knot.
    #[test]
    fn offsets_are_subtracted_from_the_scaled_displacement() {
        let shifted = theta(|k| {
            if k == 2 {
                [2.0, 7.0, 0.5, 1.25]
            } else {
                [1.0, 0.0, 0.0, 1.0]
            }
        });
        let value = wrench(&shifted, &at([0.0, 0.0, (4.0 + 0.5) / 1.25], [0.0; 3])).value;
        assert!((value[2] - (7.0 - 2.0 * (80.0 * 4.0 + 30.0 * 16.0))).abs() < 1e-9);
    }

    /// Beyond its last knot, a curve is extrapolated along its last chord, also in torsion.
    #[test]
    fn curves_are_lines_beyond_their_ends() {
        let plain = theta(|_| [1.0, 0.0, 0.0, 1.0]);
        let c = |x: f64| 2e4 * x + 3e6 * x * x * x;
        let (a, b) = (0.2, 0.3);
        let beyond = 0.5;
        let expected = c(b) + (c(b) - c(a)) / (b - a) * (beyond - b);
        let value = wrench(&plain, &at([0.0; 3], [0.0, 0.0, beyond])).value;
        assert!((value[5] + expected).abs() < 1e-6, "{value} {expected}");
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let theta = general();
        for motion in motions() {
            let exact = wrench(&theta, &motion);
            let scale = exact.by_motion.norm();
            for k in 0..6 {
                let h = 1e-6;
                let at = |h: f64| wrench(&theta, &advanced(&motion, &Vec6::ith(k, h))).value;
                let difference = (at(h) - at(-h)) / (2.0 * h);
                let apart = (exact.by_motion.column(k) - difference).norm();
                assert!(apart < 1e-8 * scale, "{k}: {apart:e} of {scale:e}");
            }
            for n in 0..66 {
                let h = 1e-6;
                let at = |h: f64| {
                    let mut theta = theta.clone();
                    theta[n] += h;
                    wrench(&theta, &motion).value
                };
                let difference = (at(h) - at(-h)) / (2.0 * h);
                let column = exact.by_parameter[n];
                assert!(
                    (column - difference).norm() < 1e-8 * scale,
                    "{n}: {column} {difference}"
                );
                // The derivative with respect to the stretch of an axis is zero if the axis is not deflected.
                let acts = CarAxis::PLACES.contains(&(n % 11));
                assert!(acts || column.norm() == 0.0, "{n}");
                assert!(!acts || column.norm() > 0.0 || at_rest(&motion), "{n}");
            }
        }
    }

    #[test]
    fn derivatives_by_the_points_of_the_curves_agree_with_differences() {
        let theta = general();
        let curves = curves();
        let mut compared = 0;
        for motion in motions() {
            for axis in 0..6 {
                for knot in 0..X.len() {
                    let by_knot = |curves: &Curves| {
                        let numbers = CarNumbers {
                            theta: &theta,
                            curves,
                        };
                        let found = law().by_knot(&motion, numbers, (axis, knot));
                        found.expect("regular")
                    };
                    let exact = by_knot(&curves);
                    let x = X[knot] * [1.0, 0.05][axis / 3];
                    let y = curves.get(axis).at(x, 0.0, 0).0;
                    let h = 1e-6 * y.abs().max(1.0);
                    let moved = |h: f64| {
                        let mut moved = curves.clone();
                        moved.set(axis, knot, y + h);
                        let value = wrench_with(&moved, &theta, &motion).value;
                        (value, by_knot(&moved))
                    };
                    let (above, below) = (moved(h), moved(-h));
                    let difference = (above.0 - below.0) / (2.0 * h);
                    // A straight line is a kink of Akima's rule.
                    let is_smooth = |side: Vec6| (side - exact).norm() < 1e-3;
                    if is_smooth(above.1) && is_smooth(below.1) {
                        compared += 1;
                        let apart = (exact - difference).norm();
                        assert!(apart < 1e-6, "{axis} {knot}: {apart:e}");
                    }
                }
            }
        }
        assert!(compared > 100, "{compared}");
    }

    /// At r = 0, the stiffness equals the slopes of the curves, for any direction of a small deflection.
    #[test]
    fn the_law_is_smooth_at_the_origin() {
        let plain = theta(|_| [1.0, 0.0, 0.0, 1.0]);
        let there = wrench(&plain, &at([0.0; 3], [0.0; 3]));
        assert_eq!(there.value, Vec6::zeros());
        let near = wrench(&plain, &at([1e-9, -1e-9, 0.0], [0.0; 3]));
        assert!((there.by_motion - near.by_motion).norm() < 1e-5 * near.by_motion.norm());
        assert!(there.by_motion[(0, 0)] < -300.0 && there.by_motion[(1, 1)] < -500.0);
    }
}
