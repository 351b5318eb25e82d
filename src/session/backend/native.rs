use super::case_sweeper::{CaseSweeper, Loads};
use super::compiled::{compile, slot, tight_settings};
use super::{Backend, BackendError, Sweep, SweepRequest};
use admire_solver::model::Model;
use admire_solver::statics::Balance;
use admire_solver::system::{Parameters, System};

/// Backend that uses the built-in solver. It keeps the compiled model and the last solution of every load case, from which the next sweep
/// starts.
#[derive(Default, Debug)]
pub struct NativeBackend {
    compiled: Option<CompiledDeck>,
}

#[derive(Debug)]
struct CompiledDeck {
    model: Model,
    system: System,
    sweeper: CaseSweeper,
}

impl NativeBackend {
    /// Creates a backend that has no compiled model and no solutions.
    pub fn new() -> Self {
        Self::default()
    }

    fn compiled(&mut self, model: &Model) -> Result<&mut CompiledDeck, BackendError> {
        let known = self
            .compiled
            .as_ref()
            .is_some_and(|compiled| compiled.model == *model);
        if !known {
            self.compiled = Some(CompiledDeck::new(model)?);
        }
        Ok(self.compiled.as_mut().expect("compiled just above"))
    }
}

impl CompiledDeck {
    fn new(model: &Model) -> Result<Self, BackendError> {
        let system = compile(model)?;
        let none = Loads {
            slots: Vec::new(),
            cases: Vec::new(),
        };
        Ok(Self {
            model: model.clone(),
            sweeper: CaseSweeper::new(&system, none, tight_settings(&system)),
            system,
        })
    }

    fn sweep(&mut self, request: &SweepRequest<'_>) -> Result<Sweep, BackendError> {
        let Self {
            system, sweeper, ..
        } = self;
        let mut parameters: Parameters = system.parameters();
        for (address, value) in request.theta {
            parameters.set(slot(system, address)?, *value);
        }
        sweeper.set_loads(Loads::of(system, request.programme)?);
        let cases = (0..sweeper.cases()).map(|case| {
            sweeper.load(case, &mut parameters);
            let own = sweeper.answer(case).cloned();
            let state = sweeper.solve(system, &parameters, case, own)?;
            let equilibrium = state.equilibrium();
            sweeper.keep(case, state);
            Ok(equilibrium)
        });
        Ok(Sweep {
            cases: cases.collect(),
        })
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
        self.compiled.as_ref()?.sweeper.balance()
    }
}
