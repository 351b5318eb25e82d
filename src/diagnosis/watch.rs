use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Observer of a long computation, which may also stop it.
pub trait ProgressObserver {
    /// Reports the start of a stage.
    fn stage(&self, stage: &str);
    /// Reports a detail of the current stage.
    fn detail(&self, detail: String);
    /// Reports the number of completed units, the maximum number if known, and the name of the unit.
    fn count(&self, done: usize, most: Option<usize>, what: &'static str);
    /// Returns true to continue the computation, false to end it after its current step.
    fn goes_on(&self) -> bool;
    /// Reports the start of a diagnosis. The diagnosis counts its progress in its own `Progress`.
    #[doc(hidden)]
    fn diagnoses(&self, _progress: &crate::Progress) {}
}

/// State of a computation at one moment.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct ProgressSnapshot {
    /// Name of the current stage.
    pub stage: String,
    /// Detail of the current stage.
    pub detail: String,
    /// Number of completed units.
    pub done: usize,
    /// Maximum number of units, if known.
    pub most: Option<usize>,
}

/// [`ProgressObserver`] shared between threads. One thread computes; another reads the progress and may stop the computation.
#[derive(Clone, Debug, Default)]
pub struct SharedProgress(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    stopped: AtomicBool,
    stand: Mutex<ProgressSnapshot>,
    diagnosis: Mutex<Option<crate::Progress>>,
}

impl SharedProgress {
    /// Returns the current state of the computation.
    pub fn stand(&self) -> ProgressSnapshot {
        let diagnosis = self
            .0
            .diagnosis
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(progress) = &*diagnosis {
            return ProgressSnapshot {
                stage: progress.stage().to_string(),
                detail: String::new(),
                done: progress.sweeps(),
                most: None,
            };
        }
        self.change(|stand| stand.clone())
    }

    /// Requests the computation to end after its current step.
    pub fn stop(&self) {
        self.0.stopped.store(true, Ordering::Relaxed);
        let diagnosis = self
            .0
            .diagnosis
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(progress) = &*diagnosis {
            progress.stop();
        }
    }

    fn change<T>(&self, change: impl FnOnce(&mut ProgressSnapshot) -> T) -> T {
        change(&mut self.0.stand.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl ProgressObserver for SharedProgress {
    fn stage(&self, stage: &str) {
        self.change(|stand| {
            *stand = ProgressSnapshot {
                stage: stage.to_string(),
                ..ProgressSnapshot::default()
            };
        });
    }

    fn detail(&self, detail: String) {
        self.change(|stand| stand.detail = detail);
    }

    fn count(&self, done: usize, most: Option<usize>, _: &'static str) {
        self.change(|stand| (stand.done, stand.most) = (done, most));
    }

    fn goes_on(&self) -> bool {
        !self.0.stopped.load(Ordering::Relaxed)
    }

    fn diagnoses(&self, progress: &crate::Progress) {
        *self
            .0
            .diagnosis
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = Some(progress.clone());
    }
}
