use admire_syntax::grammar::STATEMENTS;

/// Static solution method of EQUILIBRIUM.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum StaticMethod {
    #[default]
    Original,
    Advanced,
    Aggressive,
    All,
}

/// EQUILIBRIUM settings, with the manual's defaults (guide/formats.md 2.15).
#[derive(Clone, PartialEq, Debug)]
pub struct EquilibriumSettings {
    /// ALIMIT: maximum rotation step of one iteration, radians.
    pub alimit: f64,
    /// TLIMIT: maximum translation step of one iteration, length units.
    pub tlimit: f64,
    /// ERROR: convergence tolerance of the relative correction.
    pub error: f64,
    /// IMBALANCE: convergence tolerance of the force imbalance, force units.
    pub imbalance: f64,
    /// MAXIT: maximum number of iterations.
    pub maxit: usize,
    /// Whether the deck states MAXIT. A stated limit applies to iterations of every kind.
    pub maxit_stated: bool,
    /// PATTERN: for each iteration, whether it evaluates a new Jacobian. The pattern repeats cyclically.
    pub pattern: Vec<bool>,
    /// STABILITY: factor of the mass matrix added to the static Jacobian.
    pub stability: f64,
    /// Static solution method.
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

/// INTEGRATOR settings. The simulation chooses the values that are not given.
#[derive(Clone, PartialEq, Debug)]
pub struct IntegratorSettings {
    /// Integration method that the deck requests: `GSTIFF`, `HHT`, ...
    pub method: &'static str,
    /// Index formulation: `I3`, `SI2` or `SI1`.
    pub formulation: &'static str,
    /// Corrector: `ORIGINAL`, `MODIFIED` or `ORIG_CONSTANT`.
    pub corrector: &'static str,
    /// ERROR: error tolerance of the integration.
    pub error: Option<f64>,
    /// HINIT: initial step size.
    pub hinit: Option<f64>,
    /// HMAX: maximum step size.
    pub hmax: Option<f64>,
    /// HMIN: minimum step size.
    pub hmin: Option<f64>,
    /// MAXIT: maximum number of corrector iterations.
    pub maxit: Option<usize>,
    /// ADAPTIVITY: relaxation of the corrector tolerance at small steps.
    pub adaptivity: f64,
    /// INTERPOLATE=ON: output values are interpolated between integration steps.
    pub interpolate: bool,
    /// Arguments given in the deck that have no effect on the built-in method, such as KMAX and PATTERN.
    pub without_effect: Vec<&'static str>,
}

impl IntegratorSettings {
    /// Returns the error tolerance; the default is 1e-5 for HHT and NEWMARK and 1e-3 otherwise.
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

/// KINEMATICS settings.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct KinematicsSettings {
    /// HMAX: maximum step size.
    pub hmax: Option<f64>,
    /// Arguments given in the deck that have no effect. Error tolerances and iteration limits are among them, because constraints are
    /// always satisfied to round-off.
    pub without_effect: Vec<&'static str>,
}

/// OUTPUT settings.
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
    /// FIXED: the tables use fixed-point numbers.
    pub fixed: bool,
    /// TELETYPE: the tables are at most 72 columns wide.
    pub teletype: bool,
    /// DZERO, VZERO, AZERO, FZERO: thresholds for displacements, velocities, accelerations and forces. Smaller magnitudes are written as
    /// zero in requests and tables.
    pub zero: [f64; 4],
}

/// RESULTS settings.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ResultsSettings {
    /// Whether the dataset has a RESULTS statement; without one no .res file is written.
    pub present: bool,
    /// XRF: write the results file in XML form.
    pub xrf: bool,
    /// FORMATTED: write the results file as text.
    pub formatted: bool,
    /// Comment text, COMMENT.
    pub comment: String,
    /// Number of decimal places, DECIMALPLACES.
    pub decimal_places: usize,
    /// NODISPLACEMENTS: omit the displacements.
    pub no_displacements: bool,
    /// NOVELOCITIES: omit the velocities.
    pub no_velocities: bool,
    /// NOACCELERATIONS: omit the accelerations.
    pub no_accelerations: bool,
    /// NOREACTIONFORCES: omit the reaction forces.
    pub no_reaction_forces: bool,
    /// NOAPPLIEDFORCES: omit the applied forces.
    pub no_applied_forces: bool,
    /// NOSYSTEMELEMENTS: omit the system elements.
    pub no_system_elements: bool,
    /// NOREQUESTS: omit the requests.
    pub no_requests: bool,
    /// NOFLOATINGMARKERS: omit the floating markers.
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
