//! Newton's method on the static equations, with step control that acts only if the full step fails.

use super::balance::Sum;
use super::measures::{
    balanced, far, force_imbalance, largest, limit, motion_norm, relative_correction,
};
use super::minimum_norm::FreeMotionSpace;
use super::path::{add_damping, add_stability};
use super::rank::{free_motions, redundant_equations};
use super::{Balance, Iteration, Report, SolveError, StaticSettings, Tangent};
use crate::linear::{Lu, Matrix};
use crate::mechanics::Pose;
use crate::system::{NoValue, Parameters, Scratch, State, System};

/// Round-off along a free motion is assigned to an equation without a pivot only if the motion's component there exceeds this share of its largest
/// component.
const LEAST_SHARE: f64 = 1e-6;
/// ADAMS' default of STABILITY. Up to this value, the only effect of STABILITY is to hold free motions of parts with mass.
const DEFAULT_STABILITY: f64 = 1e-5;
/// Number of shortened steps above which a sequence of iterations is given up.
const CREEPING: usize = 10;
/// Shortest fraction of a Newton step that the line search tries.
const SHORTEST: f64 = 1.0 / 256.0;
/// Relative correction below which the factors of an earlier iteration are tried first.
const NEAR: f64 = 1e-3;
/// Relative correction below which an increase of the residual may be round-off. The step is then taken without a test.
const NOISE: f64 = 1e-9;
/// Relative error of the numbers written in a deck, which have about ten digits.
const WRITTEN: f64 = 1e-9;
/// Scaled pivots below this count as zero in a model that is declared to have free motions. Near an equilibrium, round-off of large forces and
/// the remaining imbalance give a free motion a little stiffness.
const FREE_MOTION_RANK_TOLERANCE: f64 = 1e-8;
/// Largest allowed violation of a removed constraint equation, as a share of the model's length.
const CONSISTENT: f64 = 1e-6;

/// Finds one equilibrium with work space of its own. To find many equilibria, use one [`Solver`].
///
/// # Errors
/// Returns [`SolveError`]; the state is then unchanged.
pub fn solve(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    settings: &StaticSettings,
) -> Result<Report, SolveError> {
    Solver::new(system).solve(system, parameters, state, settings)
}

/// Static solver for one system. Successive solutions share its work space.
#[derive(Clone, Debug)]
pub struct Solver {
    pub(super) scratch: Scratch,
    /// Factors of the Jacobian in use.
    pub(super) matrix: Lu,
    /// Tangent taken back by [`Self::give_back`], whose memory the next tangent reuses.
    spare: Option<Tangent>,
    /// Jacobian that was assembled last.
    pub(super) next: Matrix,
    pub(super) g: Vec<f64>,
    pub(super) g_trial: Vec<f64>,
    pub(super) dx: Vec<f64>,
    dx_bar: Vec<f64>,
    step: Vec<f64>,
    /// Residual at the start of load continuation. Load continuation subtracts a fraction of it from the residual, and lowers this fraction to
    /// zero in steps.
    pub(super) held: Vec<f64>,
    pub(super) start: State,
    /// True if initial multipliers were computed because all given multipliers were zero.
    began: bool,
    trial: State,
    pub(super) history: Vec<Iteration>,
    shortened: usize,
    pub(super) limited: usize,
    at_roundoff: bool,
    factorisations: usize,
    /// Number of iterations that are still allowed.
    pub(super) remaining: usize,
    /// Poses of the equilibrium at which the factors were computed. Empty if the factors do not belong to an equilibrium.
    pub(super) poses: Vec<Pose>,
    /// Worst balance of all equilibria found so far.
    worst: Option<Balance>,
    /// Work space for the sums of a balance.
    sums: Vec<Sum>,
}

/// Reason why a sequence of iterations found no equilibrium.
pub(super) enum Failure {
    NotConverged,
    NoValue(NoValue),
}

impl From<NoValue> for Failure {
    fn from(reason: NoValue) -> Self {
        Self::NoValue(reason)
    }
}

