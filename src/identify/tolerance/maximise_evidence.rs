//! Maximisation of the evidence over the log standard deviations by the BFGS method with bounds.

use nalgebra::{DMatrix, DVector};

use super::group::VarianceComponents;
use crate::settings::{EVIDENCE_MAX_EVALUATIONS, EVIDENCE_MAX_LN_STEP, EVIDENCE_TOLERANCE_NATS};

/// Returns the variance components of maximum evidence within the bounds of their priors. The search starts from `start`.
///
/// `evidence` returns the log evidence, its gradient with respect to the log standard deviations, and the Fisher information of each component.
/// The information is needed only at the first call, where its reciprocal is the first inverse Hessian. Later, the inverse Hessian is updated
/// by the BFGS formula. A component at a bound stays there while the gradient points outwards.
pub(crate) fn climb(
    start: &VarianceComponents,
    mut evidence: impl FnMut(&VarianceComponents, bool) -> Option<(f64, Vec<f64>, Vec<f64>)>,
) -> VarianceComponents {
    let bounds: Vec<(f64, f64)> = start.each().map(|size| size.bounds).collect();
    let clamp = |ln: &mut [f64]| {
        for (ln, (low, high)) in ln.iter_mut().zip(&bounds) {
            *ln = ln.clamp(*low, *high);
        }
    };
    let mut ln = start.ln.clone();
    clamp(&mut ln);
    let n = ln.len();
    let mut here = start.at(ln);
    let Some((mut value, gradient, information)) = evidence(&here, true) else {
        return start.clone();
    };
    let mut gradient = DVector::from_vec(gradient);
    let first = || {
        DMatrix::from_diagonal(&DVector::from_iterator(
            n,
            information.iter().map(|i| 1.0 / i),
        ))
    };
    let mut inverse = first();
    let mut evaluations = 1;
    let mut stuck = false;
    while evaluations < EVIDENCE_MAX_EVALUATIONS {
        let free: Vec<bool> = (0..n)
            .map(|k| {
                let low = here.ln[k] <= bounds[k].0 && gradient[k] < 0.0;
                let high = here.ln[k] >= bounds[k].1 && gradient[k] > 0.0;
                !(low || high)
            })
            .collect();
        let mut uphill = gradient.clone();
        for k in (0..n).filter(|k| !free[*k]) {
            uphill[k] = 0.0;
        }
        let mut step = &inverse * &uphill;
        for k in (0..n).filter(|k| !free[*k]) {
            step[k] = 0.0;
        }
        if step.dot(&uphill) <= 0.0 {
            inverse = first();
            step = &inverse * &uphill;
        }
        let longest = step.amax();
        if longest > EVIDENCE_MAX_LN_STEP {
            step *= EVIDENCE_MAX_LN_STEP / longest;
        }
        let promised = step.dot(&uphill);
        if promised < EVIDENCE_TOLERANCE_NATS {
            break;
        }
        let mut scale = 1.0;
        let mut next = None;
        while evaluations < EVIDENCE_MAX_EVALUATIONS && scale > 1e-3 {
            let mut ln: Vec<f64> = here
                .ln
                .iter()
                .zip(step.iter())
                .map(|(ln, s)| ln + scale * s)
                .collect();
            clamp(&mut ln);
            let there = start.at(ln);
            evaluations += 1;
            match evidence(&there, false) {
                Some((better, gradient, _)) if better > value => {
                    next = Some((there, better, DVector::from_vec(gradient)));
                    break;
                }
                _ => scale *= 0.3,
            }
        }
        let Some((there, better, slope)) = next else {
            if stuck {
                break;
            }
            stuck = true;
            inverse = first();
            continue;
        };
        stuck = false;
        let moved = DVector::from_iterator(n, there.ln.iter().zip(&here.ln).map(|(a, b)| a - b));
        let bent = &gradient - &slope;
        let curve = moved.dot(&bent);
        if curve > 1e-9 * moved.norm() * bent.norm() {
            let rho = 1.0 / curve;
            let unit = DMatrix::identity(n, n);
            let left = &unit - &moved * bent.transpose() * rho;
            inverse = &left * &inverse * left.transpose() + &moved * moved.transpose() * rho;
        }
        let gained = better - value;
        (here, value, gradient) = (there, better, slope);
        if gained < EVIDENCE_TOLERANCE_NATS {
            break;
        }
    }
    here
}
