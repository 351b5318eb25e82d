//! Geometric measures of markers: value and derivatives with respect to the motion of each marker.
//!
//! The module depends on marker poses only. It is independent of the parts that carry the markers and of the part coordinates.

use super::{Measure, MeasureKind};
use crate::mechanics::{Mat3, Pose, Vec3, Vec6, projected_angles, unwrap_near};

/// Value of a measure and its derivatives with respect to the motion of each of its markers.
///
/// The motion of a marker consists of the translation of its origin in ground axes and a rotation vector dphi in ground axes, with `R <-
/// exp(dphi) R`. The caller must omit the derivatives of absent markers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Measured {
    /// Value, in length units or radians.
    pub value: f64,
    /// Derivative with respect to the motion of I.
    pub by_i: Vec6,
    /// Derivative with respect to the motion of J.
    pub by_j: Vec6,
    /// Derivative with respect to the motion of K.
    pub by_k: Vec6,
}

/// Sine of the angle below which two lines count as parallel, because half of the digits of their normal are round-off.
const STRAIGHT: f64 = 1.5e-8;

/// Angle of the previous solution, the reference for counting full turns.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Reference {
    /// Angle, in radians.
    pub angle: f64,
    /// For INCANG, the unit vector in ground axes about which a positive angle turns the line to I onto the line to K. Zero until the first
    /// nonzero angle.
    pub normal: Vec3,
}

impl Reference {
    /// Reference before the first measurement.
    pub const NONE: Self = Self {
        angle: 0.0,
        normal: Vec3::new(0.0, 0.0, 0.0),
    };
}

