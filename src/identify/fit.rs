use std::collections::BTreeMap;

use serde::Serialize;

use super::Unknown;
use super::goodness::FitTest;
use super::lack_of_fit::LackOfFitTest;
use super::repeated::{BootstrapMade, PosteriorMade, Repeated};
use admire_solver::statics::Balance;

/// Remark on a fit that ended before it reached its minimum.
pub const NOT_CONVERGED: &str = "The fit did not converge; these are the values it had reached.";

/// Outcome of the identification of one parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The readings determine the parameter.
    Identified,
    /// The readings do not determine the parameter. In the regression, the parameter kept its previous value. In the other methods, the
    /// standard deviation of its logarithm exceeds 0.5.
    Unidentifiable,
    /// The parameter is at a bound of its allowed range.
    Bound,
}

/// Number of the deck that an identified change or factor sets.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NumberFit {
    /// Address of the number.
    pub address: String,
    /// Value in the deck; angles in radians.
    pub before: f64,
    /// Value set by this parameter alone; angles in radians.
    pub after: f64,
}

impl NumberFit {
    /// Returns the numbers of the deck that an unknown changes, with their values if the unknown has the value `value`.
    pub fn of(unknown: &Unknown, value: f64) -> Vec<Self> {
        let changed = unknown.changed_numbers().iter();
        changed
            .zip(unknown.assign(value))
            .map(|(own, (address, after))| Self {
                address: address.to_string(),
                before: own.deck,
                after,
            })
            .collect()
    }
}

/// One identified parameter, as `identification.json` shows it.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ParameterFit {
    /// Address of the parameter, such as `BUSHING/1.K.1`.
    pub address: String,
    /// `change` or `factor` if the parameter changes or scales numbers of the deck; `None` if it is a number of the deck itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<&'static str>,
    /// Addresses of further parameters that symmetry makes equal to this one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tied: Vec<String>,
    /// Numbers of the deck that a change or a factor sets; empty if the parameter is a number of the deck itself.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub numbers: Vec<NumberFit>,
    /// Unit of the parameter; rotational stiffnesses are per radian.
    pub unit: String,
    /// Value at which the identification started.
    pub initial: f64,
    /// Identified value.
    pub value: f64,
    /// Standard error of the value, in the unit of the value; `None` if it is not determined.
    pub std_error: Option<f64>,
    /// 95 percent interval of the value. A side without a bound is `None`, written as `null`.
    pub interval95: [Option<f64>; 2],
    /// Correlation coefficient. In the regression, it is the correlation r of force and deflection (equation 15 of the paper). In the other
    /// methods, it is the largest correlation, by magnitude, of the estimates of this and another parameter.
    pub correlation: Option<f64>,
    /// Share of the variance `std_error^2` that is due to tolerances; `None` for methods without tolerances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance_share: Option<f64>,
    /// 95 percent profile-likelihood interval with tolerances marginalised; `None` unless the fit was repeated by bootstrap or posterior
    /// sampling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile95: Option<[Option<f64>; 2]>,
    /// Distribution of the parameter over repeated fits of simulated readings (bootstrap).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<Repeated>,
    /// Distribution of the parameter over draws from the posterior.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posterior: Option<Repeated>,
    /// Outcome of the identification of this parameter.
    pub status: Status,
}

/// Estimated size (standard deviation) of a group of tolerances.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ToleranceFound {
    /// Estimated standard deviation of each error in the group.
    pub sd: f64,
    /// Usual standard deviation of such errors: the median of its prior.
    pub usual: f64,
    /// Unit of `sd` and `usual`.
    pub unit: &'static str,
    /// True if the estimate is implausibly large: it exceeds the range of its prior or, for pose noise, the noise of a mark. The group may then
    /// have absorbed a model error.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub strained: bool,
}

/// Noise of the measured mark coordinates.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NoiseFound {
    /// Standard deviation per mark coordinate as stated by the study; `None` if the study does not state it.
    pub declared: Option<f64>,
    /// Standard deviation per mark coordinate, estimated from the scatter of the marks of rigid parts.
    pub estimated: Option<f64>,
    /// Degrees of freedom of the Student t distribution of the noise, if its tails are heavy.
    pub dof: Option<f64>,
}

/// Estimated assembly offset of a bushing (equation 9 of the paper).
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct OffsetFit {
    /// Address of the bushing, such as `BUSHING/1`.
    pub address: String,
    /// Measured minus true deflection in J axes: three lengths, then three angles in radians.
    pub delta: [f64; 6],
    /// Standard error of each component of `delta`; `None` if it is not determined.
    pub std_error: [Option<f64>; 6],
}

/// Linear combination of the logarithms of the parameters that is poorly determined by the readings.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct UnidentifiableDirection {
    /// Coefficient of each logarithm by the address of the parameter: a unit vector without its small components.
    pub combination: BTreeMap<String, f64>,
    /// Standard deviation of the combination.
    pub sd_log: f64,
}

