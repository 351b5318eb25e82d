//! Which measurement to make next: what each would add to stiffnesses, to the wheel's curves, and to the choice between causes.
//!
//! Everything is linear at the fit: exact sensitivities, and covariances before and after in closed form with tolerances marginalised
//! at the sizes that were found. Nothing is fitted again. Source of expected information: Lindley, Ann. Math. Stat. 27 (1956) 986.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::candidate::{BEYOND, Candidate, Candidates, Kind, in_the_file};
use super::information::{Information, ln_det};
use super::prospect::{Prospect, Readings};
use super::rivals::{Rivals, Separation, separated};
use admire_diagnosis::{
    CauseLimit, Data, DetectionLimit, DiagnosisProblem, FittedModel, Progress, as_it_is,
    cause_limits, detection_limits, seek,
};
use admire_identify::{IdentifyError, Problem};
use admire_solver::mechanics::eigen::symmetric_eigen;

/// So many of the worst-determined combinations are looked at.
const WORST: usize = 3;
/// Shares of a combination below this are left out of its name.
const SHARE: f64 = 0.15;
/// Cases at which the wheel is predicted, at most.
const MOST_CASES: usize = 40;

/// What a measurement is to serve.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// The worst-determined combinations of stiffnesses.
    Stiffnesses,
    /// Place, camber and toe of the wheel over the cases of the study.
    Curves,
    /// Which of two explanations is true.
    Causes,
    /// All three.
    All,
}

impl Aim {
    fn looks_at(self, other: Self) -> bool {
        self == Self::All || self == other
    }
}

/// A combination of logarithms of stiffnesses.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Combination {
    /// Unit vector over ln K, small components left out.
    pub combination: BTreeMap<String, f64>,
    /// Its standard deviation.
    pub sd_log: f64,
    /// The whole vector, in the order of the numbers sought.
    #[serde(skip)]
    pub vector: Vec<f64>,
}

/// How well the wheel is predicted: root of the mean variance over the cases of the study.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct WheelSd {
    /// Toe, degrees.
    pub toe_deg: f64,
    /// Camber, degrees.
    pub camber_deg: f64,
    /// A coordinate of the wheel centre, in the deck's length unit.
    pub position: f64,
}

/// The wheel that is predicted.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Curves {
    /// Its marker.
    pub wheel: String,
    /// Standard deviations as the readings leave them.
    #[serde(flatten)]
    pub sd: WheelSd,
}

/// Two explanations that the readings do not decide between.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Undecided {
    /// What each holds that the other does not.
    pub between: [String; 2],
    /// Their probabilities.
    pub probability: [f64; 2],
}

/// A measurement and what it would do.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Ranked {
    /// What kind of measurement it is.
    pub kind: Kind,
    /// What to do.
    pub what: String,
    /// Load cases in this order, the columns of the study's file; empty for an instrument, which is read in all cases.
    pub cases: Vec<BTreeMap<String, f64>>,
    /// By what they are ranked, nats: what is aimed at, added up.
    pub score: f64,
    /// Expected information about all stiffnesses, nats.
    pub information: Option<f64>,
    /// Standard deviations of the worst-determined combinations with it.
    pub sd_log: Vec<f64>,
    /// How well the wheel is predicted with it.
    pub curves: Option<WheelSd>,
    /// What it would say of the two explanations.
    pub causes: Option<Separation>,
    /// Values of its load cases in the units of the programme.
    #[serde(skip)]
    pub loads: Vec<Vec<f64>>,
}

/// What `plan.json` holds.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Plan {
    /// What was aimed at.
    pub aim: Aim,
    /// The worst-determined combinations, worst first.
    pub combinations: Vec<Combination>,
    /// How well the wheel is predicted; `null` where the loads act at no marker.
    pub curves: Option<Curves>,
    /// What is undecided; `null` where nothing is, or nobody asked.
    pub causes: Option<Undecided>,
    /// From what size on the readings show a hardpoint that is off; empty where nobody asked for causes.
    pub detection_limits: Vec<DetectionLimit>,
    /// The same for all other causes.
    pub cause_limits: Vec<CauseLimit>,
    /// The factor beyond the largest magnitude of the study.
    pub beyond: f64,
    /// What could not be solved or read.
    pub not_possible: Vec<String>,
    /// Combinations of loads that were not looked at because there are too many.
    pub left_out: usize,
    /// All candidates, the best first; none where only causes were asked for and nothing is undecided.
    pub candidates: Vec<Ranked>,
}

impl Plan {
    /// `plan.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a plan holds only names and numbers") + "\n"
    }
}

