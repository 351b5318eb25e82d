use std::collections::BTreeMap;

use serde::Serialize;

use super::goodness::FitTest;
use super::repeated::{BootstrapMade, PosteriorMade, Repeated};
use super::structure::LackOfFitTest;
use admire_solver::statics::Balance;

/// What is told of a fit that ended before its minimum.
pub const NOT_CONVERGED: &str = "The fit did not converge; these are the values it had reached.";

/// What became of a number.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Found.
    Identified,
    /// Regression: the previous value was kept. Other methods: sd of ln K above 0.5.
    Unidentifiable,
    /// At a bound.
    Bound,
}

/// One identified number, as `identification.json` shows it.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ParameterFit {
    /// `BUSHING/1.K.1`.
    pub address: String,
    /// Addresses of numbers that equal it by symmetry.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tied: Vec<String>,
    /// Its unit; KT is per radian.
    pub unit: String,
    /// Where it started.
    pub initial: f64,
    /// The estimate.
    pub value: f64,
    /// Standard error, in the unit of the value.
    pub std_error: Option<f64>,
    /// 95 percent interval; a side without a bound is `null`.
    pub interval95: [Option<f64>; 2],
    /// Regression: r of equation 15. Other methods: the largest correlation with another number.
    pub correlation: Option<f64>,
    /// Part of the variance behind `std_error` that is due to tolerances; `None` where the method knows none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance_share: Option<f64>,
    /// 95 percent interval by profile likelihood with tolerances marginalised; only where the fit was repeated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile95: Option<[Option<f64>; 2]>,
    /// What fits of readings drawn anew say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<Repeated>,
    /// What draws from the posterior say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posterior: Option<Repeated>,
    /// What became of it.
    pub status: Status,
}

/// The size of a group of tolerances.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ToleranceFound {
    /// Standard deviation of one member.
    pub sd: f64,
    /// What is usual.
    pub usual: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// Whether it is more than its prior allows, or of whole parts more than the noise of a mark: it may have taken up what the model lacks.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub strained: bool,
}

/// Noise of mark coordinates.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NoiseFound {
    /// As the study states it.
    pub declared: Option<f64>,
    /// As the marks of rigid parts show it.
    pub estimated: Option<f64>,
    /// Degrees of freedom of Student's t, where the tails ask for it.
    pub dof: Option<f64>,
}

/// The assembly offset of a bushing (equation 9).
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct OffsetFit {
    /// `BUSHING/1`.
    pub address: String,
    /// Measured minus real deflection: three lengths, three angles in radians, J axes.
    pub delta: [f64; 6],
    /// Standard errors.
    pub std_error: [Option<f64>; 6],
}

/// A combination of logarithms of numbers the data say little about.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct UnidentifiableDirection {
    /// Unit vector over ln K, small components left out.
    pub combination: BTreeMap<String, f64>,
    /// Its standard deviation.
    pub sd_log: f64,
}

/// How the marks are explained.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Marks {
    /// Rms of one coordinate.
    pub rms: Option<f64>,
    /// Chi-square per degree of freedom.
    pub chi2_per_dof: Option<f64>,
    /// Sd of one coordinate.
    pub sigma: f64,
}

/// How far a deck is from the marks of the cases that were fitted, by itself: rms of one coordinate.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Written {
    /// With the initial numbers.
    pub marks_rms_before: f64,
    /// With the identified numbers, and nothing else that was fitted.
    pub marks_rms_after: f64,
}

/// What no fit saw.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct HeldOut {
    /// Labels of the cases.
    pub cases: Vec<String>,
    /// Rms mark error before.
    pub marks_rms_before: Option<f64>,
    /// Rms mark error after.
    pub marks_rms_after: Option<f64>,
    /// Curves that no fit saw.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curves: Vec<CurveHeldOut>,
}

/// A channel that no fit saw.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct CurveHeldOut {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: Option<String>,
    /// How many readings it has.
    pub count: usize,
    /// Rms error before.
    pub rms_before: f64,
    /// Rms error after.
    pub rms_after: f64,
}

/// How the wheel is explained.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[allow(missing_docs)] // The names are those of identification.json.
pub struct WheelFit {
    pub camber_deg_rms_before: f64,
    pub camber_deg_rms_after: f64,
    pub steer_deg_rms_before: f64,
    pub steer_deg_rms_after: f64,
}

/// The answer of an identification: what `identification.json` holds, and what only the report shows.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Fit {
    /// `gauss-newton`, `regression` or `direct`.
    pub method: String,
    /// `native`, `command` or `replay`.
    pub backend: String,
    /// Whether the method's own test of convergence was met.
    pub converged: bool,
    /// Whether somebody ended the run before it was done.
    pub interrupted: bool,
    /// Addresses of the numbers whose value or interval the rest of the run would still have changed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub affected: Vec<String>,
    /// Iterations.
    pub iterations: usize,
    /// Equilibria asked of the solver: sweeps times cases.
    pub solver_runs: usize,
    /// What was left of the forces on a part at worst when they were summed anew; `None` if another solver ran.
    pub balance: Option<Balance>,
    /// SHA-256 over every input file.
    pub inputs_sha256: String,
    /// One per unknown.
    pub parameters: Vec<ParameterFit>,
    /// One per bushing, where offsets were estimated.
    pub assembly_offsets: Vec<OffsetFit>,
    /// What the data do not tell apart.
    pub unidentifiable_directions: Vec<UnidentifiableDirection>,
    /// Sizes of tolerances the intervals allow for, by group; empty where the method knows none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub tolerances: BTreeMap<String, ToleranceFound>,
    /// The noise of the marks, as stated and as they show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseFound>,
    /// Whether what is left of the readings is no more than their noise; `None` for readings without any.
    pub fit_test: Option<FitTest>,
    /// Tests of structure in what is left.
    pub structure: Vec<LackOfFitTest>,
    /// How the marks are explained, with all that was fitted beside the numbers: offsets, errors of frame and marks.
    pub marks: Option<Marks>,
    /// How the marks are explained by the deck as it is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub written: Option<Written>,
    /// What no fit saw.
    pub held_out: HeldOut,
    /// How the wheel is explained.
    pub wheel: Option<WheelFit>,
    /// How the fits of readings drawn anew were made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<BootstrapMade>,
    /// How the draws from the posterior were made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorMade>,
    /// Values of the unknowns after every iteration, the initial ones first. For the report only.
    #[serde(skip)]
    pub history: Vec<Vec<f64>>,
    /// What a person should know about this result, one sentence each. For report and console.
    #[serde(skip)]
    pub remarks: Vec<String>,
}

impl Fit {
    /// The values of the unknowns.
    pub fn values(&self) -> Vec<f64> {
        self.parameters
            .iter()
            .map(|parameter| parameter.value)
            .collect()
    }

    /// Marks a fit that was ended before its values had settled.
    pub(super) fn cut_short(&mut self) {
        self.interrupted = true;
        self.affected = self.parameters.iter().map(|p| p.address.clone()).collect();
    }

    /// `identification.json`.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self);
        text.expect("a fit holds only names and numbers") + "\n"
    }
}
