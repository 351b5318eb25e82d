use std::collections::{BTreeMap, BTreeSet};

use admire_solver::function::Measure;
use admire_solver::model::{Definitions, Ignore, Model, Request, left_out_warning};
use admire_solver::statics::Solver;
use admire_solver::system::{EquationName, Name, Parameters, Scratch, Slot, State, System};
use admire_syntax::diagnostic::{Checked, Diagnostic, Severity};
use admire_syntax::expression::Node;
use admire_syntax::text::Source;
use admire_syntax::{Address, Argument, Dataset, Statement, Value};

use super::file_policy::FilePolicy;
use super::files::{folder_of, read_files};
use super::measures::Measures;
use super::output_options::not_written;
use super::outputs::Outputs;
use super::saved::{Kind, Saved};

/// A loaded model and its current state.
pub(super) struct Loaded {
    pub model: Model,
    /// Statements of the model, with all redefinitions by commands.
    pub definitions: Definitions,
    pub outputs: Outputs,
    /// Diagnostics about objects of the model that were already reported, by severity and message.
    pub told: BTreeSet<(Severity, String)>,
    /// Redundant constraint equations that were reported last.
    pub said_redundant: Option<Vec<EquationName>>,
    /// Indices of the parts that move most in the unstable modes reported since the model was last stable.
    pub said_unstable: Vec<usize>,
    /// Names of the parts that were already reported because they moved far in one static solution.
    pub said_far: Vec<Name>,
    /// True once the message about the iteration limit was written; it is written only once.
    pub said_iterations: bool,
    /// Descriptions of the zero-stiffness motions that were reported last.
    pub said_free: Option<Vec<String>>,
    pub(super) compiled: Option<CompiledModel>,
    /// Statements that the user allows to be left out of the model.
    ignored: Vec<Ignore>,
    /// State of the model before a change, from which the compiled model will continue.
    before: Option<Before>,
    beginning: Beginning,
    /// True once the initial state of a simulation over time was written.
    pub begun: bool,
}

/// The compiled equations of a model, and their current state.
pub(super) struct CompiledModel {
    pub system: System,
    pub parameters: Parameters,
    pub state: State,
    pub solver: Solver,
    /// Errors found when the model was compiled: reasons why the equations do not represent the model.
    pub errors: Vec<Diagnostic>,
    /// Warnings about elements that the equations leave out; some are left out only in statics.
    pub warnings: Vec<Diagnostic>,
    /// Source of the initial velocities for the next simulation over time.
    pub beginning: Beginning,
}

/// State of a model before the model was changed.
struct Before {
    state: State,
    /// Angles whose full turns were counted, with their indices in the state.
    counted: BTreeMap<Measure, usize>,
    /// One flag for each dynamic state: true if the state was active.
    active_states: Vec<bool>,
}

impl Before {
    fn of(system: &System, state: State) -> Self {
        Self {
            state,
            counted: system.counted_angles(),
            active_states: system.active_states(),
        }
    }
}

/// Source of the initial velocities for a simulation over time.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) enum Beginning {
    /// The dataset gives the velocities, because nothing has moved yet, or because a static solution was found at time zero.
    #[default]
    Dataset,
    /// The velocities are zero, because a static solution came before.
    Rest,
    /// The current velocities are used. The model has changed, so the initial conditions must be computed again.
    Changed,
    /// The current velocities are used. They already satisfy the initial conditions.
    Known,
}

impl Beginning {
    /// Returns the source of initial velocities after a static solution. At time zero, the velocities in the dataset apply again.
    pub(crate) fn after_statics(self, time: f64) -> Self {
        if time == 0.0 {
            Self::Dataset
        } else {
            Self::Rest
        }
    }

    fn after_change(self) -> Self {
        match self {
            Self::Known => Self::Changed,
            other => other,
        }
    }
}

impl Loaded {
    /// Loads the model of a parsed dataset. The model can be used only if no diagnostic is an error.
    pub(crate) fn read(
        parsed: &Checked<Dataset>,
        outputs: Outputs,
        policy: &FilePolicy,
        ignored: &[Ignore],
    ) -> Checked<Self> {
        let folder = folder_of(parsed.value.source());
        let files = read_files(&parsed.value, &folder, policy);
        let lowered = Definitions::lower(&parsed.value, &files.value);
        let (model, definitions) = lowered.value;
        let mut diagnostics = parsed.diagnostics.clone();
        diagnostics.extend(files.diagnostics);
        diagnostics.extend(lowered.diagnostics);
        diagnostics.extend(not_written(&parsed.value));
        Checked {
            value: Self {
                model,
                definitions,
                outputs,
                told: BTreeSet::new(),
                said_redundant: None,
                said_unstable: Vec::new(),
                said_far: Vec::new(),
                said_iterations: false,
                said_free: None,
                compiled: None,
                ignored: ignored.to_vec(),
                before: None,
                beginning: Beginning::default(),
                begun: false,
            },
            diagnostics,
        }
    }

