use super::effect::EffectSpec;
use super::load_table::LoadTable;
use super::scatter::Scatter;
use super::tolerances::Tolerances;

/// Options of the virtual rig.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RigOptions {
    /// Seed of all random streams.
    pub seed: u64,
    /// Standard deviation of a mark coordinate, in place of the study's. Zero makes every reading exact.
    pub sigma: Option<f64>,
    /// Standard deviation of a mark coordinate in the first session, in place of the study's. The folder states it, as a data sheet would.
    pub sigma_on_parts: Option<f64>,
    /// Effects to plant.
    pub effects: Vec<EffectSpec>,
    /// Small errors in many places, planted in addition.
    pub tolerances: Tolerances,
    /// Distribution of the noise of the marks.
    pub scatter: Scatter,
    /// Load programme in place of the study's load cases. The loads of the study must be called vertical, lateral and longitudinal.
    pub programme: Option<LoadTable>,
}
