//! Estimation of the noise of mark readings without a model of the axle: the distances between the marks of a rigid part are constant.
//!
//! The `m` marks of a part have `3 m` coordinates, and its pose has six degrees of freedom. The remaining `3 m - 6` coordinates contain the
//! noise and the position errors of the marks on the part. The position errors are constant over the cases and are removed by subtracting the
//! mean.

use std::collections::{BTreeMap, BTreeSet};

use super::misplaced::{Misplaced, misplaced, misplaced_marks};
use super::part_marks::{Mark, centres, coordinates, part_marks, residuals};
use super::rigidity_screen::{MarkOutlier, RigidityScreen};
use super::tails::Tails;
use crate::settings::{
    HEAVY_TAILS_LN_ALLOWANCE, HEAVY_TAILS_NATS, LONE_MARK_CASE_DIVISOR, LONE_MARK_CASES,
    LONE_MARK_SHARE, NOISE_REJECTION_SD, OUTLIER_MARK_SIGMA, POSSIBLE_HEAVY_TAILS_NATS,
    WRONG_MARK_SHARE,
};
use admire_solver::mechanics::Vec3;
use admire_study::{MarkReading, Measurement};

/// Noise of the mark coordinates of a measurement, with the outliers and misplaced marks.
#[derive(Clone, PartialEq, Debug)]
pub struct MarkNoise {
    /// Standard deviation per mark coordinate as stated by the study; `None` if the study does not state it.
    pub declared: Option<f64>,
    /// Standard deviation per mark coordinate, estimated from the scatter of the marks of rigid parts; `None` with fewer than six degrees
    /// of freedom.
    pub estimated: Option<f64>,
    /// Standard deviation of the natural logarithm of `estimated`.
    pub ln_sd: f64,
    /// Gain in log-likelihood of the Student t over the Gaussian distribution for the residuals of the marks, in nats.
    pub tails: f64,
    /// Single mark readings that are outliers.
    pub outliers: Vec<MarkOutlier>,
    /// Marks that are not at their listed positions. None of their readings is used.
    pub misplaced: Vec<Misplaced>,
    /// Pairs of case and part in which at least one mark is wrong, but the marks alone do not show which one. Finding the wrong mark
    /// requires a model of the axle.
    pub suspects: Vec<(usize, usize)>,
}

impl MarkNoise {
    /// Estimates the noise of the marks of a measurement, and finds outliers and misplaced marks.
    pub fn of(measurement: &Measurement) -> Self {
        let declared = (!measurement.sigma_estimated).then_some(measurement.sigma);
        let none = BTreeMap::new();
        let mut left_out: BTreeSet<Mark> = BTreeSet::new();
        let without = |marks: &BTreeSet<Mark>| {
            RigidityScreen::new(measurement, &part_marks(measurement, marks))
        };
        let mut sorted = loop {
            let sorted = without(&left_out);
            let found = misplaced(measurement, &sorted);
            if found.is_empty() {
                break sorted;
            }
            left_out.extend(found);
        };
        let misplaced = misplaced_marks(measurement, &sorted, &left_out);
        // A mark that is never read together with three other marks of its part cannot be assessed. It is used and screened like the other
        // marks.
        if misplaced.len() < left_out.len() {
            left_out = misplaced.iter().map(|of| (of.part, of.mark)).collect();
            sorted = without(&left_out);
        }
        let RigidityScreen {
            blocks,
            outliers,
            suspects,
            ..
        } = sorted;
        let clean = residuals(measurement, &blocks, &none);
        let centre = centres(&clean, false);
        let left = coordinates(measurement, &clean, &centre);
        let squares: f64 = left.iter().map(|value| value * value).sum();
        // The pose uses six degrees of freedom in each block. The mean over the cases uses the remaining coordinates once for each part.
        let mut dof: f64 = blocks
            .iter()
            .map(|b| 3.0 * b.readings.len() as f64 - 6.0)
            .sum();
        let mut parts = BTreeMap::new();
        for block in &blocks {
            let most = parts.entry(block.part).or_insert(0.0_f64);
            *most = most.max(3.0 * block.readings.len() as f64 - 6.0);
        }
        if !centre.is_empty() {
            dof -= parts.values().sum::<f64>();
        }
        let usable = dof >= 6.0 && squares > 0.0;
        Self {
            declared,
            estimated: usable.then(|| (squares / dof).sqrt()),
            ln_sd: (1.0 / (2.0 * dof.max(1.0))).sqrt(),
            tails: Tails::best(&left).map_or(0.0, |(_, gain)| gain),
            outliers,
            misplaced,
            suspects,
        }
    }

    /// Decides with a model which readings of the suspect parts are outliers. `misfit` returns reading minus prediction of the model for a case
    /// and a reading.
    pub fn judge(
        &mut self,
        measurement: &Measurement,
        misfit: &dyn Fn(usize, usize) -> Option<Vec3>,
    ) {
        let sigma = self.sigma().unwrap_or(0.0);
        for (case, part) in std::mem::take(&mut self.suspects) {
            let readings = measurement.cases[case].marks.iter().enumerate();
            let errors: Vec<(usize, Vec3)> = readings
                .filter(|(_, mark)| mark.part == part && !self.is_misplaced(mark))
                .filter_map(|(reading, _)| Some((reading, misfit(case, reading)?)))
                .collect();
            let largest = errors.iter().map(|(_, e)| e.norm()).fold(0.0, f64::max);
            let least = (OUTLIER_MARK_SIGMA * sigma).max(WRONG_MARK_SHARE * largest);
            let wrong = errors.into_iter().filter(|(_, e)| e.norm() > least);
            self.outliers
                .extend(wrong.map(|(reading, error)| MarkOutlier {
                    case,
                    reading,
                    error,
                }));
        }
        self.outliers
            .sort_by_key(|outlier| (outlier.case, outlier.reading));
    }

