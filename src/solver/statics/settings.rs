use crate::model::EquilibriumSettings;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Upper limit of MAXIT, so that a typing error does not hang the machine.
pub(crate) const MOST_ITERATIONS: usize = 20_000;

/// Settings of the EQUILIBRIUM statement, and of the built-in solver's extensions of ADAMS' plain iteration.
#[derive(Clone, PartialEq, Debug)]
pub struct StaticSettings {
    /// ERROR: largest relative correction of the last iteration.
    pub error: f64,
    /// IMBALANCE: largest residual allowed in any equation, in its own unit.
    pub imbalance: f64,
    /// TLIMIT: largest translation per iteration, length units.
    pub tlimit: f64,
    /// ALIMIT: largest rotation per iteration, radians.
    pub alimit: f64,
    /// MAXIT: largest number of iterations per sequence, at most [`MOST_ITERATIONS`].
    pub maxit: usize,
    /// Largest total number of iterations, including those of continuation: MAXIT if the model states it, otherwise unlimited.
    pub budget: Option<usize>,
    /// PATTERN: whether iteration k computes a new Jacobian; repeated cyclically.
    pub pattern: Vec<bool>,
    /// STABILITY: this number times mass is added to the Jacobian. Values up to ADAMS' default of 1e-5 have no effect: their only use is to
    /// hold massive free motions, which are held exactly instead.
    pub stability: f64,
    /// Whether continuation may be tried if plain iteration fails.
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
    /// As tight as double precision allows for models in millimetres and newtons.
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
            let message = format!("MAXIT = {} is taken as {MOST_ITERATIONS}", e.maxit);
            Diagnostic::warning(Code::LimitExceeded, message)
        })
    }

    pub(super) fn new_jacobian(&self, iteration: usize) -> bool {
        let n = self.pattern.len();
        n == 0 || self.pattern[iteration % n]
    }
}
