use admire_kc::BenchError;

/// A test without an equilibrium.
#[derive(Clone, Debug)]
pub struct TuneError {
    /// Values of the unknowns as the user states them; empty for the deck of the study.
    pub unknowns: Vec<f64>,
    /// Reason why the rig gives no result.
    pub why: BenchError,
}
