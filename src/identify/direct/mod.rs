//! `method = "direct"`: the stiffnesses are computed from the equilibrium equations at the measured poses. These equations are linear in the
//! stiffnesses, so no solver run is needed.
//!
//! In every load case, the forces on each part must balance at its measured pose. Joint reactions are eliminated by projecting the equations
//! onto the orthogonal complement of the reactions. The remaining equations are linear in stiffnesses and preloads. An assembly offset `delta0`
//! acts as a preload `p = K delta0`.
//!
//! Noise of the poses with covariance `Sigma` gives the equations the covariance `C = K_T Sigma K_T^T`, where `K_T` is the tangent stiffness.
//! The equations are weighted by the inverse of `C`. The noise also affects the deflections that multiply the stiffnesses, which biases the
//! stiffnesses towards zero. Most of this bias is removed by repeatedly moving the poses, within their covariance, to positions that satisfy
//! the equations.

mod equations;
mod report;

pub use report::identify;

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};

use self::equations::{CaseState, Linearised};
use super::unknowns::stiffness;
use super::{IdentifyError, Problem, Progress, bounded};
use crate::settings::{
    DIRECT_ACCEPTED_P_VALUE, DIRECT_DAMPING, DIRECT_DAMPING_DECREASE, DIRECT_DAMPING_INCREASE,
    DIRECT_LN_TOLERANCE, DIRECT_MAX_DAMPING, DIRECT_MAX_LN_DISTANCE, DIRECT_MAX_LN_STEP,
    DIRECT_MEASURED_POSE_ROUNDS, DIRECT_MIN_MARK_SIGMA, DIRECT_POSE_CORRECTIONS,
    DIRECT_SD_TOLERANCE,
};
use admire_session::backend::{compile, slot};
use admire_solver::mechanics::eigen::pseudo_inverse;
use admire_solver::system::{NoValue, Scratch, Slot, System};
use admire_study::orientation::chi_square_p_value;
use admire_study::settings::Method;
use admire_syntax::Address;

/// Settings of the direct solution.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct DirectSettings {
    /// Maximum number of Levenberg-Marquardt steps in one attempt. In each step, the poses are corrected as well.
    pub rounds: usize,
    /// If true, also solves with uncorrected poses, to show the bias due to their noise.
    pub show_bias: bool,
}

impl Default for DirectSettings {
    fn default() -> Self {
        Self {
            rounds: 60,
            show_bias: true,
        }
    }
}

/// Result of the direct solution.
#[derive(Clone, PartialEq, Debug)]
pub struct DirectSolution {
    /// Identified values, one per unknown of the problem.
    pub values: Vec<f64>,
    /// Values from plain weighted least squares with uncorrected poses; empty if not requested.
    pub uncorrected: Vec<f64>,
    /// True for each unknown that is at a bound of its allowed range.
    pub at_bound: Vec<bool>,
    /// Covariance matrix of the logarithms of the values, followed by the offsets in the order of `offsets`.
    pub covariance: DMatrix<f64>,
    /// Assembly offsets of equation 9 of the paper, as (bushing, axis, delta0) in J axes. Axes 0 to 2 are lengths, axes 3 to 5 angles in
    /// radians. Empty if offsets are disabled.
    pub offsets: Vec<(usize, usize, f64)>,
    /// Number of weighted least-squares and Levenberg-Marquardt steps over all attempts.
    pub rounds: usize,
    /// True if the iteration converged.
    pub settled: bool,
    /// Chi-square of the pose corrections under the covariance of the poses, plus the prior terms.
    pub chi_square: f64,
    /// Degrees of freedom: number of equations minus number of identified parameters.
    pub dof: usize,
    /// Indices of the load cases that were used.
    pub cases: Vec<usize>,
}

