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
/// `reference_angle` is the value of the previous solution: AX, AY, AZ are taken nearest to it, so that they count turns (ADAMS-FORMATS
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
    let value = sin.atan2(cos);
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