/// What the readings of a study leave open, and what each candidate would add.
///
/// # Errors
/// [`IdentifyError::NoCases`] when the deck cannot be solved where the fit starts.
pub fn plan(problem: &Problem<'_>, aim: Aim, progress: &Progress) -> Result<Plan, IdentifyError> {
    let no_cases = || IdentifyError::NoCases(None);
    let held = |case: &admire_study::Case| case.held_out;
    let held_out: Vec<bool> = problem.measurement.cases.iter().map(held).collect();
    let mut of_all = DiagnosisProblem::new(problem, held_out.clone());
    of_all.with_progress(progress);
    let (mut rivals, mut of_points, mut of_causes) = (None, Vec::new(), Vec::new());
    if aim.looks_at(Aim::Causes) {
        let sought = seek(&mut of_all, progress).ok_or_else(no_cases)?;
        rivals = Rivals::of(&sought.found, &sought.leading);
        of_points = detection_limits(&of_all, &sought.leading);
        of_causes = cause_limits(&of_all, &sought.leading);
    }
    let mut subject = DiagnosisProblem::new(problem, held_out);
    subject.with_progress(progress);
    progress.begin("fitting the model as it is");
    let fitted = as_it_is(&mut subject, None, Data::Fitted).ok_or_else(no_cases)?;
    progress.begin("weighing what could be measured");
    let programme = problem.programme;
    let mut candidates = Candidates::loads(programme, &[1.0, BEYOND]);
    candidates.repeats(programme);
    if rivals.as_ref().is_some_and(Rivals::remember) {
        candidates.loops(programme);
    }
    candidates.marks(problem.model);
    candidates.curves(&subject);
    candidates.load_cells(problem.model);
    let weighing = Weighing::new(&subject, &fitted, &candidates, aim).ok_or_else(no_cases)?;
    let apart = rivals
        .as_ref()
        .and_then(|rivals| Apart::new(&of_all, rivals, &candidates));
    let mut ranked = Vec::new();
    let mut not_possible = Vec::new();
    // Where nothing is undecided there is nothing to rank by.
    let is_idle = aim == Aim::Causes && rivals.is_none();
    let count = if is_idle { 0 } else { candidates.list.len() };
    for (at, candidate) in candidates.list.iter().enumerate().take(count) {
        match weighing.of(at, candidate, apart.as_ref()) {
            Some(found) => ranked.push((at, found)),
            None => not_possible.push(candidate.what.clone()),
        }
    }
    ranked.sort_by(|(_, a), (_, b)| b.score.total_cmp(&a.score));
    // Of the places on a part the best one.
    let mut parts = Vec::new();
    ranked.retain(|(at, _)| match candidates.list[*at].new {
        super::candidate::New::Mark(part, _) => {
            let first = !parts.contains(&part);
            parts.push(part);
            first
        }
        _ => true,
    });
    Ok(Plan {
        aim,
        combinations: weighing.combinations,
        curves: weighing.curves,
        causes: rivals.map(|rivals| Undecided {
            between: rivals.names,
            probability: rivals.probability,
        }),
        detection_limits: of_points,
        cause_limits: of_causes,
        beyond: BEYOND,
        not_possible,
        left_out: candidates.left_out,
        candidates: ranked.into_iter().map(|(_, found)| found).collect(),
    })
}

/// Two explanations, asked about candidates.
struct Apart<'a, 'b> {
    prospects: [Prospect<'a, 'b>; 2],
    information: Information,
    odds: f64,
}

impl<'a, 'b> Apart<'a, 'b> {
    fn new(
        subject: &'a DiagnosisProblem<'b>,
        rivals: &'a Rivals,
        candidates: &'a Candidates,
    ) -> Option<Self> {
        let [first, second] = rivals
            .fits
            .each_ref()
            .map(|fit| Prospect::new(subject, fit, candidates));
        Some(Self {
            prospects: [first?, second?],
            information: Information::of(&rivals.fits[0]),
            odds: rivals.odds(),
        })
    }

    fn of(&self, at: usize) -> Option<Separation> {
        let [first, second] = self.prospects.each_ref().map(|p| p.readings(at));
        let chi_square = separated(&self.information, &first?, &second?)?;
        Some(Separation::of(chi_square.max(0.0), self.odds))
    }
}

/// What the readings of the study leave open.
struct Weighing<'a, 'b> {
    subject: &'a DiagnosisProblem<'b>,
    prospect: Prospect<'a, 'b>,
    information: Information,
    aim: Aim,
    combinations: Vec<Combination>,
    curves: Option<Curves>,
    /// How many stiffnesses there are: the first rows; then five for each case of the wheel.
    count: usize,
    rows: DMatrix<f64>,
    ln_det: Option<f64>,
}

/// What readings say of stiffnesses and wheel.
struct Said {
    stiffnesses: DMatrix<f64>,
    wheel: Option<WheelSd>,
}

