use admire_solver::statics::SolveError;
use admire_syntax::diagnostic::Diagnostic;

/// Why the rig has no answer.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BenchError {
    /// The deck cannot be used.
    #[error("the deck cannot be put on the rig")]
    Deck(Vec<Diagnostic>),
    /// No equilibrium.
    #[error("{at}: {why}")]
    NoEquilibrium {
        /// Which test and point.
        at: String,
        /// Why.
        why: Box<SolveError>,
    },
    /// No height of the axle bears its load.
    #[error("{at}: no height of both wheels keeps the load of the axle")]
    NoAxleLoad {
        /// Which test and point.
        at: String,
    },
    /// A motion of the wheel that nothing resists.
    #[error("{at}: the compliance is not defined: {motion}")]
    Free {
        /// Which test.
        at: String,
        /// The motion, in words.
        motion: String,
    },
}
