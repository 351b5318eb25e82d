//! Absolute orientation: the pose of a part and its covariance, from three or more marks (measured points) on the part (equation 3 of the
//! paper).

use nalgebra::{DMatrix, Matrix3x6, SVD};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use admire_solver::mechanics::eigen::symmetric_eigen;
use admire_solver::mechanics::{Mat3, Mat6, Pose, Vec3, skew};

/// Ratio of the width to the length of a set of marks up to which the marks count as collinear and are rejected. The rotation about their
/// common line would be mostly noise.
pub(crate) const LEAST_SPREAD: f64 = 5e-3;

/// Measured pose of a part, with its covariance and the residuals of the marks.
#[derive(Clone, PartialEq, Debug)]
pub struct Orientation {
    /// Pose of the part frame in ground.
    pub pose: Pose,
    /// Covariance of the pose: position of the part's origin, then rotation vector `a` with `R <- exp(a) R`, both in ground axes.
    pub covariance: Mat6,
    /// Residuals of the marks (measured minus fitted position) in ground axes, in the order of the marks.
    pub residuals: Vec<Vec3>,
    /// Sum of squared residuals divided by the noise variance per coordinate; `None` if that variance is zero.
    pub chi_square: Option<f64>,
    /// Degrees of freedom of the fit: `3 n - 6` for `n` marks.
    pub dof: usize,
    /// Probability of a larger chi-square if the part is rigid and the noise has the stated variance; `None` without a chi-square.
    pub p_value: Option<f64>,
}

/// Reason why the marks do not determine a pose.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum OrientationError {
    /// Fewer than three marks.
    #[error("at least three marks are needed; the number of marks is {0}")]
    TooFew(usize),
    /// All marks lie on one line, or nearly so.
    #[error(
        "the marks lie on one line (rms width {lateral:.3}, rms length {length:.3}, in the unit of the marks), so the rotation about this line is not determined"
    )]
    Collinear {
        /// Rms extent of the marks across their common line.
        lateral: f64,
        /// Rms extent of the marks along their common line.
        length: f64,
    },
    /// A coordinate or its square is not finite.
    #[error("a coordinate is not a finite number, or too large or too small to be squared")]
    NotFinite,
}

/// Maximum number of iterations of the singular value decomposition. A 3 x 3 matrix takes fewer than ten.
const SVD_STEPS: usize = 1_000;

/// Returns the rms extents of a set of points about their mean along their principal axes, largest first.
pub(crate) fn extents(points: &[Vec3]) -> [f64; 3] {
    let n = points.len().max(1) as f64;
    let mean = points.iter().sum::<Vec3>() / n;
    let scatter = points
        .iter()
        .map(|point| (point - mean) * (point - mean).transpose())
        .sum::<Mat3>()
        / n;
    let mut values: Vec<f64> = symmetric_eigen(DMatrix::from_fn(3, 3, |i, j| scatter[(i, j)]))
        .eigenvalues
        .iter()
        .map(|value| value.max(0.0).sqrt())
        .collect();
    values.sort_by(|a, b| b.total_cmp(a));
    [values[0], values[1], values[2]]
}

/// Computes the pose of a part from its marks. The rigid motion `A` minimises `sum |A p_m - x_m|^2` by the singular value decomposition of the
/// cross-covariance (Arun; Eggert et al.). Reflections are excluded as by Umeyama.
///
/// `on_part` holds the marks in the part frame (`p_m`), and `measured` the same marks in ground (`x_m`), in the same length unit. `sigma` is
/// the standard deviation of one measured coordinate. If `sigma` is zero, the covariance is zero and there is no chi-square test.
///
/// # Errors
/// Fails for fewer than three marks, for collinear marks, and for coordinates that are not finite.
pub fn absolute_orientation(
    on_part: &[Vec3],
    measured: &[Vec3],
    sigma: f64,
) -> Result<Orientation, OrientationError> {
    let count = on_part.len().min(measured.len());
    let (on_part, measured) = (&on_part[..count], &measured[..count]);
    if count < 3 {
        return Err(OrientationError::TooFew(count));
    }
    let finite = |points: &[Vec3]| {
        points
            .iter()
            .all(|point| point.iter().all(|x| x.is_finite()))
    };
    if !finite(on_part) || !finite(measured) {
        return Err(OrientationError::NotFinite);
    }
    for points in [on_part, measured] {
        let [length, lateral, _] = extents(points);
        if lateral <= LEAST_SPREAD * length {
            return Err(OrientationError::Collinear { lateral, length });
        }
    }
    let n = count as f64;
    let mean_part = on_part.iter().sum::<Vec3>() / n;
    let mean_ground = measured.iter().sum::<Vec3>() / n;
    let cross = on_part
        .iter()
        .zip(measured)
        .map(|(p, x)| (x - mean_ground) * (p - mean_part).transpose())
        .sum::<Mat3>();
    let Some(svd) = SVD::try_new(cross, true, true, 5.0 * f64::EPSILON, SVD_STEPS) else {
        return Err(OrientationError::NotFinite);
    };
    let u = svd.u.expect("asked for");
    let v_t = svd.v_t.expect("asked for");
    // If the best orthogonal matrix is a reflection, the axis of the smallest singular value is reversed. Singular values are sorted in
    // descending order.
    let turn = Vec3::new(1.0, 1.0, (u * v_t).determinant().signum());
    let R = u * Mat3::from_diagonal(&turn) * v_t;
    let pose = Pose {
        p: mean_ground - R * mean_part,
        R,
    };
    let residuals: Vec<Vec3> = on_part
        .iter()
        .zip(measured)
        .map(|(p, x)| x - pose.point(p))
        .collect();
    let covariance = information(&pose, on_part)
        .try_inverse()
        .map_or_else(Mat6::zeros, |inverse| inverse * (sigma * sigma));
    let dof = 3 * count - 6;
    let squares: f64 = residuals.iter().map(Vec3::norm_squared).sum();
    let chi_square = (sigma > 0.0).then(|| squares / (sigma * sigma));
    Ok(Orientation {
        pose,
        covariance,
        residuals,
        chi_square,
        dof,
        p_value: chi_square.map(|value| chi_square_p_value(value, dof)),
    })
}

