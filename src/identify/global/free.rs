//! Treatment of free motions: zero-stiffness motions such as the spin of a link with a ball joint at each end.
//!
//! A model does not determine the position along a free motion; on a rig, friction does. The position is a nuisance parameter of each load
//! case. Predictions are placed where they fit the readings of the case best, and the remaining residual is compared.
//!
//! Let `F` hold the derivatives of the rows with respect to the free motions of a case. Residuals and derivatives become `r - F F+ r` and
//! `J - F F+ J` with `F+ = (F'WF)^-1 F'W`. This is variable projection (Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413) with
//! Kaufman's derivative.

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
    /// Position in the part's frame.
    pub local: Vec3,
    /// Measured position in ground.
    pub x: Vec3,
}

/// Readings of a case that its free motions affect, as rows.
#[derive(Clone, Debug)]
pub(super) struct FreeRows {
    /// Derivatives of the rows, one column per motion.
    F: DMatrix<f64>,
    /// Rows that form one reading: the first row and their number.
    readings: Vec<(usize, usize)>,
}

/// Projection that removes the free motions from rows.
pub(super) struct Projection<'a> {
    F: &'a DMatrix<f64>,
    /// Weighted pseudo-inverse `(F'WF)^-1 F'W`.
    inverse: DMatrix<f64>,
}

impl FreeRows {
    /// Creates the rows from their derivatives; `readings` lists the first row and the number of rows of each reading.
    pub(super) fn new(F: DMatrix<f64>, readings: Vec<(usize, usize)>) -> Self {
        Self { F, readings }
    }

    /// Returns the weighted projection that fits these residuals (prediction minus reading) best.
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

    /// Returns an orthonormal basis of the columns of `F`.
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

    /// Returns the amounts of each motion in the best fit of a residual.
    fn amounts(&self, residual: &DVector<f64>) -> DVector<f64> {
        &self.inverse * residual
    }

    /// Removes the free motions from columns of these rows.
    pub(super) fn apply(&self, columns: &mut DMatrix<f64>) {
        let along = &self.inverse * &*columns;
        *columns -= self.F * along;
    }
}

/// Returns the steps along the free motions that fit the marks of a case best; `None` if no motion affects a mark or the steps are
/// negligible.
///
/// `poses` returns the poses of the observed parts. `motions` holds their twists along each motion: velocity of the origin and angular
/// velocity, ground axes.
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
