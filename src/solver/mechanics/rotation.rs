use super::{Mat3, Vec3};

/// Returns the cross-product matrix: `skew(a) * b = a x b`.
pub fn skew(a: &Vec3) -> Mat3 {
    Mat3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Returns the rotation matrix of the rotation vector `a` (Rodrigues' formula).
pub fn exp(a: &Vec3) -> Mat3 {
    let angle2 = a.norm_squared();
    let s = skew(a);
    // f = sin(t)/t and g = (1 - cos t)/t^2; small angles use the series, because the quotients would lose digits.
    let (f, g) = if angle2 < 1e-8 {
        (1.0 - angle2 / 6.0, 0.5 - angle2 / 24.0)
    } else {
        let angle = angle2.sqrt();
        (libm::sin(angle) / angle, (1.0 - libm::cos(angle)) / angle2)
    };
    Mat3::identity() + s * f + s * s * g
}

/// Returns the matrix that maps an angular velocity in base axes to the time derivative of the rotation vector `a`. With `R = exp(a) R_0` and
/// `R' = w~ R`, `a' = (1 - a~/2 + (1 - (t/2) cot(t/2)) / t^2 a~^2) w`, where t = |a|.
pub(crate) fn turning_rate(a: &Vec3) -> Mat3 {
    let angle2 = a.norm_squared();
    let s = skew(a);
    let g = if angle2 < 1e-4 {
        1.0 / 12.0 + angle2 / 720.0 + angle2 * angle2 / 30240.0
    } else {
        let half = 0.5 * angle2.sqrt();
        (1.0 - half / libm::tan(half)) / angle2
    };
    Mat3::identity() - s * 0.5 + s * s * g
}

/// Returns the rotation vector of a rotation matrix. Its length is at most pi.
pub fn log(R: &Mat3) -> Vec3 {
    let q = nalgebra::UnitQuaternion::from_rotation_matrix(
        &nalgebra::Rotation3::from_matrix_unchecked(*R),
    );
    let v = if q.w < 0.0 { -q.imag() } else { q.imag() };
    let sine = v.norm();
    if sine == 0.0 {
        return Vec3::zeros();
    }
    v * (2.0 * libm::atan2(sine, q.w.abs()) / sine)
}

/// Returns the matrix of the body-fixed 3-1-3 rotation `Rz(psi) * Rx(theta) * Rz(phi)` (guide/formats.md 4.1). The angles are in radians.
pub fn euler313(psi: f64, theta: f64, phi: f64) -> Mat3 {
    let (sa, ca) = libm::sincos(psi);
    let (sb, cb) = libm::sincos(theta);
    let (sc, cc) = libm::sincos(phi);
    Mat3::new(
        ca * cc - sa * cb * sc,
        -ca * sc - sa * cb * cc,
        sa * sb,
        sa * cc + ca * cb * sc,
        -sa * sc + ca * cb * cc,
        -ca * sb,
        sb * sc,
        sb * cc,
        cb,
    )
}

/// Returns the angles PSI, THETA, PHI of a rotation matrix in radians. THETA is in [0, pi]; PSI and PHI are in (-pi, pi]. At THETA = 0 or pi,
/// PHI is zero and PSI contains the whole rotation about z (guide/formats.md 4.1).
pub fn psi_theta_phi(R: &Mat3) -> [f64; 3] {
    let s = libm::hypot(R[(0, 2)], R[(1, 2)]);
    if s < 1e-12 {
        let theta = if R[(2, 2)] > 0.0 {
            0.0
        } else {
            std::f64::consts::PI
        };
        return [libm::atan2(R[(1, 0)], R[(0, 0)]), theta, 0.0];
    }
    let (sin, cos) = (R[(0, 2)] / s, -R[(1, 2)] / s);
    // phi is computed from R after the rotation psi is removed. Near theta = 0, where psi is inaccurate, the sum of psi and phi then stays
    // accurate.
    let phi = libm::atan2(
        0.0 - (cos * R[(0, 1)] + sin * R[(1, 1)]),
        cos * R[(0, 0)] + sin * R[(1, 0)],
    );
    [libm::atan2(sin, cos), libm::atan2(s, R[(2, 2)]), phi]
}

/// Returns AX, AY, AZ of I with respect to J from `R_ji`: `atan2(-zi.yj, zi.zj)`, `atan2(zi.xj, zi.zj)`, `atan2(xi.yj, xi.xj)`
/// (guide/formats.md 2.7, 4.3). Each angle is in radians in (-pi, pi].
pub fn projected_angles(R_ji: &Mat3) -> Vec3 {
    Vec3::new(
        atan2(-R_ji[(1, 2)], R_ji[(2, 2)]),
        atan2(R_ji[(0, 2)], R_ji[(2, 2)]),
        atan2(R_ji[(1, 0)], R_ji[(0, 0)]),
    )
}

/// Returns `y.atan2(x)`. Small angles, which are usual at bushings, are computed by a series that is as accurate and much faster.
fn atan2(y: f64, x: f64) -> f64 {
    let small = x > 0.0 && y.abs() <= 0.1 * x;
    if !small {
        return libm::atan2(y, x);
    }
    let t = y / x;
    let u = -t * t;
    // The first omitted term of the series is below 1e-17 of the first term.
    let tail = 1.0 / 11.0 + u * (1.0 / 13.0 + u / 15.0);
    t + t * u * (1.0 / 3.0 + u * (0.2 + u * (1.0 / 7.0 + u * (1.0 / 9.0 + u * tail))))
}

/// Returns the angle nearest to `reference` that differs from `angle` by whole turns, in radians.
pub(crate) fn unwrap_near(angle: f64, reference: f64) -> f64 {
    let gap = reference - angle;
    if gap.abs() < std::f64::consts::PI {
        return angle;
    }
    angle + (gap / std::f64::consts::TAU).round() * std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn euler_angles_come_back() {
        for (psi, theta, phi) in [
            (0.3, 0.7, -1.2),
            (-2.9, 2.8, 3.0),
            (1.0, 1e-9, 0.0),
            (0.4, 3e-7, -0.4),
            (2.0, std::f64::consts::PI - 1e-10, 0.7),
            (1.0, 1e-13, 0.5),
        ] {
            // The additional rotation and its inverse add the round-off of many products.
            let R = exp(&Vec3::new(0.3, 0.2, 0.1)) * euler313(psi, theta, phi);
            let R = exp(&Vec3::new(0.3, 0.2, 0.1)).transpose() * R;
            let [a, b, c] = psi_theta_phi(&R);
            let apart = (euler313(a, b, c) - R).norm();
            assert!(apart < 2e-12, "{psi} {theta} {phi}: {apart:e}");
        }
    }

    #[test]
    fn the_series_of_the_arctangent_meets_the_library() {
        for n in -300..=300 {
            let y = f64::from(n) * 1e-3;
            for x in [0.95, 1.0, -1.0, 0.0] {
                let exact = y.atan2(x);
                assert!(
                    (atan2(y, x) - exact).abs() <= 4.5e-16 * exact.abs(),
                    "{y} {x}"
                );
            }
        }
    }

    #[test]
    fn the_rate_of_a_rotation_vector_turns_with_the_angular_velocity() {
        let w = Vec3::new(0.7, -0.4, 1.1);
        for a in [
            Vec3::new(1e-3, 2e-3, -1e-3),
            Vec3::new(9e-3, 4e-3, 1e-3),
            Vec3::new(0.8, -1.1, 0.6),
        ] {
            let h = 1e-5;
            let R = exp(&a);
            let at = |h: f64| log(&(exp(&(w * h)) * R));
            let difference = (at(h) - at(-h)) / (2.0 * h);
            assert!((turning_rate(&a) * w - difference).norm() < 1e-9, "{a}");
        }
    }

    #[test]
    fn exp_and_log_are_inverse() {
        for a in [
            Vec3::new(0.1, -0.2, 0.3),
            Vec3::new(1e-6, 2e-6, 0.0),
            Vec3::new(2.0, -1.5, 1.0),
        ] {
            assert!((log(&exp(&a)) - a).norm() < 1e-12);
            assert!((exp(&a) * exp(&-a) - Mat3::identity()).norm() < 1e-14);
        }
    }
}
