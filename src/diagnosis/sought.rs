//! The whole way from readings to the causes that act: on all cases, or without those held out.

use std::sync::Arc;

use super::candidate_effect::CandidateEffect;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::{FittedModel, fit, refit};
use super::lack_of_fit::{is_of_far_readings, is_structured, lack_of_fit_tests};
use super::progress::Progress;
use super::search::{Search, resume};
use super::visited::Found;

/// A place is named from this probability on.
pub(super) const NAMED: f64 = 0.5;

/// Readings under suspicion are judged so often at most.
const JUDGED: usize = 3;

/// What a search ended with.
#[derive(Debug)]
pub struct Sought {
    /// All models that were looked at.
    pub found: Found,
    /// The model that is reported.
    pub leading: Arc<FittedModel>,
}

/// A model without any cause, where a search begins.
pub(super) struct Begun<'a> {
    /// The study, its readings weighed by what the model leaves.
    pub subject: DiagnosisProblem<'a>,
    /// The model.
    pub none: Arc<FittedModel>,
}

impl<'a> Begun<'a> {
    /// Fitted without the cases held out; `None` where there are none, or where the deck cannot be solved.
    pub(super) fn without_held_out(subject: &DiagnosisProblem<'a>) -> Option<Self> {
        if !subject.holds_out() {
            return None;
        }
        let mut subject = subject.clone();
        let none = as_it_is(&mut subject, None, Data::Fitted)?;
        Some(Self {
            subject,
            none: Arc::new(none),
        })
    }
}

