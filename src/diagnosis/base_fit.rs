//! Fit without effects, from which every selection starts. Its residuals determine the weights of the readings.

use std::sync::Arc;

use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::{FittedModel, fit, refit};
use super::lack_of_fit::{is_of_far_readings, is_structured, lack_of_fit_tests};
use crate::settings::OUTLIER_ROUNDS;

/// Fit without effects, and the study with its readings weighted by the residuals of that fit.
pub(super) struct BaseFit<'a> {
    /// Study, with the readings weighted by the residuals of the fit.
    pub subject: DiagnosisProblem<'a>,
    pub none: Arc<FittedModel>,
}

impl<'a> BaseFit<'a> {
    /// Fits the cases that are not held out. Returns `None` if no case is held out, or if the deck cannot be solved.
    pub(super) fn without_held_out(subject: &DiagnosisProblem<'a>) -> Option<Self> {
        if !subject.holds_out() {
            return None;
        }
        let mut subject = subject.clone();
        let none = fit_without_effects(&mut subject, None, Data::Fitted)?;
        Some(Self {
            subject,
            none: Arc::new(none),
        })
    }
}

/// Fits the model without effects, and weights the readings by its residuals. The fit starts from `known`, a fit to some of the cases, if there is
/// one. Returns `None` if the deck cannot be solved.
pub fn fit_without_effects(
    subject: &mut DiagnosisProblem<'_>,
    known: Option<&FittedModel>,
    data: Data,
) -> Option<FittedModel> {
    let begun = known.and_then(|known| refit(subject, known, data));
    let mut none = match begun {
        Some(begun) => begun,
        None => fit(subject, &[], None, data)?,
    };
    // A wrong reading can mask other wrong readings until it is left out.
    for _ in 0..OUTLIER_ROUNDS {
        if subject.flag_three_mark_outliers(&none.residual) {
            subject.set_row_weights(None);
            none = refit(subject, &none, data)?;
        }
        let judged = subject.resolve_flagged(&none.residual);
        subject.set_row_weights(Some(&none.residual));
        if judged || subject.is_reweighed() {
            none = refit(subject, &none, data)?;
        }
        if !judged {
            break;
        }
    }
    if let Some((tailed, again)) = explained_by_tails(subject, &none, data) {
        *subject = tailed;
        return Some(again);
    }
    Some(none)
}

/// Returns the study with Student-t weights, and a fit with them, if heavy tails explain all structure that the fit leaves. Readings far from a
/// wrong model may look like heavy tails, so no other structure may be left.
pub(super) fn explained_by_tails<'a>(
    subject: &DiagnosisProblem<'a>,
    fitted: &FittedModel,
    data: Data,
) -> Option<(DiagnosisProblem<'a>, FittedModel)> {
    let tailed = tailed(subject, fitted)?;
    let again = refit(&tailed, fitted, data)?;
    (!is_structured(&lack_of_fit_tests(&tailed, &again))).then_some((tailed, again))
}

/// Returns the study with Student-t weights, if heavy tails may explain the structure that a fit leaves.
fn tailed<'a>(
    subject: &DiagnosisProblem<'a>,
    fitted: &FittedModel,
) -> Option<DiagnosisProblem<'a>> {
    if subject.tails.is_some() || !subject.has_few_far(&fitted.residual) {
        return None;
    }
    let left = lack_of_fit_tests(subject, fitted);
    if !is_structured(&left) {
        return None;
    }
    subject.with_tails(&fitted.residual, is_of_far_readings(&left))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::progress::Progress;
    use admire_identify::{LoadedStudy, Problem};

    /// Returns the shipped axle study, in which nothing is wrong.
    pub(in super::super) fn shipped_axle() -> LoadedStudy {
        let folder =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpus/pseudo-mcpherson");
        LoadedStudy::read(&folder).value.expect("a shipped study")
    }

    /// Returns the problem of a study with no case held out, and its fit without effects.
    pub(in super::super) fn axle_problem<'a>(
        problem: &'a Problem<'a>,
    ) -> (DiagnosisProblem<'a>, FittedModel) {
        let held_out = vec![false; problem.measurement.cases.len()];
        let mut subject = DiagnosisProblem::with_rig_errors(problem, held_out);
        let none = fit_without_effects(&mut subject, None, Data::All).expect("it can be solved");
        (subject, none)
    }

    /// Checks that a fit to all cases, started from a fit to some of them, reaches the same result in fewer sweeps.
    #[test]
    fn a_fit_to_all_cases_begins_where_that_without_some_ended() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let held_out = (0..problem.measurement.cases.len()).map(|k| k % 4 == 3);
        let unfitted = DiagnosisProblem::with_rig_errors(&problem, held_out.collect());
        let begun = BaseFit::without_held_out(&unfitted).expect("cases are held out");
        let to_all = |known: Option<&FittedModel>| {
            let mut subject = unfitted.clone();
            let progress = Progress::default();
            subject.with_progress(&progress);
            let fitted =
                fit_without_effects(&mut subject, known, Data::All).expect("it can be solved");
            (fitted.ln_posterior(), progress.sweeps())
        };
        let (cold, far) = to_all(None);
        let (warm, near) = to_all(Some(&begun.none));
        assert!((cold - warm).abs() < 0.1, "{cold} {warm}");
        assert!(near < far, "{near} {far}");
    }
}
