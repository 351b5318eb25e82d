//! Noise of mark readings without any model: the marks of a rigid part keep their distances.
//!
//! Of the 3 m coordinates of m marks six tell the pose; the others are noise and the marks' places on the part, which are the same in
//! every case and cancel against their mean.

use std::collections::{BTreeMap, BTreeSet};

use super::misplaced::{Misplaced, misplaced, misplaced_marks};
use super::part_marks::{Mark, OUTLIER, centres, coordinates, part_marks, residuals};
use super::sorted::{MarkOutlier, RigidityScreen};
use super::tails::Tails;
use admire_solver::mechanics::Vec3;
use admire_study::{MarkReading, Measurement};

/// A model shows a mark to be wrong that is off by this part of the worst of its part.
const APART: f64 = 0.4;
/// Of three marks one stands alone if the others are off by less than this part of it.
const ALONE: f64 = 0.25;
/// The same one stands alone in so many cases at most, or in one of so many.
const FEW: usize = 2;
const OFTEN: usize = 10;
/// The declared noise is contradicted from so many standard deviations of its logarithm on.
const CONTRADICTED: f64 = 4.0;
/// With heavy tails its logarithm may be off by so much more.
const TAILED: f64 = 0.3;

/// How exact mark coordinates are.
#[derive(Clone, PartialEq, Debug)]
pub struct MarkNoise {
    /// Standard deviation of a coordinate as the study states it; `None` if it states none.
    pub declared: Option<f64>,
    /// The same from the readings, where parts carry four marks or more in several cases.
    pub estimated: Option<f64>,
    /// Standard deviation of the logarithm of the estimate.
    pub ln_sd: f64,
    /// By how many nats Student's t is a better distribution of what is left of the marks than the Gaussian.
    pub tails: f64,
    /// Readings that are plainly wrong.
    pub outliers: Vec<MarkOutlier>,
    /// Marks that do not sit where they are listed: none of their readings is used.
    pub misplaced: Vec<Misplaced>,
    /// Case and part of marks of which several are wrong, so that they do not tell themselves which: a model has to.
    pub suspects: Vec<(usize, usize)>,
}

impl MarkNoise {
    /// From the marks of a measurement.
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
        // One that no case has beside three others cannot be told: it is used, and judged with the rest.
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
        // Six of each block told its pose, and as many coordinates of each part as are left its mean.
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

    /// Marks under suspicion judged by a model: `misfit` is reading minus prediction of a reading in a case.
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
            let least = (OUTLIER * sigma).max(APART * largest);
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

    /// True for a reading that is not used: it is wrong, its mark is, or it cannot be told which of several are.
    pub fn is_excluded(&self, case: usize, reading: usize, read: &MarkReading) -> bool {
        self.is_outlier(case, reading)
            || self.is_misplaced(read)
            || self.suspects.contains(&(case, read.part))
    }

    /// True for a reading that is known to be wrong, by itself or with its mark.
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

    /// The standard deviation a fit should use: the estimate where there is one.
    pub fn sigma(&self) -> Option<f64> {
        self.estimated.or(self.declared)
    }

    /// True if the declared noise is not the noise of the readings, which may have heavy tails.
    pub fn contradicts(&self, tailed: bool) -> bool {
        match (self.declared, self.estimated) {
            (Some(declared), Some(estimated)) if declared > 0.0 => {
                // With heavy tails a standard deviation says little.
                let loose = if tailed { TAILED } else { 0.0 };
                libm::log(estimated / declared).abs() > CONTRADICTED * self.ln_sd + loose
            }
            _ => false,
        }
    }

    /// True if the residuals are further out than those of a Gaussian.
    pub fn has_tails(&self) -> bool {
        self.tails > Tails::BETTER
    }

    /// True if they may be: marks in few cases do not tell.
    pub fn may_have_tails(&self) -> bool {
        self.tails > Tails::HINT
    }

    /// Puts three marks of a part under suspicion where a model of which most marks are `usual` far off says so: they fit a rigid part if one
    /// of them is off across the others. Of a part that has no more, one has to stand alone, and not the same one in many cases: that is
    /// the model's doing. True if there are any.
    pub fn suspect_three(
        &mut self,
        measurement: &Measurement,
        misfit: &dyn Fn(usize, usize) -> Option<Vec3>,
        usual: f64,
    ) -> bool {
        let least = OUTLIER * usual.max(self.sigma().unwrap_or(0.0));
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
            } else if next < ALONE * largest {
                let mark = measurement.cases[case].marks[reading].mark;
                alone.entry((part, mark)).or_default().push(case);
            }
        }
        for ((part, _), cases) in alone {
            let read = blocks.iter().filter(|block| block.part == part).count();
            if cases.len() <= FEW.max(read / OFTEN) {
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
