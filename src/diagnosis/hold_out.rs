//! Prediction of cases that no fit used, usually with causes selected without them.

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
    /// Model without causes.
    none: Arc<FittedModel>,
    /// Selected model.
    pub chosen: Arc<FittedModel>,
    /// Tests of the held-out cases: without causes, and with the selected causes.
    pub tests: [HeldOutTest; 2],
    /// Predictions of the held-out cases: without causes, and with the selected causes.
    pub predicted: [HoldOutPrediction; 2],
    /// True if a separate search selected the causes; false if they were selected with these cases.
    pub searched: bool,
    /// True if the search ended early, by its budget or by request.
    cut_short: bool,
    /// All models that the search fitted.
    fits: Vec<Arc<FittedModel>>,
    /// Rig errors for which the search stopped early.
    gave_way: Option<RigErrors>,
}

/// Result on the held-out cases, for `diagnosis.json`.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct HoldOut {
    /// True if a search without these cases selected the causes; false if they were selected with these cases.
    pub searched: bool,
    /// Labels of the held-out cases.
    pub cases: Vec<String>,
    /// Names of the held-out curves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<String>,
    /// Causes of the selected model, as `cause address`.
    pub causes: Vec<String>,
    /// Measure of the error: `mark` for a mark coordinate in the deck's length unit, `noise` for all readings in units of their noise.
    pub of: &'static str,
    /// Rms prediction error without causes.
    pub rms_before: f64,
    /// Rms prediction error with the selected causes.
    pub rms_after: f64,
    /// Decrease of the rms: `rms_before - rms_after`.
    pub gain: f64,
    /// Standard error of the gain, by a jackknife over the cases; the readings of one case share their errors.
    pub gain_std_error: f64,
    /// P-value of the readings under the prediction and its covariance.
    pub p_value: f64,
}

impl HoldOutSelection {
    /// Selects causes without the held-out cases, starting from the fit `begun`. The search stops early in favour of the rig errors in
    /// `open`. `None` where no further search may start.
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

    /// Predicts the held-out cases by two models whose causes were selected with all cases. Their linear models are conditioned on the other
    /// cases.
    pub fn refit_only(
        subject: &DiagnosisProblem<'_>,
        models: [Arc<FittedModel>; 2],
    ) -> Option<Self> {
        Self::of(subject, models, (false, false))
    }

    /// Predicts the held-out cases by two models conditioned on the other cases.
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

    /// Refits both models with the same causes, and predicts the held-out cases again.
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

    /// Returns the models without and with causes.
    pub fn models(&self) -> [&Arc<FittedModel>; 2] {
        [&self.none, &self.chosen]
    }

    /// Returns all models that the search fitted.
    pub(super) fn fits(&self) -> &[Arc<FittedModel>] {
        &self.fits
    }

    /// Returns the rig errors for which the search stopped early.
    pub(super) fn gave_way(&self) -> Option<RigErrors> {
        self.gave_way
    }

    /// Returns the model selected and fitted without the held-out cases; `None` if it was selected with them.
    pub fn selected_without_held_out(&self) -> Option<&Arc<FittedModel>> {
        self.searched.then_some(&self.chosen)
    }

    /// Returns true if the search ended early, by its budget or by request.
    pub fn is_cut_short(&self) -> bool {
        self.cut_short
    }

    /// Returns the rms errors over the held-out cases; `None` where no rows are compared.
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
