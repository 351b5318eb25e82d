//! Comparison of held-out channels with the predictions of a model.

use nalgebra::DVector;

use super::observation::{Observations, Row};
use super::problem::GlobalProblem;
use crate::{CurveHeldOut, Problem};
use admire_study::Channel;

/// Returns the rms prediction errors of the held-out channels for two sets of unknowns: before and after the identification. The result is
/// empty if a case has no equilibrium.
pub(super) fn held_curves(
    problem: &Problem<'_>,
    global: &mut GlobalProblem<'_>,
    models: [&Vec<f64>; 2],
) -> Vec<CurveHeldOut> {
    let measurement = problem.measurement;
    if !measurement.channels.iter().any(|channel| channel.held_out) {
        return Vec::new();
    }
    let cases: Vec<usize> = (0..measurement.cases.len()).collect();
    let mut observations = Observations::new(measurement, problem.model, &cases);
    let is_held = |channel: usize| measurement.channels[channel].held_out;
    observations
        .rows
        .retain(|row| matches!(*row, Row::Channel { channel, .. } if is_held(channel)));
    let residuals = models.map(|x| {
        let numbers = global.unknowns.numbers(&global.deck, x);
        let prediction = global.predictor.predict(&numbers, None);
        let found = observations.evaluate(&prediction, &global.layout, x, 0)?;
        Some(found.residual)
    });
    let [Some(before), Some(after)] = residuals else {
        return Vec::new();
    };
    let of = |(channel, info): (usize, &Channel)| {
        let rows = observations.rows.iter().enumerate();
        let own = rows
            .filter(|(_, row)| matches!(**row, Row::Channel { channel: k, .. } if k == channel));
        let own: Vec<usize> = own.map(|(at, _)| at).collect();
        let rms = |residual: &DVector<f64>| {
            let squares: f64 = own.iter().map(|at| residual[*at].powi(2)).sum();
            (squares / own.len() as f64).sqrt() * info.sigma
        };
        (!own.is_empty()).then(|| CurveHeldOut {
            name: info.name.clone(),
            unit: info.unit.clone(),
            count: own.len(),
            rms_before: rms(&before),
            rms_after: rms(&after),
        })
    };
    measurement
        .channels
        .iter()
        .enumerate()
        .filter_map(of)
        .collect()
}
