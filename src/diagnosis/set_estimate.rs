//! Estimated log posteriors of sets of effects that are not fitted.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::closure::{EffectSet, Sets};
use super::fitted_set::FittedSet;
use super::point::{Ids, Point, RoughLaw, new_rough_laws};
use super::settings::{EQUIVALENT_DISTANCE, OCCAM_WINDOW_NATS, ROUND_OFF_DISTANCE};

/// Estimated log posterior of a set of effects that is not fitted.
pub(super) struct SetEstimate {
    pub ln_posterior: f64,
    /// Squared distance between the predictions of this set and of the nearest fitted set, in units of noise.
    pub distance: f64,
    /// Linearisation point.
    pub point: Arc<Point>,
    /// Index of the marginal at this point.
    pub marginal: usize,
    pub set: EffectSet,
}

/// Contribution of each effect of a set to the prediction: pairs of column index and coefficient.
type Contributions = Vec<Vec<(usize, f64)>>;

/// Fitted set, evaluated in the linear model of a point.
struct Reference {
    set: EffectSet,
    /// Contributions at each marginal.
    parts: Vec<Option<Contributions>>,
    /// Log posterior of the fit minus the log posterior in the linear model.
    error: f64,
}

/// Estimates the log posterior of all probable sets that are not fitted. The linear model of a fit is used only for sets that contain all
/// effects of the fit, because its estimate is wrong for a set that lacks a large effect of the fit.
pub(super) fn estimates(
    points: &[Arc<Point>],
    fits: &BTreeMap<Ids, FittedSet>,
    discarded: &BTreeSet<Ids>,
) -> BTreeMap<Ids, SetEstimate> {
    let each = fits.values().map(FittedSet::ln_posterior);
    let best = each.fold(f64::NEG_INFINITY, f64::max);
    let mut out: BTreeMap<Ids, SetEstimate> = BTreeMap::new();
    for point in points {
        let references = references(point, fits);
        let by_law = errors_of_laws(point, &references);
        let largest = references.iter().map(|known| known.error);
        let largest = largest.fold(0.0, f64::max);
        for (r, (marginal, pool)) in point.marginals.iter().zip(&point.pools).enumerate() {
            let sets = Sets::new(&point.model, marginal);
            for (set, score) in pool {
                let linear = marginal.ln_z + score;
                if linear + largest < best - OCCAM_WINDOW_NATS || !point.holds_fit(set) {
                    continue;
                }
                let ids = point.ids_of(set);
                if fits.contains_key(&ids) || discarded.contains(&ids) {
                    continue;
                }
                let Some(parts) = sets.contributions(set) else {
                    continue;
                };
                let (mut distance, mut error) = (f64::INFINITY, 0.0);
                for known in &references {
                    let Some(other) = &known.parts[r] else {
                        continue;
                    };
                    let apart = sets.distance(&parts, other);
                    if apart < distance {
                        (distance, error) = (apart, known.error);
                    }
                }
                // A set that predicts the same as a fitted set has the same error of the linear model. Any other set gets the error of its
                // largest fitted subset.
                let alike = libm::exp(-0.5 * distance);
                let enlarged = error_of_subset(&references, set, false);
                let mut correction = alike * error + (1.0 - alike) * enlarged;
                // The linear model of such a law has a similar error for the same law at another site. A law with a negligible effect has no
                // error.
                for (k, law) in new_rough_laws(&point.model, set) {
                    let own = set.iter().position(|other| *other == k);
                    let part = own.and_then(|own| parts.get(own..=own));
                    let acts = part.map_or(0.0, |part| sets.distance(part, &[]));
                    let acting = 1.0 - libm::exp(-0.5 * acts);
                    let known = by_law.get(&law).copied().unwrap_or_default();
                    correction = correction.max(enlarged + acting * known);
                }
                let new = SetEstimate {
                    ln_posterior: linear + correction,
                    distance,
                    point: Arc::clone(point),
                    marginal: r,
                    set: set.clone(),
                };
                // If several linear models estimate a set, the model with the nearest fitted set counts, provided that such a set predicts the
                // same. Otherwise, the highest estimate counts.
                let is_better = |old: &SetEstimate| {
                    let apart = new.distance - old.distance;
                    let is_known = new.distance.min(old.distance) <= EQUIVALENT_DISTANCE;
                    if is_known && apart.abs() > ROUND_OFF_DISTANCE {
                        apart < 0.0
                    } else {
                        new.ln_posterior > old.ln_posterior
                    }
                };
                if out.get(&ids).is_none_or(is_better) {
                    out.insert(ids, new);
                }
            }
        }
    }
    out
}

