use super::compiled::slot;
use super::{BackendError, LoadProgramme};
use admire_solver::statics::{Settings, SolveError, Solver};
use admire_solver::system::{Parameters, Slot, State, System};

/// Numbers that change from case to case: the loads.
#[derive(Clone, PartialEq, Debug)]
pub struct Loads {
    /// One slot per column.
    pub slots: Vec<Slot>,
    /// One row per case, in the order of application.
    pub cases: Vec<Vec<f64>>,
}

impl Loads {
    /// The loads of a programme, of a compiled deck.
    ///
    /// # Errors
    /// A load that drives nothing the solver can change.
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

/// Solves load cases with the built-in solver: sets their loads, and starts each from the first of several states that leads to an
/// equilibrium.
#[derive(Debug)]
pub struct CaseSweeper {
    loads: Loads,
    settings: Settings,
    solver: Solver,
    /// The last answer of each case.
    answers: Vec<Option<State>>,
}

impl CaseSweeper {
    /// For the loads of a compiled deck.
    pub fn new(system: &System, loads: Loads, settings: Settings) -> Self {
        Self {
            settings,
            solver: Solver::new(system),
            answers: vec![None; loads.cases.len()],
            loads,
        }
    }

    /// Takes other loads. The answers stay if there are as many cases.
    pub(crate) fn set_loads(&mut self, loads: Loads) {
        if self.answers.len() != loads.cases.len() {
            self.forget(loads.cases.len());
        }
        self.loads = loads;
    }

    /// Takes other values of the loads, and forgets the answers.
    pub fn set_cases(&mut self, cases: Vec<Vec<f64>>) {
        self.forget(cases.len());
        self.loads.cases = cases;
    }

    fn forget(&mut self, cases: usize) {
        self.answers = vec![None; cases];
    }

    /// How many cases there are.
    pub fn cases(&self) -> usize {
        self.loads.cases.len()
    }

    /// Sets the loads of a case.
    pub fn load(&self, case: usize, parameters: &mut Parameters) {
        for (slot, value) in self.loads.slots.iter().zip(&self.loads.cases[case]) {
            parameters.set(*slot, *value);
        }
    }

    /// The last answer of a case.
    pub fn answer(&self, case: usize) -> Option<&State> {
        self.answers[case].as_ref()
    }

    /// The last answers of all cases.
    pub fn answers(&self) -> &[Option<State>] {
        &self.answers
    }

    /// Returns to earlier answers of all cases.
    pub fn return_to(&mut self, answers: &[Option<State>]) {
        self.answers.clone_from_slice(answers);
    }

    /// Keeps an answer of a case: the next solution starts there.
    pub fn keep(&mut self, case: usize, state: State) {
        self.answers[case] = Some(state);
    }

    /// Solves a case from `own`, where it stood before; failing that from the answer of the nearest case before it, failing that from the
    /// design position. The answer is not kept.
    ///
    /// # Errors
    /// Why the first of these led nowhere.
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

    /// The solver, for what is asked about an answer.
    pub fn solver(&mut self) -> &mut Solver {
        &mut self.solver
    }

    /// What the equilibria so far left over at worst.
    pub fn balance(&self) -> Option<&admire_solver::statics::Balance> {
        self.solver.worst_balance()
    }
}
