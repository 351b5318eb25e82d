//! Ranking of candidate measurements. The criteria are the information about stiffnesses, about the wheel's curves, and about the choice
//! between causes.
//!
//! All predictions are linearised at the fit, with exact sensitivities. Covariances before and after a measurement have a closed form, in
//! which tolerances are marginalised at the fitted variance components. Nothing is refitted. Source of the expected information: Lindley,
//! Ann. Math. Stat. 27 (1956) 986.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::candidate::{Kind, ProposedMeasurement, ProposedMeasurements};
use super::information::{Information, ln_det};
use super::load_values::in_the_file;
use super::prospect::{MeasurementPredictor, Readings};
use super::rivals::{CompetingModels, Separation, discriminations};
use super::separator::{Separator, separators};
use crate::settings::{
    BEYOND_RANGE_FACTOR, MAX_WHEEL_CASES, SEPARATION_CHI_SQUARE, WORST_COMBINATIONS,
};
use admire_diagnosis::{
    CauseLimit, Data, DetectionLimit, DiagnosisProblem, FittedModel, Progress, cause_limits,
    detection_limits, fit_without_effects, selected,
};
use admire_identify::settings::NAMED_COMPONENT;
use admire_identify::{IdentifyError, Problem};
use admire_solver::mechanics::eigen::symmetric_eigen;

/// Purpose of the planned measurement.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// Information about the worst-determined combinations of unknowns.
    Stiffnesses,
    /// Accurate prediction of position, camber and toe of the wheel over the cases of the study.
    Curves,
    /// Decision between two rival explanations.
    Causes,
    /// All three purposes.
    All,
}

impl Aim {
    fn looks_at(self, other: Self) -> bool {
        self == Self::All || self == other
    }
}

/// Linear combination of the coordinates of the identified unknowns. The coordinate of a stiffness is its logarithm.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Combination {
    /// Coefficients of the coordinates, by the address of the unknown. Small coefficients of the unit vector are left out.
    pub combination: BTreeMap<String, f64>,
    /// Standard deviation of the combination. It is dimensionless if all coordinates are logarithms.
    pub sd_log: f64,
    /// Complete unit vector of coefficients, in the order of the unknowns.
    #[serde(skip)]
    pub vector: Vec<f64>,
}

/// Standard deviations of the predicted wheel position and angles: square roots of the mean variance over the cases of the study.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct WheelSd {
    /// Standard deviation of toe, in degrees.
    pub toe_deg: f64,
    /// Standard deviation of camber, in degrees.
    pub camber_deg: f64,
    /// Standard deviation of the position of the wheel centre, per coordinate and in the deck's length unit.
    pub position: f64,
}

/// Wheel whose position and angles are predicted, and the accuracy of the prediction from the present readings.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Curves {
    /// Marker that defines the wheel, as text.
    pub wheel: String,
    /// Standard deviations of the prediction, given the present readings.
    #[serde(flatten)]
    pub sd: WheelSd,
}

/// Two explanations between which the readings cannot decide.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Undecided {
    /// Names of the causes that each explanation contains and the other explanation does not contain.
    pub between: [String; 2],
    /// Posterior probabilities of the two explanations.
    pub probability: [f64; 2],
    /// Largest chi-square between the two explanations by a load case, a repetition or a loop that is available; zero if there is none.
    pub by_loads: f64,
    /// Instruments that would distinguish the explanations; empty if available loads do.
    pub would_separate: Vec<Separator>,
}

impl Undecided {
    /// Returns true if an available load case, repetition or loop distinguishes the explanations.
    pub fn is_separated_by_loads(&self) -> bool {
        self.by_loads > SEPARATION_CHI_SQUARE
    }
}

/// Candidate measurement with its expected benefit.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Ranked {
    /// Kind of measurement.
    pub kind: Kind,
    /// Instruction for the measurement, in words.
    pub what: String,
    /// Load cases in order, in the columns and units of the study's file. Empty for an instrument, which is read in all cases of the study.
    pub cases: Vec<BTreeMap<String, f64>>,
    /// Score by which candidates are ranked, in nats: the sum of the benefits for the chosen purposes.
    pub score: f64,
    /// Expected information about all stiffnesses together, in nats.
    pub information: Option<f64>,
    /// Standard deviations of the worst-determined combinations after the measurement, in the order of [`Plan::combinations`].
    pub sd_log: Vec<f64>,
    /// Standard deviations of the predicted wheel position and angles after the measurement.
    pub curves: Option<WheelSd>,
    /// Expected ability of the measurement to distinguish the two undecided explanations.
    pub causes: Option<Separation>,
    /// Load values of the cases in `cases`, in the units of the load programme.
    #[serde(skip)]
    pub loads: Vec<Vec<f64>>,
}

