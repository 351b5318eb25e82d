use admire_kc::BenchError;

/// A test without an equilibrium.
#[derive(Clone, Debug)]
pub struct TuneError {
    /// Unknowns, by what the user calls their values; empty for the deck of the study.
    pub unknowns: Vec<f64>,
    /// Why the rig gives no result.
    pub why: BenchError,
}
