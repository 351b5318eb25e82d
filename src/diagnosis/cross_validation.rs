//! Groups of cases, each predicted from the others, with the causes chosen anew from what the others say.
//!
//! [`Folds::validate`]: each fitted model is refitted in its linear model to the rows of the other groups; the one of greatest
//! evidence there predicts the group. Which models were fitted, and where they were linearised, is what the search over all cases left.
//! [`Folds::search`]: the whole search is done again for each group, without it.
//!
//! The logarithm of the density with which a model predicts a group from the rest is `ln Z(all) - ln Z(rest)`, both at the same sizes.
//! Source: the chain rule of probabilities; MacKay, Neural Computation 4 (1992) 415.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use nalgebra::DVector;
use serde::Serialize;

use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::hold_out::HoldOutSelection;
use super::hypothesis::Hypothesis;
use super::jackknife::{Squares, rms_reduction};
use super::progress::Progress;
use super::sought::Begun;
use super::visited::Visited;
use admire_identify::global::Row;
use admire_session::backend::LoadCase;

/// Groups at most; the smallest are put together.
const MOST: usize = 6;
/// Groups of one kind of load are cut into so many, where there is one kind only.
const BLOCKS: usize = 4;
/// Cases that are needed at all.
const LEAST: usize = 4;
/// A load is at its usual value within this part of its range.
const USUAL: f64 = 1e-3;
/// Gains of groups that lie further apart than so many times the gain of all depend on the cases.
const APART: f64 = 1.5;

/// One group, predicted from the others.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct GroupGain {
    /// Labels of its cases.
    pub cases: Vec<String>,
    /// Causes that the other groups chose, `cause address`.
    pub causes: Vec<String>,
    /// Rms of what is predicted, by the model without any cause.
    pub rms_before: f64,
    /// The same by the model that was chosen.
    pub rms_after: f64,
}

/// All groups.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CrossValidation {
    /// True if causes were searched anew for each group; false if they were chosen among the models that all cases had fitted.
    pub searched: bool,
    /// `mark` if the rms is that of a mark coordinate in the deck's length unit, `noise` if of all readings in units of their noise.
    pub of: &'static str,
    /// Over all groups, without any cause.
    pub rms_before: f64,
    /// Over all groups, each by the model that the others chose.
    pub rms_after: f64,
    /// By how much it falls.
    pub gain: f64,
    /// Standard error of that: the groups are left out one after the other (jackknife).
    pub gain_std_error: f64,
    /// The groups.
    pub groups: Vec<GroupGain>,
}

impl CrossValidation {
    /// The groups that gain least and most, where it matters which cases are held out.
    pub fn spread(&self) -> Option<[&GroupGain; 2]> {
        let gain = |group: &&GroupGain| group.rms_before - group.rms_after;
        let by_gain = |a: &&GroupGain, b: &&GroupGain| gain(a).total_cmp(&gain(b));
        let least = self.groups.iter().min_by(by_gain)?;
        let most = self.groups.iter().max_by(by_gain)?;
        let apart = gain(&most) - gain(&least);
        (self.gain > 0.0 && apart > APART * self.gain).then_some([least, most])
    }
}

/// Cases with the same loads away from their usual values, in the order of first application; cases at the usual loads belong to what
/// was applied before them. One kind only is cut into blocks of neighbours. Empty with too few cases.
pub(super) fn groups(cases: &[LoadCase]) -> Vec<Vec<usize>> {
    if cases.len() < LEAST {
        return Vec::new();
    }
    let loads = cases.first().map_or(0, |case| case.values.len());
    let usual: Vec<(f64, f64)> = (0..loads)
        .map(|k| {
            let mut values: Vec<f64> = cases.iter().map(|case| case.values[k]).collect();
            values.sort_by(f64::total_cmp);
            let range = values[values.len() - 1] - values[0];
            (most_frequent(&values, USUAL * range), USUAL * range)
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
        let size = cases.len().div_ceil(BLOCKS);
        let all: Vec<usize> = (0..cases.len()).collect();
        return all.chunks(size).map(<[usize]>::to_vec).collect();
    }
    while groups.len() > MOST {
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

/// The value that most of these sorted ones are near.
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

/// Models as the rest of the cases see them.
pub(super) struct Folds<'a> {
    subject: &'a DiagnosisProblem<'a>,
    groups: Vec<Vec<usize>>,
    /// For each group the rows that the rest of the cases does not see.
    left_out: Vec<Vec<bool>>,
    /// Models as the rest of each group sees them.
    known: RefCell<Vec<(Arc<FittedModel>, Rc<Refits>)>>,
}

/// A model without each of the groups.
type Refits = Vec<Option<Refit>>;

/// A model refitted to the rest of a group.
#[derive(Debug)]
struct Refit {
    misfit: DVector<f64>,
    /// Evidence of the rest.
    ln_z: f64,
}

impl<'a> Folds<'a> {
    /// Over the cases of a study; `None` with too few.
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

    /// A model of all cases as the rest of each group sees it.
    fn refits(&self, fitted: &Arc<FittedModel>) -> Rc<Refits> {
        let is_own = |(of, _): &&(Arc<FittedModel>, Rc<Refits>)| Arc::ptr_eq(of, fitted);
        if let Some((_, refits)) = self.known.borrow().iter().find(is_own) {
            return Rc::clone(refits);
        }
        let (jacobian, residual) = (fitted.whitened_jacobian(), fitted.whitened_residual());
        let without = |left_out: &Vec<bool>| {
            let rows = (&jacobian, &residual);
            let (misfit, ln_z) = fitted.evidence_without(rows, left_out)?;
            Some(Refit { misfit, ln_z })
        };
        let refits: Rc<Refits> = Rc::new(self.left_out.iter().map(without).collect());
        let known = (Arc::clone(fitted), Rc::clone(&refits));
        self.known.borrow_mut().push(known);
        refits
    }

    /// By how many nats a model predicts the groups, each from the others, better than another.
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

    /// The rows of a group that are compared.
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

    /// Predicts each group by the model that the others choose among all that were fitted.
    pub(super) fn validate(
        &self,
        none: &Arc<FittedModel>,
        models: &[(Visited, f64)],
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
            Some(Predicted {
                misfits: [before, after],
                causes: Hypothesis::causes(&chosen.effects)
                    .map(ToString::to_string)
                    .collect(),
            })
        })
    }

    /// Predicts each group by a search of the others that nothing was fitted to yet. `None` where a search may not begin or come to its end.
    pub(super) fn search(
        &self,
        unfitted: &DiagnosisProblem<'_>,
        progress: &Progress,
    ) -> Option<CrossValidation> {
        self.collected(true, |group| {
            let mut subject = unfitted.clone();
            subject.hold_out(&self.groups[group]);
            let begun = Begun::without_held_out(&subject)?;
            let unseen = HoldOutSelection::new(begun, &[], progress)
                .filter(|found| !found.is_cut_short())?;
            let chosen = Hypothesis::causes(&unseen.chosen.effects);
            Some(Predicted {
                causes: chosen.map(ToString::to_string).collect(),
                misfits: unseen.predicted.map(|blind| blind.misfit),
            })
        })
    }

    /// The rms of all groups; `None` where one of them cannot be predicted.
    fn collected(
        &self,
        searched: bool,
        predict: impl Fn(usize) -> Option<Predicted>,
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
            let Predicted { misfits, causes } = predict(group)?;
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

/// A group as the others predict it.
struct Predicted {
    /// Prediction minus reading of all rows, without any cause and with those chosen.
    misfits: [DVector<f64>; 2],
    /// What was chosen.
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
