//! Where the fits of a search began and how they ended, so that none is made twice.

use super::candidate_effect::CandidateEffect;
use super::fit::{EarlyStopping, FitOutcome, FittedModel};
use admire_identify::tolerance::VarianceComponents;

/// Where a fit begins.
#[derive(Clone, PartialEq)]
pub(super) struct Start {
    /// Causes and guesses of their numbers.
    causes: Vec<(CandidateEffect, Vec<f64>)>,
    /// Unknowns of the fit that it begins at, and what they are taken to be; `None` for the deck.
    from: Option<(Vec<f64>, Vec<f64>)>,
    /// Sizes of tolerances, if not those of that fit.
    sizes: Option<VarianceComponents>,
}

impl Start {
    pub(super) fn new(
        causes: &[(CandidateEffect, Vec<f64>)],
        from: Option<(&FittedModel, &[f64])>,
        sizes: Option<&VarianceComponents>,
    ) -> Self {
        Self {
            causes: causes.to_vec(),
            from: from.map(|(fitted, x)| (fitted.x.clone(), x.to_vec())),
            sizes: sizes.cloned(),
        }
    }
}

/// A fit that was made.
pub(super) struct End {
    start: Start,
    /// What it was measured by,
    lead: f64,
    least: f64,
    known: Option<Vec<f64>>,
    /// and how it ended; `None` where it could not be made.
    pub fit: Option<FitOutcome>,
}

/// Fits that were made on the same readings.
#[derive(Default)]
pub(super) struct Ends(Vec<End>);

impl Ends {
    /// The fit from a start, if it was made. One that stopped short counts where its target was no harder: now it would stop no later.
    pub(super) fn of(&self, start: &Start, target: &EarlyStopping<'_>) -> Option<&End> {
        let known = target.known.map(|known| known.x.as_slice());
        let counts = |end: &&End| {
            let is_as_hard = target.lead >= end.lead && target.least >= end.least;
            let own = EarlyStopping {
                lead: end.lead,
                ..EarlyStopping::NONE
            };
            let is_over = match &end.fit {
                Some(FitOutcome::New(fit)) => {
                    is_as_hard || (fit.is_converged() && !own.is_beaten(fit))
                }
                Some(FitOutcome::Duplicate) | None => true,
            };
            is_over && end.known.as_deref() == known && end.start == *start
        };
        self.0.iter().find(counts)
    }

    /// Takes note of how a fit ended.
    pub(super) fn note(
        &mut self,
        start: Start,
        target: &EarlyStopping<'_>,
        fit: Option<&FitOutcome>,
    ) {
        self.0.push(End {
            start,
            lead: target.lead,
            least: target.least,
            known: target.known.map(|known| known.x.clone()),
            fit: fit.cloned(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::diagnosis_problem::Data;
    use super::super::progress::Progress;
    use super::super::scan::Catalogue;
    use super::super::sought::tests::{of_the_axle, shipped_axle};
    use super::super::tried::Tried;
    use super::*;

    /// A fit with a target out of reach stops short. It is made again for a nearer target, and then not again.
    #[test]
    fn a_fit_is_made_again_only_for_a_target_that_is_less_hard() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (mut subject, none) = of_the_axle(&problem);
        let progress = Progress::default();
        subject.with_progress(&progress);
        let catalogue = Catalogue::new(&subject, &none);
        let mut smooth = catalogue.hypotheses.iter();
        let smooth = smooth.find(|h| !h.cause.has_rough_law() && h.numbers.len() == 1);
        let far = vec![(smooth.expect("a cause of one number").clone(), vec![3.0])];
        let mut tried = Tried::new(&subject, Data::All);
        let mut reached = |lead: f64| {
            let target = EarlyStopping {
                lead,
                ..EarlyStopping::NONE
            };
            let from = Some((&none, none.x.as_slice()));
            let Some(FitOutcome::New(found)) = tried.fitted(&far, from, None, target) else {
                panic!("it can be fitted");
            };
            (found.posterior.gain, progress.sweeps())
        };
        let best = none.posterior.ln_z;
        let (short, first) = reached(best + 1e6);
        let (harder, second) = reached(best + 2e6);
        assert_eq!((harder, second), (short, first));
        let (end, third) = reached(f64::NEG_INFINITY);
        assert!(end < short && third > second, "{end} {short}");
        let (again, fourth) = reached(best);
        assert_eq!((again, fourth), (end, third));
    }
}