    /// Returns the current simulation time; zero before the first simulation.
    pub(crate) fn time(&self) -> f64 {
        self.state().map_or(0.0, |state| state.time)
    }

    /// Returns the current state; `None` before the first simulation.
    pub(crate) fn state(&self) -> Option<&State> {
        match &self.compiled {
            Some(compiled) => Some(&compiled.state),
            None => self.before.as_ref().map(|before| &before.state),
        }
    }

    /// Marks the model as changed. It is compiled again before the next simulation, which continues from the current state.
    pub(crate) fn changed(&mut self) {
        if let Some(compiled) = self.compiled.take() {
            self.before = Some(Before::of(&compiled.system, compiled.state));
            self.beginning = compiled.beginning.after_change();
        }
        self.outputs.last = None;
    }

    /// Redefines a statement by a command and returns the diagnostics. If there is an error, nothing is changed.
    pub(crate) fn redefine(&mut self, command: &Statement, source: &Source) -> Vec<Diagnostic> {
        let constants = self.constants(command);
        let poses: Vec<_> = self.model.parts.iter().map(|part| part.pose).collect();
        let complaints = self.definitions.redefine(&mut self.model, command, source);
        if complaints.iter().any(|d| d.severity == Severity::Error) {
            return complaints;
        }
        if let (Some(constants), Some(compiled), true) =
            (constants, &mut self.compiled, complaints.is_empty())
        {
            for (slot, value) in constants {
                compiled.parameters.set(slot, value);
            }
            compiled.beginning = compiled.beginning.after_change();
            self.outputs.last = None;
            return complaints;
        }
        self.changed();
        // A part with a new position moves to that position. The other parts keep their current poses.
        if let Some(Before { state, .. }) = &mut self.before {
            for (k, part) in self.model.parts.iter().enumerate() {
                if poses.get(k) != Some(&part.pose)
                    && let Some(pose) = state.poses.get_mut(k)
                {
                    *pose = part.pose;
                }
            }
        }
        complaints
    }

    /// Returns parameter slots and values if a command such as `SFORCE/3, FUNCTION=1200` only sets loads of the compiled model to
    /// constants; `None` otherwise.
    ///
    /// With these slots, the usual sequence of load cases needs no new compilation.
    fn constants(&self, command: &Statement) -> Option<Vec<(Slot, f64)>> {
        const LOADS: [&str; 5] = ["SFORCE", "GFORCE", "VFORCE", "VTORQUE", "MOTION"];
        let compiled = self.compiled.as_ref()?;
        let kind = command.kind().filter(|kind| LOADS.contains(kind))?;
        let constant = |argument: &Argument| {
            let name = argument.def?.name;
            let Value::Function(function) = &argument.value else {
                return None;
            };
            let value = match &function.root {
                Node::Literal(k) => function.literals.get(*k)?.value,
                Node::Negate(inner) => match **inner {
                    Node::Literal(k) => -function.literals.get(k)?.value,
                    _ => return None,
                },
                _ => return None,
            };
            // The whole FUNCTION of an SFORCE or MOTION has the address of the object itself.
            let argument = (name != "FUNCTION").then(|| name.to_string());
            let address = Address {
                kind: kind.to_string(),
                id: command.number(),
                argument,
                index: None,
            };
            let slot = compiled.system.catalogue().slot(&address)?;
            value.is_finite().then_some((slot, value))
        };
        command.arguments.iter().map(constant).collect()
    }

    /// Evaluates a request, which need not be in the dataset, at the current state; `None` if a value is not finite.
    pub(crate) fn answer(&mut self, request: Request) -> Option<[f64; 8]> {
        let compiled = self.compiled().value;
        let before = Before::of(&compiled.system, compiled.state.clone());
        let mut model = self.model.clone();
        model.requests = vec![request];
        let system = System::compile(&model).value;
        let mut here = system.state();
        carry_over(&system, &mut here, before);
        let parameters = system.parameters();
        let mut scratch = Scratch::new(&system);
        let mut measures = Measures::new(&system, &parameters, &here, &mut scratch);
        Some(measures.request(&model, 0))
            .filter(|values| values.iter().all(|value| value.is_finite()))
    }

