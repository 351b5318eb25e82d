//! Final fit to the predictions of the study's own solver, with derivatives from the built-in solver.
//!
//! Let m be the residual of the built-in solver at the end of a fit, J the derivatives of m, and s the step from there. Let d(s) be the
//! predictions of the other solver minus the predictions of the built-in solver, both for the exported deck (without random effects) at step
//! s. The residual of the other solver is then `m + J s + d(s)`. Each round solves for s with d from the previous round. A few rounds are
//! enough, because d changes slowly.

use nalgebra::DVector;

use super::candidate_effect::CandidateEffect;
use super::corrected_number::corrected;
use super::deck_only::DeckOnlyPrediction;
use super::diagnose::Outcome;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::extension::driven;
use super::fit::FittedModel;
use crate::settings::{MAX_LN_STIFFNESS_STEP, OTHER_SOLVER_MAX_ROUNDS, OTHER_SOLVER_TOLERANCE_SD};
use admire_identify::global::{CaseChanges, CasePrediction, NuisanceLayout, Observations, Row};
use admire_identify::meet_marks_of_all;
use admire_session::backend::{
    Backend, BackendError, Load, LoadCase, LoadProgramme, NativeBackend, SweepRequest,
};
use admire_solver::mechanics::Pose;
use admire_solver::system::Scratch;
use admire_syntax::Address;

/// Poses of all parts in every case; `None` where the case was not solved.
type Poses = Vec<Option<Vec<Pose>>>;

impl Outcome<'_> {
    /// Compares the study's solver with the built-in solver, then refits all models to the study's solver. Returns a message if one of these
    /// steps failed.
    pub fn by_the_study(&mut self, other: &mut dyn Backend) -> Option<String> {
        if let Err(error) = self.compare(other) {
            return Some(format!(
                "the solver of the study could not be compared with the built-in solver, which made this diagnosis: {error}"
            ));
        }
        let why = match self.refit(other) {
            Ok(true) => return None,
            Ok(false) => "the deck with the refitted numbers has no equilibrium".to_string(),
            Err(error) => error.to_string(),
        };
        Some(format!(
            "the numbers of this diagnosis are fitted to the built-in solver, not to that of the study: {why}"
        ))
    }

    /// Refits the parameters of all models to the predictions of another solver, without changing the selection of causes. The exported
    /// deck, the stiffnesses, the parameters of the findings and the gain on held-out cases then refer to that solver. Returns false, with
    /// nothing changed, if the built-in solver finds no equilibrium with the new parameters.
    ///
    /// # Errors
    /// [`BackendError`] if the other solver could not solve any case; nothing is changed then.
    pub fn refit(&mut self, other: &mut dyn Backend) -> Result<bool, BackendError> {
        let subject = &self.subject;
        let baseline = refitted(subject, &self.baseline, Data::All, other)?;
        let extended = refitted(subject, &self.extended, Data::All, other)?;
        let unseen = match &self.unseen {
            Some(unseen) => Some(unseen.refitted(subject, |fitted| {
                refitted(subject, fitted, Data::Fitted, other)
            })?),
            None => None,
        };
        let Some(plain) = DeckOnlyPrediction::new(subject, &extended) else {
            return Ok(false);
        };
        let poses = solved(other, &extended, &plain, subject)?;
        self.diagnosis.baseline.chi2_per_dof = baseline.posterior.chi_square_per_dof();
        for (k, parameter) in self.diagnosis.parameters.iter_mut().enumerate() {
            let unknown = &subject.problem.unknowns[k];
            parameter.move_to(unknown, [self.extended.x[k], extended.x[k]]);
        }
        for finding in &mut self.diagnosis.findings {
            let mut chosen = extended.effects.iter();
            let is_named = |h: &CandidateEffect| {
                let form = finding.form.as_deref().unwrap_or_default();
                h.cause == finding.cause && h.address == finding.address && h.side == form
            };
            let Some(k) = chosen.position(is_named) else {
                continue;
            };
            for number in extended.estimates(k) {
                finding.parameters.insert(number.name.clone(), number.value);
                finding.std_error.insert(number.name, number.std_error);
            }
        }
        if let Some(unseen) = &unseen {
            self.diagnosis.hold_out = unseen.hold_out(subject);
            self.diagnosis.baseline.held_out_rms = unseen.tests[0].marks_rms;
        }
        self.corrected = corrected(&subject.problem, &baseline, &extended);
        if let Some(found) = &mut self.diagnosis.solver {
            found.refitted_rms = missed(subject, &poses);
        }
        self.plain = plain;
        self.baseline = baseline.into();
        self.extended = extended.into();
        self.unseen = unseen;
        Ok(true)
    }
}

/// Refits a model to the predictions of another solver, starting from the end of its fit.
fn refitted(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    data: Data,
    other: &mut dyn Backend,
) -> Result<FittedModel, BackendError> {
    let whitening = subject.whitening(data);
    let stiffnesses = subject.problem.unknowns.len();
    let mut at = fitted.clone();
    for _ in 0..OTHER_SOLVER_MAX_ROUNDS {
        let Some(plain) = DeckOnlyPrediction::new(subject, &at) else {
            break;
        };
        let apart = apart(subject, &at, &plain, other)?;
        let Some((_, posterior)) = fitted.relinearised_with_offset(&whitening, &apart) else {
            break;
        };
        let mut most = 0.0_f64;
        let mut next = at.x.clone();
        for (k, next) in next.iter_mut().enumerate() {
            let goal = fitted.x[k] + posterior.step[k];
            *next = if k < stiffnesses {
                at.x[k] + (goal - at.x[k]).clamp(-MAX_LN_STIFFNESS_STEP, MAX_LN_STIFFNESS_STEP)
            } else {
                goal
            };
            if fitted.is_of_the_model(k) {
                let sd = posterior.covariance[(k, k)].max(0.0).sqrt();
                most = most.max((*next - at.x[k]).abs() / sd.max(f64::MIN_POSITIVE));
            }
        }
        // The residual belongs to the step actually taken, which the limit on stiffness steps may have shortened.
        let step = DVector::from_column_slice(&next) - DVector::from_column_slice(&fitted.x);
        at.residual = &fitted.residual + apart + &fitted.jacobian * step;
        at.x = next;
        at.posterior = posterior;
        at.posterior.step.fill(0.0);
        at.posterior.gain = 0.0;
        if most < OTHER_SOLVER_TOLERANCE_SD {
            break;
        }
    }
    Ok(at)
}

