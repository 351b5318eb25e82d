use super::arrival::has_arrived;
use super::consistent::Consistent;
use super::coupled::Coupled;
use super::derivatives::Derivatives;
use super::discrete_states::DiscreteStates;
use super::error::{MotionError, MotionFailure, NotSettled};
use super::error_scales::{ErrorScales, LargestComponent};
use super::newton::{StageValues, Stages, Step, StepMatrices, Unknowns};
use super::sequence::StageSequence;
use super::settings::{INSIDE, MotionSettings};
use super::tableau::{A, C, lagrange};
use crate::system::{Parameters, State, System};

/// Relative difference below which two step sizes count as equal.
const SAME: f64 = 1e-9;
/// Growth factor up to which the step size stays unchanged, so that the factors of its matrices can be reused.
const WORTH: f64 = 1.2;
/// Safety factor of the step-size control.
const SAFETY: f64 = 0.9;
/// Smallest ratio of a step size to the previous one.
const SHORTEST: f64 = 0.2;
/// Largest ratio of a step size to the previous one.
const LONGEST: f64 = 5.0;

/// Counts of the work done in an integration.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Statistics {
    /// Number of accepted steps.
    pub steps: usize,
    /// Number of rejected steps.
    pub rejected: usize,
    /// Number of evaluations of the residual of one stage.
    pub evaluations: usize,
    /// Number of assemblies of the derivatives.
    pub jacobians: usize,
    /// Number of factorisations. The real and the complex matrix of a step count as one factorisation.
    pub factorisations: usize,
}

/// Integrator of the equations of motion, with error control and event location.
pub struct Integrator<'a> {
    pub(super) system: &'a System,
    pub(super) parameters: &'a Parameters,
    pub(super) settings: MotionSettings,
    pub(super) state: State,
    pub(super) equations: StepMatrices,
    /// Iteration over the stages one after the other; `None` until it is needed.
    pub(super) sequence: Option<Box<StageSequence>>,
    /// Iteration over all stages together; `None` until it is needed.
    pub(super) coupled: Option<Box<Coupled>>,
    pub(super) consistent: Consistent,
    pub(super) unknowns: Unknowns,
    /// Correction from the current Newton iteration.
    pub(super) change: Unknowns,
    /// Unknowns of the last step. They define its dense-output polynomial, which is extrapolated into the next step.
    pub(super) polynomial: Unknowns,
    pub(super) sizes: ErrorScales,
    /// Error scales before the last step.
    pub(super) sizes_before: ErrorScales,
    /// Step size to try next.
    pub(super) h: f64,
    /// Size of the last step; `None` before the first step.
    pub(super) last: Option<f64>,
    /// True if the next step uses no data from previous steps.
    pub(super) anew: bool,
    /// True if the next step repeats the last step with another end.
    pub(super) within: bool,
    /// State at the start of the last step.
    pub(super) origin: State,
    /// Size and error of the last step, for the prediction of the step size.
    pub(super) before: Option<(f64, f64)>,
    /// Step size for which the matrices were factored; `None` if there are no valid factors.
    pub(super) factored: Option<f64>,
    /// True if the derivatives were evaluated within the current step.
    fresh: bool,
    /// True if the multipliers of the current step did not converge.
    pub(super) loose: bool,
    /// Number of times that the step was cut after a failed iteration, since the last step that was accepted at the first try.
    pub(super) cuts: usize,
    pub(super) statistics: Statistics,
    /// Description of the component with the largest error in the last step, or of the failure of that step.
    pub(super) worst: String,
    /// Discrete states; `None` if the system has none.
    pub(super) regimes: Option<Box<DiscreteStates>>,
}

