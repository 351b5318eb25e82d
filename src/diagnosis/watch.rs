use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Is told how far a long computation is, and may end it.
pub trait ProgressObserver {
    /// The next stage begins.
    fn stage(&self, stage: &str);
    /// A remark on the stage.
    fn detail(&self, detail: String);
    /// So many are done, of how many at most, and of what.
    fn count(&self, done: usize, most: Option<usize>, what: &'static str);
    /// False to end the computation after its present step.
    fn goes_on(&self) -> bool;
    /// A diagnosis begins, which counts by itself.
    #[doc(hidden)]
    fn diagnoses(&self, _progress: &crate::Progress) {}
}

/// Where a computation stands.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct ProgressSnapshot {
    /// What is being done.
    pub stage: String,
    /// A remark on it.
    pub detail: String,
    /// How much of it is done.
    pub done: usize,
    /// Of how much at most, where that is known.
    pub most: Option<usize>,
}

/// A [`ProgressObserver`] that several threads share: one computes, another looks and may stop it.
#[derive(Clone, Debug, Default)]
pub struct SharedProgress(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    stopped: AtomicBool,
    stand: Mutex<ProgressSnapshot>,
    diagnosis: Mutex<Option<crate::Progress>>,
}

impl SharedProgress {
    /// Where the computation stands.
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

    /// Asks the computation to end after its present step.
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