/// Computes the direct solution for all unknowns of a problem.
///
/// # Errors
/// Returns [`IdentifyError`] if no case has the poses of all moving parts, or if the model cannot be compiled.
pub fn solve(
    problem: &Problem<'_>,
    settings: &DirectSettings,
    progress: &mut Progress<'_>,
) -> Result<DirectSolution, IdentifyError> {
    let not_possible = |needs| IdentifyError::NotPossible {
        method: Method::Direct.as_str(),
        needs,
    };
    if problem.unknowns.is_empty() {
        return Err(IdentifyError::NoUnknowns);
    }
    if problem.changes_numbers() {
        return Err(not_possible(
            "unknowns of form = \"value\", not changes or factors",
        ));
    }
    let system = compile(problem.model)?;
    if system.has_data_unknowns() {
        return Err(not_possible(
            "a deck without VARIABLEs and DIFFs whose values are unknowns of the equilibrium",
        ));
    }
    let direct = Direct::new(problem, &system)?;
    if direct.cases.is_empty() {
        return Err(not_possible(
            "three or more marks on every moving part in at least one load case",
        ));
    }
    direct.run(settings, progress)
}

/// Final state of one attempt at the direct solution.
struct Attempt {
    x: DVector<f64>,
    information: DMatrix<f64>,
    settled: bool,
    stopped: bool,
    chi_square: f64,
    dof: usize,
}

struct Direct<'a> {
    problem: &'a Problem<'a>,
    system: &'a System,
    cases: Vec<CaseState>,
    /// Slots of each unknown of the problem, followed by the slot of the preload of each offset.
    slots: Vec<Vec<Slot>>,
    /// Bushing and axis of each offset.
    offsets: Vec<(usize, usize)>,
    loads: Vec<Slot>,
    /// Logarithms of the identified parameters, followed by the offsets.
    x: DVector<f64>,
}

impl<'a> Direct<'a> {
    fn new(problem: &'a Problem<'a>, system: &'a System) -> Result<Self, IdentifyError> {
        let mut slots = Vec::new();
        for unknown in &problem.unknowns {
            let tied = std::iter::once(&unknown.address).chain(unknown.tied());
            slots.push(
                tied.map(|address| slot(system, address))
                    .collect::<Result<_, _>>()?,
            );
        }
        let sd = problem.settings.offset_sd;
        let mut offsets = Vec::new();
        for bushing in problem.bushings() {
            let id = problem.model.bushings[bushing].header.id;
            for axis in 0..6 {
                if sd.of_axis(axis, &problem.model.units) > 0.0 {
                    let argument = if axis < 3 { "FORCE" } else { "TORQUE" };
                    let address = Address {
                        argument: Some(argument.to_string()),
                        ..stiffness(id, axis)
                    };
                    slots.push(vec![slot(system, &address)?]);
                    offsets.push((bushing, axis));
                }
            }
        }
        let loads = problem.programme.loads.iter();
        let loads = loads
            .map(|load| slot(system, &load.target))
            .collect::<Result<_, _>>()?;
        let sigma = problem.measurement.sigma.max(DIRECT_MIN_MARK_SIGMA);
        let cases = problem.measurement.fitted_cases().filter_map(|case| {
            CaseState::new(system, problem.model, problem.measurement, case, sigma)
        });
        let mut x: Vec<f64> = problem
            .initial()
            .iter()
            .map(|value| libm::log(*value))
            .collect();
        x.resize(slots.len(), 0.0);
        Ok(Self {
            cases: cases.collect(),
            x: DVector::from_vec(x),
            problem,
            system,
            slots,
            offsets,
            loads,
        })
    }

    fn values(&self) -> Vec<f64> {
        self.x
            .iter()
            .take(self.problem.unknowns.len())
            .map(|ln| libm::exp(*ln))
            .collect()
    }

