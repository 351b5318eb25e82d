//! Continuation methods for equilibria that plain Newton iteration does not find, and the error report if they fail, too.

use super::causes::Ended;
use super::measures::largest;
use super::newton::{Failure, NewtonOptions, Solver};
use super::settings::MOST_ITERATIONS;
use super::{Continuation, Report, Softest, SolveError, StaticSettings};
use crate::system::{Parameters, State, System};

/// Upper bound on the path length of the end of an arm in a half turn, in arm lengths.
const HALF_TURN: f64 = 4.0;

impl Solver {
    /// Tries the continuation methods after plain iteration has failed. Returns the method that succeeded, if any, and the number of
    /// iterations.
    pub(super) fn continuation(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        plain: NewtonOptions,
    ) -> (Option<Continuation>, usize) {
        let mut iterations = 0;
        self.restart(state);
        let damped = NewtonOptions {
            damped: true,
            maxit: 200,
            error: 1e-3,
            imbalance: plain.imbalance.max(1e-6 * self.scratch.largest),
            ..plain
        };
        let slowed = self.iterate(system, parameters, state, settings, damped);
        iterations += self.history.len();
        if slowed.is_ok() {
            let found = self.iterate(system, parameters, state, settings, plain);
            iterations += self.history.len();
            if found.is_ok() {
                return (Some(Continuation::Damped), iterations);
            }
        }
        let on_its_way = matches!(slowed, Err(Failure::NotConverged)).then(|| state.clone());
        self.restart(state);
        let (found, more) = self.release(system, parameters, state, settings, plain);
        iterations += more;
        let (None, Some(there)) = (&found, on_its_way) else {
            return (found, iterations);
        };
        // An arm that starts horizontal falls slowly because of the damping. Once it has fallen part of the way, plain iteration covers the
        // rest. The number of iterations allowed for this is the length of a half turn of the model divided by TLIMIT.
        state.clone_from(&there);
        let steps = (HALF_TURN * system.length / settings.tlimit).ceil() as usize;
        let patient = NewtonOptions {
            maxit: plain.maxit.max(steps.min(MOST_ITERATIONS)),
            ..plain
        };
        let found = self.iterate(system, parameters, state, settings, patient);
        iterations += self.history.len();
        (found.is_ok().then_some(Continuation::Damped), iterations)
    }

    /// Replaces an unstable equilibrium by the equilibrium that continuation finds, if it finds one.
    ///
    /// Newton's method converges to saddles of the energy as well as to minima. If the start is so far from equilibrium that steps were cut,
    /// Newton's method may pass a stable equilibrium and end at an unstable one. Continuation is then tried, and its result is used. Large
    /// systems are not examined, because their stability analysis costs more than their solution.
    pub(super) fn leave_saddle(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        plain: NewtonOptions,
        report: &mut Report,
    ) -> Result<(), SolveError> {
        if self.remaining == 0 || !Softest::is_cheap(system) {
            return Ok(());
        }
        let softest = Softest::doubtful(system, parameters, state, &mut self.scratch)?;
        if !softest.is_some_and(|softest| softest.is_unstable()) {
            return Ok(());
        }
        let (saddle, memory) = (state.clone(), self.clone());
        let (help, more) = self.continuation(system, parameters, state, settings, plain);
        report.iterations += more;
        report.continuation = help;
        if help.is_none() {
            *state = saddle;
            *self = memory;
        }
        Ok(())
    }

    /// Resets the state to the start of the solution, but keeps the flags of the redundant equations.
    pub(super) fn restart(&self, state: &mut State) {
        let redundant = std::mem::take(&mut state.redundant);
        state.clone_from(&self.start);
        state.redundant = redundant;
    }

    /// Runs load continuation: starts with an artificial load that balances the initial residual, and removes this load in steps. Returns the
    /// method if it succeeded, and the number of iterations.
    fn release(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        plain: NewtonOptions,
    ) -> (Option<Continuation>, usize) {
        let mut iterations = 0;
        if system
            .residual(parameters, state, &mut self.scratch, &mut self.held)
            .is_err()
        {
            return (None, iterations);
        }
        let (mut released, mut increment, mut steps) = (0.0_f64, 0.25_f64, 0);
        while released < 1.0 && steps < 200 {
            let goal = (released + increment).min(1.0);
            let way = NewtonOptions {
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

    /// Converts a failure of the iteration to an error that lists the probable causes.
    pub(super) fn explain(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        settings: &StaticSettings,
        failure: Failure,
    ) -> SolveError {
        if let Failure::NoValue(reason) = failure {
            return reason.into();
        }
        let ended = Ended {
            system,
            parameters,
            start: &self.start,
            end: state,
            g: &self.g,
            matrix: &self.next,
            factors: &self.matrix,
            spent: self.remaining == 0,
            limited: self.limited,
            settings,
        };
        let causes = match ended.causes(&mut self.scratch) {
            Ok(causes) => causes,
            Err(motion) => return SolveError::FreeMotion(Box::new(motion)),
        };
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
