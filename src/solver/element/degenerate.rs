//! Why a law has no value. Knows no names: the caller says which element.

/// A motion at which a law has no value. ADAMS stops there too; a line search may step back instead.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Degenerate {
    /// The origins of I and J coincide, so that the direction of their line is undefined.
    #[error("the I and J origins coincide: the line between them has no direction")]
    ZeroLengthLine,
    /// Both arguments of the arctangent of a projected angle vanish. The axis of J: 0, 1, 2 for AX, AY, AZ.
    #[error("the projected angle A{} of I about J is undefined at 90 degrees of another angle", ["X", "Y", "Z"][*axis])]
    UndefinedAngle {
        /// Axis of J.
        axis: usize,
    },
}