    fn run(
        mut self,
        settings: &DirectSettings,
        progress: &mut Progress<'_>,
    ) -> Result<DirectSolution, IdentifyError> {
        let count = self.problem.unknowns.len();
        let start = self.x.clone();
        let mut best: Option<Attempt> = None;
        let mut rounds = 0;
        for weighting in DIRECT_MEASURED_POSE_ROUNDS {
            self.x.clone_from(&start);
            let attempt = self.attempt(weighting, settings, &mut rounds, progress)?;
            let done = attempt.stopped
                || chi_square_p_value(attempt.chi_square, attempt.dof) > DIRECT_ACCEPTED_P_VALUE;
            if best
                .as_ref()
                .is_none_or(|best| attempt.chi_square < best.chi_square)
            {
                best = Some(attempt);
            }
            if done {
                break;
            }
        }
        let Attempt {
            x,
            information,
            settled,
            chi_square,
            dof,
            ..
        } = best.expect("there is at least one attempt");
        self.x = x;
        let x = self.x.clone();
        let uncorrected = if settings.show_bias {
            self.as_measured()?
        } else {
            Vec::new()
        };
        self.x = x;
        let at_bound = (0..count).map(|k| {
            let initial = libm::log(self.problem.unknowns[k].initial);
            (self.x[k] - initial).abs() >= DIRECT_MAX_LN_DISTANCE - 1e-9
        });
        let offsets = self.offsets.iter().enumerate();
        Ok(DirectSolution {
            at_bound: at_bound.collect(),
            offsets: offsets
                .map(|(k, (bushing, axis))| (*bushing, *axis, self.x[count + k]))
                .collect(),
            values: self.values(),
            uncorrected,
            covariance: inverse(&information),
            rounds,
            settled,
            chi_square,
            dof,
            cases: self.cases.iter().map(|case| case.case).collect(),
        })
    }

    /// Makes one attempt at the solution. First takes `weighting` weighted least-squares steps with uncorrected poses. Then minimises the
    /// chi-square of the pose corrections by the Levenberg-Marquardt method.
    fn attempt(
        &mut self,
        weighting: usize,
        settings: &DirectSettings,
        rounds: &mut usize,
        progress: &mut Progress<'_>,
    ) -> Result<Attempt, IdentifyError> {
        let count = self.problem.unknowns.len();
        for case in &mut self.cases {
            case.as_measured();
        }
        for _ in 0..weighting {
            self.round()?;
            *rounds += 1;
        }
        let (mut linear, mut chi_square) = self.corrected()?;
        let (mut damping, mut settled, mut stopped) = (DIRECT_DAMPING, false, false);
        for _ in 0..settings.rounds {
            let (normal, right) = self.normal_equations(&linear);
            let mut damped = normal.clone();
            for k in 0..damped.nrows() {
                damped[(k, k)] *= 1.0 + damping;
            }
            let (lower, upper) = self.bounds();
            let (step, _) = bounded::solve(&damped, &right, &lower, &upper);
            *rounds += 1;
            // A negligible predicted decrease of chi-square also counts as converged, because exact readings are limited by the rounding of
            // their last digit.
            let unnoticed = step.dot(&right) < 1e-4 * (1.0 + 1e-2 * chi_square);
            let before = (self.x.clone(), self.cases.clone());
            self.x += &step;
            let trial = self.corrected();
            let variance = inverse(&normal).diagonal();
            let small = (0..count).all(|k| {
                step[k].abs()
                    < DIRECT_LN_TOLERANCE + DIRECT_SD_TOLERANCE * variance[k].max(0.0).sqrt()
            });
            match trial {
                Ok((next, value)) if value <= chi_square => {
                    (linear, chi_square) = (next, value);
                    damping /= DIRECT_DAMPING_DECREASE;
                    settled = (small || unnoticed) && damping < 1.0;
                }
                _ => {
                    (self.x, self.cases) = before;
                    damping *= DIRECT_DAMPING_INCREASE;
                    settled = (small || unnoticed) && damping < 1.0;
                }
            }
            let change = step.rows(0, count).amax();
            stopped = progress(*rounds, &self.values(), change) == ControlFlow::Break(());
            if settled || stopped || damping > DIRECT_MAX_DAMPING {
                break;
            }
        }
        let (information, _) = self.normal_equations(&linear);
        let rows: usize = linear.iter().map(|case| case.residual.len()).sum();
        Ok(Attempt {
            x: self.x.clone(),
            information,
            settled,
            stopped,
            chi_square,
            dof: rows.saturating_sub(count),
        })
    }