/// Contents of `plan.json`.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Plan {
    /// Purpose of the plan.
    pub aim: Aim,
    /// Worst-determined combinations of unknowns, the worst first.
    pub combinations: Vec<Combination>,
    /// Accuracy of the predicted wheel position and angles. `null` if the study defines no wheel and its loads act at no marker.
    pub curves: Option<Curves>,
    /// Explanations between which the readings cannot decide. `null` if the readings decide, or if the purpose does not include causes.
    pub causes: Option<Undecided>,
    /// Detection limits of the hardpoints. Empty if the purpose does not include causes.
    pub detection_limits: Vec<DetectionLimit>,
    /// Detection limits of all other causes. Empty if the purpose does not include causes.
    pub cause_limits: Vec<CauseLimit>,
    /// Load deviation of candidates beyond the applied range, as a multiple of the largest load deviation in the study.
    pub beyond: f64,
    /// Candidates that have no equilibrium or yield no reading, as text.
    pub not_possible: Vec<String>,
    /// Number of load combinations that were not considered, to limit the effort.
    pub left_out: usize,
    /// Ranked candidates, the best first. Empty if causes are the only purpose and the readings decide between them.
    pub candidates: Vec<Ranked>,
}

impl Plan {
    /// Returns the contents of `plan.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a plan holds only names and numbers") + "\n"
    }
}

/// Ranks the candidate measurements of a study by their expected benefit for the purpose `aim`.
///
/// # Errors
/// [`IdentifyError::NoCases`] if the deck has no equilibrium at the start of the fit.
pub fn plan(problem: &Problem<'_>, aim: Aim, progress: &Progress) -> Result<Plan, IdentifyError> {
    let no_cases = || IdentifyError::NoCases(None);
    let held = |case: &admire_study::Case| case.held_out;
    let held_out: Vec<bool> = problem.measurement.cases.iter().map(held).collect();
    let mut of_all = DiagnosisProblem::with_rig_errors(problem, held_out.clone());
    of_all.with_progress(progress);
    let (mut rivals, mut of_points, mut of_causes) = (None, Vec::new(), Vec::new());
    if aim.looks_at(Aim::Causes) {
        let selected = selected(&mut of_all, progress).ok_or_else(no_cases)?;
        rivals = CompetingModels::of(&selected);
        of_points = detection_limits(&of_all, &selected.leading);
        of_causes = cause_limits(&of_all, &selected.leading);
    }
    let mut subject = DiagnosisProblem::with_rig_errors(problem, held_out);
    subject.with_progress(progress);
    progress.begin("fitting the model as it is");
    let fitted = fit_without_effects(&mut subject, None, Data::Fitted).ok_or_else(no_cases)?;
    progress.begin("evaluating candidate measurements");
    let programme = problem.programme;
    let available = &problem.measurement.available;
    let factors = [1.0, BEYOND_RANGE_FACTOR];
    let mut candidates = ProposedMeasurements::loads(programme, available, &factors);
    candidates.repeats(programme, available);
    let remembers = rivals.as_ref().is_some_and(CompetingModels::remember);
    if remembers && available.repeats {
        candidates.loops(programme, available);
    }
    candidates.marks(problem.model, available);
    candidates.curves(&subject);
    candidates.load_cells(problem.model, available);
    candidates.list.retain(|candidate| candidate.is_available);
    let weighing = Weighing::new(&subject, &fitted, &candidates, aim).ok_or_else(no_cases)?;
    let fits = rivals
        .as_ref()
        .map(|rivals| rivals.fits.each_ref().map(AsRef::as_ref));
    let odds = rivals
        .as_ref()
        .map_or(0.5, CompetingModels::probability_of_first);
    let apart: Vec<Option<Separation>> = fits
        .and_then(|fits| discriminations(&of_all, fits, &candidates))
        .unwrap_or_default()
        .into_iter()
        .map(|found| Some(Separation::of(found?, odds)))
        .collect();
    let of_loads = candidates.list.iter().zip(&apart);
    let of_loads = of_loads.filter(|(candidate, _)| !candidate.sequence().is_empty());
    let by_loads = of_loads.filter_map(|(_, found)| Some(found.as_ref()?.chi_square));
    let by_loads = by_loads.fold(0.0, f64::max);
    let mut ranked = Vec::new();
    let mut not_possible = Vec::new();
    // Without rival explanations, a plan for causes has no criterion to rank by.
    let is_idle = aim == Aim::Causes && rivals.is_none();
    let count = if is_idle { 0 } else { candidates.list.len() };
    for (at, candidate) in candidates.list.iter().enumerate().take(count) {
        match weighing.of(at, candidate, apart.get(at).copied().flatten()) {
            Some(found) => ranked.push((at, found)),
            None => not_possible.push(candidate.what.clone()),
        }
    }
    ranked.sort_by(|(_, a), (_, b)| b.score.total_cmp(&a.score));
    // Only the best mark position on each part is kept in the ranking.
    let mut parts = Vec::new();
    ranked.retain(|(at, _)| match candidates.list[*at].new {
        super::candidate::New::Mark(part, _) => {
            let first = !parts.contains(&part);
            parts.push(part);
            first
        }
        _ => true,
    });
    let would_separate = match fits {
        Some(fits) if by_loads <= SEPARATION_CHI_SQUARE => separators(&of_all, fits),
        _ => Vec::new(),
    };
    Ok(Plan {
        aim,
        combinations: weighing.combinations,
        curves: weighing.curves,
        causes: rivals.map(|rivals| Undecided {
            between: rivals.names,
            probability: rivals.probability,
            by_loads,
            would_separate,
        }),
        detection_limits: of_points,
        cause_limits: of_causes,
        beyond: BEYOND_RANGE_FACTOR,
        not_possible,
        left_out: candidates.left_out,
        candidates: ranked.into_iter().map(|(_, found)| found).collect(),
    })
}

