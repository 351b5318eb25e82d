//! Free motions: those that nothing in a model resists, such as the spin of a link with a ball joint at each end.
//!
//! No model says where a part is along a free motion; on a rig friction decides. It is a nuisance of each load case: predictions are taken
//! where they meet the readings of the case best, and what is left is compared without it. Let `F` hold the rows' derivatives by the free
//! motions of a case. Residuals and derivatives become `r - F F+ r` and `J - F F+ J`, `F+ = (F'WF)^-1 F'W`: variable projection (Golub and
//! Pereyra, SIAM J. Numer. Anal. 10 (1973) 413) with Kaufman's derivative.

use nalgebra::{DMatrix, DVector};

use admire_solver::mechanics::eigen::symmetric_eigen;
use admire_solver::mechanics::{Pose, Vec3};

/// A reading that is off by more than this many times the median of its case is weighed down in proportion: one wrong mark must not turn a part.
const WILD: f64 = 3.0;
/// Weights are found in so many passes.
const PASSES: usize = 4;
/// Squares of motions below this share of the largest are round-off.
const ROUND_OFF: f64 = 1e-12;
/// Predictions are moved along free motions until a step is below so much of one radian, or of the size of the model,
const CLOSE: f64 = 1e-4;
/// in so many steps at most, none of which is longer than this.
pub(crate) const STEPS: usize = 20;
const LONGEST: f64 = 0.5;

/// A mark on an observed part and where it was read.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SeenMark {
    /// Index into [`Observed::parts`](super::Observed::parts).
    pub part: usize,
    /// In the part's frame.
    pub local: Vec3,
    /// In ground.
    pub x: Vec3,
}

/// Rows of some readings by the free motions of a case.
#[derive(Clone, Debug)]
pub(super) struct FreeRows {
    /// Derivatives, one column for each motion.
    F: DMatrix<f64>,
    /// Rows that are one reading: the first and how many.
    readings: Vec<(usize, usize)>,
}

/// How free motions are taken off rows.
pub(super) struct Projection<'a> {
    F: &'a DMatrix<f64>,
    /// `(F'WF)^-1 F'W`.
    inverse: DMatrix<f64>,
}

impl FreeRows {
    /// Of derivatives; `readings` are rows that belong together, by the first and their number.
    pub(super) fn new(F: DMatrix<f64>, readings: Vec<(usize, usize)>) -> Self {
        Self { F, readings }
    }

    /// The projection at which these residuals, prediction minus reading, are least.
    pub(super) fn projection(&self, residual: &DVector<f64>) -> Projection<'_> {
        let mut weights = DVector::from_element(residual.len(), 1.0);
        let mut out = Projection::new(&self.F, &weights);
        for _ in 0..PASSES {
            let left = residual - &self.F * out.amounts(residual);
            let size = |(first, count): (usize, usize)| {
                left.rows(first, count).norm() / (count as f64).sqrt()
            };
            let mut sizes: Vec<f64> = self.readings.iter().map(|own| size(*own)).collect();
            sizes.sort_by(f64::total_cmp);
            let limit = WILD * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
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

    /// An orthonormal basis of the derivatives.
    pub(super) fn basis(&self) -> DMatrix<f64> {
        let eigen = symmetric_eigen(self.F.tr_mul(&self.F));
        let largest = eigen.eigenvalues.max();
        let held: Vec<usize> = (0..eigen.eigenvalues.len())
            .filter(|k| eigen.eigenvalues[*k] > ROUND_OFF * largest)
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
        let least = ROUND_OFF * eigen.eigenvalues.max();
        let inverse = eigen
            .eigenvalues
            .map(|value| if value > least { 1.0 / value } else { 0.0 });
        let Q = &eigen.eigenvectors;
        Self {
            inverse: Q * DMatrix::from_diagonal(&inverse) * Q.transpose() * weighed.transpose(),
            F,
        }
    }

    /// How far along each motion the best fit of a residual lies.
    fn amounts(&self, residual: &DVector<f64>) -> DVector<f64> {
        &self.inverse * residual
    }

    /// Takes the free motions off columns of these rows.
    pub(super) fn apply(&self, columns: &mut DMatrix<f64>) {
        let along = &self.inverse * &*columns;
        *columns -= self.F * along;
    }
}

/// The steps along free motions to where predictions meet the marks of a case best; `None` where there is nothing to move, or no more.
///
/// `poses` are those of the observed parts, `motions` their twists along each motion: velocity of the origin, angular velocity, ground axes.
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
    let shorter = (LONGEST / amounts.amax()).min(1.0);
    (amounts.amax() > CLOSE).then(|| amounts.iter().map(|amount| amount * shorter).collect())
}