impl<'a> Integrator<'a> {
    /// Creates an integrator that starts at a state on its constraints at the levels of positions, velocities and accelerations.
    pub fn new(
        system: &'a System,
        parameters: &'a Parameters,
        mut state: State,
        settings: MotionSettings,
    ) -> Self {
        let regimes = DiscreteStates::new(system, parameters, &mut state);
        let mut new = Self {
            system,
            parameters,
            equations: StepMatrices::new(system),
            sequence: None,
            coupled: None,
            consistent: Consistent::new(system),
            unknowns: Unknowns::new(system),
            change: Unknowns::new(system),
            polynomial: Unknowns::new(system),
            sizes: ErrorScales::new(system),
            sizes_before: ErrorScales::new(system),
            h: settings.hinit.max(settings.hmin).min(settings.hmax),
            last: None,
            anew: true,
            within: false,
            origin: State::empty(),
            before: None,
            factored: None,
            fresh: false,
            loose: false,
            cuts: 0,
            statistics: Statistics::default(),
            worst: String::new(),
            regimes,
            settings,
            state,
        };
        let scratch = &mut new.equations.scratch;
        system.advance_stiction(parameters, &mut new.state, scratch);
        let step = 1e-2 * new.settings.hmax;
        // If this fails, the first step reports the reason.
        let _ = new
            .consistent
            .settle_massless(system, parameters, &mut new.state, step);
        new.sizes.grow(system, &new.state);
        // The first step is so short that the accelerations alone displace parts by no more than the tolerance.
        let mut most = 0.0_f64;
        for a in &new.state.accelerations {
            most = most
                .max(a.linear.norm() / new.sizes.position)
                .max(a.angular.norm());
        }
        let reach = (new.tolerance() / most.max(f64::MIN_POSITIVE)).sqrt();
        new.h = new.h.min(reach.max(10.0 * new.settings.hmin));
        new
    }

    /// Returns the state at the end of the last step.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the step size to try next.
    pub fn step(&self) -> f64 {
        self.h
    }

    /// Describes the component with the largest error in the last step, which determines the step size.
    pub fn governed_by(&self) -> &str {
        &self.worst
    }

    /// Returns the work counts so far.
    pub fn statistics(&self) -> Statistics {
        Statistics {
            evaluations: self.equations.evaluations,
            jacobians: self.equations.jacobians,
            factorisations: self.equations.factorisations,
            ..self.statistics
        }
    }

    /// Sets the values that SENVAL returns from the present time on.
    pub fn set_sensors(&mut self, sensors: &[f64]) {
        self.state.sensors.copy_from_slice(sensors);
    }

    /// Returns the state at the end of the last step, reconciled with the constraints at the levels of positions, velocities and accelerations.
    /// Its reactions match the accelerations.
    ///
    /// # Errors
    /// Returns [`MotionError`] if an element has no value or a removed constraint equation is violated.
    pub fn output(&mut self) -> Result<State, MotionError> {
        let mut state = self.state.clone();
        let step = self.settings.hmax * 1e-2;
        self.consistent
            .reconcile(self.system, self.parameters, &mut state, step)
            .map_err(|reason| reason.at(self.state.time))?;
        state.clear_branches();
        Ok(state)
    }

    /// Integrates to a time, in as many steps as the error control requires.
    ///
    /// # Errors
    /// Returns [`MotionError`]; the state is then at the end of the last accepted step.
    pub fn advance_to(&mut self, end: f64) -> Result<(), MotionError> {
        while self.step_towards(end)? {}
        Ok(())
    }

    /// Integrates to a time with fixed discrete states: no events are located.
    pub(super) fn advance_plainly(&mut self, end: f64) -> Result<(), MotionError> {
        while let Some(left) = self.left(end) {
            self.take_step(left, end)?;
        }
        Ok(())
    }

    /// Returns the next break: the first later time at which a function of time is not smooth.
    fn next_break(&self) -> Option<f64> {
        let breaks = &self.system.breaks;
        let after = breaks.partition_point(|time| self.left(*time).is_none());
        breaks.get(after).copied()
    }

    /// Returns the time left until `end`; `None` if the time left is round-off.
    fn left(&self, end: f64) -> Option<f64> {
        let left = end - self.state.time;
        (!has_arrived(self.state.time, end, self.settings.hmax)).then_some(left)
    }

    /// Takes one step, at most to `end`. Returns false if `end` is already reached.
    ///
    /// # Errors
    /// Returns the errors of [`Self::advance_to`].
    pub fn step_towards(&mut self, end: f64) -> Result<bool, MotionError> {
        if self.left(end).is_none() {
            return Ok(false);
        }
        // A step ends at a break, so no step crosses a break. The next step starts without extrapolation.
        let target = self.next_break().map_or(end, |next| next.min(end));
        if let Some(left) = self.left(target) {
            self.take_step(left, target)?;
            self.settle_regimes()?;
            self.exchange_equations()?;
        }
        if target < end && self.left(target).is_none() {
            self.restart();
        }
        Ok(true)
    }

