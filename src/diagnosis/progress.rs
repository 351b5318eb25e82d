use crate::settings::MAX_SWEEPS;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Progress of a diagnosis, readable from another thread.
#[derive(Clone, Debug)]
pub struct Progress {
    sweeps: Arc<AtomicUsize>,
    budget: Arc<AtomicUsize>,
    stage: Arc<Mutex<&'static str>>,
    /// Time at which the diagnosis ends with its results so far; `None` without a time limit.
    deadline: Option<Instant>,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            sweeps: Arc::default(),
            budget: Arc::new(AtomicUsize::new(MAX_SWEEPS)),
            stage: Arc::default(),
            deadline: None,
        }
    }
}

impl Progress {
    /// Sets a time limit for the diagnosis, starting now. After this time, it ends as if the user had stopped it.
    #[must_use]
    pub fn within(self, time: Duration) -> Self {
        Self {
            deadline: Instant::now().checked_add(time),
            ..self
        }
    }

    /// Returns the number of sweeps so far. One sweep solves all load cases once.
    pub fn sweeps(&self) -> usize {
        self.sweeps.load(Ordering::Relaxed)
    }

    /// Returns the maximum number of sweeps, counted over all searches up to the current one.
    pub fn budget(&self) -> usize {
        self.budget.load(Ordering::Relaxed)
    }

    /// Returns the name of the current stage.
    pub fn stage(&self) -> &'static str {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stops the diagnosis: every fit ends after its current step, and the search ends with its fits. The budgets of the current search and
    /// of all further searches then count as spent.
    pub fn stop(&self) {
        self.budget.store(0, Ordering::Relaxed);
    }

    /// Returns true if the user stopped the diagnosis.
    pub fn is_interrupted(&self) -> bool {
        self.budget() == 0
    }

    /// Returns true if the time limit is reached.
    pub fn is_late(&self) -> bool {
        self.deadline
            .is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Returns true if the user stopped the diagnosis, or if its time limit is reached.
    pub fn is_stopped(&self) -> bool {
        self.is_interrupted() || self.is_late()
    }

    /// Starts a stage with this name.
    pub fn begin(&self, stage: &'static str) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
    }

    /// Adds to the number of sweeps.
    pub(super) fn spend(&self, sweeps: usize) {
        self.sweeps.fetch_add(sweeps, Ordering::Relaxed);
    }

    /// Returns true if the budget is spent, so that no further round of a search starts.
    pub(super) fn is_spent(&self) -> bool {
        self.sweeps() >= self.budget() || self.is_late()
    }

    /// Grants a further search a new full budget. Returns false, without a grant, if the previous search was stopped or spent its budget.
    pub(super) fn extend(&self) -> bool {
        if self.is_late() {
            return false;
        }
        let further = self.sweeps() + MAX_SWEEPS;
        let grant = |budget: usize| (budget > self.sweeps()).then_some(further);
        let order = Ordering::Relaxed;
        self.budget.fetch_update(order, order, grant).is_ok()
    }
}