/// Statistics of the mark residuals in a fit.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Marks {
    /// Rms residual per coordinate, over all marks.
    pub rms: Option<f64>,
    /// Chi-square of the mark residuals per degree of freedom.
    pub chi2_per_dof: Option<f64>,
    /// Standard deviation of the noise per mark coordinate.
    pub sigma: f64,
}

/// Rms errors of the mark coordinates over the fitted cases, as predicted by the plain deck. Other fitted unknowns, such as offsets and
/// frame errors, are not applied.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Written {
    /// Rms error with the initial parameters.
    pub marks_rms_before: f64,
    /// Rms error with the identified parameters.
    pub marks_rms_after: f64,
}

/// Prediction errors of the readings that were held out of the fit.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct HeldOut {
    /// Labels of the held-out cases.
    pub cases: Vec<String>,
    /// Rms error per mark coordinate in these cases with the initial parameters.
    pub marks_rms_before: Option<f64>,
    /// Rms error per mark coordinate in these cases with the identified parameters.
    pub marks_rms_after: Option<f64>,
    /// Prediction errors of the held-out channels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<CurveHeldOut>,
}

/// Prediction error of a channel that was held out of the fit.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CurveHeldOut {
    /// Name of the channel.
    pub name: String,
    /// Unit of the channel.
    pub unit: Option<String>,
    /// Number of readings of the channel.
    pub count: usize,
    /// Rms error of the channel with the initial parameters.
    pub rms_before: f64,
    /// Rms error of the channel with the identified parameters.
    pub rms_after: f64,
}

/// Rms errors of the wheel angles camber and steer, before and after the identification.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[allow(missing_docs)] // The fields have the names of the keys in identification.json.
pub struct WheelFit {
    pub camber_deg_rms_before: f64,
    pub camber_deg_rms_after: f64,
    pub steer_deg_rms_before: f64,
    pub steer_deg_rms_after: f64,
}

/// Result of an identification: the contents of `identification.json` and further data for the report.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Fit {
    /// Identification method: `gauss-newton`, `regression` or `direct`.
    pub method: String,
    /// Solver backend: `native`, `command` or `replay`.
    pub backend: String,
    /// True if the convergence test of the method was met.
    pub converged: bool,
    /// True if the run was stopped before it was complete.
    pub interrupted: bool,
    /// Addresses of the parameters that were not final when the run was interrupted: the rest of the run might still have changed their
    /// value or interval.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub affected: Vec<String>,
    /// Number of iterations of the method.
    pub iterations: usize,
    /// Number of equilibria that were solved.
    pub solver_runs: usize,
    /// Largest force imbalance of a part over all solutions; `None` if the backend does not report it.
    pub balance: Option<Balance>,
    /// SHA-256 over all input files, in hexadecimal.
    pub inputs_sha256: String,
    /// Identified parameters, in the order of the unknowns.
    pub parameters: Vec<ParameterFit>,
    /// Assembly offsets, one entry per bushing; empty if offsets were not estimated.
    pub assembly_offsets: Vec<OffsetFit>,
    /// Combinations of parameters that the readings do not determine.
    pub unidentifiable_directions: Vec<UnidentifiableDirection>,
    /// Estimated sizes of the tolerances that the intervals include, by name of the group; empty for methods without tolerances.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub tolerances: BTreeMap<String, ToleranceFound>,
    /// Noise of the mark coordinates: as stated by the study and as estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseFound>,
    /// Chi-square test of the residuals against the stated noise; `None` for readings without noise.
    pub fit_test: Option<FitTest>,
    /// Tests for structure in the residuals that noise alone would not show.
    pub structure: Vec<LackOfFitTest>,
    /// Statistics of the mark residuals with all fitted unknowns applied, including offsets, frame errors and mark errors.
    pub marks: Option<Marks>,
    /// Errors of the marks with only the identified parameters applied.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<Written>,
    /// Prediction errors of readings that were held out of the fit.
    pub held_out: HeldOut,
    /// Errors of the wheel angles before and after the identification.
    pub wheel: Option<WheelFit>,
    /// Settings and summary of the bootstrap, if one was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<BootstrapMade>,
    /// Settings and summary of the posterior sampling, if it was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorMade>,
    /// Values of the identified parameters at the start and after every iteration, used only for the report.
    #[serde(skip)]
    pub history: Vec<Vec<f64>>,
    /// Remarks on the result for report and console, one sentence each.
    #[serde(skip)]
    pub remarks: Vec<String>,
}

impl Fit {
    /// Returns the identified values in the order of the unknowns.
    pub fn values(&self) -> Vec<f64> {
        self.parameters
            .iter()
            .map(|parameter| parameter.value)
            .collect()
    }

    /// Records that the fit was interrupted before its values had converged. All parameters then count as affected.
    pub(super) fn cut_short(&mut self) {
        self.interrupted = true;
        self.affected = self.parameters.iter().map(|p| p.address.clone()).collect();
    }

    /// Returns the text of `identification.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a fit holds only names and numbers") + "\n"
    }
}
