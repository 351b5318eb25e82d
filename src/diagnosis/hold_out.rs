//! Cases that no fit saw, and as a rule the choice of causes neither.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::folds::{Blind, HeldOutTest, compared};
use super::hypothesis::Hypothesis;
use super::jackknife::{Squares, rms_reduction};
use super::progress::Progress;
use super::rig_errors::RigErrors;
use super::search::Search;
use super::sought::{Begun, Sought};
use admire_session::backend::BackendError;

/// What models say of the cases held out that were fitted without them.
#[derive(Clone, Debug)]
pub struct HoldOutSelection {
    /// The model without any cause.
    none: Arc<FittedModel>,
    /// The model that it chose.
    pub chosen: Arc<FittedModel>,
    /// The cases held out as the model was and as it was extended.
    pub tests: [HeldOutTest; 2],
    /// The predictions behind that.
    pub predicted: [Blind; 2],
    /// True if a search of its own chose the causes; false if they were chosen with these cases.
    pub searched: bool,
    /// The search was asked to end before it did.
    cut_short: bool,
    /// All models that it fitted.
    fits: Vec<Arc<FittedModel>>,
    /// Errors of the rig that its search gave way to before its end.
    gave_way: Option<RigErrors>,
}

/// What it says, for `diagnosis.json`.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct HoldOut {
    /// True if a search that did not see these cases chose the causes; false if they were chosen with them.
    pub searched: bool,
    /// Labels of the cases.
    pub cases: Vec<String>,
    /// Names of the curves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<String>,
    /// Causes that were chosen without them, `cause address`.
    pub causes: Vec<String>,
    /// `mark` if the rms is that of a mark coordinate in the deck's length unit, `noise` if of all readings in units of their noise.
    pub of: &'static str,
    /// Without any cause.
    pub rms_before: f64,
    /// With the causes that were chosen.
    pub rms_after: f64,
    /// By how much it falls.
    pub gain: f64,
    /// Standard error of that: the cases are left out one after the other (jackknife); the readings of one case share their errors.
    pub gain_std_error: f64,
    /// Whether the readings agree with the prediction and its own covariance.
    pub p_value: f64,
}

impl HoldOutSelection {
    /// Of a model fitted without the cases held out, its search giving way to errors of the rig in `open`; `None` where it may not begin.
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

    /// Of models that were chosen with these cases, refitted without them in their linear models.
    pub fn refit_only(
        subject: &DiagnosisProblem<'_>,
        models: [Arc<FittedModel>; 2],
    ) -> Option<Self> {
        Self::of(subject, models, (false, false))
    }

    /// Predictions of two models that have not seen the cases.
    fn of(
        subject: &DiagnosisProblem<'_>,
        models: [Arc<FittedModel>; 2],
        (searched, cut_short): (bool, bool),
    ) -> Option<Self> {
        let [before, after] = models.each_ref().map(|fitted| {
            let blind = Blind::new(subject, fitted)?;
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

    /// The same causes with other numbers.
    ///
    /// # Errors
    /// As `refit` has them.
    pub fn refitted(
        &self,
        subject: &DiagnosisProblem<'_>,
        mut refit: impl FnMut(&FittedModel) -> Result<FittedModel, BackendError>,
    ) -> Result<Self, BackendError> {
        let models = [refit(&self.none)?.into(), refit(&self.chosen)?.into()];
        let found = Self::of(subject, models, (self.searched, self.cut_short));
        Ok(found.unwrap_or_else(|| self.clone()))
    }

    /// The models without and with causes behind it.
    pub fn models(&self) -> [&Arc<FittedModel>; 2] {
        [&self.none, &self.chosen]
    }

    /// All models that its search fitted.
    pub(super) fn fits(&self) -> &[Arc<FittedModel>] {
        &self.fits
    }

    /// Errors of the rig that its search gave way to before its end.
    pub(super) fn gave_way(&self) -> Option<RigErrors> {
        self.gave_way
    }

    /// The model that was chosen and fitted without these cases; `None` if it was only refitted.
    pub fn selected_without_held_out(&self) -> Option<&Arc<FittedModel>> {
        self.searched.then_some(&self.chosen)
    }

    /// True if the search was asked to end before it did.
    pub fn is_cut_short(&self) -> bool {
        self.cut_short
    }

    /// Rms over the cases held out; `None` where there is nothing to compare.
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
            causes: Hypothesis::causes(&self.chosen.effects)
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