    /// Exchanges redundant and kept constraint equations where that conditions the constraints better. After an exchange, the integration is
    /// restarted.
    fn exchange_equations(&mut self) -> Result<(), MotionError> {
        if !self.state.redundant.contains(&true) {
            return Ok(());
        }
        let (system, parameters) = (self.system, self.parameters);
        let mut anew = self.state.clone();
        let exchanged = self
            .consistent
            .exchange_equations(system, parameters, &mut anew);
        if exchanged.map_err(|reason| reason.at(anew.time))? {
            let step = self.settings.hmax * 1e-2;
            self.consistent
                .reconcile(system, parameters, &mut anew, step)
                .map_err(|reason| reason.at(self.state.time))?;
            self.state = anew;
            self.restart();
        }
        Ok(())
    }

    /// Restarts the integration at the current state: the next step uses no data from previous steps.
    pub fn restart(&mut self) {
        self.anew = true;
        self.before = None;
        self.factored = None;
    }

    /// Sets the step size to try next, at most HMAX.
    pub fn set_step(&mut self, h: f64) {
        self.h = h.min(self.settings.hmax);
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.settings.error * INSIDE
    }

    /// Takes one step towards `end`, which is `left` away. The step is repeated with smaller step sizes until it is accepted.
    pub(super) fn take_step(&mut self, left: f64, end: f64) -> Result<(), MotionError> {
        let time = self.state.time;
        self.fresh = false;
        let mut failures = 0;
        let mut rejected = false;
        loop {
            if self.h < self.settings.hmin && left > self.settings.hmin {
                let changed = self.regimes.as_ref().map(|r| r.describe(self.system));
                let worst = self.worst.clone() + &changed.unwrap_or_default();
                let step = self.h;
                return Err(MotionFailure::StepTooSmall { step, worst }.at(time));
            }
            // Equal steps to the end avoid a very short last step.
            let count = (left / self.h.min(self.settings.hmax) - 1e-9)
                .ceil()
                .max(1.0);
            let h = left / count;
            let to = if count == 1.0 { end } else { time + h };
            self.loose = false;
            self.predict(h);
            if let Err(reason) = self.prepare(h) {
                if self.let_go() {
                    continue;
                }
                return Err(reason.at(time));
            }
            let mut solved = self.solve(h, Derivatives::Single);
            for better in Derivatives::BETTER {
                if solved.is_err() && self.fresh {
                    self.predict(h);
                    solved = self.solve(h, better);
                }
            }
            if matches!(&solved, Err(NotSettled { no_value: true, .. })) && self.let_go() {
                continue;
            }
            let Ok(iterations) = solved.map_err(|not| self.worst = not.why) else {
                self.statistics.rejected += 1;
                failures += 1;
                if self.fresh || failures > 1 {
                    self.h = 0.4 * h;
                    self.cuts += 1;
                    rejected = true;
                } else {
                    // The step is repeated with derivatives evaluated within it.
                    self.h = h;
                }
                self.factored = None;
                continue;
            };
            let error = match self.error(h, rejected) {
                Ok(error) => error,
                Err(_) if self.let_go() => continue,
                Err(worst) => {
                    self.worst = worst;
                    f64::INFINITY
                }
            };
            let budget = self.settings.maxit as f64;
            let safety = SAFETY * (2.0 * budget + 1.0) / (2.0 * budget + iterations as f64);
            let mut factor = safety * libm::pow(error, -0.25);
            if error < 1.0 {
                if let Some((h_before, error_before)) = self.before {
                    // Gustafsson's predictive controller extrapolates the trend of the error over the last two steps.
                    let trend = libm::pow(error_before / (error * error), 0.25);
                    factor = factor.min(safety * (h / h_before) * trend);
                }
                factor = factor.clamp(SHORTEST, LONGEST);
                if rejected {
                    factor = factor.min(1.0);
                }
                if (1.0..=WORTH).contains(&factor) && self.factored.is_some() {
                    factor = 1.0;
                }
                self.accept(h, to).map_err(|reason| reason.at(time))?;
                if !self.loose && !rejected {
                    self.cuts = 0;
                }
                self.anew = std::mem::take(&mut self.loose);
                self.before = Some((h, error.max(1e-2)));
                // A step that was cut to end at an output may be shorter than HMIN, but the next step is not.
                self.h = (h * factor).max(self.settings.hmin).min(self.settings.hmax);
                return Ok(());
            }
            self.statistics.rejected += 1;
            rejected = true;
            let factor = if error.is_finite() {
                factor.clamp(SHORTEST, 0.9)
            } else {
                SHORTEST
            };
            self.h = h * factor;
        }
    }

    /// Releases all functions that are held on pieces, for one step. The formula of a piece may be undefined beyond the end of the piece, for
    /// example `SQRT(x)` in an `IF` that selects it for x above zero. Returns false if no function is held.
    fn let_go(&mut self) -> bool {
        let held = self.state.pieces.iter().any(Option::is_some);
        self.state.pieces.fill(None);
        held
    }