/// Options of a sequence of iterations.
#[derive(Clone, Copy)]
pub(super) struct NewtonOptions {
    /// Fraction of the initial residual ([`Solver::held`]) that is subtracted from the residual; zero except in load continuation.
    pub held: f64,
    pub damped: bool,
    /// True if the factors are from an earlier iteration.
    pub keep: bool,
    pub error: f64,
    pub imbalance: f64,
    pub maxit: usize,
}

impl Solver {
    /// Allocates the work space for a system.
    pub fn new(system: &System) -> Self {
        let n = system.unknowns;
        Self {
            scratch: Scratch::new(system),
            matrix: Lu::new(n),
            spare: None,
            next: Matrix::new(n),
            g: vec![0.0; n],
            g_trial: vec![0.0; n],
            dx: vec![0.0; n],
            dx_bar: vec![0.0; n],
            step: vec![0.0; n],
            held: vec![0.0; n],
            start: system.state(),
            began: false,
            trial: system.state(),
            history: Vec::with_capacity(64),
            shortened: 0,
            limited: 0,
            at_roundoff: false,
            factorisations: 0,
            remaining: usize::MAX,
            poses: Vec::new(),
            worst: None,
            sums: Vec::new(),
        }
    }

    /// Returns the work space, for evaluations of the system between two solutions.
    pub fn scratch(&mut self) -> &mut Scratch {
        &mut self.scratch
    }

    /// Discards the results of earlier solutions except the worst balance. The next solution then computes its own factors.
    pub fn forget(&mut self, system: &System) {
        *self = Self {
            worst: self.worst.take(),
            ..Self::new(system)
        };
    }

    /// Finds the equilibrium next to the given state and moves the state there.
    ///
    /// # Errors
    /// Returns [`SolveError`]; the state is then unchanged.
    pub fn solve(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
    ) -> Result<Report, SolveError> {
        self.start.clone_from(state);
        self.began = false;
        let result = self.attempt(system, parameters, state, settings);
        if result.is_err() {
            state.clone_from(&self.start);
            if self.began {
                state.multipliers.fill(0.0);
            }
        }
        result
    }

    fn attempt(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
    ) -> Result<Report, SolveError> {
        let mut report = Report::default();
        let from_afar = self.poses != state.poses;
        self.factorisations = 0;
        self.remaining = settings.budget.unwrap_or(usize::MAX);
        if state.redundant.len() != system.equations {
            self.find_redundant(system, parameters, state)?;
        }
        self.give_values(system, parameters, state)?;
        self.began = self.first_multipliers(system, parameters, state)?;
        self.start.multipliers.clone_from(&state.multipliers);
        let plain = NewtonOptions {
            held: 0.0,
            damped: false,
            keep: false,
            error: settings.error,
            imbalance: settings.imbalance,
            maxit: settings.maxit,
        };
        let result = self.iterate(system, parameters, state, settings, plain);
        report.iterations += self.history.len();
        if let Err(failure) = result {
            // The plain iteration is the method that users expect. Its failure is reported if continuation fails, too.
            let error = self.explain(system, parameters, state, settings, failure);
            if !settings.continuation || self.remaining == 0 {
                return Err(error);
            }
            let (help, more) = self.continuation(system, parameters, state, settings, plain);
            report.iterations += more;
            if help.is_none() {
                return Err(error);
            }
            report.continuation = help;
        } else if settings.continuation && from_afar && self.limited > 0 {
            self.leave_saddle(system, parameters, state, settings, plain, &mut report)?;
        }
        if self.matrix.deficiency() > 0 {
            // The factors may be several iterations old, but the free motions must be those of this state.
            self.assemble(system, parameters, state)?;
            self.matrix.factor(&self.next);
        }
        match free_motions(system, parameters, state, &self.next, &self.matrix) {
            Ok(motions) => report.free_motions = motions,
            Err(massless) => return Err(SolveError::FreeMotion(massless)),
        }
        self.check_removed(system, parameters, state, &mut report)?;
        system.accept(parameters, state, &mut self.scratch);
        report.imbalance = largest(&self.g);
        report.correction = self.history.last().map_or(0.0, |i| i.correction);
        report.history.clone_from(&self.history);
        report.far = far(system, &self.start, state);
        report.shortened = self.shortened;
        report.at_roundoff = self.at_roundoff;
        report.factorisations = self.factorisations;
        self.check_balance(system, parameters, state, settings, &mut report)?;
        self.poses.clone_from(&state.poses);
        Ok(report)
    }

