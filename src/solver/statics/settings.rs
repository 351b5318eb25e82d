use crate::model::EquilibriumSettings;
use admire_syntax::diagnostic::{Code, Diagnostic};

/// MAXIT beyond this is as good as never: a typing error may not hang the machine.
pub(crate) const MOST_ITERATIONS: usize = 20_000;

/// EQUILIBRIUM's own words, and what the built-in solver may do beyond ADAMS' plain iteration.
#[derive(Clone, PartialEq, Debug)]
pub struct StaticSettings {
    /// ERROR: largest relative correction of the last iteration.
    pub error: f64,
    /// IMBALANCE: largest residual of any equation, in its own unit.
    pub imbalance: f64,
    /// TLIMIT: largest translation of one iteration, length units.
    pub tlimit: f64,
    /// ALIMIT: largest rotation of one iteration, radians.
    pub alimit: f64,
    /// MAXIT, at most [`MOST_ITERATIONS`].
    pub maxit: usize,
    /// Iterations in all, those of continuation among them: MAXIT where the model states it.
    pub budget: Option<usize>,
    /// PATTERN: whether iteration k works out a new Jacobian; repeated cyclically.
    pub pattern: Vec<bool>,
    /// STABILITY times mass is added to the Jacobian. Up to ADAMS' default of 1e-5 its only use is to hold massive free motions,
    /// which are held exactly instead.
    pub stability: f64,
    /// Whether continuation may be tried where plain iteration fails.
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

    /// Says that MAXIT is beyond what is done.
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
