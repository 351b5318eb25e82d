use super::arrival::has_arrived;
use super::consistent::Consistent;
use super::coupled::Coupled;
use super::derivatives::Derivatives;
use super::discrete_states::Regimes;
use super::error::{MotionError, NotSettled, MotionFailure};
use super::error_scales::ErrorScales;
use super::newton::{StepMatrices, Stages, Unknowns};
use super::sequence::StageSequence;
use super::settings::{INSIDE, MotionSettings};
use super::tableau::{A, C, lagrange};
use crate::system::{Parameters, State, System};

/// Steps that differ by less are the same.
const SAME: f64 = 1e-9;
/// A step that could grow by no more than this stays, and its factors with it.
const WORTH: f64 = 1.2;
/// Safety, shortest and longest change of the step.
const SAFETY: f64 = 0.9;
const SHORTEST: f64 = 0.2;
const LONGEST: f64 = 5.0;

/// How much was done.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Steps that were tried and given up.
    pub rejected: usize,
    /// Evaluations of the equations of one stage.
    pub evaluations: usize,
    /// Assemblies of the derivatives.
    pub jacobians: usize,
    /// Pairs of factorisations.
    pub factorisations: usize,
}

/// A motion on its way through time.
pub struct Integrator<'a> {
    pub(super) system: &'a System,
    pub(super) parameters: &'a Parameters,
    pub(super) settings: MotionSettings,
    pub(super) state: State,
    pub(super) equations: StepMatrices,
    /// The iterations with derivatives of every stage, once they were needed.
    pub(super) sequence: Option<Box<StageSequence>>,
    pub(super) coupled: Option<Box<Coupled>>,
    pub(super) consistent: Consistent,
    pub(super) unknowns: Unknowns,
    /// The corrections of an iteration.
    pub(super) change: Unknowns,
    /// The unknowns of the last step: what the next one begins with.
    pub(super) polynomial: Unknowns,
    pub(super) sizes: ErrorScales,
    /// The same before the last step.
    pub(super) sizes_before: ErrorScales,
    /// The step to try next.
    pub(super) h: f64,
    /// The last step; none before the first.
    pub(super) last: Option<f64>,
    /// Nothing of the steps before is used for the next one.
    pub(super) anew: bool,
    /// The next step is the last one again, to another end.
    pub(super) within: bool,
    /// Where the last step began.
    pub(super) origin: State,
    /// The last step and its error, for the prediction of the next one.
    pub(super) before: Option<(f64, f64)>,
    /// The step that the factors are of.
    pub(super) factored: Option<f64>,
    /// The derivatives are those within this step.
    fresh: bool,
    /// The multipliers of this step did not settle.
    pub(super) loose: bool,
    /// How often a step was cut as its iteration did not settle, since one settled at once.
    pub(super) cuts: usize,
    pub(super) statistics: Statistics,
    /// What was worst in the last step that was given up.
    pub(super) worst: String,
    /// Pieces of functions and frictions, where there are any.
    pub(super) regimes: Option<Box<Regimes>>,
}

