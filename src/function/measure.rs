//! Geometric measures of markers: value and derivatives by the motion of each marker.
//!
//! Knows poses only: not which part a marker is on, nor what the coordinates of parts are.

use super::{Measure, MeasureKind};
use crate::mechanics::{Mat3, Pose, Vec3, Vec6, projected_angles, unwrap_near};

/// A measure and its derivatives by the world motion of each of its markers: (translation of the marker's origin in ground axes,
/// rotation vector in ground axes with `R <- exp(dphi) R`). Those of absent markers are to be left out by the caller.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Measured {
    /// Length units or radians.
    pub value: f64,
    /// By the motion of I.
    pub by_i: Vec6,
    /// By the motion of J.
    pub by_j: Vec6,
    /// By the motion of K.
    pub by_k: Vec6,
}

/// Evaluates a measure at the world poses of its markers; for absent ones pass [`Pose::identity`].
///
/// `reference_angle` is the value of the previous solution: AX, AY, AZ are taken nearest to it, so that they count turns (guide/formats.md
/// 4.3). Other measures do not use it. Where a measure has no derivative (distance zero, angles of a singular sequence, lines of
/// INCANG in one direction) the derivative is returned as zero.
pub fn evaluate(measure: &Measure, i: &Pose, j: &Pose, k: &Pose, reference_angle: f64) -> Measured {
    match measure.kind {
        MeasureKind::Displacement(axis) => displacement(axis, i, j, k),
        MeasureKind::Distance => {
            let d = i.p - j.p;
            let distance = d.norm();
            let u = if distance > 0.0 {
                d / distance
            } else {
                Vec3::zeros()
            };
            Measured {
                value: distance,
                by_i: pair(&u, &Vec3::zeros()),
                by_j: pair(&-u, &Vec3::zeros()),
                by_k: Vec6::zeros(),
            }
        }
        MeasureKind::IncludedAngle => included_angle(i, j, k),
        MeasureKind::ProjectedAngle(axis) => {
            let R_ji = j.R.transpose() * i.R;
            let value = unwrap_near(projected_angles(&R_ji)[axis], reference_angle);
            relative(j, value, &projected_row(&R_ji, axis))
        }
        MeasureKind::Angle {
            sequence,
            which,
            minus,
        } => {
            let (value, row) = sequence.angle(&(j.R.transpose() * i.R), which);
            if minus {
                relative(j, -value, &-row)
            } else {
                relative(j, value, &row)
            }
        }
        MeasureKind::EulerParameter(which) => {
            let (value, row) = euler_parameter(&(j.R.transpose() * i.R), which);
            relative(j, value, &row)
        }
    }
}

fn pair(translation: &Vec3, rotation: &Vec3) -> Vec6 {
    Vec6::new(
        translation.x,
        translation.y,
        translation.z,
        rotation.x,
        rotation.y,
        rotation.z,
    )
}

/// A measure of the rotation of I in J, from its derivative by a rotation `dtheta` in J axes:
/// `dtheta = R_jg (dphi_i - dphi_j)`.
fn relative(j: &Pose, value: f64, row_j: &Vec3) -> Measured {
    let by_rotation = pair(&Vec3::zeros(), &(j.R * row_j));
    Measured {
        value,
        by_i: by_rotation,
        by_j: -by_rotation,
        by_k: Vec6::zeros(),
    }
}

/// `(p_i - p_j) . e` with e an axis of K, de = dphi_k x e.
fn displacement(axis: usize, i: &Pose, j: &Pose, k: &Pose) -> Measured {
    let d = i.p - j.p;
    let e: Vec3 = k.R.column(axis).into();
    Measured {
        value: d.dot(&e),
        by_i: pair(&e, &Vec3::zeros()),
        by_j: pair(&-e, &Vec3::zeros()),
        by_k: pair(&Vec3::zeros(), &e.cross(&d)),
    }
}

/// The angle between `a = p_i - p_j` and `b = p_k - p_j`: `dangle/da = (cos a/|a| - b/|b|) / (|a| sin)`, and so for b.
fn included_angle(i: &Pose, j: &Pose, k: &Pose) -> Measured {
    let (a, b) = (i.p - j.p, k.p - j.p);
    let (sin, cos) = (a.cross(&b).norm(), a.dot(&b));
    let value = libm::atan2(sin, cos);
    let lengths = a.norm() * b.norm();
    let (by_a, by_b) = if sin > f64::EPSILON * lengths {
        let (sin, cos) = (sin / lengths, cos / lengths);
        let (ua, ub) = (a.normalize(), b.normalize());
        (
            (ua * cos - ub) / (a.norm() * sin),
            (ub * cos - ua) / (b.norm() * sin),
        )
    } else {
        (Vec3::zeros(), Vec3::zeros())
    };
    let translation = |v: Vec3| pair(&v, &Vec3::zeros());
    Measured {
        value,
        by_i: translation(by_a),
        by_j: translation(-by_a - by_b),
        by_k: translation(by_b),
    }
}

