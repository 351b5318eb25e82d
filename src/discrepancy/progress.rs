use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// How far a diagnosis is, for whoever watches it from another thread.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    pub(super) sweeps: Arc<AtomicUsize>,
    stage: Arc<Mutex<&'static str>>,
}

impl Progress {
    /// How often all load cases were solved.
    pub fn sweeps(&self) -> usize {
        self.sweeps.load(Ordering::Relaxed)
    }

    /// What is being done.
    pub fn stage(&self) -> &'static str {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks the search to end after its present step: its budget counts as spent.
    pub fn stop(&self) {
        self.sweeps.fetch_max(super::SWEEPS, Ordering::Relaxed);
    }

    pub(super) fn begin(&self, stage: &'static str) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage;
    }
}