/// Returns the fitted sets to which the linear model of a point applies, with the error of this model. A fit optimises its variance components,
/// whereas each marginal of the point has fixed ones. The log posterior of a fit is therefore compared with the highest over all marginals.
fn references(point: &Point, fits: &BTreeMap<Ids, FittedSet>) -> Vec<Reference> {
    let sets = || {
        let each = point.marginals.iter();
        each.map(|marginal| (marginal, Sets::new(&point.model, marginal)))
    };
    let of = |(ids, fit): (&Ids, &FittedSet)| {
        let set = point.set_of(ids, &fit.forms().cloned().unwrap_or_default())?;
        let linear = sets().filter_map(|(marginal, sets)| Some(marginal.ln_z + sets.score(&set)?));
        let linear = linear.max_by(f64::total_cmp)?;
        point.holds_fit(&set).then(|| Reference {
            parts: sets().map(|(_, sets)| sets.contributions(&set)).collect(),
            error: fit.ln_posterior() - linear,
            set,
        })
    };
    fits.iter().filter_map(of).collect()
}

/// Returns the error of the linear model for the largest fitted subset of a set; zero without such a subset. Among subsets of the same size,
/// the lowest error counts. If `is_proper` is true, the set itself does not count as a subset.
fn error_of_subset(references: &[Reference], set: &EffectSet, is_proper: bool) -> f64 {
    let is_subset = |known: &&Reference| {
        known.set.iter().all(|k| set.contains(k)) && !(is_proper && known.set.len() == set.len())
    };
    let each = references.iter().filter(is_subset);
    let largest = each.max_by(|a, b| {
        let by_size = a.set.len().cmp(&b.set.len());
        by_size.then(b.error.total_cmp(&a.error))
    });
    largest.map_or(0.0, |known| known.error)
}

/// Returns, for each poorly linearised law, the largest error of the linear model over all fitted sets with this law. The error of the largest
/// proper subset is subtracted if it is positive.
fn errors_of_laws(point: &Point, references: &[Reference]) -> BTreeMap<RoughLaw, f64> {
    let mut out: BTreeMap<RoughLaw, f64> = BTreeMap::new();
    for known in references {
        let enlarged = error_of_subset(references, &known.set, true).max(0.0);
        let own = known.error - enlarged;
        for (_, law) in new_rough_laws(&point.model, &known.set) {
            let largest = out.entry(law).or_insert(0.0);
            *largest = largest.max(own);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(set: &[usize], error: f64) -> Reference {
        Reference {
            set: set.to_vec(),
            parts: Vec::new(),
            error,
        }
    }

    /// Checks that a set has the error of its largest fitted subset. Among two subsets of the same size, the lower error counts. The set itself
    /// is not a proper subset.
    #[test]
    fn a_set_inherits_the_error_of_its_largest_fitted_subset() {
        let known = [
            reference(&[], 0.0),
            reference(&[1], -3.0),
            reference(&[2], -5.0),
            reference(&[1, 4], -40.0),
        ];
        let of = |set: &[usize], is_proper| error_of_subset(&known, &set.to_vec(), is_proper);
        assert_eq!(of(&[3], false), 0.0);
        assert_eq!(of(&[1, 2], false), -5.0);
        assert_eq!(of(&[1, 2, 4], false), -40.0);
        assert_eq!(of(&[1, 4], false), -40.0);
        assert_eq!(of(&[1, 4], true), -3.0);
    }
}
