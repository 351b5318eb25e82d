//! Prediction of held-out cases, which no fit of the predicting models used. Usually the causes are selected without these cases, too.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::base_fit::BaseFit;
use super::candidate_effect::CandidateEffect;
use super::cause::Cause;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::hold_out_test::{HeldOutTest, HoldOutPrediction, compared};
use super::jackknife::{Squares, rms_reduction};
use super::model_set::{ModelSet, probability};
use super::progress::Progress;
use super::select::select;
use crate::settings::NAMED_PROBABILITY;
use admire_session::backend::BackendError;

/// Predictions of the held-out cases by models fitted without them.
#[derive(Clone, Debug)]
pub struct HoldOutSelection {
    /// Fitted model without causes.
    none: Arc<FittedModel>,
    /// Fitted model with the selected causes.
    pub chosen: Arc<FittedModel>,
    /// Tests of the predictions of the held-out cases: by the model without causes, then by the selected model.
    pub tests: [HeldOutTest; 2],
    /// Predictions of the held-out cases: by the model without causes, then by the selected model.
    pub predicted: [HoldOutPrediction; 2],
    /// True if a separate search without the held-out cases selected the causes; false if they were selected with all cases.
    pub searched: bool,
    /// True if the search ended early: its budget was spent, or the user stopped it.
    cut_short: bool,
    /// Probabilities of the sets that the selection compared.
    models: Vec<(ModelSet, f64)>,
}

/// Result of the prediction of held-out cases, as written to `diagnosis.json`.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct HoldOut {
    /// True if a search without the held-out cases selected the causes; false if they were selected with all cases.
    pub searched: bool,
    /// Labels of the held-out cases.
    pub cases: Vec<String>,
    /// Names of the held-out curves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<String>,
    /// Causes of the selected model, each as `cause address`.
    pub causes: Vec<String>,
    /// Quantity to which the rms errors refer. `mark` means the errors of the marks per coordinate, in the deck's length unit. `noise` means the
    /// errors of all readings, in units of their noise.
    pub of: &'static str,
    /// Rms prediction error of the model without causes.
    pub rms_before: f64,
    /// Rms prediction error of the model with the selected causes.
    pub rms_after: f64,
    /// Decrease of the rms: `rms_before - rms_after`.
    pub gain: f64,
    /// Standard error of `gain`, by a jackknife over the cases. Whole cases are left out, because the readings of one case share their
    /// errors.
    pub gain_std_error: f64,
    /// P-value of the held-out readings under the prediction and its covariance.
    pub p_value: f64,
}

impl HoldOutSelection {
    /// Selects causes without the held-out cases, starting from the fit `base`. Returns `None` if no further selection may start, or if nothing
    /// can be predicted.
    pub(super) fn new(base: BaseFit<'_>, progress: &Progress) -> Option<Self> {
        if !progress.extend() {
            return None;
        }
        progress.begin("searching for causes without the cases held out");
        let BaseFit { subject, none } = base;
        let selected = select(&subject, &none, Data::Fitted);
        let models = [selected.none, selected.leading];
        let new = Self::of(&subject, models, (true, selected.cut_short))?;
        Some(Self {
            models: selected.models,
            ..new
        })
    }

    /// Predicts the held-out cases by two models, without and with causes. Their causes were selected with all cases; only their linear
    /// models are conditioned on the cases that are not held out.
    pub fn refit_only(
        subject: &DiagnosisProblem<'_>,
        models: [Arc<FittedModel>; 2],
    ) -> Option<Self> {
        Self::of(subject, models, (false, false))
    }

    /// Predicts the held-out cases by two models, without and with causes, conditioned on the cases that are not held out.
    fn of(
        subject: &DiagnosisProblem<'_>,
        models: [Arc<FittedModel>; 2],
        (searched, cut_short): (bool, bool),
    ) -> Option<Self> {
        let [before, after] = models.each_ref().map(|fitted| {
            let blind = HoldOutPrediction::new(subject, fitted)?;
            let test = blind.test(subject, fitted)?;
            Some((blind, test))
        });
        let (before, after) = (before?, after?);
        let [none, chosen] = models;
        Some(Self {
            none,
            chosen,
            tests: [before.1, after.1],
            predicted: [before.0, after.0],
            searched,
            cut_short,
            models: Vec::new(),
        })
    }

    /// Fits both models again by `refit`, with the same causes, and predicts the held-out cases again.
    ///
    /// # Errors
    /// Any error of `refit`.
    pub fn refitted(
        &self,
        subject: &DiagnosisProblem<'_>,
        mut refit: impl FnMut(&FittedModel) -> Result<FittedModel, BackendError>,
    ) -> Result<Self, BackendError> {
        let models = [refit(&self.none)?.into(), refit(&self.chosen)?.into()];
        let found = Self::of(subject, models, (self.searched, self.cut_short));
        Ok(found.unwrap_or_else(|| self.clone()))
    }

    /// Returns true if the selection without the held-out cases confirms a finding: at least one of its `causes`, given with their addresses, is
    /// more probable than not. Returns `None` if no selection was made without the held-out cases.
    pub(super) fn confirms(&self, causes: &[(Cause, &str)]) -> Option<bool> {
        let is_one = |h: &CandidateEffect| causes.contains(&(h.cause, h.address.as_str()));
        self.searched.then(|| {
            let here = probability(&self.models, |causes| causes.iter().any(is_one));
            here > NAMED_PROBABILITY
        })
    }

    /// Returns the selected model if its causes were selected without the held-out cases, otherwise `None`.
    pub fn selected_without_held_out(&self) -> Option<&Arc<FittedModel>> {
        self.searched.then_some(&self.chosen)
    }

    /// Returns true if the search ended early: its budget was spent, or the user stopped it.
    pub fn is_cut_short(&self) -> bool {
        self.cut_short
    }

    /// Returns the rms prediction errors over the held-out cases. Returns `None` if there are no rows to compare.
    pub fn hold_out(&self, subject: &DiagnosisProblem<'_>) -> Option<HoldOut> {
        let (of, unit) = subject.compared();
        let [before, after] = &self.predicted;
        let mut by_case: BTreeMap<usize, Squares> = BTreeMap::new();
        for k in compared(subject) {
            let sums = by_case.entry(subject.rows[k].case()).or_default();
            sums.before += (before.misfit[k] * unit).powi(2);
            sums.after += (after.misfit[k] * unit).powi(2);
            sums.count += 1.0;
        }
        let by_case: Vec<Squares> = by_case.into_values().collect();
        let fall = rms_reduction(&by_case)?;
        let cases = &subject.problem.measurement.cases;
        Some(HoldOut {
            searched: self.searched,
            cases: subject
                .cases_held_out()
                .map(|case| cases[case].label.clone())
                .collect(),
            curves: subject
                .problem
                .measurement
                .channels
                .iter()
                .filter(|channel| channel.held_out)
                .map(|channel| channel.name.clone())
                .collect(),
            causes: CandidateEffect::causes(&self.chosen.effects)
                .map(ToString::to_string)
                .collect(),
            of,
            rms_before: fall.before,
            rms_after: fall.after,
            gain: fall.before - fall.after,
            gain_std_error: fall.std_error,
            p_value: self.tests[1].p_value,
        })
    }
}
