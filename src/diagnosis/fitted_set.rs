//! Fits of one set of effects.

use std::sync::Arc;

use super::fit::FittedModel;
use super::point::Forms;

/// Fits of one set of effects, one for each combination of functions of its laws.
#[derive(Default)]
pub(super) struct FittedSet {
    fits: Vec<FitOfForms>,
}

struct FitOfForms {
    forms: Forms,
    ln_posterior: f64,
    /// The fit itself. `None` if it is outside of Occam's window, to save memory.
    model: Option<Arc<FittedModel>>,
}

impl FittedSet {
    /// Adds a fit. A fit with the same functions is replaced if its log posterior is lower. Returns true if the new fit
    /// is the most probable one.
    pub(super) fn add(&mut self, forms: Forms, fitted: &Arc<FittedModel>) -> bool {
        let ln_posterior = fitted.ln_posterior();
        let leads = self
            .best()
            .is_none_or(|best| best.ln_posterior < ln_posterior);
        let new = FitOfForms {
            forms,
            ln_posterior,
            model: Some(Arc::clone(fitted)),
        };
        match self.fits.iter_mut().find(|old| old.forms == new.forms) {
            Some(old) if old.ln_posterior >= ln_posterior => return false,
            Some(old) => *old = new,
            None => self.fits.push(new),
        }
        leads
    }

    /// Returns true if the set was fitted with these functions.
    pub(super) fn holds(&self, forms: &Forms) -> bool {
        self.fits.iter().any(|fit| fit.forms == *forms)
    }

    /// Returns the log posterior probability of the set, up to a constant: the logarithm of the summed posterior probabilities of its fits.
    pub(super) fn ln_posterior(&self) -> f64 {
        let best = self
            .best()
            .map_or(f64::NEG_INFINITY, |best| best.ln_posterior);
        let each = self.fits.iter();
        let sum: f64 = each.map(|fit| libm::exp(fit.ln_posterior - best)).sum();
        best + libm::log(sum)
    }

    /// Returns the functions of the most probable fit.
    pub(super) fn forms(&self) -> Option<&Forms> {
        self.best().map(|best| &best.forms)
    }

    /// Returns the most probable fit, if it is inside of Occam's window.
    pub(super) fn model(&self) -> Option<&Arc<FittedModel>> {
        self.best()?.model.as_ref()
    }

    /// Iterates over the fits inside of Occam's window, with their log posterior probabilities.
    pub(super) fn models(&self) -> impl Iterator<Item = (&Arc<FittedModel>, f64)> {
        let each = self.fits.iter();
        each.filter_map(|fit| Some((fit.model.as_ref()?, fit.ln_posterior)))
    }

    /// Frees the fits whose log posterior is below `least`.
    pub(super) fn forget(&mut self, least: f64) {
        for fit in &mut self.fits {
            if fit.ln_posterior < least {
                fit.model = None;
            }
        }
    }

    fn best(&self) -> Option<&FitOfForms> {
        let each = self.fits.iter();
        each.max_by(|a, b| a.ln_posterior.total_cmp(&b.ln_posterior))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base_fit::tests::{axle_problem, shipped_axle};

    /// Checks that two equally probable functions of a law make a set twice as probable as one of them. The same function counts only once.
    #[test]
    fn functions_of_a_law_add_up() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (_subject, fitted) = axle_problem(&problem);
        let fitted = Arc::new(fitted);
        let mut set = FittedSet::default();
        for form in ["cubic", "quadratic", "cubic"] {
            set.add(Forms::from([(0, form)]), &fitted);
        }
        let sum = fitted.ln_posterior() + std::f64::consts::LN_2;
        assert!((set.ln_posterior() - sum).abs() < 1e-12);
        assert_eq!(set.models().count(), 2);
        assert!(set.holds(&Forms::from([(0, "cubic")])));
        set.forget(f64::INFINITY);
        assert!(set.model().is_none() && (set.ln_posterior() - sum).abs() < 1e-12);
    }
}
