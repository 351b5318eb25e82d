use std::sync::atomic::{AtomicUsize, Ordering};

/// How often all load cases may be solved in one search. It is looked at between rounds only, so that what is found does not depend
/// on the machine.
const SWEEPS: usize = 6000;

/// What a whole search has cost.
#[derive(Debug, Default)]
pub struct Budget {
    sweeps: AtomicUsize,
}

impl Budget {
    /// Takes note of a fit that solved all cases so often.
    pub fn spend(&self, sweeps: usize) {
        self.sweeps.fetch_add(sweeps, Ordering::Relaxed);
    }

    /// Sweeps so far.
    pub fn sweeps(&self) -> usize {
        self.sweeps.load(Ordering::Relaxed)
    }

    /// True if no further round begins.
    pub fn is_spent(&self) -> bool {
        self.sweeps() >= SWEEPS
    }
}

/// How much a fit may cost.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Effort {
    /// Steps tried at most.
    pub steps: usize,
    /// A step that gains less than this part of chi-square was the last one.
    pub relative: f64,
    /// An objective that is known to be reached otherwise: a fit that stays far above it and no longer comes down fast is given up.
    pub reached: f64,
}

impl Effort {
    /// For a model that is to be kept.
    pub const FULL: Self = Self {
        steps: 30,
        relative: 1e-7,
        reached: f64::INFINITY,
    };

    /// For one of many candidates, of which most are dropped.
    pub const fn candidate(reached: f64) -> Self {
        Self {
            steps: 14,
            relative: 1e-4,
            reached,
        }
    }

    /// Whether a fit that has come down from one objective to another may stop.
    pub(super) fn is_enough(self, step: usize, (before, after): (f64, f64)) -> bool {
        let gained = before - after;
        let hopeless = after > 2.0 * self.reached + 100.0 && gained < 0.3 * (after - self.reached);
        gained < self.relative * after || (step >= 4 && hopeless)
    }
}