    /// Provides derivatives and factors for a step of size `h`. Factors for the same step size are reused.
    pub(super) fn prepare(&mut self, h: f64) -> Result<(), MotionFailure> {
        if self.factored.is_some_and(|f| (h / f - 1.0).abs() < SAME) {
            return Ok(());
        }
        if !self.fresh {
            self.equations.linearise_within(
                self.system,
                self.parameters,
                Step {
                    start: &self.state,
                    h,
                },
                &self.unknowns,
            )?;
            self.fresh = true;
        }
        self.equations.factor(self.system, h);
        self.factored = Some(h);
        Ok(())
    }

    /// Predicts the unknowns of a step by the dense-output polynomial of the last step, or by constant accelerations after a restart.
    pub(super) fn predict(&mut self, h: f64) {
        let (system, n) = (self.system, self.system.first_equation);
        let old = &self.polynomial;
        for stage in &mut self.unknowns.mu {
            stage.fill(0.0);
        }
        if let Some(last) = self.last.filter(|_| self.within || !self.anew) {
            // If the last step is repeated, the prediction starts where that step started; otherwise it starts where that step ended.
            let end = f64::from(u8::from(!self.within));
            for i in 0..3 {
                let weights = lagrange(end + C[i] * h / last);
                let onwards = |all: &Stages, k: usize| {
                    weights[0] * all[0][k] + weights[1] * all[1][k] + weights[2] * all[2][k]
                        - end * all[2][k]
                };
                for k in 0..n {
                    self.unknowns.w[i][k] = onwards(&old.w, k);
                }
                for k in n..system.moving_unknowns {
                    self.unknowns.z[i][k] = onwards(&old.z, k);
                }
            }
        } else {
            let mut a = Vec::new();
            system.gathered(&self.state.accelerations, &mut a);
            for i in 0..3 {
                for k in 0..n {
                    self.unknowns.w[i][k] = C[i] * h * a[k];
                }
                self.unknowns.z[i][n..].fill(0.0);
                for (k, equation) in system.states.iter().enumerate() {
                    self.unknowns.z[i][equation.moving_unknown] =
                        C[i] * h * self.state.state_rates[k];
                }
            }
        }
        let mut v = Vec::new();
        system.velocity_vector(&self.state, &mut v);
        for i in 0..3 {
            for k in 0..n {
                let w = &self.unknowns.w;
                let sum = A[i][0] * w[0][k] + A[i][1] * w[1][k] + A[i][2] * w[2][k];
                self.unknowns.z[i][k] = h * (C[i] * v[k] + sum);
            }
        }
    }

    pub(super) fn report_error(&self, worst: LargestComponent) -> String {
        let of = if worst.is_velocity {
            "the velocity of "
        } else {
            ""
        };
        format!("{of}{}", self.system.freedom_name(worst.index))
    }

    pub(super) fn measured(&self, z: &[f64], w: &[f64], variables: bool) -> LargestComponent {
        let tolerance = self.tolerance();
        self.sizes.measured(self.system, tolerance, z, w, variables)
    }

    /// Accepts a step of size `h`: its third stage becomes the state, at time `to`.
    fn accept(&mut self, h: f64, to: f64) -> Result<(), MotionFailure> {
        let system = self.system;
        let B = self.equations.tableau.B[2];
        let unknowns = &self.unknowns;
        let rate =
            |all: &Stages, k: usize| (B[0] * all[0][k] + B[1] * all[1][k] + B[2] * all[2][k]) / h;
        let mut end = State::empty();
        self.equations.stage_state(
            system,
            &self.state,
            &StageValues {
                time: to,
                z: &unknowns.z[2],
                w: &unknowns.w[2],
                acceleration: &|k| rate(&unknowns.w, k),
                state_rate: &|k| rate(&unknowns.z, k),
            },
            &mut end,
        );
        let scratch = &mut self.equations.scratch;
        system.drive_on(self.parameters, &mut end, scratch)?;
        system.accept(self.parameters, &mut end, scratch);
        system.advance_stiction(self.parameters, &mut end, scratch);
        self.origin = std::mem::replace(&mut self.state, end);
        std::mem::swap(&mut self.unknowns, &mut self.polynomial);
        self.last = Some(h);
        (self.anew, self.within) = (false, false);
        self.statistics.steps += 1;
        self.sizes_before = self.sizes;
        self.sizes.grow(system, &self.state);
        Ok(())
    }
}
