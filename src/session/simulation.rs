use admire_results::StepKind;
use admire_solver::model::Model;
use admire_solver::statics::{Balance, Far, Left, Report, Softest, SolveError, StaticSettings};
use admire_syntax::Statement;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;
use admire_syntax::units::Dimension;
use std::fmt::Write as _;

use super::ending::Stop;
use super::loaded::{CompiledModel, Loaded};
use super::measures::Measures;
use super::message::{equation_as_adams, exponent, object_as_adams};
use super::outputs::Outputs;
use super::run_state::{Flow, Place, Session};
use super::sensing::Sensed;
use super::simulate::{Analysis, OutputTimes, RequestedAnalysis, too_many};

/// Values that the function MODE returns in static and quasi-static simulations (guide/formats.md 3.1).
const MODE_STATIC: i32 = 5;
const MODE_QUASI_STATIC: i32 = 6;

/// Maximum number of times that the time step is halved after a failed quasi-static solution.
const HALVINGS: i32 = 8;

/// Maximum number of iterations that are printed for a solution that did not converge.
const SHOWN: usize = 12;

impl Session<'_> {
    /// Executes a SIMULATE command.
    pub(super) fn simulate(&mut self, command: &Statement, source: &Source) -> Flow {
        let place = Place {
            source,
            span: command.span,
        };
        let Some(loaded) = &mut self.loaded else {
            return self.misunderstood(
                Diagnostic::error(Code::NoModel, "no model was read before this command")
                    .help("FILE/MODEL=name reads one"),
                Some(place),
            );
        };
        let now = loaded.time();
        if let Some(limited) = StaticSettings::limited(&loaded.model.equilibrium)
            && !std::mem::replace(&mut loaded.said_iterations, true)
        {
            self.complain(&limited);
        }
        let Some(loaded) = &mut self.loaded else {
            return Ok(());
        };
        let compiled = loaded.compiled();
        let errors = compiled.value.errors.clone();
        let mut complaints = compiled.diagnostics;
        complaints.extend(compiled.value.warnings.iter().cloned());
        complaints.extend(errors.iter().cloned());
        // Warnings that concern only statics are not reported for simulations over time.
        let statics = command.has("STATICS") || command.text("TYPE", source).is_some();
        let of_statics = [Code::InactiveInStatics, Code::NotSolvedInStatics];
        complaints.retain(|told| statics || !of_statics.contains(&told.code));
        self.report_once(complaints);
        let lacks =
            |d: &Diagnostic| matches!(d.code, Code::NotSolvedNatively | Code::UserSubroutine);
        if !errors.iter().all(lacks) {
            return Err(Stop::Model);
        }
        let analysis = match Analysis::of(command, source, now) {
            Ok(analysis) => analysis,
            Err(diagnostic) => return self.misunderstood(diagnostic, None),
        };
        if let Err(diagnostic) = self.model().begin_outputs() {
            return self.unwritable(&diagnostic);
        }
        if !errors.is_empty() {
            let refusal = Diagnostic::error(
                Code::NotSolvedNatively,
                "this simulation is not executed: its result would omit the elements named above",
            );
            return self.refused(refusal, Some(place));
        }
        match analysis {
            Analysis::Static => self.lone_static(place),
            Analysis::QuasiStatic(times) => self.sequence(times, StepKind::QuasiStatic, place),
            Analysis::Kinematic(times) => self.motion(times, RequestedAnalysis::Kinematic, place),
            Analysis::Transient(times) => self.motion(times, RequestedAnalysis::Transient, place),
            Analysis::Dynamic(times) => self.motion(times, RequestedAnalysis::Dynamic, place),
            Analysis::InitialConditions(phases) => self.initial_conditions(phases, place),
        }
    }

    fn lone_static(&mut self, place: Place<'_>) -> Flow {
        self.messages.begin_static();
        let outcome = self.model().solve(None, MODE_STATIC);
        match outcome {
            Ok(report) => {
                self.remarks(&report);
                let time = self.model().time();
                self.warn_if_far(&report, time);
                let told = self.balance_line(&report.balance);
                self.worst_balance.or_worse(&report.balance);
                self.messages
                    .converged(report.iterations, report.imbalance, &told);
                self.warn_if_unbalanced(&report.balance);
                self.warn_if_unstable();
                self.write_step(StepKind::Static)?;
                let sensed = self.sense();
                self.simulation_ended()?;
                if sensed.halts {
                    Err(Stop::Finished)
                } else {
                    Ok(())
                }
            }
            Err(error) => {
                self.no_equilibrium(&error, place);
                self.messages.say("\n  End Static Solution\n");
                self.simulation_failed()
            }
        }
    }

    /// Solves equilibria at the output times of a quasi-static simulation.
    ///
    /// The start is solved first, unless a preceding quasi-static simulation has just written it. Their common time is thus not repeated,
    /// whereas a single static solution has a Data block of its own (guide/formats.md 6.1).
    fn sequence(&mut self, mut times: OutputTimes, kind: StepKind, place: Place<'_>) -> Flow {
        self.messages.begin_simulation("Quasi-Static");
        let fresh = self.model().outputs.begins_with(times.start, kind);
        let mut k = usize::from(!fresh);
        let mut halted = false;
        let mut balance = Balance::default();
        while k <= times.count {
            let time = if k == 0 { times.start } else { times.at(k) };
            k += 1;
            let before = self.model().time();
            match self.model().advance(time, MODE_QUASI_STATIC) {
                Ok(report) => {
                    self.remarks(&report);
                    self.warn_if_far(&report, before);
                    self.messages
                        .simulation_step(time, report.iterations, report.imbalance);
                    balance.or_worse(&report.balance);
                    let cheap = Softest::is_cheap(&self.model().compiled().value.system);
                    if cheap || k > times.count {
                        self.warn_if_unstable();
                    }
                    self.write_step(kind)?;
                    self.tell(times.moment(time, times.at(1) - times.start))?;
                    let sensed = self.sense();
                    halted = sensed.halts;
                    if sensed.halts || sensed.returns {
                        break;
                    }
                    if let Some(dt) = sensed.dt.filter(|_| time < times.end) {
                        let Some(other) = times.every(dt, time) else {
                            self.messages.end_simulation();
                            return self.refused(too_many(dt), Some(place));
                        };
                        (times, k) = (other, 1);
                    }
                }
                Err(error) => {
                    self.no_equilibrium(&error, place);
                    self.messages.end_simulation();
                    return self.simulation_failed();
                }
            }
            self.messages.flush();
        }
        let told = self.balance_line(&balance);
        self.messages.say(&told);
        self.messages.end_simulation();
        self.worst_balance.or_worse(&balance);
        self.warn_if_unbalanced(&balance);
        self.simulation_ended()?;
        if halted { Err(Stop::Finished) } else { Ok(()) }
    }

    /// Formats the recomputed force balance as a line of the message file.
    fn balance_line(&mut self, balance: &Balance) -> String {
        let units = self.model().model.units;
        let left = |left: &Left, dimension: Dimension| {
            let part = object_as_adams(&left.part);
            let size = exponent(left.size, 2);
            format!("{size} {} on {part}", units.name(dimension))
        };
        let force = balance
            .force
            .iter()
            .map(|force| left(force, Dimension::FORCE));
        let torque = balance
            .torque
            .iter()
            .map(|torque| left(torque, Dimension::TORQUE));
        let told: Vec<String> = force.chain(torque).collect();
        if told.is_empty() {
            return String::new();
        }
        format!(
            "  Recomputed force balance: at most {} remains\n",
            told.join(", ")
        )
    }

    /// Warns if the residual of the recomputed force balance exceeds IMBALANCE and round-off.
    fn warn_if_unbalanced(&mut self, balance: &Balance) {
        let imbalance = StaticSettings::from(&self.model().model.equilibrium).imbalance;
        if balance.holds(imbalance) {
            return;
        }
        let told = self.balance_line(balance);
        let text = format!(
            "{}: this is more than IMBALANCE and round-off allow.",
            told.trim_end()
        );
        self.messages.frame("WARNING", &text);
    }

    /// Evaluates the sensors at the current state and reports the sensors that fired.
    pub(super) fn sense(&mut self) -> Sensed {
        let sensed = self.model().sense();
        if !sensed.said.is_empty() {
            self.messages.say(&sensed.said);
        }
        sensed
    }

    pub(super) fn simulation_ended(&mut self) -> Flow {
        match self.model().outputs.simulation_ended() {
            Ok(()) => Ok(()),
            Err(diagnostic) => self.unwritable(&diagnostic),
        }
    }

    pub(super) fn model(&mut self) -> &mut Loaded {
        self.loaded
            .as_mut()
            .expect("a simulation begins only with a model")
    }

    pub(super) fn write_step(&mut self, kind: StepKind) -> Flow {
        match self.model().write(kind) {
            Ok(()) => Ok(()),
            Err(diagnostic) => self.unwritable(&diagnostic),
        }
    }

    /// Reports redundant constraints and zero-stiffness motions found by a solution, if they have changed since the last report.
    fn remarks(&mut self, report: &Report) {
        let loaded = self.model();
        let time = loaded.time();
        let redundant = loaded.said_redundant.replace(report.redundant.clone());
        let free: Vec<String> = report
            .free_motions
            .iter()
            .map(ToString::to_string)
            .collect();
        let was_free = loaded.said_free.replace(free.clone());
        if redundant.unwrap_or_default() != report.redundant && !report.redundant.is_empty() {
            let equations: Vec<String> = report.redundant.iter().map(equation_as_adams).collect();
            self.messages.say("\n");
            self.messages.redundant(time, &equations);
        }
        if was_free.unwrap_or_default() != free && !free.is_empty() {
            let text = format!(
                "Little or no stiffness resists these motions; they keep their present position:\n  {}",
                free.join("\n  ")
            );
            self.messages.frame("WARNING", &text);
        }
    }

    /// Warns of parts that moved far in one static solution, once for each part.
    ///
    /// If MOTIONs drive the model from one time to the next, large displacements are expected and are not reported.
    fn warn_if_far(&mut self, report: &Report, time_before: f64) {
        let loaded = self.model();
        let (time, units) = (loaded.time(), loaded.model.units);
        if time > time_before && loaded.compiled().value.system.is_driven() {
            return;
        }
        let new = |far: &&Far| !loaded.said_far.contains(&far.part);
        let far: Vec<&Far> = report.far.iter().filter(new).collect();
        let lines: Vec<String> = far.iter().map(|far| far.described(&units)).collect();
        loaded
            .said_far
            .extend(far.iter().map(|far| far.part.clone()));
        if !lines.is_empty() {
            let text = format!(
                "In the static solution at time {time}\n  {}\nCheck whether this is the intended equilibrium.",
                lines.join("\n  ")
            );
            self.messages.frame("WARNING", &text);
        }
    }

    /// Warns of an unstable equilibrium and describes the motion that leads away from it. The same motion is reported only once while the
    /// model stays unstable.
    fn warn_if_unstable(&mut self) {
        let loaded = self.model();
        let (time, units) = (loaded.time(), loaded.model.units);
        let CompiledModel {
            system,
            parameters,
            state,
            solver,
            ..
        } = loaded.compiled().value;
        let softest = Softest::doubtful(system, parameters, state, solver.scratch());
        let Some(softest) = softest.ok().flatten() else {
            loaded.said_unstable.clear();
            return;
        };
        let part = softest.part(system);
        let motion = softest.described(system, parameters, state);
        let motion = motion.unwrap_or_else(|| "the parts move away from it".to_string());
        // If two motions have nearly the same stiffness, either of them may be the softest at different times. Each is reported once until
        // the model is stable again.
        if !softest.is_unstable() || loaded.said_unstable.contains(&part) {
            return;
        }
        let stiffness = exponent(softest.stiffness, 4);
        loaded.said_unstable.push(part);
        let unit = units.name(Dimension::new(1, 0, -1, 0, 0));
        let text = format!(
            "The equilibrium at time {time} is UNSTABLE.\nAfter the slightest disturbance {motion}.\nThe smallest stiffness is {stiffness} {unit}."
        );
        self.messages.frame("WARNING", &text);
    }

    /// Reports why no equilibrium was found, at the location of the command that requested it.
    fn no_equilibrium(&mut self, error: &Failure, place: Place<'_>) {
        let mut causes: Vec<String> = Vec::new();
        if let SolveError::NotConverged {
            history,
            causes: found,
            ..
        } = &error.reason
        {
            causes.extend(found.iter().cloned());
            let skipped = history.len().saturating_sub(SHOWN);
            let mut text = String::from("   Iteration    Imbalance     Correction    Step\n");
            for (k, iteration) in history.iter().enumerate().skip(skipped) {
                _ = writeln!(
                    text,
                    "   {:>9}    {}   {}   {:.4}",
                    k + 1,
                    exponent(iteration.imbalance, 4),
                    exponent(iteration.correction, 4),
                    iteration.step
                );
            }
            self.messages.say(&text);
        }
        let mut diagnostic = Diagnostic::error(
            Code::NoEquilibrium,
            format!(
                "Static solution failed to converge at time {}: {}",
                error.time, error.reason
            ),
        )
        .label(place.source.name(), place.span, "");
        if !causes.is_empty() {
            diagnostic = diagnostic.help(causes.join("; "));
        }
        self.complain(&diagnostic);
    }
}

