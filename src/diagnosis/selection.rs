//! Selection of effects for a study: from all cases, and from those that are not held out.

use std::sync::Arc;

use super::base_fit::{BaseFit, explained_by_tails, fit_without_effects};
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::refit;
use super::hold_out::HoldOutSelection;
use super::lack_of_fit::{is_structured, lack_of_fit_tests};
use super::model_set::Selected;
use super::progress::Progress;
use super::select::select;
use admire_identify::LackOfFitTest;

/// Selection from all cases, and selection from those that are not held out.
pub(super) struct Selection<'a> {
    /// Study, with weighted readings.
    pub subject: DiagnosisProblem<'a>,
    /// Selection from all cases.
    pub selected: Selected,
    /// Tests of structure in the residuals of the leading fit.
    pub tested: Vec<LackOfFitTest>,
    /// Selection from the cases that are not held out, and its predictions. `None` if it was not made.
    pub unseen: Option<HoldOutSelection>,
}

impl<'a> Selection<'a> {
    /// Selects the effects. The selection without the held-out cases is made if `is_blind` and if there is anything to confirm. Returns `None` if
    /// the deck cannot be solved.
    pub(super) fn new(
        mut subject: DiagnosisProblem<'a>,
        is_blind: bool,
        progress: &Progress,
    ) -> Option<Self> {
        progress.begin("fitting the model as it is");
        let base = BaseFit::without_held_out(&subject);
        let known = base.as_ref().map(|base| &*base.none);
        let none = Arc::new(fit_without_effects(&mut subject, known, Data::All)?);
        progress.begin("searching for causes");
        let mut selected = select(&subject, &none, Data::All);
        progress.begin("testing the remaining residuals");
        let mut tested = lack_of_fit_tests(&subject, &selected.leading);
        // Before the causes were known, other structure may have hidden heavy tails.
        if is_structured(&tested)
            && !selected.leading.effects.is_empty()
            && !subject.budget_exhausted()
            && let Some((tailed, _)) = explained_by_tails(&subject, &selected.leading, Data::All)
            && let Some(none) = refit(&tailed, &none, Data::All)
        {
            subject = tailed;
            selected = select(&subject, &Arc::new(none), Data::All);
            tested = lack_of_fit_tests(&subject, &selected.leading);
        }
        let is_unsure = is_structured(&tested) || !selected.leading.effects.is_empty();
        let unseen = base
            .filter(|_| is_blind && is_unsure)
            .and_then(|base| HoldOutSelection::new(base, progress));
        Some(Self {
            subject,
            selected,
            tested,
            unseen,
        })
    }
}

/// Fits the study without effects to all cases, and selects effects. Returns `None` if the deck cannot be solved.
pub fn selected(subject: &mut DiagnosisProblem<'_>, progress: &Progress) -> Option<Selected> {
    progress.begin("fitting the model as it is");
    let none = Arc::new(fit_without_effects(subject, None, Data::All)?);
    progress.begin("searching for causes");
    Some(select(subject, &none, Data::All))
}
