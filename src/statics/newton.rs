//! Newton's method on the static equations, with step control that is only used where the plain step fails.

use super::lu::Lu;
use super::matrix::Matrix;
use super::rank::{free_motion, redundant_equations};
use super::{Continuation, Iteration, Report, Settings, SolveError, Tangent};
use crate::mechanics::{Mat6, Pose, Vec3, skew};
use crate::system::{NoValue, Parameters, Scratch, State, System};

/// ADAMS' default of STABILITY: up to here it only holds massive free motions.
const DEFAULT_STABILITY: f64 = 1e-5;
/// So many shortened steps in one sequence are too many.
const CREEPING: usize = 10;
/// Shortest fraction of a step the line search tries.
const SHORTEST: f64 = 1.0 / 256.0;
/// Relative corrections below which old factors are tried.
const NEAR: f64 = 1e-3;
/// Relative size of corrections and imbalances that may be round-off.
const NOISE: f64 = 1e-9;
/// A removed constraint equation may be violated by so much of the model's length.
const CONSISTENT: f64 = 1e-6;

/// Solves one equilibrium with memory of its own. Those who solve many keep a [`Solver`].
///
/// # Errors
/// [`SolveError`]; the state is then as it was.
pub fn solve(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    settings: &Settings,
) -> Result<Report, SolveError> {
    Solver::new(system).solve(system, parameters, state, settings)
}

/// Memory for solving one system again and again: nothing is allocated per iteration.
#[derive(Clone, Debug)]
pub struct Solver {
    scratch: Scratch,
    /// Factors of the last Jacobian in use.
    matrix: Lu,
    /// Assembled at the trial state.
    next: Matrix,
    g: Vec<f64>,
    g_trial: Vec<f64>,
    dx: Vec<f64>,
    dx_bar: Vec<f64>,
    step: Vec<f64>,
    /// What is not yet released of the imbalance at the start.
    held: Vec<f64>,
    start: State,
    trial: State,
    history: Vec<Iteration>,
    shortened: usize,
    limited: usize,
    at_roundoff: bool,
    factorisations: usize,
    /// Where the factors are the tangent of an equilibrium.
    poses: Vec<Pose>,
}

/// Why a sequence of iterations ended without an answer.
enum Failure {
    NotConverged,
    NoValue(NoValue),
}

impl From<NoValue> for Failure {
    fn from(reason: NoValue) -> Self {
        Self::NoValue(reason)
    }
}

/// How a sequence of iterations is run.
#[derive(Clone, Copy)]
struct Way {
    /// Fraction of `held` that still acts against the imbalance.
    held: f64,
    damped: bool,
    /// The factors are those of an earlier iteration.
    keep: bool,
    error: f64,
    imbalance: f64,
    maxit: usize,
}

impl Solver {
    /// Memory for a system.
    pub fn new(system: &System) -> Self {
        let n = system.unknowns;
        Self {
            scratch: Scratch::new(system),
            matrix: Lu::new(n),
            next: Matrix::new(n),
            g: vec![0.0; n],
            g_trial: vec![0.0; n],
            dx: vec![0.0; n],
            dx_bar: vec![0.0; n],
            step: vec![0.0; n],
            held: vec![0.0; n],
            start: system.state(),
            trial: system.state(),
            history: Vec::with_capacity(64),
            shortened: 0,
            limited: 0,
            at_roundoff: false,
            factorisations: 0,
            poses: Vec::new(),
        }
    }

    /// Finds the equilibrium next to the state and puts it there.
    ///
    /// # Errors
    /// [`SolveError`]; the state is then as it was.
    pub fn solve(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &Settings,
    ) -> Result<Report, SolveError> {
        self.start.clone_from(state);
        let result = self.attempt(system, parameters, state, settings);
        if result.is_err() {
            state.clone_from(&self.start);
        }
        result
    }

