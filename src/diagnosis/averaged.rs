//! Stiffnesses averaged over the models that remain.

use nalgebra::DVector;

use super::diagnosis::Parameter;
use super::diagnosis_problem::DiagnosisProblem;
use super::visited::Visited;
use admire_identify::Status;
use admire_identify::global::UNIDENTIFIABLE;

/// Two-sided 95 percent of a Gaussian.
const Z95: f64 = 1.959_963_985;
/// Beyond this half width, as a part of the estimate, only the upper side is stated.
const WIDE: f64 = 0.8;

/// Mean and variance of the mixture over fitted models, each number with its interval on the scale of the stiffness itself: there the
/// posterior is closer to a Gaussian than in logarithms where a number is poorly known.
pub(super) fn model_averaged_parameters(
    subject: &DiagnosisProblem<'_>,
    models: &[(Visited, f64)],
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
        // Without tolerances: members known, stiffnesses and causes not.
        let kept: Vec<usize> = (0..model.x.len())
            .filter(|k| model.is_of_the_model(*k))
            .collect();
        let without = if probability / sum > 0.01 {
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
    let unknowns = subject.problem.unknowns.iter().enumerate();
    unknowns
        .map(|(k, unknown)| {
            let sd = (square[k] - mean[k] * mean[k]).max(0.0).sqrt();
            let value: f64 = libm::exp(mean[k]);
            let half = Z95 * sd;
            let low = (half < WIDE).then_some(value * (1.0 - half));
            Parameter {
                address: unknown.address.to_string(),
                unit: unknown.unit.clone(),
                initial: unknown.initial,
                value,
                std_error: value * sd,
                interval95: [low, Some(value * (1.0 + half))],
                tolerance_share: if sd > 0.0 {
                    (1.0 - exact[k] / (sd * sd)).clamp(0.0, 1.0)
                } else {
                    0.0
                },
                status: if sd > UNIDENTIFIABLE {
                    Status::Unidentifiable
                } else {
                    Status::Identified
                },
            }
        })
        .collect()
}
