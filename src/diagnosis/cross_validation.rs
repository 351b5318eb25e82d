//! Cross-validation: each group of load cases is predicted from the other groups, with causes selected from those other groups.
//!
//! [`Folds::validate`] conditions the linear model of each fitted model on the rows of the other groups. The model with the largest
//! posterior probability given those rows predicts the group. The set of fitted models and their linearisation points come from the search
//! over all cases. [`Folds::search`] repeats the whole search for each group without its cases.
//!
//! The log predictive density of a group, given all other readings, is `ln Z(all) - ln Z(rest)`. Both evidences use the same variance
//! components. Source: the chain rule of probabilities; MacKay, Neural Computation 4 (1992) 415.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use nalgebra::DVector;
use serde::Serialize;

use super::base_fit::BaseFit;
use super::candidate_effect::CandidateEffect;
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::hold_out::HoldOutSelection;
use super::jackknife::{Squares, rms_reduction};
use super::model_set::ModelSet;
use super::progress::Progress;

use crate::settings::{
    AT_REST_TOLERANCE, CV_BLOCKS, CV_MAX_GROUPS, CV_MIN_CASES, UNEVEN_GAIN_RATIO,
};
use admire_identify::global::Row;
use admire_session::backend::LoadCase;

/// Improvement in the prediction of one group of cases from the other groups.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct GroupGain {
    /// Labels of the cases in the group.
    pub cases: Vec<String>,
    /// Causes in the model that was selected by the readings of the other groups, each written as `cause address`.
    pub causes: Vec<String>,
    /// Rms error of the model without causes in predicting this group.
    pub rms_before: f64,
    /// Rms error of the selected model in predicting this group.
    pub rms_after: f64,
}

/// Result of the cross-validation over all groups of cases.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CrossValidation {
    /// True if the search was repeated for each group; false if the causes were selected among the models fitted to all cases.
    pub searched: bool,
    /// Quantity to which the rms errors refer. `mark` means the errors of the marks per coordinate, in the deck's length unit. `noise` means the
    /// errors of all readings, in units of their noise.
    pub of: &'static str,
    /// Rms prediction error over all groups by the model without causes.
    pub rms_before: f64,
    /// Rms prediction error over all groups. Each group is predicted by the model selected from the other groups.
    pub rms_after: f64,
    /// Decrease of the rms: `rms_before - rms_after`.
    pub gain: f64,
    /// Standard error of `gain`, by a jackknife over the groups.
    pub gain_std_error: f64,
    /// Prediction errors of each group.
    pub groups: Vec<GroupGain>,
}

impl CrossValidation {
    /// Returns the groups with the least and the greatest gain if the gains of the groups differ strongly, otherwise `None`.
    pub fn spread(&self) -> Option<[&GroupGain; 2]> {
        let gain = |group: &&GroupGain| group.rms_before - group.rms_after;
        let by_gain = |a: &&GroupGain, b: &&GroupGain| gain(a).total_cmp(&gain(b));
        let least = self.groups.iter().min_by(by_gain)?;
        let most = self.groups.iter().max_by(by_gain)?;
        let apart = gain(&most) - gain(&least);
        (self.gain > 0.0 && apart > UNEVEN_GAIN_RATIO * self.gain).then_some([least, most])
    }
}

/// Divides the cases into groups for cross-validation. Two cases belong to the same group if the same loads deviate from their usual values,
/// with the same signs. Groups are in the order of first application. A case with all loads at their usual values joins the group applied
/// before it. If a single group results, it is cut into blocks of successive cases. Returns an empty list if there are too few cases.
pub(super) fn groups(cases: &[LoadCase]) -> Vec<Vec<usize>> {
    if cases.len() < CV_MIN_CASES {
        return Vec::new();
    }
    let loads = cases.first().map_or(0, |case| case.values.len());
    let usual: Vec<(f64, f64)> = (0..loads)
        .map(|k| {
            let mut values: Vec<f64> = cases.iter().map(|case| case.values[k]).collect();
            values.sort_by(f64::total_cmp);
            let range = values[values.len() - 1] - values[0];
            (
                most_frequent(&values, AT_REST_TOLERANCE * range),
                AT_REST_TOLERANCE * range,
            )
        })
        .collect();
    let signature = |case: &LoadCase| -> Vec<i8> {
        let pairs = case.values.iter().zip(&usual);
        pairs
            .map(|(value, (usual, near))| match value - usual {
                off if off > *near => 1,
                off if off < -near => -1,
                _ => 0,
            })
            .collect()
    };
    let mut found: Vec<(Vec<i8>, Vec<usize>)> = Vec::new();
    let mut waiting: Vec<usize> = Vec::new();
    let mut last: Option<usize> = None;
    for (k, case) in cases.iter().enumerate() {
        let own = signature(case);
        if own.iter().all(|sign| *sign == 0) {
            match last {
                Some(at) => found[at].1.push(k),
                None => waiting.push(k),
            }
            continue;
        }
        let at = found.iter().position(|(of, _)| *of == own);
        let at = at.unwrap_or_else(|| {
            found.push((own, std::mem::take(&mut waiting)));
            found.len() - 1
        });
        found[at].1.push(k);
        last = Some(at);
    }
    let mut groups: Vec<Vec<usize>> = found.into_iter().map(|(_, cases)| cases).collect();
    if groups.len() < 2 {
        let size = cases.len().div_ceil(CV_BLOCKS);
        let all: Vec<usize> = (0..cases.len()).collect();
        return all.chunks(size).map(<[usize]>::to_vec).collect();
    }
    while groups.len() > CV_MAX_GROUPS {
        groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
        let smallest = groups.pop().unwrap_or_default();
        if let Some(next) = groups.last_mut() {
            next.extend(smallest);
            next.sort_unstable();
        }
    }
    groups.sort_by_key(|group| group.first().copied());
    groups
}