    fn attempt(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &Settings,
    ) -> Result<Report, SolveError> {
        let mut report = Report::default();
        self.factorisations = 0;
        if state.redundant.len() != system.equations {
            self.find_redundant(system, parameters, state)?;
        }
        let plain = Way {
            held: 0.0,
            damped: false,
            keep: false,
            error: settings.error,
            imbalance: settings.imbalance,
            maxit: settings.maxit,
        };
        let mut result = self.iterate(system, parameters, state, settings, plain);
        report.iterations += self.history.len();
        if result.is_err() && settings.continuation {
            let first = (std::mem::take(&mut self.history), self.limited);
            let (help, more) = self.continuation(system, parameters, state, settings, plain);
            report.iterations += more;
            if let Some(help) = help {
                report.continuation = Some(help);
                result = Ok(());
            } else {
                // The plain iteration is what the user knows: its history is told.
                (self.history, self.limited) = first;
            }
        }
        if let Err(failure) = result {
            return Err(self.explain(system, parameters, state, settings, failure));
        }
        if self.matrix.deficiency() > 0 {
            // The factors may be some iterations old, the free motions are to be those of here.
            self.assemble(system, parameters, state)?;
            self.matrix.factor(&self.next);
        }
        for m in 0..self.matrix.deficiency() {
            let z = self.matrix.null_vector(m);
            if let Some(motion) = free_motion(system, parameters, state, &z) {
                if !motion.has_mass {
                    return Err(SolveError::FreeMotion(motion));
                }
                report.free_motions.push(motion);
            }
        }
        self.check_removed(system, parameters, state, &mut report)?;
        system.accept(parameters, state, &mut self.scratch);
        report.imbalance = largest(&self.g);
        report.correction = self.history.last().map_or(0.0, |i| i.correction);
        report.history.clone_from(&self.history);
        report.shortened = self.shortened;
        report.at_roundoff = self.at_roundoff;
        report.factorisations = self.factorisations;
        self.poses.clone_from(&state.poses);
        Ok(report)
    }

