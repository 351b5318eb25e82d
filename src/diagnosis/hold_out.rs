//! Prediction of held-out cases, which no fit of the predicting models used. Usually the causes are selected without these cases, too.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::candidate_effect::CandidateEffect;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::hold_out_test::{HeldOutTest, HoldOutPrediction, compared};
use super::jackknife::{Squares, rms_reduction};
use super::progress::Progress;
use super::rig_errors::RigErrors;
use super::search::Search;
use super::sought::{Begun, Sought};
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
    /// All models that the search fitted.
    fits: Vec<Arc<FittedModel>>,
    /// Rig errors that made the search stop early, because they explain the readings much better than any cause. `None` if no rig errors did
    /// so.
    gave_way: Option<RigErrors>,
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
    /// Selects causes without the held-out cases, starting from the fit `begun`. The search stops early if the rig errors in `open` explain
    /// the readings much better than any cause. Returns `None` if no further search may start, or if nothing can be predicted.
    pub(super) fn new(begun: Begun<'_>, open: &[RigErrors], progress: &Progress) -> Option<Self> {
        if !progress.extend() {
            return None;
        }
        progress.begin("searching causes without the cases held out");
        let Begun { subject, none } = begun;
        let search = Search::new(&subject, none, Data::Fitted).giving_way_to(open);
        let sought = Sought::new(search.ended());
        let found = sought.found;
        let models = [found.none, sought.leading];
        let new = Self::of(&subject, models, (true, found.cut_short))?;
        let fits = found.models.into_iter();
        Some(Self {
            gave_way: found.gave_way.map(|way| way.errors),
            fits: fits.filter_map(|(model, _)| model.fitted).collect(),
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
            fits: Vec::new(),
            gave_way: None,
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

    /// Returns the model without causes and the model with the selected causes.
    pub fn models(&self) -> [&Arc<FittedModel>; 2] {
        [&self.none, &self.chosen]
    }

    /// Returns all models that the search fitted.
    pub(super) fn fits(&self) -> &[Arc<FittedModel>] {
        &self.fits
    }

    /// Returns the rig errors that made the search stop early, if any did so.
    pub(super) fn gave_way(&self) -> Option<RigErrors> {
        self.gave_way
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