/// Returns the predictions of another solver minus the predictions of the built-in solver, in units of the residual rows. The difference is
/// zero for a case that either solver did not solve, and for a channel that cannot be computed from poses.
fn apart(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    plain: &DeckOnlyPrediction,
    other: &mut dyn Backend,
) -> Result<DVector<f64>, BackendError> {
    let own = solved(&mut NativeBackend::new(), fitted, plain, subject)?;
    let mut foreign = solved(other, fitted, plain, subject)?;
    let mut out = DVector::zeros(subject.rows.len());
    for (foreign, own) in foreign.iter_mut().zip(&own) {
        if own.is_none() || foreign.is_none() {
            foreign.clone_from(own);
        }
    }
    let at = (subject, fitted, plain);
    if let Some([own, foreign]) = residuals(at, &own)
        .zip(residuals(at, &foreign))
        .map(<[_; 2]>::from)
    {
        out = foreign - own;
    }
    Ok(out)
}

/// Returns prediction minus reading of all rows at these poses. Predictions of channels that cannot be computed from poses are set to zero.
fn residuals(
    (subject, fitted, plain): (&DiagnosisProblem<'_>, &FittedModel, &DeckOnlyPrediction),
    poses: &Poses,
) -> Option<DVector<f64>> {
    let measurement = subject.problem.measurement;
    let cases: Vec<usize> = (0..measurement.cases.len()).collect();
    let observations = Observations::new(measurement, &fitted.deck.model, &cases);
    let prepared = &fitted.deck.prepared;
    let mut scratch = Scratch::new(&prepared.system);
    let prediction: Vec<Option<CasePrediction>> = poses
        .iter()
        .zip(&plain.thetas)
        .map(|(poses, theta)| {
            let poses = poses.clone()?;
            let read = prepared.channels;
            let channels = read.at(&prepared.system, theta, &poses, &mut scratch);
            Some(CasePrediction {
                poses,
                channels: channels
                    .into_iter()
                    .map(Option::unwrap_or_default)
                    .collect(),
                by_unknown: CaseChanges::default(),
                free: CaseChanges::default(),
            })
        })
        .collect();
    let found = observations.evaluate(&prediction, &NuisanceLayout::default(), &[], 0)?;
    Some(found.residual)
}

/// Returns the rms error of the marks at these poses without outliers, per coordinate and in the deck's length unit. Returns `None` if no mark
/// can be compared.
fn missed(subject: &DiagnosisProblem<'_>, poses: &Poses) -> Option<f64> {
    let measurement = subject.problem.measurement;
    let (mut sum, mut count) = (0.0, 0.0);
    for (row, precision) in subject.rows.iter().zip(&subject.precision) {
        let Row::Mark {
            case,
            reading,
            axis,
        } = *row
        else {
            continue;
        };
        let (Some(poses), true) = (&poses[case], *precision > 0.0) else {
            continue;
        };
        let read = measurement.cases[case].marks[reading];
        let part = &measurement.parts[read.part];
        let place = poses[part.part.0].point(&part.marks[read.mark].p);
        sum += (read.x[axis] - place[axis]).powi(2);
        count += 1.0;
    }
    (count > 0.0).then(|| f64::sqrt(sum / count))
}

/// Solves the exported deck of a fit in all cases with the backend `by`.
fn solved(
    by: &mut dyn Backend,
    fitted: &FittedModel,
    plain: &DeckOnlyPrediction,
    subject: &DiagnosisProblem<'_>,
) -> Result<Poses, BackendError> {
    let system = &fitted.deck.prepared.system;
    let (catalogue, deck) = (system.catalogue(), system.parameters());
    let driven = driven(subject, fitted);
    let first = &plain.thetas[0];
    let theta: Vec<(Address, f64)> = catalogue
        .slots()
        .filter(|slot| {
            let (old, new) = (deck.get(*slot), first.get(*slot));
            old.to_bits() != new.to_bits() && new.is_finite() && !driven.contains(slot)
        })
        .map(|slot| (catalogue.info(slot).address, first.get(slot)))
        .collect();
    let cases = subject.problem.programme.cases.iter().zip(&plain.thetas);
    let programme = LoadProgramme {
        loads: driven
            .iter()
            .map(|slot| {
                let target = catalogue.info(*slot).address;
                Load {
                    name: target.to_string(),
                    target,
                }
            })
            .collect(),
        cases: cases
            .map(|(case, theta)| LoadCase {
                label: case.label.clone(),
                values: driven.iter().map(|slot| theta.get(*slot)).collect(),
            })
            .collect(),
    };
    let mut sweep = by.sweep(&SweepRequest {
        dataset: &fitted.deck.dataset,
        model: &fitted.deck.model,
        theta: &theta,
        programme: &programme,
    })?;
    let problem = &subject.problem;
    meet_marks_of_all(problem.free, &mut sweep, problem.measurement);
    let poses = |case| sweep.equilibrium(case).map(|found| found.poses.clone());
    Ok((0..programme.cases.len()).map(poses).collect())
}
