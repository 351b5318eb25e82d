use super::compiled::slot;
use super::{BackendError, LoadProgramme};
use admire_solver::statics::{SolveError, Solver, StaticSettings};
use admire_solver::system::{Parameters, Slot, State, System};

/// Loads of a compiled deck, with their values in all load cases.
#[derive(Clone, PartialEq, Debug)]
pub struct Loads {
    /// Parameter slot of each load.
    pub slots: Vec<Slot>,
    /// Values of the loads: one row for each load case in the order of application, one column for each slot.
    pub cases: Vec<Vec<f64>>,
}

impl Loads {
    /// Finds the parameter slots of the loads of a programme in a compiled deck.
    ///
    /// # Errors
    /// Returns an error if the target of a load is not a parameter that the solver can change.
    pub fn of(system: &System, programme: &LoadProgramme) -> Result<Self, BackendError> {
        let slots = programme.loads.iter();
        let cases = programme.cases.iter();
        Ok(Self {
            slots: slots
                .map(|load| slot(system, &load.target))
                .collect::<Result<_, _>>()?,
            cases: cases.map(|case| case.values.clone()).collect(),
        })
    }
}

/// Solver of load cases that uses the built-in static solver. It tries several start states in turn until one of them leads to an
/// equilibrium.
#[derive(Debug)]
pub struct CaseSweeper {
    loads: Loads,
    settings: StaticSettings,
    solver: Solver,
    /// Stored solution of each load case.
    answers: Vec<Option<State>>,
}

impl CaseSweeper {
    /// Creates a sweeper for the loads of a compiled deck.
    pub fn new(system: &System, loads: Loads, settings: StaticSettings) -> Self {
        Self {
            settings,
            solver: Solver::new(system),
            answers: vec![None; loads.cases.len()],
            loads,
        }
    }

    /// Replaces the loads. The stored solutions are kept if the number of load cases stays the same.
    pub(crate) fn set_loads(&mut self, loads: Loads) {
        if self.answers.len() != loads.cases.len() {
            self.forget(loads.cases.len());
        }
        self.loads = loads;
    }

    /// Replaces the values of the loads and discards the stored solutions.
    pub fn set_cases(&mut self, cases: Vec<Vec<f64>>) {
        self.forget(cases.len());
        self.loads.cases = cases;
    }

    fn forget(&mut self, cases: usize) {
        self.answers = vec![None; cases];
    }

    /// Returns the number of load cases.
    pub fn cases(&self) -> usize {
        self.loads.cases.len()
    }

    /// Sets the loads of a load case in `parameters`.
    pub fn load(&self, case: usize, parameters: &mut Parameters) {
        for (slot, value) in self.loads.slots.iter().zip(&self.loads.cases[case]) {
            parameters.set(*slot, *value);
        }
    }

    /// Returns the stored solution of a load case.
    pub fn answer(&self, case: usize) -> Option<&State> {
        self.answers[case].as_ref()
    }

    /// Returns the stored solutions of all load cases.
    pub fn answers(&self) -> &[Option<State>] {
        &self.answers
    }

    /// Replaces the stored solutions of all load cases by earlier ones.
    pub fn return_to(&mut self, answers: &[Option<State>]) {
        self.answers.clone_from_slice(answers);
    }

    /// Stores the solution of a load case.
    pub fn keep(&mut self, case: usize, state: State) {
        self.answers[case] = Some(state);
    }

    /// Solves a load case and returns the solution without storing it.
    ///
    /// Three start states are tried in turn until one leads to an equilibrium: `own`, the stored solution of the nearest earlier load case,
    /// and the design position.
    ///
    /// # Errors
    /// Returns the error for the first start state if none of them leads to an equilibrium.
    pub fn solve(
        &mut self,
        system: &System,
        parameters: &Parameters,
        case: usize,
        own: Option<State>,
    ) -> Result<State, SolveError> {
        let before = self.answers[..case].iter().flatten().next_back().cloned();
        let mut first = None;
        for mut state in [own, before].into_iter().flatten() {
            match self
                .solver
                .solve(system, parameters, &mut state, &self.settings)
            {
                Ok(_) => return Ok(state),
                Err(error) => first = first.or(Some(error)),
            }
        }
        let mut state = system.state();
        match self
            .solver
            .solve(system, parameters, &mut state, &self.settings)
        {
            Ok(_) => Ok(state),
            Err(error) => Err(first.unwrap_or(error)),
        }
    }

    /// Returns the static solver, for queries at a solution.
    pub fn solver(&mut self) -> &mut Solver {
        &mut self.solver
    }

    /// Returns the largest residual of the force balance in all equilibria found so far.
    pub fn balance(&self) -> Option<&admire_solver::statics::Balance> {
        self.solver.worst_balance()
    }
}