impl<'a> Integrator<'a> {
    /// Begins at a state that satisfies the constraints at all three levels.
    pub fn new(
        system: &'a System,
        parameters: &'a Parameters,
        mut state: State,
        settings: MotionSettings,
    ) -> Self {
        let regimes = Regimes::new(system, parameters, &mut state);
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
        system.grip_on(parameters, &mut new.state, scratch);
        let step = 1e-2 * new.settings.hmax;
        // Where it cannot be done, the first step says why.
        let _ = new
            .consistent
            .settle_massless(system, parameters, &mut new.state, step);
        new.sizes.grow(system, &new.state);
        // A step in which the accelerations alone move things by the tolerance.
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

    /// Where it stands, at the end of a step.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The step that would be taken next.
    pub fn step(&self) -> f64 {
        self.h
    }

    /// What errs most in the last step: what its size follows.
    pub fn governed_by(&self) -> &str {
        &self.worst
    }

    /// How much was done.
    pub fn statistics(&self) -> Statistics {
        Statistics {
            evaluations: self.equations.evaluations,
            jacobians: self.equations.jacobians,
            factorisations: self.equations.factorisations,
            ..self.statistics
        }
    }

    /// What SENVAL gives from here on.
    pub fn set_sensors(&mut self, sensors: &[f64]) {
        self.state.sensors.copy_from_slice(sensors);
    }

    /// The state with accelerations and reactions that go with it, on its constraints at all three levels.
    ///
    /// # Errors
    /// [`MotionError`] where an element has no value or a constraint that was taken out is violated.
    pub fn output(&mut self) -> Result<State, MotionError> {
        let mut state = self.state.clone();
        let step = self.settings.hmax * 1e-2;
        self.consistent
            .reconcile(self.system, self.parameters, &mut state, step)
            .map_err(|reason| reason.at(self.state.time))?;
        state.clear_branches();
        Ok(state)
    }

    /// Goes to a time, in as many steps as the tolerance asks for.
    ///
    /// # Errors
    /// [`MotionError`]; the state is that of the last step that was found.
    pub fn advance_to(&mut self, end: f64) -> Result<(), MotionError> {
        while self.step_towards(end)? {}
        Ok(())
    }

    /// The same without a look at the regimes: they do not change on the way.
    pub(super) fn advance_plainly(&mut self, end: f64) -> Result<(), MotionError> {
        while let Some(left) = self.left(end) {
            self.take_step(left, end)?;
        }
        Ok(())
    }

    /// The first time from here on at which a function of the time is not smooth.
    fn next_break(&self) -> Option<f64> {
        let breaks = &self.system.breaks;
        let after = breaks.partition_point(|time| self.left(*time).is_none());
        breaks.get(after).copied()
    }

    /// The time to `end`; none where what is left is round-off.
    fn left(&self, end: f64) -> Option<f64> {
        let left = end - self.state.time;
        (!has_arrived(self.state.time, end, self.settings.hmax)).then_some(left)
    }

    /// One step, at most to `end`. False if it is there.
    ///
    /// # Errors
    /// [`MotionError`] as of [`Self::advance_to`].
    pub fn step_towards(&mut self, end: f64) -> Result<bool, MotionError> {
        if self.left(end).is_none() {
            return Ok(false);
        }
        // A break ends a step: nothing is stepped over, and the next step begins anew.
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

    /// Leaves out other constraint equations where that holds the mechanism better, and begins anew with them.
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

    /// Begins anew from where it stands: nothing of the steps before is used.
    pub fn restart(&mut self) {
        self.anew = true;
        self.before = None;
        self.factored = None;
    }

    /// The step to try next.
    pub fn set_step(&mut self, h: f64) {
        self.h = h.min(self.settings.hmax);
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.settings.error * INSIDE
    }

    /// One step, at most to `end`.
    pub(super) fn take_step(&mut self, left: f64, end: f64) -> Result<(), MotionError> {
        let time = self.state.time;
        self.fresh = false;
        let mut failures = 0;
        let mut rejected = false;
        loop {
            if self.h < self.settings.hmin && left > self.settings.hmin {
                let changed = self.regimes.as_ref().map(|r| r.told(self.system));
                let worst = self.worst.clone() + &changed.unwrap_or_default();
                let step = self.h;
                return Err(MotionFailure::StepTooSmall { step, worst }.at(time));
            }
            // Even steps to the end: the last one is no splinter.
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
                    // The same step with derivatives of its own.
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
                    // Gustafsson's prediction: how the error changed with the last step.
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
                // A step that was cut, as at an output, may be short without being too short.
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

    /// Lets functions go that are held on pieces, for one step: beyond its end a piece may have no value, as `SQRT(x)` where `IF` asks for
    /// x above zero. False if none is held.
    fn let_go(&mut self) -> bool {
        let held = self.state.pieces.iter().any(Option::is_some);
        self.state.pieces.fill(None);
        held
    }

    /// Derivatives and factors for a step.
    pub(super) fn prepare(&mut self, h: f64) -> Result<(), MotionFailure> {
        if self.factored.is_some_and(|f| (h / f - 1.0).abs() < SAME) {
            return Ok(());
        }
        if !self.fresh {
            self.equations.linearise_within(
                self.system,
                self.parameters,
                (&self.state, h),
                &self.unknowns,
            )?;
            self.fresh = true;
        }
        self.equations.factor(self.system, h);
        self.factored = Some(h);
        Ok(())
    }

    /// Begins the iteration with the polynomial of the last step.
    pub(super) fn predict(&mut self, h: f64) {
        let (system, n) = (self.system, self.system.first_equation);
        let old = &self.polynomial;
        for stage in &mut self.unknowns.mu {
            stage.fill(0.0);
        }
        if let Some(last) = self.last.filter(|_| self.within || !self.anew) {
            // From the start of the last step if it is done again, else from its end.
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

    pub(super) fn told(&self, (_, at, velocity): (f64, usize, bool)) -> String {
        let of = if velocity { "the velocity of " } else { "" };
        format!("{of}{}", self.system.freedom_name(at))
    }

    pub(super) fn measured(&self, z: &[f64], w: &[f64], variables: bool) -> (f64, usize, bool) {
        let tolerance = self.tolerance();
        self.sizes
            .measured(self.system, tolerance, (z, w), variables)
    }

    /// The third stage is the end of the step.
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
            to,
            (&unknowns.z[2], &unknowns.w[2]),
            (&|k| rate(&unknowns.w, k), &|k| rate(&unknowns.z, k)),
            &mut end,
        );
        let scratch = &mut self.equations.scratch;
        system.drive_on(self.parameters, &mut end, scratch)?;
        system.accept(self.parameters, &mut end, scratch);
        system.grip_on(self.parameters, &mut end, scratch);
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
