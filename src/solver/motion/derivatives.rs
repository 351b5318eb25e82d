//! Which derivatives the iteration of a step uses.

use super::sequence::RATE;

/// Which derivatives the iteration of a step uses: each kind settles where the one before does not, and costs more.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Derivatives {
    /// Those of one stage, kept while they serve.
    Single,
    /// Those of every stage, one stage after the other, kept while they serve.
    Sequence,
    /// Those of every stage, all together, kept while they serve.
    Kept,
    /// The same, made anew for each iteration.
    Renewed,
}

impl Derivatives {
    /// After those of one stage.
    pub(crate) const BETTER: [Self; 3] = [Self::Sequence, Self::Kept, Self::Renewed];

    /// What may be left falls by no more than this in an iteration, however fast the rest went.
    pub(crate) fn slowest(self) -> f64 {
        match self {
            Self::Sequence => RATE,
            Self::Single | Self::Kept | Self::Renewed => 0.0,
        }
    }
}
