use admire_solver::statics::SolveError;
use admire_syntax::diagnostic::Diagnostic;

/// Reason why the rig gives no result.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BenchError {
    /// The deck cannot be put on the rig.
    #[error("the deck cannot be put on the rig")]
    Deck(Vec<Diagnostic>),
    /// The equilibrium was not found.
    #[error("{at}: {why}")]
    NoEquilibrium {
        /// Test and point, in words.
        at: String,
        /// Cause reported by the solver.
        why: Box<SolveError>,
    },
    /// No common height of both wheels gives the axle its load.
    #[error("{at}: no common height of both wheels gives the axle load")]
    NoAxleLoad {
        /// Test and point, in words.
        at: String,
    },
    /// A wheel has a zero-stiffness motion, so its compliance is undefined.
    #[error("{at}: the compliance is not defined: {motion}")]
    Free {
        /// Test and point, in words.
        at: String,
        /// Zero-stiffness motion, in words.
        motion: String,
    },
}
