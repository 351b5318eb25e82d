//! How the fits of a search ended, by where they began: none is made twice from the same start.

use super::fit::{Fit, Fitted, Target};
use super::hypothesis::Hypothesis;
use crate::tolerance::Sizes;

/// Where a fit begins.
#[derive(Clone, PartialEq)]
pub(super) struct Start {
    /// Causes and guesses of their numbers.
    causes: Vec<(Hypothesis, Vec<f64>)>,
    /// Unknowns of the fit that it begins at, and what they are taken to be; `None` for the deck.
    from: Option<(Vec<f64>, Vec<f64>)>,
    /// Sizes of tolerances, if not those of that fit.
    sizes: Option<Sizes>,
}

impl Start {
    pub(super) fn new(
        causes: &[(Hypothesis, Vec<f64>)],
        from: Option<(&Fitted, &[f64])>,
        sizes: Option<&Sizes>,
    ) -> Self {
        Self {
            causes: causes.to_vec(),
            from: from.map(|(fitted, x)| (fitted.x.clone(), x.to_vec())),
            sizes: sizes.cloned(),
        }
    }
}

/// A fit that was made.
struct End {
    start: Start,
    /// What it was measured by,
    lead: f64,
    least: f64,
    known: Option<Vec<f64>>,
    /// and how it ended; `None` where it could not be made.
    fit: Option<Fit>,
}

/// Fits that were made on the same readings.
#[derive(Default)]
pub(super) struct Ends(Vec<End>);

impl Ends {
    /// How the fit from a start ended. One that stopped short of its end counts where its target was no harder: it would stop no later now.
    pub(super) fn of(&self, start: &Start, target: &Target<'_>) -> Option<Option<Fit>> {
        let known = target.known.map(|known| known.x.as_slice());
        let counts = |end: &&End| {
            let is_as_hard = target.lead >= end.lead && target.least >= end.least;
            let own = Target {
                lead: end.lead,
                ..Target::NONE
            };
            let is_over = match &end.fit {
                Some(Fit::New(fit)) => is_as_hard || (fit.is_settled() && !own.is_beaten(fit)),
                Some(Fit::Known) | None => true,
            };
            is_over && end.known.as_deref() == known && end.start == *start
        };
        self.0.iter().find(counts).map(|end| end.fit.clone())
    }

    /// Takes note of how a fit ended.
    pub(super) fn note(&mut self, start: Start, target: &Target<'_>, fit: Option<&Fit>) {
        self.0.push(End {
            start,
            lead: target.lead,
            least: target.least,
            known: target.known.map(|known| known.x.clone()),
            fit: fit.cloned(),
        });
    }
}