/// Evaluates a measure at the world poses of its markers. For an absent marker, pass [`Pose::identity`].
///
/// AX, AY, AZ and INCANG count full turns: they are shifted by full turns to the value nearest to the reference (guide/formats.md 4.3).
/// Other measures ignore the reference. The derivative is returned as zero where it does not exist: at zero distance, for angles of a
/// singular sequence, and for INCANG while its lines are still parallel at the start.
pub fn evaluate(
    measure: &Measure,
    i: &Pose,
    j: &Pose,
    k: &Pose,
    reference: &Reference,
) -> Measured {
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
        MeasureKind::IncludedAngle => included_angle(i, j, k, reference).0,
        MeasureKind::ProjectedAngle(axis) => {
            let R_ji = j.R.transpose() * i.R;
            let value = unwrap_near(projected_angles(&R_ji)[axis], reference.angle);
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

/// Returns a measure of the rotation of I in J with its derivatives. `row_j` is the derivative with respect to a rotation `dtheta` in J
/// axes, where `dtheta = R_jg (dphi_i - dphi_j)`.
fn relative(j: &Pose, value: f64, row_j: &Vec3) -> Measured {
    let by_rotation = pair(&Vec3::zeros(), &(j.R * row_j));
    Measured {
        value,
        by_i: by_rotation,
        by_j: -by_rotation,
        by_k: Vec6::zeros(),
    }
}

/// Returns the displacement `(p_i - p_j) . e` with its derivatives. e is an axis of K, and `de = dphi_k x e`.
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

/// Returns the reference for the next solution, computed from the marker poses of this solution.
pub(crate) fn next_reference(
    measure: &Measure,
    i: &Pose,
    j: &Pose,
    k: &Pose,
    reference: &Reference,
) -> Reference {
    let normal = match measure.kind {
        MeasureKind::IncludedAngle => included_angle(i, j, k, reference).1,
        _ => reference.normal,
    };
    let angle = evaluate(measure, i, j, k, reference).value;
    Reference { angle, normal }
}

/// Returns the angle in radians from `a = p_i - p_j` to `b = p_k - p_j` about their common normal n, and n itself.
///
/// The sign of n is chosen to continue the normal of the previous solution. The derivatives are `dangle/da = a x n / a^2` and `dangle/db =
/// n x b / b^2`.
fn included_angle(i: &Pose, j: &Pose, k: &Pose, reference: &Reference) -> (Measured, Vec3) {
    let (a, b) = (i.p - j.p, k.p - j.p);
    let (cross, cos) = (a.cross(&b), a.dot(&b));
    let side = if cross.dot(&reference.normal) < 0.0 {
        -1.0
    } else {
        1.0
    };
    let sin = cross.norm();
    let angle = libm::atan2(side * sin, cos);
    let normal = if sin > STRAIGHT * a.norm() * b.norm() {
        cross * (side / sin)
    } else {
        // Parallel lines define no normal: use the previous normal, made perpendicular to the lines.
        let along = a.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let left = reference.normal - along * along.dot(&reference.normal);
        left.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    };
    let by = |turned: Vec3, line: &Vec3| match line.norm_squared() {
        0.0 => Vec3::zeros(),
        square => turned / square,
    };
    let (by_a, by_b) = (by(a.cross(&normal), &a), by(normal.cross(&b), &b));
    let translation = |v: Vec3| pair(&v, &Vec3::zeros());
    let measured = Measured {
        value: unwrap_near(angle, reference.angle),
        by_i: translation(by_a),
        by_j: translation(-by_a - by_b),
        by_k: translation(by_b),
    };
    (measured, normal)
}

/// Returns the derivative of AX, AY or AZ with respect to a rotation `dtheta` of I in J axes. For v = zi (AX, AY) or xi (AZ) in J axes, `dv
/// = dtheta x v` and `d atan2(p, q) = (q dp - p dq) / (p^2 + q^2)`.
fn projected_row(R_ji: &Mat3, axis: usize) -> Vec3 {
    let v: Vec3 = R_ji.column(if axis == 2 { 0 } else { 2 }).into();
    // The angle is atan2(p, q); p and q are the components of v along the J axes `up` and `along`.
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

/// Returns Euler parameter `which` (0 for e0, 1 to 3 for the components of e) and its derivative with respect to `dtheta`: `de0 = -e .
/// dtheta / 2`, `de = (e0 dtheta + dtheta x e) / 2`.
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
    use crate::function::RotationSequence;
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
                    sequence: RotationSequence::BODY_321,
                    which: k,
                    minus,
                });
            }
            for orient in 1..=24 {
                kinds.push(MeasureKind::Angle {
                    sequence: RotationSequence::of_orient(orient).unwrap(),
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
            let at = |poses: &[Pose; 3]| {
                evaluate(
                    &measure(kind),
                    &poses[0],
                    &poses[1],
                    &poses[2],
                    &Reference::NONE,
                )
            };
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
                let sequence = RotationSequence::of_orient(orient).unwrap();
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
                assert!((RotationSequence::BODY_313.angle(&R, k).0 - angle).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_singular_sequence_puts_the_turn_into_its_first_angle() {
        // guide/formats.md 4.1: at theta = 0 or pi, psi holds the sum and phi is 0.
        for theta in [0.0, std::f64::consts::PI] {
            let R = euler313(0.4, theta, 0.3);
            let angles = [0, 1, 2].map(|k| RotationSequence::BODY_313.angle(&R, k));
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
                sequence: RotationSequence::BODY_321,
                which,
                minus,
            };
            evaluate(
                &measure(kind),
                &i,
                &Pose::identity(),
                &Pose::identity(),
                &Reference::NONE,
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
            let mut angle = Reference::NONE;
            for step in 1..=100 {
                // Five turns in a hundred steps.
                let turned = std::f64::consts::TAU * f64::from(step) / 20.0;
                let i = Pose {
                    p: j.p,
                    R: j.R * exp(&Vec3::ith(axis, turned)),
                };
                let kind = MeasureKind::ProjectedAngle(axis);
                angle = next_reference(&measure(kind), &i, &j, &Pose::identity(), &angle);
                assert!((angle.angle - turned).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn euler_parameters_turn_i_axes_into_j() {
        let [i, j, k] = poses();
        let e: Vec<f64> = (0..4)
            .map(|n| {
                evaluate(
                    &measure(MeasureKind::EulerParameter(n)),
                    &i,
                    &j,
                    &k,
                    &Reference::NONE,
                )
                .value
            })
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
        let none = Reference::NONE;
        let angle = |k: Pose| evaluate(&kind, &at(3.0, 1.0), &at(1.0, 1.0), &k, &none).value;
        assert!((angle(at(1.0, 6.0)) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert!((angle(at(0.0, 2.0)) - 0.75 * std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(angle(at(9.0, 1.0)), 0.0);
    }

    /// Real ADAMS output continues past 180 degrees: 156.98, 182.25, 325.06, 354.53 degrees.
    #[test]
    fn included_angle_runs_on_past_180_degrees() {
        let at = |degrees: f64| Pose {
            p: exp(&Vec3::new(0.3, -0.2, 0.1))
                * Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0),
            R: Mat3::identity(),
        };
        let (centre, kind) = (Pose::identity(), measure(MeasureKind::IncludedAngle));
        for way in [1.0, -1.0] {
            let mut reference = Reference::NONE;
            // The first value is positive for either sense of rotation. On the way back, the two lines are parallel at 0 and 180 degrees.
            for degrees in (0..=36)
                .map(|k| 20.0 * f64::from(k))
                .chain([710.0, 600.0, 480.0, 360.0, 300.0, 180.0, 90.0, 0.0, -30.0])
            {
                let (i, k) = (at(0.0), at(way * degrees));
                reference = next_reference(&kind, &i, &centre, &k, &reference);
                let found = reference.angle.to_degrees();
                assert!((found - degrees).abs() < 1e-6, "{way} {degrees}: {found}");
            }
        }
    }

    /// The derivatives agree with central differences on both sides of 180 degrees and at 180 degrees.
    #[test]
    fn included_angle_is_smooth_at_180_degrees() {
        let kind = measure(MeasureKind::IncludedAngle);
        let reference = Reference {
            angle: 3.1,
            normal: Vec3::z(),
        };
        for height in [-0.1, -1e-9, 0.0, 1e-9, 0.1] {
            let poses = [[1.0, 0.0, 0.0], [0.0; 3], [-2.0, height, 0.0]].map(|p| Pose {
                p: Vec3::from(p),
                R: Mat3::identity(),
            });
            let at =
                |poses: &[Pose; 3]| evaluate(&kind, &poses[0], &poses[1], &poses[2], &reference);
            let exact = at(&poses);
            for (which, by) in [exact.by_i, exact.by_j, exact.by_k].into_iter().enumerate() {
                // A displacement along z would move the lines out of the plane of rotation.
                for axis in 0..2 {
                    let moved = |h: f64| {
                        let mut poses = poses;
                        poses[which].p[axis] += h;
                        at(&poses).value
                    };
                    let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                    assert!(
                        (difference - by[axis]).abs() < 1e-8,
                        "{height} {which} {axis}"
                    );
                }
            }
        }
    }
}