/// Derivative of AX, AY or AZ by a rotation in J axes: for v = zi (AX, AY) or xi (AZ) in J axes, dv = dtheta x v, and
/// `d atan2(p, q) = (q dp - p dq) / (p^2 + q^2)`.
fn projected_row(R_ji: &Mat3, axis: usize) -> Vec3 {
    let v: Vec3 = R_ji.column(if axis == 2 { 0 } else { 2 }).into();
    // atan2(p, q) with p, q along the J axes `up` and `along`.
    let (p, q, up, along) = match axis {
        0 => (-v.y, v.z, -Vec3::y(), Vec3::z()),
        1 => (v.x, v.z, Vec3::x(), Vec3::z()),
        _ => (v.y, v.x, Vec3::y(), Vec3::x()),
    };
    let square = p * p + q * q;
    if square == 0.0 {
        return Vec3::zeros();
    }
    // (dtheta x v) . w = dtheta . (v x w)
    (v.cross(&up) * q - v.cross(&along) * p) / square
}

/// e0 or a component of e, and its derivative: `de0 = -e . dtheta / 2`, `de = (e0 dtheta + dtheta x e) / 2`.
fn euler_parameter(R: &Mat3, which: usize) -> (f64, Vec3) {
    let q = nalgebra::UnitQuaternion::from_rotation_matrix(
        &nalgebra::Rotation3::from_matrix_unchecked(*R),
    );
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let (e0, e) = (sign * q.w, Vec3::new(q.i, q.j, q.k) * sign);
    if which == 0 {
        return (e0, e * -0.5);
    }
    let axis = Vec3::ith(which - 1, 1.0);
    (e[which - 1], (axis * e0 + e.cross(&axis)) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::function::Sequence;
    use crate::mechanics::{euler313, exp, psi_theta_phi};

    fn poses() -> [Pose; 3] {
        let pose = |p: [f64; 3], r: [f64; 3]| Pose {
            p: Vec3::from(p),
            R: exp(&Vec3::from(r)),
        };
        [
            pose([1.0, 2.0, -0.5], [0.4, -0.3, 0.7]),
            pose([-0.3, 0.2, 0.6], [-0.5, 0.2, 0.1]),
            pose([0.8, -1.1, 0.9], [0.3, 0.9, -0.8]),
        ]
    }

    fn measure(kind: MeasureKind) -> Measure {
        Measure {
            kind,
            i: None,
            j: None,
            k: None,
        }
    }

    fn kinds() -> Vec<MeasureKind> {
        let mut kinds = vec![MeasureKind::Distance, MeasureKind::IncludedAngle];
        for k in 0..3 {
            kinds.push(MeasureKind::Displacement(k));
            kinds.push(MeasureKind::ProjectedAngle(k));
            for minus in [false, true] {
                kinds.push(MeasureKind::Angle {
                    sequence: Sequence::BODY_321,
                    which: k,
                    minus,
                });
            }
            for orient in 1..=24 {
                kinds.push(MeasureKind::Angle {
                    sequence: Sequence::of_orient(orient).unwrap(),
                    which: k,
                    minus: false,
                });
            }
        }
        kinds.extend((0..4).map(MeasureKind::EulerParameter));
        kinds
    }

    #[test]
    fn derivatives_are_those_of_central_differences() {
        let poses = poses();
        for kind in kinds() {
            let at =
                |poses: &[Pose; 3]| evaluate(&measure(kind), &poses[0], &poses[1], &poses[2], 0.0);
            let exact = at(&poses);
            for (which, by) in [exact.by_i, exact.by_j, exact.by_k].into_iter().enumerate() {
                for freedom in 0..6 {
                    let moved = |h: f64| {
                        let mut poses = poses;
                        let pose = &mut poses[which];
                        if freedom < 3 {
                            pose.p[freedom] += h;
                        } else {
                            pose.R = exp(&Vec3::ith(freedom - 3, h)) * pose.R;
                        }
                        at(&poses).value
                    };
                    let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                    assert!(
                        (difference - by[freedom]).abs() < 2e-8,
                        "{kind:?} by {which}.{freedom}: {} and {difference}",
                        by[freedom]
                    );
                }
            }
        }
    }

    #[test]
    fn angles_of_a_sequence_build_the_rotation() {
        for seed in 0..40 {
            let s = f64::from(seed);
            let R = exp(&Vec3::new(
                (1.3 * s).sin() * 2.0,
                (0.7 * s).cos() * 2.0,
                (2.1 * s).sin(),
            ));
            for orient in 1..=24 {
                let sequence = Sequence::of_orient(orient).unwrap();
                let turn = |k: usize| exp(&Vec3::ith(sequence.axes[k], sequence.angle(&R, k).0));
                let built = if sequence.space_fixed {
                    turn(2) * turn(1) * turn(0)
                } else {
                    turn(0) * turn(1) * turn(2)
                };
                assert!((built - R).norm() < 1e-12, "{orient}");
            }
            let [psi, theta, phi] = psi_theta_phi(&R);
            for (k, angle) in [psi, theta, phi].into_iter().enumerate() {
                assert!((Sequence::BODY_313.angle(&R, k).0 - angle).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_singular_sequence_puts_the_turn_into_its_first_angle() {
        // guide/formats.md 4.1: at theta = 0 or pi the sum stands in psi and phi is 0.
        for theta in [0.0, std::f64::consts::PI] {
            let R = euler313(0.4, theta, 0.3);
            let angles = [0, 1, 2].map(|k| Sequence::BODY_313.angle(&R, k));
            let psi = if theta == 0.0 { 0.7 } else { 0.1 };
            assert!((angles[0].0 - psi).abs() < 1e-12 && angles[2].0 == 0.0);
            assert!((angles[1].0 - theta).abs() < 1e-12);
            assert!(angles.iter().all(|(_, row)| *row == Vec3::zeros()));
        }
    }

    #[test]
    fn pitch_is_minus_the_second_angle() {
        // guide/formats.md 4.4.
        let i = Pose {
            p: Vec3::zeros(),
            R: exp(&Vec3::new(0.0, 0.0, 0.3))
                * exp(&Vec3::new(0.0, 0.2, 0.0))
                * exp(&Vec3::new(0.1, 0.0, 0.0)),
        };
        let angle = |which, minus| {
            let kind = MeasureKind::Angle {
                sequence: Sequence::BODY_321,
                which,
                minus,
            };
            evaluate(
                &measure(kind),
                &i,
                &Pose::identity(),
                &Pose::identity(),
                0.0,
            )
            .value
        };
        assert!((angle(0, false) - 0.3).abs() < 1e-14);
        assert!((angle(1, true) + 0.2).abs() < 1e-14);
        assert!((angle(2, false) - 0.1).abs() < 1e-14);
    }

    #[test]
    fn projected_angles_count_turns() {
        let j = poses()[1];
        for axis in 0..3 {
            let mut angle = 0.0;
            for step in 1..=100 {
                // Five turns in a hundred steps.
                let turned = std::f64::consts::TAU * f64::from(step) / 20.0;
                let i = Pose {
                    p: j.p,
                    R: j.R * exp(&Vec3::ith(axis, turned)),
                };
                let kind = MeasureKind::ProjectedAngle(axis);
                angle = evaluate(&measure(kind), &i, &j, &Pose::identity(), angle).value;
                assert!((angle - turned).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn euler_parameters_turn_i_axes_into_j() {
        let [i, j, k] = poses();
        let e: Vec<f64> = (0..4)
            .map(|n| evaluate(&measure(MeasureKind::EulerParameter(n)), &i, &j, &k, 0.0).value)
            .collect();
        let axis = Vec3::new(e[1], e[2], e[3]);
        let angle = 2.0 * axis.norm().atan2(e[0]);
        let R = exp(&(axis.normalize() * angle));
        assert!((R - j.R.transpose() * i.R).norm() < 1e-14);
    }

    #[test]
    fn included_angle_is_that_of_the_lines() {
        let at = |x: f64, y: f64| Pose {
            p: Vec3::new(x, y, 0.0),
            R: Mat3::identity(),
        };
        let kind = measure(MeasureKind::IncludedAngle);
        let angle = |k: Pose| evaluate(&kind, &at(3.0, 1.0), &at(1.0, 1.0), &k, 0.0).value;
        assert!((angle(at(1.0, 6.0)) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!((angle(at(0.0, 2.0)) - 0.75 * std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(angle(at(9.0, 1.0)), 0.0);
    }
}
