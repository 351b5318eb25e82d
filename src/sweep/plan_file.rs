//! Tables and keys of SWEEP.toml.

use serde::Deserialize;
use toml::Spanned;

use super::variation::Apply;
use admire_diagnosis::GainCheck;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanFile {
    pub deck: Option<Spanned<String>>,
    pub study: Option<Spanned<String>>,
    pub commands: Option<Spanned<String>>,
    pub kc: Option<Spanned<String>>,
    pub check_gain: Option<Spanned<GainCheck>>,
    #[serde(default)]
    pub seed: u64,
    #[serde(default)]
    pub ignore: Vec<Spanned<String>>,
    pub sampling: Sampling,
    #[serde(default)]
    pub vary: Vec<Spanned<Vary>>,
    #[serde(default)]
    pub correlate: Vec<Spanned<Correlate>>,
    #[serde(default)]
    pub keep: Vec<Spanned<Keep>>,
    pub solver: Option<Spanned<Solver>>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum PlanWord {
    Random,
    LatinHypercube,
    Sobol,
    FullFactorial,
    SobolIndices,
    Morris,
    Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sampling {
    pub plan: Spanned<PlanWord>,
    /// Number of cases; for `sobol-indices` the number of base points, for `morris` the number of trajectories.
    pub cases: Option<Spanned<u64>>,
    pub levels: Option<Spanned<u64>>,
    pub file: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Vary {
    pub name: Option<Spanned<String>>,
    pub address: Spanned<OneOrMore>,
    #[serde(default)]
    pub apply: Apply,
    #[serde(default)]
    pub degrees: bool,
    pub uniform: Option<Spanned<[f64; 2]>>,
    pub normal: Option<Spanned<Normal>>,
    pub log_normal: Option<Spanned<LogNormal>>,
    pub values: Option<Spanned<Vec<f64>>>,
    pub weights: Option<Spanned<Vec<f64>>>,
    pub levels: Option<Spanned<u64>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum OneOrMore {
    One(String),
    More(Vec<String>),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Normal {
    pub mean: f64,
    pub sd: f64,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LogNormal {
    pub median: f64,
    pub sigma: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Correlate {
    pub names: Vec<Spanned<String>>,
    pub coefficient: Option<f64>,
    pub matrix: Option<Vec<Vec<f64>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Keep {
    pub column: Option<Spanned<String>>,
    pub at: Option<Spanned<String>>,
    pub step: Option<Spanned<usize>>,
    pub time: Option<Spanned<f64>>,
    pub mode: Option<Spanned<usize>>,
    pub characteristic: Option<Spanned<String>>,
    pub identification: Option<Spanned<String>>,
    pub diagnosis: Option<Spanned<String>>,
    pub test: Option<Spanned<String>>,
    pub name: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Solver {
    pub command: Option<Spanned<Vec<String>>>,
    pub recordings: Option<Spanned<String>>,
    #[serde(default = "an_hour")]
    pub timeout_s: f64,
    #[serde(default = "an_hour")]
    pub licence_wait_s: f64,
}

const fn an_hour() -> f64 {
    3600.0
}
