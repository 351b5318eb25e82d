//! Kinds of derivatives for the Newton iteration of a step.

use super::sequence::RATE;

/// Derivatives used by the Newton iteration of a step. Each kind converges where the kinds before it fail, and costs more.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Derivatives {
    /// Derivatives of one stage, used for all stages and kept as long as the iteration converges fast.
    Single,
    /// Derivatives of every stage, solved one stage after the other.
    Sequence,
    /// Derivatives of every stage, solved for all stages together, and reassembled when convergence becomes slow.
    Kept,
    /// Derivatives of every stage, solved for all stages together, and reassembled in each iteration.
    Renewed,
}

impl Derivatives {
    /// Kinds to try, in this order, after [`Self::Single`] has failed.
    pub(crate) const BETTER: [Self; 3] = [Self::Sequence, Self::Kept, Self::Renewed];

    /// Returns the theoretical convergence rate of the slowest error components: the error ratio from one iteration to the next. Returns zero where
    /// theory gives no such rate. Error estimates use the larger one of this rate and the observed rate.
    pub(crate) fn slowest(self) -> f64 {
        match self {
            Self::Sequence => RATE,
            Self::Single | Self::Kept | Self::Renewed => 0.0,
        }
    }
}