    /// Moves the poses to positions that satisfy the equations for the current parameter values. Returns the equations linearised there, and
    /// chi-square.
    fn corrected(&mut self) -> Result<(Vec<Linearised>, f64), IdentifyError> {
        let nothing = DVector::zeros(self.x.len());
        for _ in 0..DIRECT_POSE_CORRECTIONS {
            let linear = self.linearise()?;
            self.correct(&linear, &nothing);
        }
        let linear = self.linearise()?;
        let misfit = self.misfit(&linear);
        Ok((linear, misfit))
    }

    /// Returns the chi-square of the pose corrections under the covariance of the poses, plus the prior terms.
    fn misfit(&self, linear: &[Linearised]) -> f64 {
        let mut sum = 0.0;
        for case in linear {
            let open = DMatrix::from_columns(std::slice::from_ref(&case.residual));
            sum += open.dot(&weigh(&case.covariance, &open));
        }
        for (k, (mean, sd)) in self.priors().into_iter().enumerate() {
            sum += ((self.x[k] - mean) / sd).powi(2);
        }
        sum
    }

    /// Returns the prior mean and standard deviation of every unknown: logarithms of the parameters, then offsets.
    fn priors(&self) -> Vec<(f64, f64)> {
        let settings = self.problem.settings;
        let unknowns = self.problem.unknowns.iter();
        let stiffnesses = unknowns.map(|unknown| {
            let mean = unknown.mean.unwrap_or(libm::log(unknown.initial));
            (mean, unknown.sd.unwrap_or(settings.prior_log_sd))
        });
        let units = &self.problem.model.units;
        let offset_sd = |axis: usize| settings.offset_sd.of_axis(axis, units);
        let offsets = self.offsets.iter().map(|(_, axis)| (0.0, offset_sd(*axis)));
        stiffnesses.chain(offsets).collect()
    }

    /// Updates the unknowns by one weighted least-squares step at the current poses.
    fn round(&mut self) -> Result<(), IdentifyError> {
        let linear = self.linearise()?;
        let (normal, right) = self.normal_equations(&linear);
        let (lower, upper) = self.bounds();
        self.x += bounded::solve(&normal, &right, &lower, &upper).0;
        Ok(())
    }

    /// Returns the parameter values from plain weighted least squares with uncorrected poses, starting from the current values.
    fn as_measured(&mut self) -> Result<Vec<f64>, IdentifyError> {
        for case in &mut self.cases {
            case.as_measured();
        }
        for _ in 0..5 {
            self.round()?;
        }
        Ok(self.values())
    }

    /// Linearises the equations of every load case with respect to ln K and delta0. An offset adds `K delta0` to the preload in the deck.
    fn linearise(&mut self) -> Result<Vec<Linearised>, IdentifyError> {
        let count = self.problem.unknowns.len();
        let values = self.values();
        let mut parameters = self.system.parameters();
        for (slots, value) in self.slots.iter().zip(&values) {
            for slot in slots {
                parameters.set(*slot, *value);
            }
        }
        let mut stiffnesses = Vec::with_capacity(self.offsets.len());
        for (k, (bushing, axis)) in self.offsets.iter().enumerate() {
            let law = &self.problem.model.bushings[*bushing];
            let deck = if *axis < 3 {
                law.force[*axis]
            } else {
                law.torque[*axis - 3]
            };
            let stiffness = self.problem.stiffnesses(*bushing, &values)[*axis];
            parameters.set(
                self.slots[count + k][0],
                deck + stiffness * self.x[count + k],
            );
            stiffnesses.push(stiffness);
        }
        let mut scratch = Scratch::new(self.system);
        let mut linear = Vec::with_capacity(self.cases.len());
        for case in &mut self.cases {
            let loads = &self.problem.programme.cases[case.case].values;
            for (slot, value) in self.loads.iter().zip(loads) {
                parameters.set(*slot, *value);
            }
            let mut equations = case
                .linearise(self.system, &parameters, &mut scratch, &self.slots)
                .map_err(no_value)?;
            let columns = &mut equations.columns;
            for (k, unknown) in self.problem.unknowns.iter().enumerate() {
                for (o, place) in self.offsets.iter().enumerate() {
                    if unknown.axes().contains(place) {
                        let preload = columns.column(count + o) * self.x[count + o];
                        let mut column = columns.column_mut(k);
                        column += preload;
                    }
                }
                let mut column = columns.column_mut(k);
                column *= values[k];
            }
            for (o, stiffness) in stiffnesses.iter().enumerate() {
                let mut column = columns.column_mut(count + o);
                column *= *stiffness;
            }
            linear.push(equations);
        }
        Ok(linear)
    }

