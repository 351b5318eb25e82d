use std::collections::BTreeMap;

use serde::Serialize;

use super::goodness::FitTest;
use super::lack_of_fit::LackOfFitTest;
use super::repeated::{BootstrapMade, PosteriorMade, Repeated};
use admire_solver::statics::Balance;

/// Remark on a fit that ended before its minimum.
pub const NOT_CONVERGED: &str = "The fit did not converge; these are the values it had reached.";

/// Outcome for one number.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The data determine the number.
    Identified,
    /// Regression: the previous value was kept. Other methods: the standard deviation of ln K exceeds 0.5.
    Unidentifiable,
    /// The number is at a bound.
    Bound,
}

/// One identified number, as `identification.json` shows it.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ParameterFit {
    /// Address, such as `BUSHING/1.K.1`.
    pub address: String,
    /// Addresses of numbers that are equal by symmetry.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tied: Vec<String>,
    /// Unit; rotational stiffnesses are per radian.
    pub unit: String,
    /// Starting value.
    pub initial: f64,
    /// Estimate.
    pub value: f64,
    /// Standard error, in the unit of the value.
    pub std_error: Option<f64>,
    /// 95 percent interval; an unbounded side is `null`.
    pub interval95: [Option<f64>; 2],
    /// Regression: r of equation 15. Other methods: the correlation of largest magnitude with another number.
    pub correlation: Option<f64>,
    /// Share of the variance behind `std_error` that is due to tolerances; `None` for methods without tolerances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance_share: Option<f64>,
    /// 95 percent profile-likelihood interval with tolerances marginalised; only where the fit was repeated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile95: Option<[Option<f64>; 2]>,
    /// Result of repeated fits of simulated readings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<Repeated>,
    /// Result of draws from the posterior.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posterior: Option<Repeated>,
    /// Outcome.
    pub status: Status,
}

/// Estimated standard deviation of a group of tolerances.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ToleranceFound {
    /// Standard deviation of one member of the group.
    pub sd: f64,
    /// Usual standard deviation of such a group.
    pub usual: f64,
    /// Unit of `sd` and `usual`.
    pub unit: &'static str,
    /// True if the size exceeds what its prior allows, or if pose noise exceeds the noise of a mark. The group may then have absorbed a
    /// model error.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub strained: bool,
}

/// Noise of mark coordinates.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NoiseFound {
    /// Standard deviation as stated by the study.
    pub declared: Option<f64>,
    /// Standard deviation as estimated from the marks of rigid parts.
    pub estimated: Option<f64>,
    /// Degrees of freedom of Student's t, if the tails are heavy.
    pub dof: Option<f64>,
}

/// Assembly offset of a bushing (equation 9).
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct OffsetFit {
    /// Address, such as `BUSHING/1`.
    pub address: String,
    /// Measured minus true deflection: three lengths, three angles in radians, J axes.
    pub delta: [f64; 6],
    /// Standard errors of `delta`.
    pub std_error: [Option<f64>; 6],
}

/// A linear combination of logarithms of numbers that the data hardly determine.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct UnidentifiableDirection {
    /// Unit vector over ln K by address, without small components.
    pub combination: BTreeMap<String, f64>,
    /// Standard deviation along the combination.
    pub sd_log: f64,
}

/// Fit statistics of the marks.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Marks {
    /// Rms residual of one coordinate.
    pub rms: Option<f64>,
    /// Chi-square per degree of freedom.
    pub chi2_per_dof: Option<f64>,
    /// Standard deviation of one coordinate.
    pub sigma: f64,
}

/// Rms errors of one mark coordinate over the fitted cases, with the numbers of the deck applied and nothing else.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Written {
    /// Rms error with the initial numbers.
    pub marks_rms_before: f64,
    /// Rms error with the identified numbers, without any other fitted unknown.
    pub marks_rms_after: f64,
}

