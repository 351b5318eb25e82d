//! Models that a search looked at, and how probable each is.

use std::cmp::Ordering;
use std::sync::Arc;

use super::candidate_effect::CandidateEffect;
use super::fit::FittedModel;
use super::rig_errors::{GaveWay, Promises};

/// A model known only by its linear approximation counts when it is so close to the best one.
pub(super) const LINEAR: f64 = 8.0;

/// A model that was looked at.
#[derive(Clone, Debug)]
pub struct Visited {
    /// What is in it.
    pub causes: Vec<CandidateEffect>,
    /// Logarithm of evidence and prior.
    pub ln_posterior: f64,
    /// The model, if it was fitted and not only weighed in the linear model of another.
    pub fitted: Option<Arc<FittedModel>>,
}

/// The end of a search.
#[derive(Debug)]
pub struct Found {
    /// The model without any cause.
    pub none: Arc<FittedModel>,
    /// The model of greatest posterior probability.
    pub best: Arc<FittedModel>,
    /// All that were looked at and count, with probabilities that add up to one.
    pub models: Vec<(Visited, f64)>,
    /// How many hypotheses there were.
    pub places: usize,
    /// True if the search had spent its budget.
    pub cut_short: bool,
    /// What it gave way to before its end.
    pub gave_way: Option<GaveWay>,
    /// What errors of the rig that it might have given way to promise.
    pub promises: Promises,
}

pub(super) fn by_evidence(a: &Arc<FittedModel>, b: &Arc<FittedModel>) -> Ordering {
    a.ln_posterior().total_cmp(&b.ln_posterior())
}

/// The one with more evidence.
pub(super) fn better(known: Option<Arc<FittedModel>>, other: Arc<FittedModel>) -> Arc<FittedModel> {
    match known {
        Some(known) if known.ln_posterior() >= other.ln_posterior() => known,
        _ => other,
    }
}

/// Models that count and their probabilities. Of a set that was looked at several times the best counts; one that was only weighed
/// counts where it is close, and not beside its own fit.
pub(super) fn probabilities(visited: &[Visited]) -> Vec<(Visited, f64)> {
    let mut fitted: Vec<&Visited> = Vec::new();
    for visited in visited.iter().filter(|v| v.fitted.is_some()) {
        match fitted
            .iter_mut()
            .find(|other| same_set(&other.causes, &visited.causes))
        {
            Some(other) if other.ln_posterior < visited.ln_posterior => *other = visited,
            Some(_) => {}
            None => fitted.push(visited),
        }
    }
    let best = fitted
        .iter()
        .map(|v| v.ln_posterior)
        .fold(f64::NEG_INFINITY, f64::max);
    let mut models = fitted;
    for visited in visited.iter().filter(|v| v.fitted.is_none()) {
        if visited.ln_posterior > best - LINEAR
            && visited.ln_posterior < best
            && !models
                .iter()
                .any(|other| same_set(&other.causes, &visited.causes))
        {
            models.push(visited);
        }
    }
    let sum: f64 = models
        .iter()
        .map(|v| libm::exp(v.ln_posterior - best))
        .sum();
    let mut out: Vec<(Visited, f64)> = models
        .into_iter()
        .map(|v| (v.clone(), libm::exp(v.ln_posterior - best) / sum))
        .collect();
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out
}

/// True if both hold the same causes in the same forms.
pub(super) fn same_set(a: &[CandidateEffect], b: &[CandidateEffect]) -> bool {
    match_each_other(a, b, CandidateEffect::same_form)
}

/// The same of laws: sliders whose forms say where their numbers begin count as one.
pub(super) fn same_laws(a: &[CandidateEffect], b: &[CandidateEffect]) -> bool {
    match_each_other(a, b, CandidateEffect::same_law)
}

fn match_each_other(
    a: &[CandidateEffect],
    b: &[CandidateEffect],
    same: fn(&CandidateEffect, &CandidateEffect) -> bool,
) -> bool {
    let within = |a: &[CandidateEffect], b: &[CandidateEffect]| {
        a.iter().all(|h| b.iter().any(|o| same(o, h)))
    };
    a.len() == b.len() && within(a, b) && within(b, a)
}

/// How many places these are, in whatever forms.
pub(super) fn distinct(hypotheses: &[&CandidateEffect]) -> usize {
    let first =
        |(k, h): &(usize, &&CandidateEffect)| !hypotheses[..*k].iter().any(|o| o.same_site(h));
    hypotheses.iter().enumerate().filter(first).count()
}