    /// Sums the forces on every part again, independently of the residual. A remaining force is accepted if the iteration stopped at the
    /// round-off of the model (`at_roundoff`). Otherwise, a remaining force beyond the tolerances is an error.
    pub(super) fn check_balance(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        settings: &StaticSettings,
        report: &mut Report,
    ) -> Result<(), SolveError> {
        let (scratch, sums) = (&mut self.scratch, &mut self.sums);
        report.balance = Balance::summed(system, parameters, state, scratch, sums)?;
        if !report.at_roundoff && !report.balance.holds(settings.imbalance) {
            return Err(SolveError::Unbalanced(Box::new(report.balance.clone())));
        }
        self.worst.get_or_insert_default().or_worse(&report.balance);
        Ok(())
    }

    /// Returns the worst balance of all equilibria found so far; `None` before the first one.
    pub fn worst_balance(&self) -> Option<&Balance> {
        self.worst.as_ref()
    }

    /// Returns true if the last solution has a motion without stiffness.
    pub fn has_free_motions(&self) -> bool {
        self.matrix.deficiency() > 0
    }

    /// Declares that the model has free motions; scaled pivots below 1e-8 then count as zero.
    pub fn expect_free_motions(&mut self) {
        self.matrix.set_rank_tolerance(FREE_MOTION_RANK_TOLERANCE);
    }