/// Results for held-out data, which no fit used.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct HeldOut {
    /// Labels of the held-out cases.
    pub cases: Vec<String>,
    /// Rms mark error with the initial numbers.
    pub marks_rms_before: Option<f64>,
    /// Rms mark error with the identified numbers.
    pub marks_rms_after: Option<f64>,
    /// Held-out curves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<CurveHeldOut>,
}

/// Results for a held-out channel, which no fit used.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CurveHeldOut {
    /// Name of the channel.
    pub name: String,
    /// Unit of the channel.
    pub unit: Option<String>,
    /// Number of readings.
    pub count: usize,
    /// Rms error with the initial numbers.
    pub rms_before: f64,
    /// Rms error with the identified numbers.
    pub rms_after: f64,
}

/// Rms errors of the wheel angles, before and after the identification.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[allow(missing_docs)] // The names are those of identification.json.
pub struct WheelFit {
    pub camber_deg_rms_before: f64,
    pub camber_deg_rms_after: f64,
    pub steer_deg_rms_before: f64,
    pub steer_deg_rms_after: f64,
}

/// Result of an identification: the contents of `identification.json`, and further data for the report.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Fit {
    /// Method: `gauss-newton`, `regression` or `direct`.
    pub method: String,
    /// Backend: `native`, `command` or `replay`.
    pub backend: String,
    /// Whether the convergence test of the method was met.
    pub converged: bool,
    /// Whether the run was stopped before it was complete.
    pub interrupted: bool,
    /// Addresses of the numbers whose value or interval the rest of the run would still have changed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub affected: Vec<String>,
    /// Number of iterations.
    pub iterations: usize,
    /// Number of equilibria solved: sweeps times cases.
    pub solver_runs: usize,
    /// Largest force imbalance of a part, recomputed from the solutions; `None` if another solver ran.
    pub balance: Option<Balance>,
    /// SHA-256 over all input files.
    pub inputs_sha256: String,
    /// Results, one per unknown.
    pub parameters: Vec<ParameterFit>,
    /// Assembly offsets, one entry per bushing, if they were estimated.
    pub assembly_offsets: Vec<OffsetFit>,
    /// Combinations of numbers that the data do not determine.
    pub unidentifiable_directions: Vec<UnidentifiableDirection>,
    /// Sizes of the tolerances that the intervals include, by group; empty for methods without tolerances.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub tolerances: BTreeMap<String, ToleranceFound>,
    /// Noise of the marks, stated and estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseFound>,
    /// Chi-square test of the residuals against the noise; `None` for readings without noise.
    pub fit_test: Option<FitTest>,
    /// Tests for structure in the residuals.
    pub structure: Vec<LackOfFitTest>,
    /// Fit statistics of the marks with all fitted unknowns, including offsets, frame errors and mark errors.
    pub marks: Option<Marks>,
    /// Fit statistics of the marks with the identified numbers alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<Written>,
    /// Results for data that no fit used.
    pub held_out: HeldOut,
    /// Fit statistics of the wheel.
    pub wheel: Option<WheelFit>,
    /// Settings and summary of the bootstrap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<BootstrapMade>,
    /// Settings and summary of the posterior sampling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorMade>,
    /// Values of the unknowns at the start and after every iteration; for the report only.
    #[serde(skip)]
    pub history: Vec<Vec<f64>>,
    /// Remarks on the result for the reader, one sentence each; for report and console.
    #[serde(skip)]
    pub remarks: Vec<String>,
}

impl Fit {
    /// Returns the values of the unknowns.
    pub fn values(&self) -> Vec<f64> {
        self.parameters
            .iter()
            .map(|parameter| parameter.value)
            .collect()
    }

    /// Marks the fit as interrupted before its values had converged.
    pub(super) fn cut_short(&mut self) {
        self.interrupted = true;
        self.affected = self.parameters.iter().map(|p| p.address.clone()).collect();
    }

    /// Returns the contents of `identification.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a fit holds only names and numbers") + "\n"
    }
}