    /// The linearised equations at an equilibrium.
    ///
    /// # Errors
    /// [`SolveError::NoValue`] if an element has no value there.
    pub fn tangent(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<Tangent, SolveError> {
        let factors = self.matrix.clone();
        Tangent::with(system, parameters, state, (factors, &mut self.next))
    }

    /// Marks the constraint equations that say nothing new in this configuration.
    fn find_redundant(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<(), SolveError> {
        state.redundant.clear();
        self.next.clear();
        let (scratch, g, next) = (&mut self.scratch, &mut self.g, &mut self.next);
        system.assemble(parameters, state, scratch, g, next)?;
        self.next.finish();
        state.redundant = redundant_equations(system, &self.next);
        for (redundant, multiplier) in state.redundant.iter().zip(&mut state.multipliers) {
            if *redundant {
                *multiplier = 0.0;
            }
        }
        Ok(())
    }

    /// Removed equations must hold all the same.
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
                    equation,
                    violation,
                });
            }
            report.redundant.push(equation);
        }
        Ok(())
    }

    /// Jacobian at the state; `g_trial` is overwritten.
    fn assemble(
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

    /// Residual at the trial state, the held part of the first imbalance taken off.
    fn evaluate(
        &mut self,
        system: &System,
        parameters: &Parameters,
        way: Way,
    ) -> Result<(), NoValue> {
        let (scratch, g) = (&mut self.scratch, &mut self.g_trial);
        system.residual(parameters, &self.trial, scratch, g)?;
        self.hold(way);
        Ok(())
    }

    fn hold(&mut self, way: Way) {
        if way.held > 0.0 {
            for (g, held) in self.g_trial.iter_mut().zip(&self.held) {
                *g -= way.held * held;
            }
        }
    }

    fn iterate(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &Settings,
        way: Way,
    ) -> Result<(), Failure> {
        self.history.clear();
        (self.shortened, self.limited) = (0, 0);
        self.at_roundoff = false;
        // The factors of the last equilibrium are the tangent that predicts the next one.
        let mut keep = self.poses == state.poses && !way.damped && way.held == 0.0;
        self.poses.clear();
        self.trial.clone_from(state);
        self.evaluate(system, parameters, way)?;
        std::mem::swap(&mut self.g, &mut self.g_trial);
        let first = largest(&self.g).max(f64::MIN_POSITIVE);
        // The first damped step is about half of TLIMIT long.
        let damping = 2.0 * force_imbalance(system, &self.g) / settings.tlimit;
        let mut iteration = 0;
        while iteration < way.maxit {
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
            let correction = relative_correction(system, state, &self.dx);
            let limit = limit(system, settings, &self.dx);
            if limit < 1.0 {
                self.limited += 1;
            }
            let way_now = Way { keep, ..way };
            let Some(step) = self.take(system, parameters, state, way_now, (limit, correction))?
            else {
                // The old factors do not serve: the same place again with new ones.
                keep = false;
                continue;
            };
            iteration += 1;
            let before = self.history.last().map_or(f64::INFINITY, |i| i.correction);
            self.history.push(Iteration {
                imbalance,
                correction,
                step,
            });
            // A search that creeps has lost its way: something else should be tried.
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
            // Below round-off of stiffness times position no iteration gets any further.
            if largest(&self.g) > 0.1 * imbalance && self.is_noise(system, state) {
                self.at_roundoff = true;
                return Ok(());
            }
            // Near the end the factors change so little that old ones do.
            let falling = !keep || correction < 0.1 * before;
            keep = !way.damped && correction < NEAR && falling;
        }
        Err(Failure::NotConverged)
    }

    /// Goes along `dx` to the trial state. The whole (limited) step is taken unless it makes things worse in the residual and in
    /// the next correction (Deuflhard's natural monotonicity test); then shorter ones are tried, or none if the factors are old.
    fn take(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        way: Way,
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

    /// True if every equation is within what round-off of positions, angles and multipliers makes of its terms. `dx_bar` is
    /// overwritten.
    fn is_noise(&mut self, system: &System, state: &State) -> bool {
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
        for (k, variable) in state.variables.iter().enumerate() {
            scales[system.first_variable + k] = variable.abs();
        }
        for (row, column, value) in self.next.entries() {
            floor[row] += value.abs() * scales[column];
        }
        self.g
            .iter()
            .zip(floor)
            .all(|(g, floor)| g.abs() <= 8.0 * f64::EPSILON * *floor)
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
        motion_norm(system, &self.dx_bar) <= (1.0 - 0.25 * step) * motion_norm(system, &self.dx)
    }

    /// Ways to an equilibrium that plain iteration does not find. Gives the one that helped and the iterations used.
    fn continuation(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &Settings,
        plain: Way,
    ) -> (Option<Continuation>, usize) {
        let mut iterations = 0;
        let start = self.start.clone();
        let reset = |state: &mut State| {
            let redundant = std::mem::take(&mut state.redundant);
            state.clone_from(&start);
            state.redundant = redundant;
        };
        reset(state);
        let damped = Way {
            damped: true,
            maxit: 200,
            error: 1e-3,
            imbalance: plain.imbalance.max(1e-6 * self.scratch.largest),
            ..plain
        };
        let found = self.iterate(system, parameters, state, settings, damped);
        iterations += self.history.len();
        if found.is_ok() {
            let found = self.iterate(system, parameters, state, settings, plain);
            iterations += self.history.len();
            if found.is_ok() {
                return (Some(Continuation::Damped), iterations);
            }
        }
        reset(state);
        if system
            .residual(parameters, state, &mut self.scratch, &mut self.held)
            .is_err()
        {
            return (None, iterations);
        }
        let (mut released, mut increment, mut steps) = (0.0_f64, 0.25_f64, 0);
        while released < 1.0 && steps < 200 {
            let goal = (released + increment).min(1.0);
            let way = Way {
                held: 1.0 - goal,
                maxit: 15,
                error: 1e-3,
                imbalance: 1e-4 * largest(&self.held),
                ..plain
            };
            let before = state.clone();
            let found = self.iterate(system, parameters, state, settings, way);
            iterations += self.history.len();
            steps += 1;
            if found.is_ok() {
                released = goal;
                increment *= 2.0;
            } else {
                state.clone_from(&before);
                increment *= 0.5;
                if increment < 1e-3 {
                    return (None, iterations);
                }
            }
        }
        let found = self.iterate(system, parameters, state, settings, plain);
        iterations += self.history.len();
        (
            found.is_ok().then_some(Continuation::Load { steps }),
            iterations,
        )
    }

    /// What to tell about a failure.
    fn explain(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        settings: &Settings,
        failure: Failure,
    ) -> SolveError {
        if let Failure::NoValue(reason) = failure {
            return reason.into();
        }
        let mut causes = Vec::new();
        for m in 0..self.matrix.deficiency() {
            let z = self.matrix.null_vector(m);
            if let Some(motion) = free_motion(system, parameters, state, &z) {
                if !motion.has_mass {
                    return SolveError::FreeMotion(motion);
                }
                causes.push(format!("{motion}, and something drives it"));
            }
        }
        if self.limited > 0 {
            causes.push(format!(
                "{} steps were cut to TLIMIT={} or ALIMIT={} degrees: the start is far from equilibrium",
                self.limited,
                settings.tlimit,
                settings.alimit.to_degrees().round()
            ));
        }
        let worst = self
            .g
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .map_or(0, |(k, _)| k);
        SolveError::NotConverged {
            worst: system.equation_name(worst),
            imbalance: self.g.get(worst).copied().unwrap_or(0.0),
            history: self.history.clone(),
            causes,
        }
    }
}

fn largest(g: &[f64]) -> f64 {
    // A NaN must not hide.
    g.iter().fold(
        0.0,
        |a: f64, b| {
            if b.is_nan() { f64::NAN } else { a.max(b.abs()) }
        },
    )
}

fn force_imbalance(system: &System, g: &[f64]) -> f64 {
    let mut out = 0.0_f64;
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 { 1.0 } else { system.length };
            out = out.max(g[body.first + k].abs() / scale);
        }
    }
    out
}

