use crate::model::EquilibriumSettings;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Upper limit of MAXIT, so that a typing error does not hang the machine.
pub(crate) const MOST_ITERATIONS: usize = 20_000;

/// Settings of the EQUILIBRIUM statement, and settings of the solver methods that ADAMS does not have.
#[derive(Clone, PartialEq, Debug)]
pub struct StaticSettings {
    /// ERROR: largest relative correction allowed in the last iteration.
    pub error: f64,
    /// IMBALANCE: largest residual allowed in any equation, in the unit of the equation.
    pub imbalance: f64,
    /// TLIMIT: largest translation of a part per iteration, in length units.
    pub tlimit: f64,
    /// ALIMIT: largest rotation of a part per iteration, in radians.
    pub alimit: f64,
    /// MAXIT: largest number of iterations per sequence of iterations, at most [`MOST_ITERATIONS`].
    pub maxit: usize,
    /// Largest total number of iterations, including the iterations of continuation. It is MAXIT if the model states MAXIT, otherwise unlimited
    /// (`None`).
    pub budget: Option<usize>,
    /// PATTERN: entry k tells whether iteration k computes a new Jacobian. The pattern is repeated cyclically.
    pub pattern: Vec<bool>,
    /// STABILITY: factor with which the mass matrix is added to the Jacobian. Values up to ADAMS' default of 1e-5 have no effect. Their only
    /// purpose is to hold free motions of parts with mass, and the solver holds these motions exactly instead.
    pub stability: f64,
    /// Whether continuation methods may be tried if plain iteration fails.
    pub continuation: bool,
}

impl From<&EquilibriumSettings> for StaticSettings {
    fn from(e: &EquilibriumSettings) -> Self {
        Self {
            error: e.error,
            imbalance: e.imbalance,
            tlimit: e.tlimit,
            alimit: e.alimit,
            maxit: e.maxit.min(MOST_ITERATIONS),
            budget: e.maxit_stated.then_some(e.maxit.min(MOST_ITERATIONS)),
            pattern: e.pattern.clone(),
            stability: e.stability,
            continuation: true,
        }
    }
}

impl Default for StaticSettings {
    fn default() -> Self {
        Self::from(&EquilibriumSettings::default())
    }
}

impl StaticSettings {
    /// Returns settings with the tightest tolerances that double precision allows for models in millimetres and newtons.
    pub fn tight() -> Self {
        Self {
            error: 1e-10,
            imbalance: 1e-8,
            maxit: 50,
            ..Self::default()
        }
    }

    /// Returns a warning if MAXIT exceeds [`MOST_ITERATIONS`].
    pub fn limited(e: &EquilibriumSettings) -> Option<Diagnostic> {
        (e.maxit > MOST_ITERATIONS).then(|| {
            let message = format!("MAXIT = {} is reduced to {MOST_ITERATIONS}", e.maxit);
            Diagnostic::warning(Code::LimitExceeded, message)
        })
    }

    pub(super) fn new_jacobian(&self, iteration: usize) -> bool {
        let n = self.pattern.len();
        n == 0 || self.pattern[iteration % n]
    }
}
