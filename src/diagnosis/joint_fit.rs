//! Identification with random effects: fit of the model without causes. The noise of the marks is estimated from the marks themselves, the
//! variance components by maximum evidence.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::averaged::model_averaged_parameters;
use super::base_fit::fit_without_effects;
use super::diagnose::tolerances;
use super::diagnosis::{NoiseFound, Parameter, ToleranceFound};
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::lack_of_fit::lack_of_fit_tests;
use super::model_set::ModelSet;
use super::settings::NEGLIGIBLE_GAIN_NATS;
use admire_identify::global::gauss_newton::Prior;
use admire_identify::global::{Joint, Marginal};
use admire_identify::{Fit, FitTest, FitVerdict, LackOfFitTest, NOT_CONVERGED, Problem, Status};

/// Joint fit of stiffnesses and tolerances. It assumes that the model has no errors other than noise and tolerances.
#[derive(Clone, Debug)]
pub struct JointFit {
    /// Stiffnesses, with intervals that are marginalised over the tolerances.
    pub parameters: Vec<Parameter>,
    /// Estimated standard deviations of the tolerance groups, by name.
    pub tolerances: BTreeMap<String, ToleranceFound>,
    /// Declared and estimated noise of the marks.
    pub noise: NoiseFound,
    /// Chi-square of the residuals at the fitted variance components, then its degrees of freedom.
    pub chi_square: (f64, f64),
    /// Tests of structure in the residuals.
    pub structure: Vec<LackOfFitTest>,
    /// Number of equilibria solved.
    pub equilibria: usize,
    /// Fitted model from which the results are computed.
    fitted: Arc<FittedModel>,
}

/// Fits stiffnesses and tolerances to the cases that are not held out. Returns `None` if the built-in solver cannot solve the deck.
pub fn fit_with_random_effects(problem: &Problem<'_>) -> Option<JointFit> {
    let cases = problem.measurement.cases.iter();
    let mut subject =
        DiagnosisProblem::with_rig_errors(problem, cases.map(|case| case.held_out).collect());
    let found = fit_without_effects(&mut subject, None, Data::Fitted)?;
    let structure = lack_of_fit_tests(&subject, &found);
    let posterior = &found.posterior;
    let chi_square = (
        posterior.chi_square * subject.variance_factor(0..subject.rows.len()),
        posterior.count - posterior.effective,
    );
    let sizes = tolerances(&subject, &found);
    let noise = NoiseFound {
        declared: subject.noise.declared,
        estimated: subject.noise.estimated,
        dof: subject.tails.map(|tails| tails.nu),
    };
    let found = Arc::new(found);
    let only = ModelSet {
        causes: Vec::new(),
        ln_posterior: 0.0,
        fitted: Some(Arc::clone(&found)),
    };
    Some(JointFit {
        parameters: model_averaged_parameters(&subject, &[(only, 1.0)]),
        tolerances: sizes,
        noise,
        chi_square,
        structure,
        equilibria: subject.sweeps() * problem.measurement.cases.len(),
        fitted: found,
    })
}

impl JointFit {
    /// Returns the joint posterior of the first `sought` unknowns, with all tolerances marginalised at the fitted variance components.
    pub fn marginal(&self, sought: usize) -> Marginal {
        let fitted = &self.fitted;
        let prior = |unknown: &admire_identify::tolerance::Coefficient| Prior {
            mean: unknown.mean,
            sd: unknown.prior_sd(&fitted.sizes),
        };
        let starts = fitted.states.iter().zip(&fitted.thetas);
        Marginal::new(Joint {
            prepared: Arc::clone(&fitted.deck.prepared),
            unknowns: fitted.unknowns.clone(),
            layout: fitted.layout.clone(),
            x: fitted.x.clone(),
            priors: fitted.priors.iter().map(prior).collect(),
            sought,
            cases: (0..fitted.states.len()).collect(),
            starts: starts.map(|(s, t)| (s.clone(), t.clone())).collect(),
            whitening: Some(Arc::clone(&fitted.whitening)),
            weights: fitted.whitening.weights(&fitted.sizes.ln),
            jacobian: fitted.jacobian.clone(),
        })
    }

    /// Returns the covariance of the logarithms of the first `sought` stiffnesses, with all tolerances marginalised at the fitted variance
    /// components.
    pub fn covariance(&self, sought: usize) -> nalgebra::DMatrix<f64> {
        let all = &self.fitted.posterior.covariance;
        all.view((0, 0), (sought, sought)).into_owned()
    }

    /// Replaces the results of a stiffness-only identification by the results of this fit. The stiffness-only identification treats
    /// everything except the stiffnesses as exact.
    pub fn apply(self, fit: &mut Fit) {
        // The reported values come from this fit, so they are valid even if the stiffness-only fit did not converge.
        if !fit.converged && !fit.interrupted && self.fitted.posterior.gain < NEGLIGIBLE_GAIN_NATS {
            fit.converged = true;
            for remark in &mut fit.remarks {
                if remark == NOT_CONVERGED {
                    *remark = "The fit without tolerances did not converge; the fit with tolerances did, and its values are given."
                        .to_string();
                }
            }
        }
        for (own, found) in fit.parameters.iter_mut().zip(self.parameters) {
            own.value = found.value;
            // A number that a bound holds has no error of its own.
            let is_free = found.status != Status::Bound;
            own.std_error = is_free.then_some(found.std_error);
            own.interval95 = if is_free { found.interval95 } else { [None; 2] };
            own.tolerance_share = Some(found.tolerance_share);
            own.status = found.status;
        }
        if let (Some(declared), Some(estimated)) = (self.noise.declared, self.noise.estimated)
            && fit
                .fit_test
                .as_ref()
                .is_some_and(|test| test.verdict != FitVerdict::Noise)
        {
            fit.remarks.push(format!(
                "The study states a noise of {declared:.3} per mark coordinate; the marks of rigid parts show {estimated:.3} (in the deck's length unit), which is used."
            ));
        }
        let readings = fit
            .fit_test
            .take()
            .map_or_else(Vec::new, |test| test.readings);
        fit.fit_test = FitTest::new(self.chi_square.0, self.chi_square.1, readings);
        fit.structure = self.structure;
        fit.solver_runs += self.equilibria;
        fit.tolerances = self.tolerances;
        fit.noise = Some(self.noise);
    }
}