/// Returns the information matrix of the pose of a part for marks with unit noise. It is `sum J^T J` over the marks, where `J` follows from `dx
/// = dp - skew(R p_m) a`.
pub fn information(pose: &Pose, on_part: &[Vec3]) -> Mat6 {
    let mut information = Mat6::zeros();
    for p in on_part {
        let mut row = Matrix3x6::zeros();
        row.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&Mat3::identity());
        row.fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&-skew(&(pose.R * p)));
        information += row.transpose() * row;
    }
    information
}

/// Returns the probability that a chi-square variable with `dof` degrees of freedom exceeds `value`. Without degrees of freedom, the
/// probability is 1.
pub fn chi_square_p_value(value: f64, dof: usize) -> f64 {
    if dof == 0 || !value.is_finite() {
        return if value.is_finite() { 1.0 } else { 0.0 };
    }
    ChiSquared::new(dof as f64).map_or(1.0, |distribution| distribution.sf(value))
}

/// Noise of both measuring sessions, estimated from the misfit of the marks to rigid bodies.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NoiseEstimate {
    /// Standard deviation of positions measured on the rig (second session), per coordinate.
    pub sigma: f64,
    /// Degrees of freedom of the estimate of `sigma`.
    pub dof: usize,
    /// Standard deviation of positions measured on the part (first session), per coordinate. This error is constant over the cases.
    pub sigma_on_parts: f64,
}

