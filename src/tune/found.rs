use crate::evaluation::Evaluation;

/// Result of a search from one start.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub start: Vec<f64>,
    pub x: Vec<f64>,
    /// Results at the end of the search; `None` if the axle has no equilibrium at the start.
    pub end: Option<Evaluation>,
    /// Cost of the misses and moves. Limits do not contribute.
    pub cost: f64,
    /// Largest miss of a limit, in units of its tolerance.
    pub violation: f64,
    /// Sum of the multipliers of the constraints on each row.
    pub pulls: Vec<f64>,
    pub is_converged: bool,
    pub evaluations: usize,
}