    /// Returns true for a reading that is not used: it is an outlier, its mark is misplaced, or the marks of its part in this case are suspect.
    pub fn is_excluded(&self, case: usize, reading: usize, read: &MarkReading) -> bool {
        self.is_outlier(case, reading)
            || self.is_misplaced(read)
            || self.suspects.contains(&(case, read.part))
    }

    /// Returns true for a reading that is known to be wrong: an outlier, or a reading of a misplaced mark.
    pub fn is_wrong(&self, case: usize, reading: usize, read: &MarkReading) -> bool {
        self.is_outlier(case, reading) || self.is_misplaced(read)
    }

    fn is_outlier(&self, case: usize, reading: usize) -> bool {
        let mut outliers = self.outliers.iter();
        outliers.any(|o| (o.case, o.reading) == (case, reading))
    }

    fn is_misplaced(&self, read: &MarkReading) -> bool {
        let mut marks = self.misplaced.iter();
        marks.any(|of| (of.part, of.mark) == (read.part, read.mark))
    }

    /// Returns the standard deviation of a mark coordinate for a fit: the estimate if there is one, otherwise the declared value.
    pub fn sigma(&self) -> Option<f64> {
        self.estimated.or(self.declared)
    }

    /// Returns true if the declared noise disagrees with the estimate. `tailed` is true if the noise may have heavy tails; the limit is then
    /// wider.
    pub fn contradicts(&self, tailed: bool) -> bool {
        match (self.declared, self.estimated) {
            (Some(declared), Some(estimated)) if declared > 0.0 => {
                // With heavy tails, an estimated standard deviation is uncertain.
                let loose = if tailed {
                    HEAVY_TAILS_LN_ALLOWANCE
                } else {
                    0.0
                };
                libm::log(estimated / declared).abs() > NOISE_REJECTION_SD * self.ln_sd + loose
            }
            _ => false,
        }
    }

    /// Returns true if the residuals have clearly heavier tails than a Gaussian.
    pub fn has_tails(&self) -> bool {
        self.tails > HEAVY_TAILS_NATS
    }

    /// Returns true if the residuals may have heavier tails than a Gaussian. The limit is lower than for [`Self::has_tails`], because a few
    /// readings cannot prove heavy tails.
    pub fn may_have_tails(&self) -> bool {
        self.tails > POSSIBLE_HEAVY_TAILS_NATS
    }

    /// Finds parts that have at most three usable marks in a case and whose mark readings there contradict a model. Adds them to the suspects.
    /// Returns true if any part was added.
    ///
    /// Three marks still fit a rigid part if one of them is displaced perpendicular to their plane, so only a model reveals the error. `misfit`
    /// returns reading minus prediction of the model, and `usual` is the typical size of its coordinates.
    ///
    /// If another mark of the part is already an outlier in the case, a large residual is sufficient. Otherwise a single mark must stand out,
    /// and only in a few cases. A mark that stands out in many cases points to an error of the model.
    pub fn flag_three_mark_outliers(
        &mut self,
        measurement: &Measurement,
        misfit: &dyn Fn(usize, usize) -> Option<Vec3>,
        usual: f64,
    ) -> bool {
        let least = OUTLIER_MARK_SIGMA * usual.max(self.sigma().unwrap_or(0.0));
        let marks = self.misplaced.iter().map(|of| (of.part, of.mark));
        let blocks = part_marks(measurement, &marks.collect());
        let mut sure = Vec::new();
        let mut alone: BTreeMap<Mark, Vec<usize>> = BTreeMap::new();
        for block in &blocks {
            let (case, part) = (block.case, block.part);
            if self.suspects.contains(&(case, part)) {
                continue;
            }
            let is_out = |k: &&usize| self.is_outlier(case, **k);
            let lost = block.readings.iter().filter(is_out).count();
            if block.readings.len() - lost > 3 {
                continue;
            }
            let rest = block.readings.iter().filter(|k| !is_out(k));
            let mut off: Vec<(f64, usize)> = rest
                .filter_map(|k| Some((misfit(case, *k)?.amax(), *k)))
                .collect();
            off.sort_by(|a, b| b.0.total_cmp(&a.0));
            let [(largest, reading), (next, _), ..] = off[..] else {
                continue;
            };
            if largest <= least {
                continue;
            }
            if lost > 0 {
                sure.push((case, part));
            } else if next < LONE_MARK_SHARE * largest {
                let mark = measurement.cases[case].marks[reading].mark;
                alone.entry((part, mark)).or_default().push(case);
            }
        }
        for ((part, _), cases) in alone {
            let read = blocks.iter().filter(|block| block.part == part).count();
            if cases.len() <= LONE_MARK_CASES.max(read / LONE_MARK_CASE_DIVISOR) {
                sure.extend(cases.into_iter().map(|case| (case, part)));
            }
        }
        let is_sure = |o: &MarkOutlier| {
            let part = measurement.cases[o.case].marks[o.reading].part;
            sure.contains(&(o.case, part))
        };
        self.outliers.retain(|o| !is_sure(o));
        self.suspects.extend(&sure);
        !sure.is_empty()
    }
}
