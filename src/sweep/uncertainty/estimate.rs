use nalgebra::{Cholesky, DMatrix, DVector};

use admire_identify::global::confidence::covariance;
use admire_identify::global::gauss_newton::{Minimum, Prior, Tolerances};
use admire_identify::global::{Marginal, MarginalProblem, profile_interval};
use admire_identify::{IdentifyError, Problem, Unknown};

/// Fit to be repeated: the estimate of the unknowns and their covariance.
pub(crate) struct Estimate<'a> {
    /// Identification problem of the study.
    pub problem: &'a Problem<'a>,
    /// Problem in the unknowns, with all tolerances marginalised.
    pub marginal: &'a Marginal,
    /// Minimum that the fit found.
    pub minimum: Minimum,
    /// Covariance of the unknowns at the minimum.
    pub covariance: DMatrix<f64>,
    /// Lower Cholesky factor of the covariance.
    pub root: DMatrix<f64>,
}

impl<'a> Estimate<'a> {
    /// Minimises the problem with all tolerances marginalised. Returns `None` if the fit finds no minimum.
    ///
    /// # Errors
    /// When a load drives something that the solver cannot change.
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

    /// Converts coordinates of the unknowns to values.
    pub(crate) fn values(&self, x: &[f64]) -> Vec<f64> {
        let unknowns = self.problem.unknowns.iter().zip(x);
        unknowns.map(|(unknown, x)| unknown.value(*x)).collect()
    }

    /// Converts values of the unknowns to coordinates.
    pub(crate) fn coordinates(&self, values: &[f64]) -> Vec<f64> {
        let unknowns = self.problem.unknowns.iter().zip(values);
        unknowns
            .map(|(unknown, value)| unknown.coordinate(*value))
            .collect()
    }

    /// Returns a fresh fit of the same problem, independent of the state of earlier fits.
    ///
    /// # Errors
    /// When a load drives something that the solver cannot change.
    pub(crate) fn again(&self) -> Result<MarginalProblem<'a>, IdentifyError> {
        self.marginal.problem(self.problem)
    }

    /// Computes the profile-likelihood interval of each parameter. The interval is of the parameter itself, not of its logarithm.
    ///
    /// # Errors
    /// When a load drives something that the solver cannot change.
    pub(crate) fn profiles(&self) -> Result<Vec<[Option<f64>; 2]>, IdentifyError> {
        let priors = self.marginal.priors();
        let (scale, held) = (self.marginal.scale(), held(priors));
        let mut fit = self.again()?;
        let of = |(k, unknown): (usize, &Unknown)| {
            let sides = profile_interval(
                &mut fit,
                &self.minimum,
                k,
                &self.covariance,
                priors,
                &scale,
                &held,
            );
            sides.map(|side| side.map(|x| unknown.value(x)))
        };
        let unknowns = self.problem.unknowns.iter().enumerate();
        Ok(unknowns.map(of).collect())
    }

    /// Returns the leverage of each reading: the derivative of its prediction with respect to the reading itself.
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
