use admire_kc::{KcRun, Probed};

/// Results of the tests and load cases that the goals name, on one deck.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Results of the tests; `None` if all goals are those of load cases.
    pub run: Option<KcRun>,
    /// Load cases that goals name, in the order of the study.
    pub cases: Vec<CaseAnswer>,
}

/// Equilibrium of a load case.
#[derive(Clone, PartialEq, Debug)]
pub struct CaseAnswer {
    /// Label of the load case.
    pub label: String,
    /// Forces, places and readings that goals name, with their derivatives.
    pub probed: Probed,
}