/// Estimates the noise of both measuring sessions from the residuals of the marks. Noise of the second session varies from case to case; noise
/// of the first session is constant over the cases.
///
/// `parts[part][case]` is the fit of all marks of a part in a case. Fits with different sets of marks must be passed as separate parts. Returns
/// `None` without degrees of freedom.
pub fn estimate_noise(parts: &[Vec<Orientation>]) -> Option<NoiseEstimate> {
    let (mut varying, mut varying_dof) = (0.0, 0);
    let (mut constant, mut constant_dof) = (0.0, 0.0);
    for fits in parts {
        let Some(first) = fits.first() else { continue };
        let cases = fits.len();
        if cases < 2
            || fits
                .iter()
                .any(|fit| fit.residuals.len() != first.residuals.len())
        {
            for fit in fits {
                varying += fit.residuals.iter().map(Vec3::norm_squared).sum::<f64>();
                varying_dof += fit.dof;
            }
            continue;
        }
        let turned: Vec<Vec<Vec3>> = fits
            .iter()
            .map(|fit| {
                fit.residuals
                    .iter()
                    .map(|r| fit.pose.R.transpose() * r)
                    .collect()
            })
            .collect();
        for mark in 0..first.residuals.len() {
            let mean = turned.iter().map(|case| case[mark]).sum::<Vec3>() / cases as f64;
            constant += mean.norm_squared();
            varying += turned
                .iter()
                .map(|case| (case[mark] - mean).norm_squared())
                .sum::<f64>();
        }
        varying_dof += (cases - 1) * first.dof;
        // The variance of the mean residual is the variance of the first session plus the variance of the second session divided by the number
        // of cases.
        constant_dof += first.dof as f64;
    }
    if varying_dof == 0 {
        return None;
    }
    let variance = varying / varying_dof as f64;
    let cases = parts.iter().map(Vec::len).max().unwrap_or(1).max(1) as f64;
    let on_parts = if constant_dof > 0.0 {
        (constant / constant_dof - variance / cases).max(0.0)
    } else {
        0.0
    };
    Some(NoiseEstimate {
        sigma: variance.sqrt(),
        dof: varying_dof,
        sigma_on_parts: on_parts.sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::noise::Noise;
    use super::*;
    use admire_solver::mechanics::{exp, log};

    /// Marks of FRONT_ARM of the reference McPherson (millimetres).
    fn marks() -> Vec<Vec3> {
        vec![
            Vec3::new(260.24, -122.27, 42.17),
            Vec3::new(9.52, -65.55, -9.44),
            Vec3::new(158.40, -345.99, 73.29),
            Vec3::new(-36.40, -248.00, 60.24),
        ]
    }

    fn pose() -> Pose {
        Pose {
            p: Vec3::new(-330.0, -400.0, 215.0),
            R: exp(&Vec3::new(0.3, 0.5, -0.2)),
        }
    }

    #[test]
    fn exact_without_noise_also_for_three_marks_in_a_plane() {
        for count in [3, 4] {
            let on_part = &marks()[..count];
            let measured: Vec<Vec3> = on_part.iter().map(|p| pose().point(p)).collect();
            let fit = absolute_orientation(on_part, &measured, 0.0).unwrap();
            assert!((fit.pose.p - pose().p).norm() < 1e-11);
            assert!((fit.pose.R - pose().R).norm() < 1e-13);
        }
    }

    #[test]
    fn covariance_agrees_with_repeated_measurements() {
        // With 20,000 repetitions, the relative standard deviation of a variance is 1 percent, so a tolerance of 5 percent is five standard
        // deviations.
        let (sigma, runs) = (0.05, 20_000);
        let mut noise = Noise::new(1, "orientation test");
        let exact: Vec<Vec3> = marks().iter().map(|p| pose().point(p)).collect();
        let predicted = absolute_orientation(&marks(), &exact, sigma)
            .unwrap()
            .covariance;
        let (mut observed, mut rejected) = (Mat6::zeros(), 0);
        for _ in 0..runs {
            let measured: Vec<Vec3> = exact.iter().map(|x| x + noise.vector(sigma)).collect();
            let fit = absolute_orientation(&marks(), &measured, sigma).unwrap();
            let dp = fit.pose.p - pose().p;
            let a = log(&(fit.pose.R * pose().R.transpose()));
            let error = nalgebra::Vector6::new(dp.x, dp.y, dp.z, a.x, a.y, a.z);
            observed += error * error.transpose() / f64::from(runs);
            rejected += u32::from(fit.p_value.unwrap() < 0.01);
        }
        let scale = predicted.diagonal().map(f64::sqrt);
        for i in 0..6 {
            for j in 0..6 {
                let difference = (observed[(i, j)] - predicted[(i, j)]) / (scale[i] * scale[j]);
                assert!(difference.abs() < 0.05, "{i} {j}: {difference}");
            }
        }
        assert!(
            (120..280).contains(&rejected),
            "1 percent of 20,000: {rejected}"
        );
    }

    #[test]
    fn degenerate_layouts_are_refused() {
        let line: Vec<Vec3> = (0..4)
            .map(|k| {
                Vec3::new(10.0, 20.0, 30.0) * f64::from(k)
                    + Vec3::new(0.0, 0.0, 0.01 * f64::from(k % 2))
            })
            .collect();
        assert!(matches!(
            absolute_orientation(&line, &line, 0.05),
            Err(OrientationError::Collinear { .. })
        ));
        assert!(matches!(
            absolute_orientation(&marks()[..2], &marks(), 0.05),
            Err(OrientationError::TooFew(2))
        ));
        let mut bad = marks();
        bad[0].x = f64::NAN;
        assert!(matches!(
            absolute_orientation(&marks(), &bad, 0.05),
            Err(OrientationError::NotFinite)
        ));
    }

    #[test]
    fn a_mirrored_part_is_not_fitted_by_a_reflection() {
        let measured: Vec<Vec3> = marks().iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
        let fit = absolute_orientation(&marks(), &measured, 0.05).unwrap();
        assert!((fit.pose.R.determinant() - 1.0).abs() < 1e-12);
        assert!(fit.p_value.unwrap() < 1e-6);
    }

    #[test]
    fn noise_of_both_sessions_is_told_apart() {
        let (sigma, on_parts) = (0.05, 0.03);
        let mut noise = Noise::new(3, "two sessions");
        let mut parts = Vec::new();
        for _ in 0..200 {
            let listed: Vec<Vec3> = marks().iter().map(|p| p + noise.vector(on_parts)).collect();
            let fits = (0..13)
                .map(|_| {
                    let measured: Vec<Vec3> = marks()
                        .iter()
                        .map(|p| pose().point(p) + noise.vector(sigma))
                        .collect();
                    absolute_orientation(&listed, &measured, sigma).unwrap()
                })
                .collect();
            parts.push(fits);
        }
        let estimate = estimate_noise(&parts).unwrap();
        assert!((estimate.sigma / sigma - 1.0).abs() < 0.02, "{estimate:?}");
        assert!(
            (estimate.sigma_on_parts / on_parts - 1.0).abs() < 0.1,
            "{estimate:?}"
        );
    }
}
