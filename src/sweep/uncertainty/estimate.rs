use nalgebra::{Cholesky, DMatrix, DVector};

use admire_identify::global::confidence::covariance;
use admire_identify::global::gauss_newton::{Minimum, Prior, Tolerances};
use admire_identify::global::{Marginal, MarginalProblem, profile_interval};
use admire_identify::{IdentifyError, Problem};

/// The fit that is done again: the sought numbers at their best, and how well they are known there.
pub(crate) struct Estimate<'a> {
    /// The study.
    pub problem: &'a Problem<'a>,
    /// The sought numbers with all else marginalised.
    pub marginal: &'a Marginal,
    /// Where they are best.
    pub minimum: Minimum,
    /// Their covariance there.
    pub covariance: DMatrix<f64>,
    /// Its lower triangular root.
    pub root: DMatrix<f64>,
}

impl<'a> Estimate<'a> {
    /// Ends the fit with all else marginalised. `None` where it has no end.
    ///
    /// # Errors
    /// A load that drives nothing the solver can change.
    pub(crate) fn new(
        problem: &'a Problem<'a>,
        marginal: &'a Marginal,
    ) -> Result<Option<Self>, IdentifyError> {
        let mut fit = marginal.problem(problem)?;
        let found = fit.minimise(&marginal.start(), marginal.priors(), Tolerances::default());
        Ok(found.and_then(|minimum| {
            let covariance = covariance(&minimum, &held(marginal.priors()));
            let root = Cholesky::new(covariance.clone())?.unpack();
            Some(Self {
                problem,
                marginal,
                minimum,
                covariance,
                root,
            })
        }))
    }

    /// The fit once more, knowing nothing of others.
    ///
    /// # Errors
    /// A load that drives nothing the solver can change.
    pub(crate) fn again(&self) -> Result<MarginalProblem<'a>, IdentifyError> {
        self.marginal.problem(self.problem)
    }

    /// Intervals by profile likelihood, of the numbers themselves.
    ///
    /// # Errors
    /// A load that drives nothing the solver can change.
    pub(crate) fn profiles(&self) -> Result<Vec<[Option<f64>; 2]>, IdentifyError> {
        let priors = self.marginal.priors();
        let (scale, held) = (self.marginal.scale(), held(priors));
        let mut fit = self.again()?;
        let of = |k: usize| {
            let place = (k, &self.covariance);
            let sides = profile_interval(&mut fit, &self.minimum, place, priors, &scale, &held);
            sides.map(|side| side.map(libm::exp))
        };
        Ok((0..self.marginal.len()).map(of).collect())
    }

    /// The share of each reading in its own prediction.
    pub(crate) fn leverages(&self) -> DVector<f64> {
        let jacobian = &self.minimum.evaluation.jacobian;
        let across = jacobian * &self.root;
        DVector::from_iterator(
            across.nrows(),
            across.row_iter().map(|row| row.norm_squared()),
        )
    }
}

fn held(priors: &[Prior]) -> Vec<bool> {
    priors.iter().map(|prior| prior.sd <= 0.0).collect()
}
