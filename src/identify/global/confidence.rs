//! Uncertainty of the unknowns of a fit: their posterior covariance and the directions that the readings determine poorly.

use nalgebra::DMatrix;

use super::gauss_newton::Minimum;
use crate::settings::NAMED_COMPONENT;
use admire_solver::mechanics::eigen::symmetric_eigen;

/// Computes the posterior covariance of all unknowns: the inverse of the information of readings and priors together. Held unknowns get zero
/// variance.
pub fn covariance(minimum: &Minimum, held: &[bool]) -> DMatrix<f64> {
    let mut information = minimum.information.clone();
    for (k, held) in held.iter().enumerate() {
        if *held {
            information.fill_row(k, 0.0);
            information.fill_column(k, 0.0);
            information[(k, k)] = 1.0;
        }
    }
    let mut covariance = invert(&information);
    for (k, held) in held.iter().enumerate() {
        if *held {
            covariance.fill_row(k, 0.0);
            covariance.fill_column(k, 0.0);
        }
    }
    covariance
}

/// Returns the inverse of an information matrix. Directions without information get a very large variance.
fn invert(information: &DMatrix<f64>) -> DMatrix<f64> {
    let mut jitter = 0.0;
    loop {
        let mut lifted = information.clone();
        for k in 0..lifted.nrows() {
            lifted[(k, k)] += jitter * information[(k, k)].max(f64::MIN_POSITIVE);
        }
        if let Some(factor) = nalgebra::Cholesky::new(lifted) {
            return factor.inverse();
        }
        jitter = if jitter == 0.0 { 1e-15 } else { jitter * 10.0 };
        if jitter > 1.0 {
            return DMatrix::identity(information.nrows(), information.ncols()) * f64::MAX.sqrt();
        }
    }
}

/// A linear combination of unknowns that the readings do not determine.
#[derive(Clone, PartialEq, Debug)]
pub struct OpenDirection {
    /// Indices of the unknowns with their weights in the combination, largest magnitude first. The combination is a unit vector; weights of
    /// magnitude 0.15 or less are omitted.
    pub weights: Vec<(usize, f64)>,
    /// Posterior standard deviation of the combination.
    pub sd: f64,
}

/// Returns the poorly determined directions among the first `count` unknowns: eigenvectors of their covariance whose standard deviation exceeds
/// `limit`, largest standard deviation first.
pub(crate) fn open_directions(
    covariance: &DMatrix<f64>,
    count: usize,
    limit: f64,
) -> Vec<OpenDirection> {
    if count == 0 {
        return Vec::new();
    }
    let eigen = symmetric_eigen(covariance.view((0, 0), (count, count)).into_owned());
    let mut found: Vec<OpenDirection> = (0..count)
        .filter_map(|k| {
            let sd = eigen.eigenvalues[k].max(0.0).sqrt();
            if sd <= limit {
                return None;
            }
            let mut weights: Vec<(usize, f64)> = eigen
                .eigenvectors
                .column(k)
                .iter()
                .copied()
                .enumerate()
                .filter(|(_, w)| w.abs() > NAMED_COMPONENT)
                .collect();
            weights.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            if weights.first().is_some_and(|(_, w)| *w < 0.0) {
                for (_, weight) in &mut weights {
                    *weight = -*weight;
                }
            }
            Some(OpenDirection { weights, sd })
        })
        .collect();
    found.sort_by(|a, b| b.sd.total_cmp(&a.sd));
    found
}
