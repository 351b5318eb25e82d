use admire_syntax::grammar::STATEMENTS;

/// Which static method EQUILIBRIUM asks for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[allow(missing_docs)] // The names are the manual's.
pub enum StaticMethod {
    #[default]
    Original,
    Advanced,
    Aggressive,
    All,
}

/// EQUILIBRIUM, with the manual's defaults (guide/formats.md 2.15).
#[derive(Clone, PartialEq, Debug)]
pub struct EquilibriumSettings {
    /// ALIMIT: largest angle step of one iteration, radians.
    pub alimit: f64,
    /// TLIMIT: largest translation step of one iteration, length units.
    pub tlimit: f64,
    /// ERROR: relative correction.
    pub error: f64,
    /// IMBALANCE: force units.
    pub imbalance: f64,
    /// MAXIT.
    pub maxit: usize,
    /// MAXIT is written somewhere: no more iterations are done, of whatever kind.
    pub maxit_stated: bool,
    /// PATTERN: whether iteration k evaluates a new Jacobian, repeated cyclically.
    pub pattern: Vec<bool>,
    /// STABILITY.
    pub stability: f64,
    /// Method.
    pub method: StaticMethod,
}

impl Default for EquilibriumSettings {
    fn default() -> Self {
        let default = |name: &str| {
            let def = STATEMENTS.iter().find(|def| def.name == "EQUILIBRIUM");
            def.and_then(|def| def.arguments.iter().find(|argument| argument.name == name))
                .and_then(|argument| argument.default.first().copied())
                .expect("the grammar states the defaults of EQUILIBRIUM")
        };
        Self {
            alimit: default("ALIMIT"),
            tlimit: default("TLIMIT"),
            error: default("ERROR"),
            imbalance: default("IMBALANCE"),
            maxit: default("MAXIT") as usize,
            maxit_stated: false,
            pattern: vec![true; 10],
            stability: default("STABILITY"),
            method: StaticMethod::Original,
        }
    }
}

/// INTEGRATOR. What is not given follows from the simulation.
#[derive(Clone, PartialEq, Debug)]
pub struct IntegratorSettings {
    /// The method the deck asks for: `GSTIFF`, `HHT`, ...
    pub method: &'static str,
    /// `I3`, `SI2` or `SI1`.
    pub formulation: &'static str,
    /// `ORIGINAL`, `MODIFIED` or `ORIG_CONSTANT`.
    pub corrector: &'static str,
    /// ERROR.
    pub error: Option<f64>,
    /// HINIT.
    pub hinit: Option<f64>,
    /// HMAX.
    pub hmax: Option<f64>,
    /// HMIN.
    pub hmin: Option<f64>,
    /// MAXIT.
    pub maxit: Option<usize>,
    /// ADAPTIVITY.
    pub adaptivity: f64,
    /// INTERPOLATE=ON.
    pub interpolate: bool,
    /// What is given and has no effect on the built-in method: KMAX, PATTERN, ...
    pub without_effect: Vec<&'static str>,
}

impl IntegratorSettings {
    /// ERROR: 1e-3 unless given, of HHT and NEWMARK 1e-5.
    pub fn error(&self) -> f64 {
        self.error.unwrap_or(match self.method {
            "HHT" | "NEWMARK" => 1e-5,
            _ => 1e-3,
        })
    }
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self {
            method: "GSTIFF",
            formulation: "I3",
            corrector: "ORIGINAL",
            error: None,
            hinit: None,
            hmax: None,
            hmin: None,
            maxit: None,
            adaptivity: 0.0,
            interpolate: false,
            without_effect: Vec::new(),
        }
    }
}

/// KINEMATICS.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct KinematicsSettings {
    /// HMAX.
    pub hmax: Option<f64>,
    /// What is given and has no effect: constraints are met to round-off, whatever the errors and iterations asked for.
    pub without_effect: Vec<&'static str>,
}

/// OUTPUT.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct OutputSettings {
    /// REQSAVE: write the .req file.
    pub reqsave: bool,
    /// GRSAVE: write the .gra file.
    pub grsave: bool,
    /// NOPRINT: no request tables in the .out file.
    pub noprint: bool,
    /// NOSEPARATOR: the tables of consecutive simulations are not separated.
    pub noseparator: bool,
    /// YPR: displacement requests give YAW, PITCH, ROLL instead of PSI, THETA, PHI.
    pub ypr: bool,
    /// FIXED: the tables hold numbers with a fixed point.
    pub fixed: bool,
    /// TELETYPE: the tables are at most 72 columns wide.
    pub teletype: bool,
    /// DZERO, VZERO, AZERO, FZERO: what is smaller is written as zero in requests and tables.
    pub zero: [f64; 4],
}

/// RESULTS.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ResultsSettings {
    /// True if the dataset has a RESULTS statement: without one there is no .res file.
    pub present: bool,
    /// XRF.
    pub xrf: bool,
    /// FORMATTED.
    pub formatted: bool,
    /// COMMENT.
    pub comment: String,
    /// DECIMALPLACES.
    pub decimal_places: usize,
    /// NODISPLACEMENTS.
    pub no_displacements: bool,
    /// NOVELOCITIES.
    pub no_velocities: bool,
    /// NOACCELERATIONS.
    pub no_accelerations: bool,
    /// NOREACTIONFORCES.
    pub no_reaction_forces: bool,
    /// NOAPPLIEDFORCES.
    pub no_applied_forces: bool,
    /// NOSYSTEMELEMENTS.
    pub no_system_elements: bool,
    /// NOREQUESTS.
    pub no_requests: bool,
    /// NOFLOATINGMARKERS.
    pub no_floating_markers: bool,
}

impl Default for ResultsSettings {
    fn default() -> Self {
        Self {
            present: false,
            xrf: false,
            formatted: false,
            comment: String::new(),
            decimal_places: 17,
            no_displacements: false,
            no_velocities: false,
            no_accelerations: false,
            no_reaction_forces: false,
            no_applied_forces: false,
            no_system_elements: false,
            no_requests: false,
            no_floating_markers: false,
        }
    }
}