/// Fits the model without any cause, from where a fit of it to some of the cases ended if one is known, and weighs the readings by what
/// it leaves. `None` where the deck cannot be solved.
pub fn as_it_is(
    subject: &mut DiagnosisProblem<'_>,
    known: Option<&FittedModel>,
    data: Data,
) -> Option<FittedModel> {
    let begun = known.and_then(|known| refit(subject, known, data));
    let mut none = match begun {
        Some(begun) => begun,
        None => fit(subject, &[], None, data)?,
    };
    // What is wrong hides other wrong readings until it is left out.
    for _ in 0..JUDGED {
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

/// The readings weighed by tails, and a fit to them, where they explain what it leaves. Far readings of a model that is wrong may look
/// like tails: they have to be all that there is.
fn explained_by_tails<'a>(
    subject: &DiagnosisProblem<'a>,
    fitted: &FittedModel,
    data: Data,
) -> Option<(DiagnosisProblem<'a>, FittedModel)> {
    let tailed = tailed(subject, fitted)?;
    let again = refit(&tailed, fitted, data)?;
    (!is_structured(&lack_of_fit_tests(&tailed, &again))).then_some((tailed, again))
}

/// The readings weighed by tails, where that may explain what a fit leaves.
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

/// Fits the model as it is to all cases, and searches causes. `None` where the deck cannot be solved.
pub fn seek(subject: &mut DiagnosisProblem<'_>, progress: &Progress) -> Option<Sought> {
    progress.begin("fitting the model as it is");
    let none = as_it_is(subject, None, Data::All)?;
    progress.begin("searching causes");
    let search = Search::new(subject, Arc::new(none), Data::All);
    Some(Sought::new(search.ended()))
}

impl Sought {
    /// Searches all cases again where tails of the readings explain what the leading model leaves: before its causes were known far
    /// readings were not all that there was. False where they do not.
    pub(super) fn with_tails(&mut self, subject: &mut DiagnosisProblem<'_>) -> bool {
        let (leading, data) = (&self.leading, Data::All);
        if leading.effects.is_empty() || subject.budget_exhausted() {
            return false;
        }
        let Some((tailed, again)) = explained_by_tails(subject, leading, data) else {
            return false;
        };
        let Some(none) = refit(&tailed, &self.found.none, data) else {
            return false;
        };
        *subject = tailed;
        let search = Search::new(subject, Arc::new(none), data);
        *self = Self::new(search.ended_from(&again, &[]));
        true
    }

    /// Of the end of a search.
    pub(super) fn new(found: Found) -> Self {
        Self {
            leading: leading(&found),
            found,
        }
    }

    /// Resumes the search from what a search of some of the cases chose; false where that is no better.
    pub(super) fn resume(
        &mut self,
        subject: &DiagnosisProblem<'_>,
        models: [&Arc<FittedModel>; 2],
        data: Data,
    ) -> bool {
        let Some(found) = resume(subject, &self.found, models, data) else {
            return false;
        };
        *self = Self::new(found);
        true
    }
}

/// Probability of all models whose causes are such.
pub(super) fn probability(found: &Found, accept: impl Fn(&[CandidateEffect]) -> bool) -> f64 {
    let models = found
        .models
        .iter()
        .filter(|(model, _)| accept(&model.causes));
    // From zero: the sum of no number at all is negative zero.
    let sum = models.fold(0.0, |sum, (_, probability)| sum + probability);
    // Of all models it is one but for round-off.
    sum.min(1.0)
}

/// Probability that no cause of the catalogue acts.
pub(super) fn none_of_these(found: &Found) -> f64 {
    probability(found, |causes| {
        !causes.iter().any(CandidateEffect::is_in_catalogue)
    })
}

/// Probability of a cause at its place.
pub(super) fn of_place(found: &Found, h: &CandidateEffect) -> f64 {
    probability(found, |causes| {
        causes.iter().any(|other| other.same_site(h))
    })
}

/// The model that is reported: the best fitted one that holds every place that is more probable than not, and a cause where it is more
/// probable than not that one acts.
fn leading(found: &Found) -> Arc<FittedModel> {
    let mut named: Vec<&CandidateEffect> = Vec::new();
    for h in found.models.iter().flat_map(|(model, _)| &model.causes) {
        if !named.iter().any(|other| other.same_site(h)) && of_place(found, h) > NAMED {
            named.push(h);
        }
    }
    let fitted = found
        .models
        .iter()
        .filter_map(|(model, _)| model.fitted.as_ref());
    let acts = none_of_these(found) < NAMED;
    let holds = |fitted: &&Arc<FittedModel>| {
        (!acts || fitted.effects.iter().any(CandidateEffect::is_in_catalogue))
            && named
                .iter()
                .all(|h| fitted.effects.iter().any(|other| other.same_site(h)))
    };
    let mut holding = fitted.filter(holds);
    holding
        .next()
        .map_or_else(|| Arc::clone(&found.best), Arc::clone)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use admire_identify::{LoadedStudy, Problem};

    /// The shipped axle in which nothing is wrong.
    pub(in super::super) fn shipped_axle() -> LoadedStudy {
        let folder =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../corpus/pseudo-mcpherson");
        LoadedStudy::read(&folder).value.expect("a shipped study")
    }

    /// The same with no case held out, and its model without any cause.
    pub(in super::super) fn of_the_axle<'a>(
        problem: &'a Problem<'a>,
    ) -> (DiagnosisProblem<'a>, FittedModel) {
        let held_out = vec![false; problem.measurement.cases.len()];
        let mut subject = DiagnosisProblem::new(problem, held_out);
        let none = as_it_is(&mut subject, None, Data::All).expect("it can be solved");
        (subject, none)
    }

    /// What a fit without some cases found is where one to all of them begins: it comes to the same end on a shorter way.
    #[test]
    fn a_fit_to_all_cases_begins_where_that_without_some_ended() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let held_out = (0..problem.measurement.cases.len()).map(|k| k % 4 == 3);
        let unfitted = DiagnosisProblem::new(&problem, held_out.collect());
        let begun = Begun::without_held_out(&unfitted).expect("cases are held out");
        let to_all = |known: Option<&FittedModel>| {
            let mut subject = unfitted.clone();
            let progress = Progress::default();
            subject.with_progress(&progress);
            let fitted = as_it_is(&mut subject, known, Data::All).expect("it can be solved");
            (fitted.ln_posterior(), progress.sweeps())
        };
        let (cold, far) = to_all(None);
        let (warm, near) = to_all(Some(&begun.none));
        assert!((cold - warm).abs() < 0.1, "{cold} {warm}");
        assert!(near < far, "{near} {far}");
    }
}
