use admire_kc::{KcRun, Probed};

/// Results of the tests and load cases that the goals name, on one deck.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Results of the tests; `None` if every goal reads a load case.
    pub run: Option<KcRun>,
    /// Load cases that goals name, in the order of the study.
    pub cases: Vec<CaseAnswer>,
}

/// Equilibrium of a load case.
#[derive(Clone, PartialEq, Debug)]
pub struct CaseAnswer {
    /// Label of the load case.
    pub label: String,
    /// Forces, positions and readings that goals name, with their derivatives.
    pub probed: Probed,
}