/// Reason of a failed solution, with the time at which it failed.
pub(super) struct Failure {
    pub time: f64,
    pub reason: SolveError,
}

impl Loaded {
    /// Finds the equilibrium at the given time, or at the current time. If this fails, the state stays unchanged.
    fn solve(&mut self, time: Option<f64>, mode: i32) -> Result<Report, Failure> {
        let settings = StaticSettings::from(&self.model.equilibrium);
        let CompiledModel {
            system,
            parameters,
            state,
            solver,
            beginning,
            ..
        } = self.compiled().value;
        *beginning = beginning.after_statics(state.time);
        let (time_before, mode_before) = (state.time, state.mode);
        state.set_at_rest();
        state.mode = mode;
        state.time = time.unwrap_or(state.time);
        solver
            .solve(system, parameters, state, &settings)
            .map_err(|reason| {
                // The solver has already restored the rest of the state.
                let time = state.time;
                (state.time, state.mode) = (time_before, mode_before);
                Failure { time, reason }
            })
    }

    /// Advances to a target time through a sequence of equilibria. After a failed solution, the time step is halved.
    fn advance(&mut self, target: f64, mode: i32) -> Result<Report, Failure> {
        let start = self.time();
        let least = (target - start) * 0.5_f64.powi(HALVINGS);
        let mut step = target - start;
        let mut iterations = 0;
        loop {
            let now = self.time();
            let next = if now + step * (1.0 + 1e-9) >= target {
                target
            } else {
                now + step
            };
            match self.solve(Some(next), mode) {
                Ok(mut report) => {
                    iterations += report.iterations;
                    if next >= target {
                        report.iterations = iterations;
                        return Ok(report);
                    }
                    step *= 2.0;
                }
                Err(failure) => {
                    step *= 0.5;
                    if step <= 0.0 || step < least {
                        return Err(failure);
                    }
                }
            }
        }
    }

    /// Writes the heads of the output files, even if no equilibrium will be found.
    fn begin_outputs(&mut self) -> Result<(), Diagnostic> {
        self.compiled();
        let Some(compiled) = &self.compiled else {
            return Ok(());
        };
        let dataset = self.definitions.dataset();
        self.outputs.begin(&self.model, dataset, &compiled.system)
    }

    /// Writes the current state to the output files.
    fn write(&mut self, kind: StepKind) -> Result<(), Diagnostic> {
        let Some((model, outputs, compiled)) = self.writing() else {
            return Ok(());
        };
        let CompiledModel {
            system,
            parameters,
            state,
            solver,
            ..
        } = compiled;
        let mut measures = Measures::new(system, parameters, state, solver.scratch());
        outputs.step(kind, model, &mut measures)
    }

    /// Returns the model, its output files, and its compiled equations.
    fn writing(&mut self) -> Option<(&Model, &mut Outputs, &mut CompiledModel)> {
        self.compiled();
        Some((&self.model, &mut self.outputs, self.compiled.as_mut()?))
    }
}
