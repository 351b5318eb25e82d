use std::collections::BTreeMap;

use serde::Serialize;

use super::cause::Cause;
use super::cross_validation::CrossValidation;
use super::hold_out::HoldOut;
use super::remainder::Remainder;
use super::solver_difference::SolverDifference;
use admire_identify::Status;
pub use admire_identify::{NoiseFound, ToleranceFound};

/// The answer in one word.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The model explains the data to their noise.
    Consistent,
    /// At least one finding that matters.
    Discrepancy,
    /// Structure remains that no known cause explains.
    Unexplained,
}

/// The model as it was, best fitted.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct BaselineFit {
    /// Chi-square per degree of freedom of the cases that were fitted.
    pub chi2_per_dof: f64,
    /// Rms of one mark coordinate in the cases held out.
    pub held_out_rms: Option<f64>,
}

/// Why a finding is one.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Evidence {
    /// Name of the statistic.
    pub statistic: &'static str,
    /// Its value: fall of chi-square.
    pub value: f64,
    /// Its p-value for so many numbers, places tried included.
    pub p_value: f64,
    /// By how much the criterion of Schwarz falls.
    pub bic_gain: f64,
}

/// Another explanation that does as well.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Indistinguishable {
    /// What.
    pub cause: Cause,
    /// Where.
    pub address: String,
    /// Posterior probability of that cause at that place.
    pub probability: f64,
    /// By how much its criterion is behind, after its own refit.
    pub bic_behind: f64,
}

/// What a finding gains.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Gain {
    /// Without it.
    pub chi2_per_dof_before: f64,
    /// With it.
    pub chi2_per_dof_after: f64,
    /// Rms of one mark coordinate held out, without it.
    pub held_out_rms_before: Option<f64>,
    /// The same with it.
    pub held_out_rms_after: Option<f64>,
    /// Whether the held-out readings agree with the prediction and its own covariance.
    pub held_out_p_value: Option<f64>,
    /// By how many nats groups of cases are predicted better with it, each from the others; `None` for what acts in one case alone.
    pub cross_validated_nats: Option<f64>,
}

/// Among the `parameters` of a finding: the force by which its law differs from the one that was fitted, root mean square over the cases.
pub const LAW_MISFIT: &str = "law_misfit";

/// One thing that is wrong.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Finding {
    /// What.
    pub cause: Cause,
    /// Where.
    pub address: String,
    /// `point`: all markers that meet there moved together; `part`: one side only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<String>,
    /// All addresses of the same thing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<String>,
    /// Posterior probability of this cause at this place.
    pub probability: f64,
    /// Posterior probability that it acts or one of `indistinguishable_from` does.
    pub group_probability: f64,
    /// How large.
    pub parameters: BTreeMap<String, f64>,
    /// How well that is known.
    pub std_error: BTreeMap<String, f64>,
    /// True if it does not matter for what the model is used for.
    pub minor: bool,
    /// Why it is a finding.
    pub evidence: Evidence,
    /// What else would do as well.
    pub indistinguishable_from: Vec<Indistinguishable>,
    /// What it gains.
    pub gain: Gain,
}

/// What remains.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Unexplained {
    /// True if something does.
    pub structured: bool,
    /// Of the hardest test, for all tests done.
    pub p_value: f64,
    /// Where it is, one sentence each. For the report only.
    #[serde(skip)]
    pub places: Vec<String>,
    /// The extra force that it looks most like; `None` where no place stands out.
    pub remainder: Option<Remainder>,
}

/// A measurement that would tell rivals apart.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NextMeasurement {
    /// Value of each load.
    pub case: BTreeMap<String, f64>,
    /// What it is for.
    pub why: String,
}

/// A stiffness, averaged over the models that remain.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Parameter {
    /// `BUSHING/1.K.1`.
    pub address: String,
    /// Its unit; KT is per radian.
    pub unit: String,
    /// Where it started.
    pub initial: f64,
    /// The estimate.
    pub value: f64,
    /// Standard error, in the unit of the value.
    pub std_error: f64,
    /// 95 percent interval, tolerances and causes included; a side without a bound is `null`.
    pub interval95: [Option<f64>; 2],
    /// Which part of its variance is due to tolerances.
    pub tolerance_share: f64,
    /// What became of it.
    pub status: Status,
}

impl Parameter {
    /// Multiplies the estimate and what is known of it.
    pub fn scale(&mut self, factor: f64) {
        self.value *= factor;
        self.std_error *= factor;
        for side in self.interval95.iter_mut().flatten() {
            *side *= factor;
        }
    }
}

/// How far off a hardpoint has to be to be named with even odds.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct DetectionLimit {
    /// Its first marker.
    pub address: String,
    /// All markers that meet there.
    pub members: Vec<String>,
    /// Along x, y, z of ground in millimetres; `null` where the readings do not see it.
    pub mm: [Option<f64>; 3],
}

/// How large another cause has to be to be named with even odds.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CauseLimit {
    /// What.
    pub cause: Cause,
    /// Where.
    pub address: String,
    /// Which of its numbers, as `findings[].parameters` has them.
    pub number: String,
    /// Its size; `null` where the readings do not see it.
    pub size: Option<f64>,
}

/// What `diagnosis.json` holds.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Diagnosis {
    /// In one word.
    pub verdict: Verdict,
    /// How far the solver of the study is from the built-in one, which searches; absent where the study has no other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<SolverDifference>,
    /// The model as it was.
    pub baseline: BaselineFit,
    /// What is wrong, the most important first.
    pub findings: Vec<Finding>,
    /// Probability that no cause of the catalogue acts.
    pub none_of_these: f64,
    /// Stiffnesses, averaged over the models that remain.
    pub parameters: Vec<Parameter>,
    /// Sizes of tolerances.
    pub tolerances: BTreeMap<String, ToleranceFound>,
    /// Noise of marks.
    pub noise: NoiseFound,
    /// What could not be seen: how far off each hardpoint has to be.
    pub detection_limits: Vec<DetectionLimit>,
    /// The same for all other causes.
    pub cause_limits: Vec<CauseLimit>,
    /// Groups of cases, each predicted from the others with causes chosen anew; `None` with too few cases or no finding.
    pub cross_validation: Option<CrossValidation>,
    /// Cases that neither the choice of causes nor any fit saw; `None` without them or without a finding.
    pub hold_out: Option<HoldOut>,
    /// What remains.
    pub unexplained: Unexplained,
    /// What to measure next.
    pub next_measurement: Option<NextMeasurement>,
    /// True if the search had spent its budget before it came to its end.
    pub interrupted: bool,
}

impl Diagnosis {
    /// `diagnosis.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a diagnosis holds only names and numbers") + "\n"
    }
}
