//! Treatment of free motions in a fit. A free motion is a motion without stiffness, such as the spin of a link with a ball joint at each end.
//!
//! The model does not determine the position along a free motion; on a rig, friction determines it. The position is a nuisance parameter of
//! each load case. The prediction is placed where it fits the readings of the case best, and only the remaining residual is compared.
//!
//! Let `F` hold the derivatives of the residuals of a case with respect to its free motions. The residuals `r` and their Jacobian `J` are
//! replaced by `r - F F+ r` and `J - F F+ J` with `F+ = (F'WF)^-1 F'W`. This is variable projection (Golub and Pereyra, SIAM J. Numer. Anal. 10
//! (1973) 413) with Kaufman's approximation of the derivative.

use crate::settings::{
    FREE_MAX_PASSES, FREE_MAX_STEP, FREE_OUTLIER_RATIO, FREE_PLACED_STEP, FREE_ROUND_OFF,
};
use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::eigen::symmetric_eigen;
use admire_solver::mechanics::{Pose, Vec3};

/// A mark on an observed part and its measured position.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SeenMark {
    /// Index into [`Observed::parts`](super::Observed::parts).
    pub part: usize,
    /// Position of the mark in the part's frame.
    pub local: Vec3,
    /// Measured position of the mark in ground.
    pub x: Vec3,
}

/// Rows of a load case that its free motions affect.
#[derive(Clone, Debug)]
pub(super) struct FreeRows {
    /// Derivatives of the rows, one column per free motion.
    F: DMatrix<f64>,
    /// First row and number of rows of each reading.
    readings: Vec<(usize, usize)>,
}

/// Projection that removes the effect of the free motions from the rows.
pub(super) struct Projection<'a> {
    F: &'a DMatrix<f64>,
    /// Weighted pseudo-inverse `(F'WF)^-1 F'W`.
    inverse: DMatrix<f64>,
}

impl FreeRows {
    /// Creates the rows from their derivatives `F` with respect to the free motions. `readings` lists the first row and the number of rows of
    /// each reading.
    pub(super) fn new(F: DMatrix<f64>, readings: Vec<(usize, usize)>) -> Self {
        Self { F, readings }
    }

    /// Returns the projection for these residuals (prediction minus reading), with lower weights for outliers.
    pub(super) fn projection(&self, residual: &DVector<f64>) -> Projection<'_> {
        let mut weights = DVector::from_element(residual.len(), 1.0);
        let mut out = Projection::new(&self.F, &weights);
        for _ in 0..FREE_MAX_PASSES {
            let left = residual - &self.F * out.amounts(residual);
            let size = |(first, count): (usize, usize)| {
                left.rows(first, count).norm() / (count as f64).sqrt()
            };
            let mut sizes: Vec<f64> = self.readings.iter().map(|own| size(*own)).collect();
            sizes.sort_by(f64::total_cmp);
            let limit = FREE_OUTLIER_RATIO * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
            let before = weights.clone();
            for own in &self.readings {
                let size = size(*own);
                let weight = if size > limit { limit / size } else { 1.0 };
                weights.rows_mut(own.0, own.1).fill(weight);
            }
            if weights == before {
                break;
            }
            out = Projection::new(&self.F, &weights);
        }
        out
    }

    /// Returns an orthonormal basis of the column space of `F`.
    pub(super) fn basis(&self) -> DMatrix<f64> {
        let eigen = symmetric_eigen(self.F.tr_mul(&self.F));
        let largest = eigen.eigenvalues.max();
        let held: Vec<usize> = (0..eigen.eigenvalues.len())
            .filter(|k| eigen.eigenvalues[*k] > FREE_ROUND_OFF * largest)
            .collect();
        let mut basis = &self.F * eigen.eigenvectors.select_columns(&held);
        for (mut column, k) in basis.column_iter_mut().zip(&held) {
            column /= eigen.eigenvalues[*k].sqrt();
        }
        basis
    }
}

impl<'a> Projection<'a> {
    fn new(F: &'a DMatrix<f64>, weights: &DVector<f64>) -> Self {
        let mut weighed = F.clone();
        for (mut row, weight) in weighed.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        let eigen = symmetric_eigen(F.tr_mul(&weighed));
        let least = FREE_ROUND_OFF * eigen.eigenvalues.max();
        let inverse = eigen
            .eigenvalues
            .map(|value| if value > least { 1.0 / value } else { 0.0 });
        let Q = &eigen.eigenvectors;
        Self {
            inverse: Q * DMatrix::from_diagonal(&inverse) * Q.transpose() * weighed.transpose(),
            F,
        }
    }

    /// Returns the amount of each free motion that fits these residuals best.
    fn amounts(&self, residual: &DVector<f64>) -> DVector<f64> {
        &self.inverse * residual
    }

    /// Removes the effect of the free motions from each column of a matrix with these rows.
    pub(super) fn apply(&self, columns: &mut DMatrix<f64>) {
        let along = &self.inverse * &*columns;
        *columns -= self.F * along;
    }
}

/// Returns the step along each free motion that fits the marks of a case best. Returns `None` if no free motion affects a mark or all steps are
/// negligible.
///
/// `poses` returns the pose of an observed part. `motions` holds, for each free motion, the twist of each observed part: velocity of the origin
/// and angular velocity in ground axes.
pub(crate) fn step(
    marks: &[SeenMark],
    poses: &dyn Fn(usize) -> Pose,
    motions: &[Vec<(Vec3, Vec3)>],
) -> Option<Vec<f64>> {
    let mut F = DMatrix::zeros(3 * marks.len(), motions.len());
    let mut residual = DVector::zeros(3 * marks.len());
    let mut readings = Vec::with_capacity(marks.len());
    for (k, mark) in marks.iter().enumerate() {
        let pose = poses(mark.part);
        let arm = pose.R * mark.local;
        residual
            .fixed_rows_mut::<3>(3 * k)
            .copy_from(&(mark.x - pose.p - arm));
        for (at, motion) in motions.iter().enumerate() {
            let (v, w) = &motion[mark.part];
            F.fixed_view_mut::<3, 1>(3 * k, at)
                .copy_from(&(v + w.cross(&arm)));
        }
        if F.rows(3 * k, 3).iter().any(|value| *value != 0.0) {
            readings.push((3 * k, 3));
        }
    }
    if readings.is_empty() {
        return None;
    }
    let rows = FreeRows::new(F, readings);
    let amounts = rows.projection(&residual).amounts(&residual);
    let shorter = (FREE_MAX_STEP / amounts.amax()).min(1.0);
    (amounts.amax() > FREE_PLACED_STEP)
        .then(|| amounts.iter().map(|amount| amount * shorter).collect())
}
