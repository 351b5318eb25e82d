use std::collections::BTreeMap;

use serde::Serialize;

use super::cause::Cause;
use super::cross_validation::CrossValidation;
use super::hold_out::HoldOut;
use super::remainder::Remainder;
use super::solver_difference::SolverDifference;
use admire_identify::Status;
pub use admire_identify::{NoiseFound, ToleranceFound};

/// Result of the diagnosis in one word.
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
    /// Chi-square per degree of freedom of the fitted cases.
    pub chi2_per_dof: f64,
    /// Rms error of one mark coordinate in the held-out cases, in the deck's length unit.
    pub held_out_rms: Option<f64>,
}

/// Statistical evidence for a finding.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Evidence {
    /// Name of the statistic: `evidence`, or `marks of rigid parts`.
    pub statistic: &'static str,
    /// Value of the statistic: twice the log Bayes factor, or the chi-square of an error seen in the marks alone.
    pub value: f64,
    /// Chi-square p-value with one degree of freedom per parameter. For causes found by the search, it is multiplied by the number of
    /// candidates tried.
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
    /// Deficit of its refitted model against the leading model: twice the log posterior odds.
    pub bic_behind: f64,
}

/// Improvement of the model by a finding.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Gain {
    /// Chi-square per degree of freedom without the finding.
    pub chi2_per_dof_before: f64,
    /// Chi-square per degree of freedom with the finding.
    pub chi2_per_dof_after: f64,
    /// Rms error of one held-out mark coordinate without the finding, in the deck's length unit.
    pub held_out_rms_before: Option<f64>,
    /// Rms error of one held-out mark coordinate with the finding, in the deck's length unit.
    pub held_out_rms_after: Option<f64>,
    /// P-value of the held-out readings under the extended model's prediction and its covariance.
    pub held_out_p_value: Option<f64>,
    /// Gain in the cross-validated log predictive density over groups of cases, in nats. `None` for a fault that acts in one case alone.
    pub cross_validated_nats: Option<f64>,
}

/// Name of the parameter that states the misfit of a fitted force law: the force by which the true law differs, rms over the cases.
pub const LAW_MISFIT: &str = "law_misfit";

/// Probable cause of a discrepancy, with its size and evidence.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Finding {
    /// Cause.
    pub cause: Cause,
    /// Address of the cause in the deck.
    pub address: String,
    /// `point`: all markers that meet there moved together. `part`: only one side moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<String>,
    /// Addresses of all members if the finding has several, such as the markers of one hardpoint.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<String>,
    /// Posterior probability of this cause at this site.
    pub probability: f64,
    /// Posterior probability that this cause or one of `indistinguishable_from` acts.
    pub group_probability: f64,
    /// Estimates of the parameters by name.
    pub parameters: BTreeMap<String, f64>,
    /// Standard errors of the parameters by name.
    pub std_error: BTreeMap<String, f64>,
    /// True if the effect on marks and wheel is too small to matter for the use of the model.
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
    /// Smallest p-value of the tests of structure, corrected for their number. Includes a failed test of the held-out cases.
    pub p_value: f64,
    /// Locations of the remaining structure, one phrase each. For the report only.
    #[serde(skip)]
    pub places: Vec<String>,
    /// Extra force that best explains the remainder. `None` where no location stands out.
    pub remainder: Option<Remainder>,
}

/// Proposed measurement that separates rival explanations.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NextMeasurement {
    /// Value of each load by name.
    pub case: BTreeMap<String, f64>,
    /// Purpose of the measurement.
    pub why: String,
}

/// Identified stiffness, averaged over the probable models.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Parameter {
    /// Address in the deck, such as `BUSHING/1.K.1`.
    pub address: String,
    /// Unit. Rotational stiffnesses KT are per radian.
    pub unit: String,
    /// Initial value from the deck.
    pub initial: f64,
    /// Estimate.
    pub value: f64,
    /// Standard error, in the unit of the value.
    pub std_error: f64,
    /// Interval of 95 percent probability, tolerances and causes included. A side without a bound is `null`.
    pub interval95: [Option<f64>; 2],
    /// Fraction of its variance that is due to tolerances.
    pub tolerance_share: f64,
    /// Result of the identification of this stiffness.
    pub status: Status,
}

impl Parameter {
    /// Multiplies the estimate, its standard error and its interval by `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.value *= factor;
        self.std_error *= factor;
        for side in self.interval95.iter_mut().flatten() {
            *side *= factor;
        }
    }
}

/// Smallest error of a hardpoint that would be named with even odds.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct DetectionLimit {
    /// First marker of the hardpoint.
    pub address: String,
    /// All markers that meet at the hardpoint.
    pub members: Vec<String>,
    /// Limits along x, y and z of ground, in mm. `null` where the readings are insensitive.
    pub mm: [Option<f64>; 3],
}

/// Smallest size of any other cause that would be named with even odds.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CauseLimit {
    /// Cause.
    pub cause: Cause,
    /// Address of the cause in the deck.
    pub address: String,
    /// Name of the parameter, as in `findings[].parameters`.
    pub number: String,
    /// Limit in the unit of the parameter. `null` where the readings are insensitive.
    pub size: Option<f64>,
}

/// Contents of `diagnosis.json`.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Diagnosis {
    /// Result in one word.
    pub verdict: Verdict,
    /// Difference between the study's solver and the built-in solver that runs the search. Absent if the study names no other solver.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<SolverDifference>,
    /// Best fit of the original model, without causes.
    pub baseline: BaselineFit,
    /// Findings, the most important first.
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
    /// Prediction of each group of cases from the other groups, with the causes selected anew. `None` with too few cases or no finding.
    pub cross_validation: Option<CrossValidation>,
    /// Prediction of cases that no fit used. `None` without held-out cases or without a finding.
    pub hold_out: Option<HoldOut>,
    /// Structure that remains in the residuals of the extended model.
    pub unexplained: Unexplained,
    /// Proposed next measurement.
    pub next_measurement: Option<NextMeasurement>,
    /// True if the search ended before it finished, by its budget or by request.
    pub interrupted: bool,
}

impl Diagnosis {
    /// Returns the contents of `diagnosis.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a diagnosis holds only names and numbers") + "\n"
    }
}
