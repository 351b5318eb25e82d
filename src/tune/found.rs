use crate::evaluation::Evaluation;

/// End of a search from one start.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub start: Vec<f64>,
    pub x: Vec<f64>,
    /// Results at the end; `None` if the axle has no equilibrium at the start.
    pub end: Option<Evaluation>,
    /// Cost of misses and moves; limits cost nothing.
    pub cost: f64,
    /// Largest miss of a limit, in units of its tolerance.
    pub violation: f64,
    /// Pull of the constraints on each row: the sum of their multipliers.
    pub pulls: Vec<f64>,
    pub is_converged: bool,
    pub evaluations: usize,
}