/// Evaluation of the candidates, starting from the present uncertainty of the study.
struct Weighing<'a, 'b> {
    subject: &'a DiagnosisProblem<'b>,
    prospect: MeasurementPredictor<'a, 'b>,
    information: Information,
    aim: Aim,
    combinations: Vec<Combination>,
    curves: Option<Curves>,
    /// Number of stiffnesses. The first `count` rows of `rows` belong to the stiffnesses. After them, each case has five rows for the wheel.
    count: usize,
    rows: DMatrix<f64>,
    ln_det: Option<f64>,
}

/// Covariance of the unknowns, and accuracy of the predicted wheel position and angles.
struct Said {
    stiffnesses: DMatrix<f64>,
    wheel: Option<WheelSd>,
}

impl<'a, 'b> Weighing<'a, 'b> {
    fn new(
        subject: &'a DiagnosisProblem<'b>,
        fitted: &'a FittedModel,
        candidates: &'a ProposedMeasurements,
        aim: Aim,
    ) -> Option<Self> {
        let prospect = MeasurementPredictor::new(subject, fitted, candidates)?;
        let count = subject.problem.unknowns.len();
        let cases: Vec<usize> = (0..subject.problem.measurement.cases.len()).collect();
        let step = cases.len().div_ceil(MAX_WHEEL_CASES).max(1);
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

    /// Returns the expected benefit of a candidate, or `None` if it cannot be measured.
    fn of(
        &self,
        at: usize,
        candidate: &ProposedMeasurement,
        causes: Option<Separation>,
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

/// Returns the combinations of unknowns with the largest variance: eigenvectors of the covariance of their coordinates.
fn combinations(subject: &DiagnosisProblem<'_>, covariance: &DMatrix<f64>) -> Vec<Combination> {
    if covariance.nrows() == 0 {
        return Vec::new();
    }
    let eigen = symmetric_eigen(covariance.clone());
    let mut order: Vec<usize> = (0..covariance.nrows()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let of = |k: usize| {
        let column = eigen.eigenvectors.column(k);
        // The sign of an eigenvector is chosen so that its largest component is positive.
        let sign = column[column.iamax()].signum();
        let vector: Vec<f64> = column.iter().map(|share| share * sign).collect();
        let named = subject.problem.unknowns.iter().zip(&vector);
        Combination {
            combination: named
                .filter(|(_, share)| share.abs() >= NAMED_COMPONENT)
                .map(|(unknown, share)| (unknown.address.to_string(), *share))
                .collect(),
            sd_log: eigen.eigenvalues[k].max(0.0).sqrt(),
            vector,
        }
    };
    order.into_iter().take(WORST_COMBINATIONS).map(of).collect()
}