impl<'a, 'b> Weighing<'a, 'b> {
    fn new(
        subject: &'a DiagnosisProblem<'b>,
        fitted: &'a FittedModel,
        candidates: &'a Candidates,
        aim: Aim,
    ) -> Option<Self> {
        let prospect = Prospect::new(subject, fitted, candidates)?;
        let count = subject.problem.unknowns.len();
        let cases: Vec<usize> = (0..subject.problem.measurement.cases.len()).collect();
        let step = cases.len().div_ceil(MOST_CASES).max(1);
        let cases: Vec<usize> = cases.into_iter().step_by(step).collect();
        let wheel = prospect.wheel(&cases);
        let predicted = wheel.as_ref().map_or(0, |(_, rows)| rows.nrows());
        let mut rows = DMatrix::zeros(count + predicted, fitted.x.len());
        for k in 0..count {
            rows[(k, k)] = 1.0;
        }
        if let Some((_, own)) = &wheel {
            rows.rows_mut(count, predicted).copy_from(own);
        }
        let mut new = Self {
            subject,
            prospect,
            information: Information::of(fitted),
            aim,
            combinations: Vec::new(),
            curves: None,
            count,
            rows,
            ln_det: None,
        };
        let said = new.said(&new.information)?;
        new.ln_det = ln_det(&said.stiffnesses);
        new.combinations = combinations(subject, &said.stiffnesses);
        new.curves = wheel
            .map(|(wheel, _)| wheel)
            .zip(said.wheel)
            .map(|(wheel, sd)| Curves { wheel, sd });
        Some(new)
    }

    fn said(&self, information: &Information) -> Option<Said> {
        let root = information.root(&self.rows)?;
        let own = root.columns(0, self.count);
        let variance = |row: usize| root.column(self.count + row).norm_squared();
        let cases = (self.rows.nrows() - self.count) / 5;
        let rms = |components: &[usize]| {
            let each = (0..cases).flat_map(|case| components.iter().map(move |k| 5 * case + k));
            let sum: f64 = each.map(variance).sum();
            (sum / (cases * components.len()) as f64).sqrt()
        };
        Some(Said {
            stiffnesses: own.tr_mul(&own),
            wheel: (cases > 0).then(|| WheelSd {
                toe_deg: rms(&[4]),
                camber_deg: rms(&[3]),
                position: rms(&[0, 1, 2]),
            }),
        })
    }

    /// What a candidate does; `None` where it cannot be measured.
    fn of(
        &self,
        at: usize,
        candidate: &Candidate,
        apart: Option<&Apart<'_, '_>>,
    ) -> Option<Ranked> {
        let readings: Readings = self.prospect.readings(at)?;
        let said = self.said(&self.information.with(&readings))?;
        let gained = |before: f64, after: f64| {
            if before > 0.0 && after > 0.0 {
                libm::log(before / after)
            } else {
                0.0
            }
        };
        let mut sd_log = Vec::new();
        let mut score = 0.0;
        for combination in &self.combinations {
            let v = DVector::from_column_slice(&combination.vector);
            let sd = v.dot(&(&said.stiffnesses * &v)).max(0.0).sqrt();
            if self.aim.looks_at(Aim::Stiffnesses) {
                score += gained(combination.sd_log, sd);
            }
            sd_log.push(sd);
        }
        if let (Some(before), Some(after), true) =
            (&self.curves, &said.wheel, self.aim.looks_at(Aim::Curves))
        {
            let before = before.sd;
            score += gained(before.toe_deg, after.toe_deg)
                + gained(before.camber_deg, after.camber_deg)
                + gained(before.position, after.position);
        }
        let causes = apart.and_then(|apart| apart.of(at));
        if let Some(causes) = causes {
            score += causes.nats;
        }
        let information = self.ln_det.zip(ln_det(&said.stiffnesses));
        let programme = self.subject.problem.programme;
        let columns = |values: &Vec<f64>| {
            let each = programme.loads.iter().zip(values).enumerate();
            each.map(|(k, (load, value))| (load.name.clone(), in_the_file(programme, k, *value)))
                .collect()
        };
        Some(Ranked {
            kind: candidate.kind,
            what: candidate.what.clone(),
            cases: candidate.sequence().iter().map(columns).collect(),
            score,
            information: information
                .filter(|_| self.count > 0)
                .map(|(before, after)| 0.5 * (before - after)),
            sd_log,
            curves: said.wheel,
            causes,
            loads: candidate.sequence().to_vec(),
        })
    }
}

/// The directions of largest variance among logarithms of stiffnesses.
fn combinations(subject: &DiagnosisProblem<'_>, covariance: &DMatrix<f64>) -> Vec<Combination> {
    if covariance.nrows() == 0 {
        return Vec::new();
    }
    let eigen = symmetric_eigen(covariance.clone());
    let mut order: Vec<usize> = (0..covariance.nrows()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let of = |k: usize| {
        let column = eigen.eigenvectors.column(k);
        // The largest component is positive.
        let sign = column[column.iamax()].signum();
        let vector: Vec<f64> = column.iter().map(|share| share * sign).collect();
        let named = subject.problem.unknowns.iter().zip(&vector);
        Combination {
            combination: named
                .filter(|(_, share)| share.abs() >= SHARE)
                .map(|(unknown, share)| (unknown.address.to_string(), *share))
                .collect(),
            sd_log: eigen.eigenvalues[k].max(0.0).sqrt(),
            vector,
        }
    };
    order.into_iter().take(WORST).map(of).collect()
}