/// Every equation within IMBALANCE, or within what round-off leaves of the forces that cancel in it.
fn balanced(system: &System, g: &[f64], imbalance: f64, force: f64) -> bool {
    let floor = 64.0 * f64::EPSILON * force;
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 { 1.0 } else { 4.0 * system.length };
            if !(g[body.first + k].abs() <= imbalance.max(floor * scale)) {
                return false;
            }
        }
    }
    let floor = 64.0 * f64::EPSILON * system.length;
    g[system.first_equation..]
        .iter()
        .all(|g| g.abs() <= imbalance.max(floor))
}

/// Largest correction: translations by the larger of position and model length, rotations in radians, multipliers by the
/// largest of them, variables and states by the larger of their value and one.
fn relative_correction(system: &System, state: &State, dx: &[f64]) -> f64 {
    let mut out = 0.0_f64;
    for (body, pose) in system.bodies.iter().zip(&state.poses) {
        let d = &dx[body.first..body.first + body.freedoms];
        for k in 0..body.freedoms {
            let scale = if k < 3 {
                pose.p[k].abs().max(system.length)
            } else {
                1.0
            };
            out = out.max(d[k].abs() / scale);
        }
    }
    let largest = state
        .multipliers
        .iter()
        .fold(1.0_f64, |a, b| a.max(b.abs()));
    for d in &dx[system.first_equation..system.first_variable] {
        out = out.max(d.abs() / largest);
    }
    for (d, v) in dx[system.first_variable..].iter().zip(&state.variables) {
        out = out.max(d.abs() / v.abs().max(1.0));
    }
    for (equation, value) in system.states.iter().zip(&state.states) {
        if let Some(unknown) = equation.unknown {
            out = out.max(dx[unknown].abs() / value.abs().max(1.0));
        }
    }
    out
}

/// The fraction of the step that keeps every part within TLIMIT and ALIMIT.
fn limit(system: &System, settings: &Settings, dx: &[f64]) -> f64 {
    let (mut shift, mut turn) = (0.0_f64, 0.0_f64);
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let d = dx[body.first + k].abs();
            if k < 3 {
                shift = shift.max(d);
            } else {
                turn = turn.max(d);
            }
        }
    }
    let mut out = 1.0;
    if shift > settings.tlimit {
        out = settings.tlimit / shift;
    }
    if turn * out > settings.alimit {
        out = settings.alimit / turn;
    }
    out
}

fn motion_norm(system: &System, dx: &[f64]) -> f64 {
    let mut sum = 0.0;
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 { 1.0 } else { system.length };
            sum += (dx[body.first + k] * scale).powi(2);
        }
    }
    sum.sqrt()
}

/// STABILITY times mass, over the units consistency factor, to the stiffness block.
fn add_stability(
    system: &System,
    parameters: &Parameters,
    state: &State,
    stability: f64,
    matrix: &mut Matrix,
) {
    for (body, pose) in system.bodies.iter().zip(&state.poses) {
        if body.freedoms == 0 {
            continue;
        }
        let mass = parameters.theta()[body.mass];
        let arm = body
            .cm
            .map_or_else(Vec3::zeros, |cm| pose.R * parameters.markers()[cm].p);
        let r = skew(&arm) * mass;
        let mut M = Mat6::zeros();
        for k in 0..3 {
            M[(k, k)] = mass;
        }
        let inertia = pose.R * body.inertia * pose.R.transpose() - r * skew(&arm);
        M.fixed_view_mut::<3, 3>(0, 3).copy_from(&-r);
        M.fixed_view_mut::<3, 3>(3, 0).copy_from(&r);
        M.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        for i in 0..body.freedoms {
            for j in 0..body.freedoms {
                let value = -stability / system.ucf * M[(i, j)];
                matrix.add_later(body.first + i, body.first + j, value);
            }
        }
    }
}

/// As if every part moved in honey.
fn add_damping(system: &System, damping: f64, matrix: &mut Matrix) {
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let scale = if k < 3 {
                1.0
            } else {
                system.length * system.length
            };
            matrix.add_later(body.first + k, body.first + k, -damping * scale);
        }
    }
}
