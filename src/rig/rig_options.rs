use super::effect::EffectSpec;
use super::load_table::LoadTable;
use super::scatter::Scatter;
use super::tolerances::Tolerances;

/// Options of the virtual rig.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RigOptions {
    /// Seed of all random streams.
    pub seed: u64,
    /// Standard deviation of the mark readings, per coordinate; `None` for the value of the study. Zero makes all readings exact.
    pub sigma: Option<f64>,
    /// Standard deviation of the listed position of a mark on its part (first session), per coordinate; `None` for the value of the study. The
    /// new study states this value.
    pub sigma_on_parts: Option<f64>,
    /// Effects to plant.
    pub effects: Vec<EffectSpec>,
    /// Sizes of the small errors that are planted in many places in addition.
    pub tolerances: Tolerances,
    /// Distribution of the noise of the mark readings.
    pub scatter: Scatter,
    /// Standard load programme; `None` for the load cases of the study. A standard programme requires load columns named `vertical`, `lateral` and
    /// `longitudinal`.
    pub programme: Option<LoadTable>,
}
