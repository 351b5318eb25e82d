use super::effect::EffectSpec;
use super::load_table::LoadTable;
use super::scatter::Scatter;
use super::tolerances::Tolerances;

/// What the rig is asked to do.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RigOptions {
    /// Seed of the noise.
    pub seed: u64,
    /// Sd of a mark coordinate instead of the study's; zero makes every reading exact.
    pub sigma: Option<f64>,
    /// Sd of one coordinate of the first session instead of the study's; the folder tells it, as the data sheet would.
    pub sigma_on_parts: Option<f64>,
    /// Effects to plant.
    pub effects: Vec<EffectSpec>,
    /// Small errors in many places besides.
    pub tolerances: Tolerances,
    /// How the marks scatter.
    pub scatter: Scatter,
    /// Load cases instead of the study's, whose loads must be called vertical, lateral and longitudinal.
    pub programme: Option<LoadTable>,
}
