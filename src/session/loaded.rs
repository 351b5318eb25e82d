use std::collections::{BTreeMap, BTreeSet};

use admire_solver::function::Measure;
use admire_solver::model::{Definitions, Ignore, Model, Request, said_left_out};
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

/// A model that was read, and where it stands.
pub(super) struct Loaded {
    pub model: Model,
    /// The statements it stands for.
    pub definitions: Definitions,
    pub outputs: Outputs,
    /// What was told of its objects.
    pub told: BTreeSet<(Severity, String)>,
    /// The redundant constraints that were last told of.
    pub said_redundant: Option<Vec<EquationName>>,
    /// The parts that move most in the instabilities that were told of since the model was stable.
    pub said_unstable: Vec<usize>,
    /// Parts that were warned of because they went far in one static solution.
    pub said_far: Vec<Name>,
    /// The limit of iterations was told of.
    pub said_iterations: bool,
    /// The free motions that were last told of.
    pub said_free: Option<Vec<String>>,
    pub(super) compiled: Option<Compiled>,
    /// What may be left out of the model.
    ignored: Vec<Ignore>,
    /// Where the model was before it is compiled anew.
    before: Option<Before>,
    beginning: Beginning,
    /// A simulation over time has written where it began.
    pub begun: bool,
}

/// The equations of a model and their state.
pub(super) struct Compiled {
    pub system: System,
    pub parameters: Parameters,
    pub state: State,
    pub solver: Solver,
    /// Why the equations are not the model's, if so.
    pub errors: Vec<Diagnostic>,
    /// What the equations leave out, some of it in statics alone.
    pub warnings: Vec<Diagnostic>,
    /// What a motion begins with.
    pub beginning: Beginning,
}

/// Where a model stood before it was changed.
struct Before {
    state: State,
    /// Places of the angles whose turns its functions counted.
    counted: BTreeMap<Measure, usize>,
    /// Which dynamic states were switched on.
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

/// What a motion begins with.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) enum Beginning {
    /// The velocities of the dataset: nothing moved yet, or a static solution found where it begins.
    #[default]
    Dataset,
    /// At rest: a static solution came before.
    Rest,
    /// It goes on as it moves, but the model has changed.
    Changed,
    /// It goes on: initial conditions are known.
    Known,
}

impl Beginning {
    /// After a static solution: at the start the velocities of the dataset count again.
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
    /// Reads a dataset. The model can be used if no complaint is an error.
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

    /// The current time.
    pub(crate) fn time(&self) -> f64 {
        self.state().map_or(0.0, |state| state.time)
    }

    /// The current state, if any simulation was asked for yet.
    pub(crate) fn state(&self) -> Option<&State> {
        match &self.compiled {
            Some(compiled) => Some(&compiled.state),
            None => self.before.as_ref().map(|before| &before.state),
        }
    }

    /// The model was changed: its equations are compiled anew before the next simulation, which starts from where it stands.
    pub(crate) fn changed(&mut self) {
        if let Some(compiled) = self.compiled.take() {
            self.before = Some(Before::of(&compiled.system, compiled.state));
            self.beginning = compiled.beginning.after_change();
        }
        self.outputs.last = None;
    }

    /// Redefines a statement by a command. Gives the complaints; nothing is changed if one is an error.
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
        // A part that is placed anew goes there; the others stay where they are.
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

    /// What a command such as `SFORCE/3, FUNCTION=1200` sets, if it does nothing but give constants to loads of the compiled model:
    /// the usual load programme needs no new equations for every case.
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
            // The whole function of an SFORCE or MOTION is the object itself.
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

    /// The components of a request that the dataset does not have, where the model stands. `None` if they have no value here.
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

    /// Goes back to a saved state.
    ///
    /// # Errors
    /// When the state is that of another model.
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
                // What moved goes on; what stood still is at rest, or begins with the dataset.
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

    /// The equations of the model as it is now, at the state where it stands, and what a new compilation warns of.
    pub(crate) fn compiled(&mut self) -> Checked<&mut Compiled> {
        let mut diagnostics = Vec::new();
        let compiled = self.compiled.get_or_insert_with(|| {
            let left_out = self.model.leave_out(&self.ignored);
            diagnostics.extend(
                left_out
                    .iter()
                    .map(|(kind, header)| said_left_out(kind, header)),
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
            Compiled {
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

/// Puts a model that was compiled anew where it stood before. What has changed in number starts from the dataset's values.
fn carry_over(system: &System, state: &mut State, before: Before) {
    let (counted, were_active, before) = (before.counted, before.active_states, before.state);
    // A state that is switched on begins anew, one that is switched off is zero (com_activate, com_deactivate).
    let begin = (state.states.clone(), state.state_rates.clone());
    system.count_on(state, (&counted, &before.measure_angles));
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
        // They begin anew, where the parts are now.
        for driven in &mut state.driven {
            driven.time = f64::NAN;
        }
    }
    if state.pair_angles.len() == before.pair_angles.len() {
        state.pair_angles = before.pair_angles;
    }
}
