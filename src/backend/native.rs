use super::{Backend, BackendError, Sweep, SweepRequest};
use crate::diagnostic::Severity;
use crate::model::Model;
use crate::statics::{Balance, Settings, Solver};
use crate::syntax::Address;
use crate::system::{Parameters, Slot, State, System};

/// The built-in solver. Keeps the compiled model and every case's last answer, so that the next sweep starts from there.
#[derive(Default, Debug)]
pub struct NativeBackend {
    compiled: Option<Compiled>,
}

#[derive(Debug)]
struct Compiled {
    model: Model,
    system: System,
    settings: Settings,
    solver: Solver,
    /// The last answer of each case.
    starts: Vec<State>,
}

impl NativeBackend {
    /// A backend that has solved nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    fn compiled(&mut self, model: &Model) -> Result<&mut Compiled, BackendError> {
        let known = self
            .compiled
            .as_ref()
            .is_some_and(|compiled| compiled.model == *model);
        if !known {
            self.compiled = Some(Compiled::new(model)?);
        }
        Ok(self.compiled.as_mut().expect("compiled just above"))
    }
}

/// Compiles a model for the built-in solver.
///
/// # Errors
/// [`BackendError::NotSolvable`] when leaving out what is not solved would change the answer.
pub fn compile(model: &Model) -> Result<System, BackendError> {
    let checked = System::compile(model);
    let errors: Vec<_> = checked
        .diagnostics
        .iter()
        .filter(|diagnostic| diagnostic.severity == Severity::Error)
        .cloned()
        .collect();
    if errors.is_empty() {
        Ok(checked.value)
    } else {
        Err(BackendError::NotSolvable(errors))
    }
}

/// The deck's EQUILIBRIUM, its tolerances tightened: estimates need more digits than a drawing does.
pub fn tight_settings(system: &System) -> Settings {
    let deck = Settings::from(system.settings());
    let tight = Settings::tight();
    Settings {
        error: deck.error.min(tight.error),
        imbalance: deck.imbalance.min(tight.imbalance),
        maxit: deck.maxit.max(tight.maxit),
        budget: None,
        ..deck
    }
}

/// The slot of an address.
///
/// # Errors
/// [`BackendError::UnknownTarget`].
pub fn slot(system: &System, address: &Address) -> Result<Slot, BackendError> {
    system
        .catalogue()
        .slot(address)
        .ok_or_else(|| BackendError::UnknownTarget(address.clone()))
}

impl Compiled {
    fn new(model: &Model) -> Result<Self, BackendError> {
        let system = compile(model)?;
        Ok(Self {
            model: model.clone(),
            settings: tight_settings(&system),
            solver: Solver::new(&system),
            starts: Vec::new(),
            system,
        })
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        let mut parameters: Parameters = self.system.parameters();
        for (address, value) in request.theta {
            parameters.set(slot(&self.system, address)?, *value);
        }
        let loads = &request.programme.loads;
        let slots = loads
            .iter()
            .map(|load| slot(&self.system, &load.target))
            .collect::<Result<Vec<_>, _>>()?;
        let count = request.programme.cases.len();
        if self.starts.len() != count {
            self.starts.clear();
        }
        let fresh = self.starts.is_empty();
        let mut before = self.system.state();
        let mut cases = Vec::with_capacity(count);
        for (at, case) in request.programme.cases.iter().enumerate() {
            for (slot, value) in slots.iter().zip(&case.values) {
                parameters.set(*slot, *value);
            }
            // From this case's last answer; failing that from the case before, failing that from the design.
            let mut starts = vec![before.clone(), self.system.state()];
            if !fresh {
                starts.insert(0, self.starts[at].clone());
            }
            let mut outcome = None;
            for mut state in starts {
                match self
                    .solver
                    .solve(&self.system, &parameters, &mut state, &self.settings)
                {
                    Ok(_) => {
                        outcome = Some(Ok(state.equilibrium()));
                        before = state;
                        break;
                    }
                    Err(error) => outcome = outcome.or(Some(Err(error.into()))),
                }
            }
            if fresh {
                self.starts.push(before.clone());
            } else {
                self.starts[at].clone_from(&before);
            }
            cases.push(outcome.expect("there is at least one start"));
        }
        Ok(Sweep { cases })
    }
}

impl Backend for NativeBackend {
    fn name(&self) -> &'static str {
        "native"
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        self.compiled(request.model)?.sweep(request)
    }

    fn balance(&self) -> Option<&Balance> {
        self.compiled.as_ref()?.solver.worst_balance()
    }
}