    /// Restores a saved state, and the saved model if there is one.
    ///
    /// # Errors
    /// Returns an error if the state belongs to another model.
    pub(crate) fn restore(&mut self, saved: Saved) -> Result<(), Diagnostic> {
        self.changed();
        if let Some(Kind::Resolved(model)) = saved.model {
            (self.model, self.definitions) = *model;
        }
        self.before = match saved.state {
            Some(placed) => {
                let system = System::compile(&self.model).value;
                let mut state = system.state();
                placed.put_into(&mut state)?;
                // A saved state with velocities continues. A saved state at rest is treated like the result of a static solution.
                self.beginning = if state.moves() {
                    Beginning::Changed
                } else {
                    self.beginning.after_statics(state.time)
                };
                Some(Before::of(&system, state))
            }
            None => None,
        };
        Ok(())
    }

    /// Returns the equations of the current model at its current state. If the model had to be compiled, the result includes the warnings
    /// about statements left out.
    pub(crate) fn compiled(&mut self) -> Checked<&mut CompiledModel> {
        let mut diagnostics = Vec::new();
        let compiled = self.compiled.get_or_insert_with(|| {
            let left_out = self.model.leave_out(&self.ignored);
            diagnostics.extend(
                left_out
                    .iter()
                    .map(|(kind, header)| left_out_warning(kind, header)),
            );
            let checked = System::compile(&self.model);
            let (errors, warnings): (Vec<_>, Vec<_>) = checked
                .diagnostics
                .into_iter()
                .partition(|diagnostic| diagnostic.severity == Severity::Error);
            let system = checked.value;
            self.outputs.locate(&self.model, &system);
            let mut state = system.state();
            if let Some(before) = self.before.take() {
                carry_over(&system, &mut state, before);
            }
            let parameters = system.parameters();
            system.begin_drives(&parameters, &mut state, &mut Scratch::new(&system));
            for (value, sensor) in state.sensors.iter_mut().zip(&self.model.sensors) {
                if !sensor.header.active {
                    *value = 0.0;
                }
            }
            CompiledModel {
                parameters,
                solver: Solver::new(&system),
                system,
                state,
                errors,
                warnings,
                beginning: self.beginning,
            }
        });
        Checked {
            value: compiled,
            diagnostics,
        }
    }
}

/// Transfers the state before a change to the newly compiled model. A vector of the state whose length has changed starts from the values
/// in the dataset.
fn carry_over(system: &System, state: &mut State, before: Before) {
    let (counted, were_active, before) = (before.counted, before.active_states, before.state);
    // A dynamic state that was switched on starts from its initial value, and one that was switched off becomes zero (com_activate,
    // com_deactivate).
    let begin = (state.states.clone(), state.state_rates.clone());
    system.count_on(state, &counted, &before.measure_angles);
    state.time = before.time;
    for (now, then) in [
        (&mut state.variables, before.variables),
        (&mut state.states, before.states),
        (&mut state.multipliers, before.multipliers),
        (&mut state.sensors, before.sensors),
    ] {
        if now.len() == then.len() {
            *now = then;
        }
    }
    if state.poses.len() == before.poses.len() {
        state.poses = before.poses;
        state.velocities = before.velocities;
        state.accelerations = before.accelerations;
    }
    if state.states.len() == before.state_rates.len() {
        state.state_rates = before.state_rates;
    }
    let active = system.active_states();
    let switched = |k: &usize| were_active.get(*k) != Some(&active[*k]);
    for k in (0..active.len()).filter(switched) {
        state.states[k] = begin.0[k];
        if let Some(rate) = state.state_rates.get_mut(k) {
            *rate = begin.1.get(k).copied().unwrap_or(0.0);
        }
    }
    if state.grips.len() == before.grips.len() {
        state.grips = before.grips;
    }
    if state.driven.len() == before.driven.len() {
        state.driven = before.driven;
    } else {
        // If the number of rate-driven MOTIONs has changed, all of them start again from the current poses.
        for driven in &mut state.driven {
            driven.time = f64::NAN;
        }
    }
    if state.pair_angles.len() == before.pair_angles.len() {
        state.pair_angles = before.pair_angles;
    }
}
