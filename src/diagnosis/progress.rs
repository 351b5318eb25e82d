use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// How often all load cases may be solved in one search. It is looked at between rounds only, so that what is found does not depend
/// on the machine.
pub(super) const SWEEPS: usize = 3000;

/// How far a diagnosis is, for whoever watches it from another thread.
#[derive(Clone, Debug)]
pub struct Progress {
    sweeps: Arc<AtomicUsize>,
    budget: Arc<AtomicUsize>,
    stage: Arc<Mutex<&'static str>>,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            sweeps: Arc::default(),
            budget: Arc::new(AtomicUsize::new(SWEEPS)),
            stage: Arc::default(),
        }
    }
}

impl Progress {
    /// How often all load cases were solved.
    pub fn sweeps(&self) -> usize {
        self.sweeps.load(Ordering::Relaxed)
    }

    /// How often they may be solved at most, searches up to the present one together.
    pub fn budget(&self) -> usize {
        self.budget.load(Ordering::Relaxed)
    }

    /// What is being done.
    pub fn stage(&self) -> &'static str {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends every fit after its present step, and with them the search: its budget counts as spent, and so does that of any further one.
    pub fn stop(&self) {
        self.budget.store(0, Ordering::Relaxed);
    }

    /// True once it was stopped.
    pub fn is_stopped(&self) -> bool {
        self.budget() == 0
    }

    /// The next stage begins.
    pub fn begin(&self, stage: &'static str) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
    }

    /// Takes note of a fit that solved all cases so often.
    pub(super) fn spend(&self, sweeps: usize) {
        self.sweeps.fetch_add(sweeps, Ordering::Relaxed);
    }

    /// True if no further round begins.
    pub(super) fn is_spent(&self) -> bool {
        self.sweeps() >= self.budget()
    }

    /// Grants a search what another one may have spent; not where it was asked to end.
    pub(super) fn renew(&self) {
        let further = self.sweeps() + SWEEPS;
        let grant = |budget: usize| (budget > 0).then_some(further);
        let order = Ordering::Relaxed;
        let _ = self.budget.fetch_update(order, order, grant);
    }

    /// Grants another search; false where the first was asked to end or has spent its own.
    pub(super) fn extend(&self) -> bool {
        let further = self.sweeps() + SWEEPS;
        let grant = |budget: usize| (budget > self.sweeps()).then_some(further);
        let order = Ordering::Relaxed;
        self.budget.fetch_update(order, order, grant).is_ok()
    }
}