/// Returns the most frequent of the sorted values. Values closer than `near` count as equal.
fn most_frequent(sorted: &[f64], near: f64) -> f64 {
    let count = |value: f64| sorted.iter().filter(|v| (*v - value).abs() <= near).count();
    let mut best = (0, 0.0);
    for value in sorted {
        let own = count(*value);
        if own > best.0 {
            best = (own, *value);
        }
    }
    best.1
}

/// Groups of load cases, and fitted models conditioned on the cases outside each group.
pub(super) struct Folds<'a> {
    subject: &'a DiagnosisProblem<'a>,
    groups: Vec<Vec<usize>>,
    /// Rows excluded for each group, one flag per row: all rows that depend on a case of the group.
    left_out: Vec<Vec<bool>>,
    /// Cache: fitted models with their refits for all groups.
    known: RefCell<Vec<(Arc<FittedModel>, Rc<Refits>)>>,
}

/// Refits of one model, one per group. `None` where the conditioned linear model has no solution.
type Refits = Vec<Option<Refit>>;

/// Linear model conditioned on the readings outside one group.
#[derive(Debug)]
struct Refit {
    /// Prediction minus reading of all rows, in units of the declared noise.
    misfit: DVector<f64>,
    /// Log evidence of the readings outside the group.
    ln_z: f64,
}

impl<'a> Folds<'a> {
    /// Divides the cases of a study into groups. Returns `None` if there are too few cases.
    pub(super) fn new(subject: &'a DiagnosisProblem<'a>) -> Option<Self> {
        let groups = groups(&subject.problem.programme.cases);
        let left_out = |group: &Vec<usize>| {
            let is_seen = |case: usize| !group.contains(&case);
            let rows = subject.rows.iter();
            rows.map(|row| !subject.sees(row, &is_seen)).collect()
        };
        (!groups.is_empty()).then(|| Self {
            left_out: groups.iter().map(left_out).collect(),
            known: RefCell::default(),
            subject,
            groups,
        })
    }

    /// Conditions a model that was fitted to all cases on the readings outside each group. Results are cached.
    fn refits(&self, fitted: &Arc<FittedModel>) -> Rc<Refits> {
        let is_own = |(of, _): &&(Arc<FittedModel>, Rc<Refits>)| Arc::ptr_eq(of, fitted);
        if let Some((_, refits)) = self.known.borrow().iter().find(is_own) {
            return Rc::clone(refits);
        }
        let (jacobian, residual) = (fitted.whitened_jacobian(), fitted.whitened_residual());
        let without = |left_out: &Vec<bool>| {
            let (misfit, ln_z) = fitted.evidence_without(&jacobian, &residual, left_out)?;
            Some(Refit { misfit, ln_z })
        };
        let refits: Rc<Refits> = Rc::new(self.left_out.iter().map(without).collect());
        let known = (Arc::clone(fitted), Rc::clone(&refits));
        self.known.borrow_mut().push(known);
        refits
    }

    /// Returns the log predictive density of `fitted` minus the log predictive density of `other`, in nats, summed over the groups. Each
    /// group is predicted from the other groups.
    pub(super) fn advantage(
        &self,
        fitted: &Arc<FittedModel>,
        other: &Arc<FittedModel>,
    ) -> Option<f64> {
        let score = |fitted: &Arc<FittedModel>| -> Option<f64> {
            let refits = self.refits(fitted);
            let gains = refits.iter();
            gains
                .map(|refit| Some(fitted.posterior.ln_z - refit.as_ref()?.ln_z))
                .sum()
        };
        Some(score(fitted)? - score(other)?)
    }