    /// Linearises the equations at an equilibrium and factors the Jacobian.
    ///
    /// # Errors
    /// Returns [`SolveError::NoValue`] if an element has no value in this state.
    pub fn tangent(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<Tangent, SolveError> {
        let fresh = || Tangent::with(system, self.matrix.clone());
        let mut tangent = self.spare.take().unwrap_or_else(fresh);
        tangent.linearise(system, parameters, state, &mut self.next)?;
        Ok(tangent)
    }

    /// Takes back a tangent of the same system, so that the next tangent can reuse its memory.
    pub fn give_back(&mut self, tangent: Tangent) {
        self.spare = Some(tangent);
    }

    /// Marks the constraint equations that are redundant in the configuration of the state.
    fn find_redundant(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<(), SolveError> {
        state.redundant.clear();
        self.next.clear();
        let (scratch, g, next) = (&mut self.scratch, &mut self.g, &mut self.next);
        system.assemble_leniently(parameters, state, scratch, g, next)?;
        self.next.finish();
        state.redundant = redundant_equations(system, &self.next);
        for (redundant, multiplier) in state.redundant.iter().zip(&mut state.multipliers) {
            if *redundant {
                *multiplier = 0.0;
            }
        }
        Ok(())
    }

    /// Checks that the removed equations are satisfied, and lists the redundant equations in the report.
    fn check_removed(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        report: &mut Report,
    ) -> Result<(), SolveError> {
        if !state.redundant.contains(&true) {
            return Ok(());
        }
        self.trial.clone_from(state);
        self.trial.redundant.fill(false);
        let (scratch, g) = (&mut self.scratch, &mut self.g_trial);
        system.residual(parameters, &self.trial, scratch, g)?;
        for (k, _) in state.redundant.iter().enumerate().filter(|(_, r)| **r) {
            let equation = system.constraint_equation_name(k);
            let violation = self.g_trial[system.first_equation + k].abs();
            if violation > CONSISTENT * system.length.max(1.0) {
                return Err(SolveError::Inconsistent {
                    equation: equation.to_string(),
                    violation,
                });
            }
            // A deactivated equation is removed without being redundant.
            if system.equation_is_active(k) {
                report.redundant.push(equation);
            }
        }
        Ok(())
    }

    /// Assembles the Jacobian at a state. Overwrites `g_trial` with the residual.
    pub(super) fn assemble(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<(), NoValue> {
        self.next.clear();
        let (scratch, g, next) = (&mut self.scratch, &mut self.g_trial, &mut self.next);
        system.assemble(parameters, state, scratch, g, next)?;
        self.next.finish();
        Ok(())
    }

    /// Computes the residual at the trial state. Subtracts the fraction `way.held` of the initial residual, as load continuation requires.
    fn evaluate(
        &mut self,
        system: &System,
        parameters: &Parameters,
        way: NewtonOptions,
    ) -> Result<(), NoValue> {
        let (scratch, g) = (&mut self.scratch, &mut self.g_trial);
        system.residual(parameters, &self.trial, scratch, g)?;
        self.hold(way);
        Ok(())
    }

    fn hold(&mut self, way: NewtonOptions) {
        if way.held > 0.0 {
            for (g, held) in self.g_trial.iter_mut().zip(&self.held) {
                *g -= way.held * held;
            }
        }
    }

    pub(super) fn iterate(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        way: NewtonOptions,
    ) -> Result<(), Failure> {
        self.history.clear();
        (self.shortened, self.limited) = (0, 0);
        self.at_roundoff = false;
        // The factors from the last equilibrium form the tangent that predicts the next equilibrium.
        let mut keep = self.poses == state.poses && !way.damped && way.held == 0.0;
        self.poses.clear();
        self.trial.clone_from(state);
        self.evaluate(system, parameters, way)?;
        std::mem::swap(&mut self.g, &mut self.g_trial);
        let first = largest(&self.g).max(f64::MIN_POSITIVE);
        // With this damping, the first step is about half of TLIMIT.
        let damping = 2.0 * force_imbalance(system, &self.g) / settings.tlimit;
        let mut iteration = 0;
        while iteration < way.maxit && self.remaining > 0 {
            let imbalance = largest(&self.g);
            if !imbalance.is_finite() {
                return Err(Failure::NotConverged);
            }
            if !keep && (settings.new_jacobian(iteration) || iteration == 0 || way.damped) {
                self.assemble(system, parameters, state)?;
                if settings.stability > DEFAULT_STABILITY * (1.0 + 1e-9) {
                    add_stability(
                        system,
                        parameters,
                        state,
                        settings.stability,
                        &mut self.next,
                    );
                }
                if way.damped {
                    let fraction = (imbalance / first).min(1.0);
                    add_damping(system, damping * fraction, &mut self.next);
                }
                self.matrix.factor(&self.next);
                self.factorisations += 1;
            }
            for (dx, g) in self.dx.iter_mut().zip(&self.g) {
                *dx = -g;
            }
            self.matrix.solve(&mut self.dx);
            FreeMotionSpace::of(system, &self.matrix).project(&mut self.dx);
            let mut correction = relative_correction(system, state, &self.dx);
            if iteration == 0
                && correction > NEAR
                && balanced(system, &self.g, way.imbalance, 0.0)
                && self.is_noise(system, state, WRITTEN)
            {
                // The state is in equilibrium to the precision of the deck's numbers. The equations are nearly singular: the correction is only
                // the magnified rounding of these numbers.
                self.dx.fill(0.0);
                correction = 0.0;
            }
            let limit = limit(system, settings, &self.dx);
            if limit < 1.0 {
                self.limited += 1;
            }
            let way_now = NewtonOptions { keep, ..way };
            let Some(step) = self.take(system, parameters, state, way_now, (limit, correction))?
            else {
                // The old factors are not accurate enough: the iteration is repeated with new ones.
                keep = false;
                continue;
            };
            iteration += 1;
            self.remaining -= 1;
            let before = self.history.last().map_or(f64::INFINITY, |i| i.correction);
            self.history.push(Iteration {
                imbalance,
                correction,
                step,
            });
            // A search with many shortened steps makes no progress. It ends here, so that another method can be tried.
            if self.shortened > CREEPING && settings.continuation && !way.damped {
                return Err(Failure::NotConverged);
            }
            std::mem::swap(state, &mut self.trial);
            std::mem::swap(&mut self.g, &mut self.g_trial);
            if step < 1.0 {
                keep = false;
                continue;
            }
            let noise = self.scratch.largest;
            if correction < way.error && balanced(system, &self.g, way.imbalance, noise) {
                return Ok(());
            }
            // The residual is at the round-off of stiffness times position. Further iterations do not reduce it.
            if largest(&self.g) > 0.1 * imbalance
                && self.is_noise(system, state, 8.0 * f64::EPSILON)
            {
                self.at_roundoff = true;
                return Ok(());
            }
            // Close to convergence the factors change so little that old ones suffice.
            let falling = !keep || correction < 0.1 * before;
            keep = !way.damped && correction < NEAR && falling;
        }
        Err(Failure::NotConverged)
    }

    /// Moves along `dx` to the trial state, and returns the fraction of the step that was taken. The full (limited) step is taken unless it increases
    /// both the residual and the next correction (Deuflhard's natural monotonicity test). In that case, shorter steps are tried. If `way.keep` is
    /// true (factors of an earlier Jacobian), `None` is returned instead.
    fn take(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        way: NewtonOptions,
        (limit, correction): (f64, f64),
    ) -> Result<Option<f64>, Failure> {
        let mut step = limit;
        loop {
            for (s, dx) in self.step.iter_mut().zip(&self.dx) {
                *s = step * dx;
            }
            self.trial.clone_from(state);
            system.advance(&mut self.trial, &self.step);
            let trust = way.damped || correction < NOISE || step <= SHORTEST;
            match self.evaluate(system, parameters, way) {
                Err(reason) if step <= SHORTEST => return Err(reason.into()),
                Err(_) => {}
                Ok(()) => {
                    if trust || self.is_better(system, step) {
                        return Ok(Some(step));
                    }
                }
            }
            if way.keep {
                return Ok(None);
            }
            self.shortened += 1;
            step *= 0.5;
        }
    }

    /// Returns true if an error `relative` of positions, angles, multipliers and variables explains every residual. Each residual is then at
    /// most the effect of this relative error on the terms of its equation. Overwrites `dx_bar` and `step`.
    fn is_noise(&mut self, system: &System, state: &State, relative: f64) -> bool {
        let floor = &mut self.dx_bar;
        floor.fill(0.0);
        let scales = &mut self.step;
        scales.fill(0.0);
        for (body, pose) in system.bodies.iter().zip(&state.poses) {
            for k in 0..body.freedoms {
                scales[body.first + k] = if k < 3 {
                    pose.p.amax().max(system.length)
                } else {
                    1.0
                };
            }
        }
        for (k, multiplier) in state.multipliers.iter().enumerate() {
            scales[system.first_equation + k] = multiplier.abs();
        }
        for (k, unknown) in system.implicit_variables() {
            scales[unknown] = state.variables[k].abs();
        }
        for (row, column, value) in self.next.entries() {
            floor[row] += value.abs() * scales[column];
        }
        // The round-off of a force or torque depends on its magnitude, not on its direction. The largest component therefore applies to all
        // three axes: along a free motion the terms vanish and would show no round-off.
        for body in &system.bodies {
            for first in (0..body.freedoms).step_by(3) {
                let own = &mut floor[body.first + first..body.first + first + 3];
                let most = own.iter().copied().fold(0.0, f64::max);
                own.fill(most);
            }
        }
        // A free motion leaves one equation without a pivot. The round-off of all other equations of the motion accumulates in this equation.
        for m in 0..self.matrix.deficiency() {
            let z = self.matrix.null_vector(m);
            let gathered: f64 = z.iter().zip(floor.iter()).map(|(z, f)| z.abs() * f).sum();
            let least = LEAST_SHARE * largest(&z[..system.first_equation]);
            for &row in self.matrix.rows_without_pivot() {
                let row = row as usize;
                if z[row].abs() > least {
                    floor[row] = floor[row].max(gathered / z[row].abs());
                }
            }
        }
        self.g
            .iter()
            .zip(floor)
            .all(|(g, floor)| g.abs() <= relative * *floor)
    }

    fn is_better(&mut self, system: &System, step: f64) -> bool {
        let before = self.matrix.scaled_norm(&self.g);
        let after = self.matrix.scaled_norm(&self.g_trial);
        if after <= before {
            return true;
        }
        if !after.is_finite() {
            return false;
        }
        for (dx, g) in self.dx_bar.iter_mut().zip(&self.g_trial) {
            *dx = -g;
        }
        self.matrix.solve(&mut self.dx_bar);
        FreeMotionSpace::of(system, &self.matrix).project(&mut self.dx_bar);
        motion_norm(system, &self.dx_bar) <= (1.0 - 0.25 * step) * motion_norm(system, &self.dx)
    }
}