    /// Returns the matrix and right-hand side of the normal equations of a step, including the priors.
    fn normal_equations(&self, linear: &[Linearised]) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.slots.len();
        let (mut normal, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        for case in linear {
            let weighted = weigh(&case.covariance, &case.columns);
            normal += case.columns.transpose() * &weighted;
            right -= weighted.transpose() * &case.residual;
        }
        for (k, (mean, sd)) in self.priors().into_iter().enumerate() {
            let weight = sd.powi(-2);
            normal[(k, k)] += weight;
            right[k] -= weight * (self.x[k] - mean);
        }
        (normal, right)
    }

    /// Returns the lower and upper bounds of a step of each unknown.
    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut lower, mut upper) = (Vec::new(), Vec::new());
        for (k, unknown) in self.problem.unknowns.iter().enumerate() {
            let moved = self.x[k] - libm::log(unknown.initial);
            lower.push((-DIRECT_MAX_LN_STEP).max(-DIRECT_MAX_LN_DISTANCE - moved));
            upper.push(DIRECT_MAX_LN_STEP.min(DIRECT_MAX_LN_DISTANCE - moved));
        }
        lower.resize(self.slots.len(), f64::NEG_INFINITY);
        upper.resize(self.slots.len(), f64::INFINITY);
        (lower, upper)
    }

    /// Moves the poses to their most probable positions after a parameter step: by `misfit - Sigma H^T C^-1 (residual + columns step)`.
    fn correct(&mut self, linear: &[Linearised], step: &DVector<f64>) {
        for (case, linear) in self.cases.iter_mut().zip(linear) {
            let open = &linear.residual + &linear.columns * step;
            let noise = &linear.gain * weigh(&linear.covariance, &DMatrix::from_columns(&[open]));
            let change = &linear.misfit - noise.column(0);
            case.advance(self.system, &change.into_owned());
        }
    }
}

/// Computes `C^-1 X` for a covariance matrix `C`. Rows are scaled internally, so their units do not affect the accuracy.
fn weigh(covariance: &DMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
    let scale = covariance
        .diagonal()
        .map(|c| 1.0 / c.max(f64::MIN_POSITIVE).sqrt());
    let scaled = DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        covariance[(i, j)] * scale[i] * scale[j]
    });
    let mut y = x.clone();
    for (mut row, s) in y.row_iter_mut().zip(scale.iter()) {
        row *= *s;
    }
    let mut solved = match scaled.clone().cholesky() {
        Some(factor) => factor.solve(&y),
        // Redundant constraints make the covariance singular.
        None => pseudo_inverse(scaled, 1e-12).map_or_else(|| y.clone(), |inverse| inverse * &y),
    };
    for (mut row, s) in solved.row_iter_mut().zip(scale.iter()) {
        row *= *s;
    }
    solved
}

fn inverse(information: &DMatrix<f64>) -> DMatrix<f64> {
    let count = information.nrows();
    let scale = information
        .diagonal()
        .map(|d| 1.0 / d.max(f64::MIN_POSITIVE).sqrt());
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        information[(i, j)] * scale[i] * scale[j]
    });
    let inverse = scaled
        .clone()
        .cholesky()
        .map(|factor| factor.inverse())
        .or_else(|| pseudo_inverse(scaled, 1e-13));
    let inverse = inverse.unwrap_or_else(|| DMatrix::zeros(count, count));
    DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j])
}

fn no_value(error: NoValue) -> IdentifyError {
    IdentifyError::NoCases(Some(admire_session::backend::CaseFailure::NoEquilibrium(
        error.into(),
    )))
}
