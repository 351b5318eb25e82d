use std::collections::BTreeMap;

use serde::Serialize;

use super::cause::Cause;
use super::cross_validation::CrossValidation;
use super::hold_out::HoldOut;
use super::remainder::Remainder;
use super::solver_difference::SolverDifference;
pub use admire_identify::{NoiseFound, ToleranceFound};
use admire_identify::{Status, Unknown};

/// Overall result of the diagnosis, in one word.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The model explains the data to within their noise.
    Consistent,
    /// At least one finding is not minor.
    Discrepancy,
    /// The residuals have structure that no known cause explains.
    Unexplained,
}

/// Best fit of the original model, without causes.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct BaselineFit {
    /// Chi-square of the fit per degree of freedom.
    pub chi2_per_dof: f64,
    /// Rms error of the marks in the held-out cases, per coordinate and in the deck's length unit.
    pub held_out_rms: Option<f64>,
}

/// Statistical evidence for a finding.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Evidence {
    /// Name of the statistic: `evidence` for causes found by the search, `marks of rigid parts` for errors seen in the marks alone.
    pub statistic: &'static str,
    /// Value of the statistic. For `evidence`, this is twice the log Bayes factor; otherwise it is the chi-square of the error in the marks.
    pub value: f64,
    /// P-value of the statistic as a chi-square. For a cause found by the search, it has one degree of freedom per parameter, and is
    /// multiplied by the number of candidates tried. For an error of the marks, it has one degree of freedom.
    pub p_value: f64,
    /// Twice the log posterior odds of the model with the finding against the model without it.
    pub bic_gain: f64,
}

/// Alternative cause that explains the readings about as well as a finding.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Indistinguishable {
    /// Alternative cause.
    pub cause: Cause,
    /// Address of the alternative cause in the deck.
    pub address: String,
    /// Posterior probability of the alternative cause at its site.
    pub probability: f64,
    /// Twice the log posterior odds of the leading model against the refitted model with the alternative cause.
    pub bic_behind: f64,
}

/// Improvement of fit and prediction by a finding.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Gain {
    /// Chi-square per degree of freedom without the finding.
    pub chi2_per_dof_before: f64,
    /// Chi-square per degree of freedom with the finding.
    pub chi2_per_dof_after: f64,
    /// Rms error of the held-out marks without the finding, per coordinate and in the deck's length unit.
    pub held_out_rms_before: Option<f64>,
    /// Rms error of the held-out marks with the finding, per coordinate and in the deck's length unit.
    pub held_out_rms_after: Option<f64>,
    /// P-value of the held-out readings under the extended model's prediction and its covariance.
    pub held_out_p_value: Option<f64>,
    /// Gain in the cross-validated log predictive density over groups of cases, in nats. `None` for a fault that acts in a single case, or
    /// without cross-validation.
    pub cross_validated_nats: Option<f64>,
}

/// Name of the reported parameter for the misfit of a fitted force law. Its value is the rms difference between the true and the fitted
/// force over the cases.
pub const LAW_MISFIT: &str = "law_misfit";

/// Probable cause of a discrepancy, with its size and evidence.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Finding {
    /// Cause that was found.
    pub cause: Cause,
    /// Address of the site in the deck.
    pub address: String,
    /// Form of the cause. For a hardpoint: `point` if all markers that meet there moved together, `part` if only one side moved. For a
    /// misplaced mark: `loose` if it moved during the measurement, otherwise `listed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<String>,
    /// Addresses of all members if the finding has several, such as the markers of one hardpoint.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<String>,
    /// Posterior probability that this cause acts at this site.
    pub probability: f64,
    /// Posterior probability that this cause or one of the causes in `indistinguishable_from` acts.
    pub group_probability: f64,
    /// Estimates of the cause's parameters, by name.
    pub parameters: BTreeMap<String, f64>,
    /// Standard errors of the cause's parameters, by name.
    pub std_error: BTreeMap<String, f64>,
    /// True if the effect of the finding on marks and wheel is too small to matter for the use of the model.
    pub minor: bool,
    /// Statistical evidence for the finding.
    pub evidence: Evidence,
    /// Alternative causes that explain the readings about as well.
    pub indistinguishable_from: Vec<Indistinguishable>,
    /// Improvement of fit and prediction by the finding.
    pub gain: Gain,
}

/// Structure that remains in the residuals of the extended model.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Unexplained {
    /// True if significant structure remains.
    pub structured: bool,
    /// Smallest p-value among the tests of structure, corrected for the number of tests. Includes the test of the held-out cases if that
    /// test fails.
    pub p_value: f64,
    /// Locations of the remaining structure, one phrase each. Used in the report, and left out of `diagnosis.json`.
    #[serde(skip)]
    pub places: Vec<String>,
    /// Extra force that best explains the remaining structure. `None` if no location stands out.
    pub remainder: Option<Remainder>,
}