    /// Returns the rows of a group on which predictions are compared: the mark rows if the study has marks, otherwise all rows in use.
    fn rows(&self, group: usize) -> impl Iterator<Item = usize> + '_ {
        let subject = self.subject;
        let marks = subject.compares_marks();
        let rows = subject.rows.iter().enumerate();
        rows.filter(move |(k, row)| {
            subject.precision[*k] > 0.0
                && self.groups[group].contains(&row.case())
                && (!marks || matches!(row, Row::Mark { .. }))
        })
        .map(|(k, _)| k)
    }

    /// Predicts each group by the fitted model that has the largest posterior probability given the other groups. `none` is the model
    /// without causes.
    pub(super) fn validate(
        &self,
        none: &Arc<FittedModel>,
        models: &[(ModelSet, f64)],
    ) -> Option<CrossValidation> {
        self.collected(false, |group| {
            let before = self.refits(none)[group].as_ref()?.misfit.clone();
            let mut best: Option<(f64, Rc<Refits>, &FittedModel)> = None;
            for fitted in models.iter().filter_map(|(m, _)| m.fitted.as_ref()) {
                let refits = self.refits(fitted);
                let Some(refit) = &refits[group] else {
                    continue;
                };
                let value = refit.ln_z + fitted.ln_prior();
                if best.as_ref().is_none_or(|(most, ..)| value > *most) {
                    best = Some((value, refits, fitted));
                }
            }
            let (_, refits, chosen) = best?;
            let after = refits[group].as_ref()?.misfit.clone();
            Some(GroupPrediction {
                misfits: [before, after],
                causes: CandidateEffect::causes(&chosen.effects)
                    .map(ToString::to_string)
                    .collect(),
            })
        })
    }

    /// Repeats the search for each group without its cases, and predicts the group. `unfitted` is the study before any fit. Returns `None`
    /// if a search cannot start or does not finish.
    pub(super) fn search(
        &self,
        unfitted: &DiagnosisProblem<'_>,
        progress: &Progress,
    ) -> Option<CrossValidation> {
        self.collected(true, |group| {
            let mut subject = unfitted.clone();
            subject.hold_out(&self.groups[group]);
            let base = BaseFit::without_held_out(&subject)?;
            let unseen =
                HoldOutSelection::new(base, progress).filter(|found| !found.is_cut_short())?;
            let chosen = CandidateEffect::causes(&unseen.chosen.effects);
            Some(GroupPrediction {
                causes: chosen.map(ToString::to_string).collect(),
                misfits: unseen.predicted.map(|blind| blind.misfit),
            })
        })
    }

    /// Collects the rms errors of all groups. Returns `None` if a group cannot be predicted, or if fewer than two groups have rows to
    /// compare.
    fn collected(
        &self,
        searched: bool,
        predict: impl Fn(usize) -> Option<GroupPrediction>,
    ) -> Option<CrossValidation> {
        let subject = self.subject;
        let (of, unit) = subject.compared();
        let mut groups = Vec::new();
        let mut sums: Vec<Squares> = Vec::new();
        for group in 0..self.groups.len() {
            let count = self.rows(group).count() as f64;
            if count == 0.0 {
                continue;
            }
            let GroupPrediction { misfits, causes } = predict(group)?;
            let [before, after] = misfits.map(|misfit| -> f64 {
                self.rows(group).map(|k| misfit[k].powi(2)).sum::<f64>() * unit * unit
            });
            sums.push(Squares {
                before,
                after,
                count,
            });
            let labels = self.groups[group].iter();
            groups.push(GroupGain {
                cases: labels
                    .map(|k| subject.problem.measurement.cases[*k].label.clone())
                    .collect(),
                causes,
                rms_before: (before / count).sqrt(),
                rms_after: (after / count).sqrt(),
            });
        }
        if sums.len() < 2 {
            return None;
        }
        let fall = rms_reduction(&sums)?;
        Some(CrossValidation {
            searched,
            of,
            rms_before: fall.before,
            rms_after: fall.after,
            gain: fall.before - fall.after,
            gain_std_error: fall.std_error,
            groups,
        })
    }
}

/// Prediction of one group from the other groups.
struct GroupPrediction {
    /// Prediction minus reading of all rows: by the model without causes, then by the model with the selected causes.
    misfits: [DVector<f64>; 2],
    /// Selected causes, each as `cause address`.
    causes: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::{LoadCase, groups};

    fn cases(values: &[[f64; 2]]) -> Vec<LoadCase> {
        let case = |(k, values): (usize, &[f64; 2])| LoadCase {
            label: k.to_string(),
            values: values.to_vec(),
        };
        values.iter().enumerate().map(case).collect()
    }

    #[test]
    fn a_loop_and_its_standing_cases_stay_together() {
        let found = groups(&cases(&[
            [3.0, 0.0],
            [4.0, 0.0],
            [5.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [3.0, 2.0],
            [3.0, 0.0],
            [3.0, -1.0],
        ]));
        assert_eq!(found, [vec![0, 1, 2, 3], vec![4, 5, 6], vec![7]]);
    }

    #[test]
    fn one_kind_of_load_is_cut_into_blocks() {
        let found = groups(&cases(&[[1.0, 0.0]; 6]));
        assert_eq!(found, [vec![0, 1], vec![2, 3], vec![4, 5]]);
        assert!(groups(&cases(&[[1.0, 0.0]; 3])).is_empty());
    }
}
