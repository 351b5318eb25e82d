//! Stiffnesses averaged over the probable models (Bayesian model averaging).

use nalgebra::DVector;

use super::diagnosis::Parameter;
use super::diagnosis_problem::DiagnosisProblem;
use super::model_set::ModelSet;
use crate::settings::{AVERAGED_MIN_PROBABILITY, ONE_SIDED_HALF_WIDTH};
use admire_identify::Status;
use admire_identify::settings::{NORMAL_QUANTILE_975, UNIDENTIFIABLE_LN_SD};

/// Returns each unknown averaged over the fitted models, weighted by the probabilities of the models. Mean and variance are computed for
/// the coordinate of the unknown: the logarithm of a stiffness or factor, or the change itself. The 95 percent interval of a stiffness is
/// symmetric in the stiffness, not in its logarithm. The posterior of a poorly determined stiffness is closer to a Gaussian in the
/// stiffness.
pub(super) fn model_averaged_parameters(
    subject: &DiagnosisProblem<'_>,
    models: &[(ModelSet, f64)],
) -> Vec<Parameter> {
    let fitted: Vec<_> = models
        .iter()
        .filter_map(|(model, probability)| Some((model.fitted.as_ref()?, *probability)))
        .collect();
    let sum: f64 = fitted.iter().map(|(_, probability)| probability).sum();
    let count = subject.problem.unknowns.len();
    let zero = || DVector::<f64>::zeros(count);
    let (mut mean, mut square, mut exact) = (zero(), zero(), zero());
    for (model, probability) in &fitted {
        let weight = probability / sum;
        // Variance without tolerances: the random effects are held fixed, while stiffnesses and parameters of causes remain uncertain.
        let kept: Vec<usize> = (0..model.x.len())
            .filter(|k| model.is_of_the_model(*k))
            .collect();
        let without = if probability / sum > AVERAGED_MIN_PROBABILITY {
            model.posterior.without(&kept)
        } else {
            Vec::new()
        };
        for k in 0..count {
            let variance = model.posterior.covariance[(k, k)];
            mean[k] += weight * model.x[k];
            square[k] += weight * (variance + model.x[k] * model.x[k]);
            exact[k] += weight * without.get(k).copied().unwrap_or(variance);
        }
    }
    let prior = |k: usize| {
        let any = fitted.first();
        any.map_or(0.0, |(model, _)| model.unknowns.list()[k].mean)
    };
    let unknowns = subject.problem.unknowns.iter().enumerate();
    unknowns
        .map(|(k, unknown)| {
            let sd = (square[k] - mean[k] * mean[k]).max(0.0).sqrt();
            let (value, rate) = (unknown.value(mean[k]), unknown.value_rate(mean[k]));
            let half = NORMAL_QUANTILE_975 * sd;
            let is_closed = half < ONE_SIDED_HALF_WIDTH || !unknown.is_logarithm();
            let low = is_closed.then_some(value - rate * half);
            Parameter {
                address: unknown.address.to_string(),
                form: unknown.form(),
                unit: unknown.unit.clone(),
                initial: unknown.initial,
                value,
                std_error: rate * sd,
                interval95: [low, Some(value + rate * half)],
                tolerance_share: if sd > 0.0 {
                    (1.0 - exact[k] / (sd * sd)).clamp(0.0, 1.0)
                } else {
                    0.0
                },
                status: if unknown.is_at_bound(mean[k], prior(k)) {
                    Status::Bound
                } else if sd > UNIDENTIFIABLE_LN_SD {
                    Status::Unidentifiable
                } else {
                    Status::Identified
                },
            }
        })
        .collect()
}