/// Proposed measurement that distinguishes rival explanations.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NextMeasurement {
    /// Value of each load in the load case that distinguishes best, by name. Empty if no load is available.
    pub case: BTreeMap<String, f64>,
    /// Purpose of the measurement.
    pub why: String,
    /// Instrument that distinguishes the explanations. `None` if the load case does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instead: Option<String>,
}

/// Identified number, averaged over the probable models.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Parameter {
    /// Address in the deck, such as `BUSHING/1.K.1`.
    pub address: String,
    /// `change` or `factor` if the parameter changes or scales numbers of the deck; `None` if it is a number of the deck itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<&'static str>,
    /// Unit of the number. Rotational stiffnesses KT are per radian.
    pub unit: String,
    /// Value at which the fit begins.
    pub initial: f64,
    /// Estimated value.
    pub value: f64,
    /// Standard error, in the unit of the value.
    pub std_error: f64,
    /// Interval of 95 percent probability. It includes the uncertainty of tolerances and causes. A side without a bound is `null`.
    pub interval95: [Option<f64>; 2],
    /// Fraction of the variance that is due to tolerances.
    pub tolerance_share: f64,
    /// Result of the identification of this number.
    pub status: Status,
}

impl Parameter {
    /// Moves the estimate and its interval by the step between two coordinates of the unknown. If the coordinate is a logarithm, estimate,
    /// interval and standard error are multiplied by a factor. Otherwise, the difference is added to estimate and interval.
    pub fn move_to(&mut self, unknown: &Unknown, coordinates: [f64; 2]) {
        let [from, to] = coordinates.map(|x| unknown.value(x));
        let moved = |value: f64| {
            if unknown.is_logarithm() {
                value * (to / from)
            } else {
                value + (to - from)
            }
        };
        self.value = moved(self.value);
        for side in self.interval95.iter_mut().flatten() {
            *side = moved(*side);
        }
        if unknown.is_logarithm() {
            self.std_error = moved(self.std_error);
        }
    }
}

/// Detection limit of a hardpoint: the displacement at which the cause `hardpoint-error` has a posterior probability of one half.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct DetectionLimit {
    /// Address of the first marker of the hardpoint.
    pub address: String,
    /// Addresses of all markers that meet at the hardpoint.
    pub members: Vec<String>,
    /// Limits along x, y and z of ground, in mm. `null` for a direction in which the readings are insensitive.
    pub mm: [Option<f64>; 3],
}

/// Detection limit of a cause other than a hardpoint error: the size of one parameter at which the cause has a posterior probability of one
/// half.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CauseLimit {
    /// Cause to which the limit applies.
    pub cause: Cause,
    /// Address of the site in the deck.
    pub address: String,
    /// Name of the parameter, as in `findings[].parameters`.
    pub number: String,
    /// Limit in the unit of the parameter. `null` if the readings are insensitive to the parameter.
    pub size: Option<f64>,
}

/// Contents of `diagnosis.json`.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Diagnosis {
    /// Overall result in one word.
    pub verdict: Verdict,
    /// Difference between the study's solver and the built-in solver that runs the search. Absent if the study uses the built-in solver.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<SolverDifference>,
    /// Best fit of the original model, without causes.
    pub baseline: BaselineFit,
    /// Findings. Errors seen in the marks alone come first, then causes found by the search, the most important first.
    pub findings: Vec<Finding>,
    /// Posterior probability that no cause of the catalogue acts.
    pub none_of_these: f64,
    /// Stiffnesses, averaged over the probable models.
    pub parameters: Vec<Parameter>,
    /// Estimated standard deviations of the tolerance groups, by name.
    pub tolerances: BTreeMap<String, ToleranceFound>,
    /// Declared and estimated noise of the marks.
    pub noise: NoiseFound,
    /// Detection limits of the hardpoints.
    pub detection_limits: Vec<DetectionLimit>,
    /// Detection limits of all other causes.
    pub cause_limits: Vec<CauseLimit>,
    /// Prediction of each group of cases from the other groups, with causes selected from those groups. `None` with too few cases or without
    /// a finding.
    pub cross_validation: Option<CrossValidation>,
    /// Prediction of the held-out cases by models fitted without them. `None` without held-out cases or without a finding.
    pub hold_out: Option<HoldOut>,
    /// Structure that remains in the residuals of the extended model.
    pub unexplained: Unexplained,
    /// Proposed next measurement. `None` without a proposal.
    pub next_measurement: Option<NextMeasurement>,
    /// True if the search ended early: its budget was spent, or the user stopped it.
    pub interrupted: bool,
}

impl Diagnosis {
    /// Returns the contents of `diagnosis.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a diagnosis holds only names and numbers") + "\n"
    }
}
