//! Reasons why a force law is undefined at a motion. The caller adds the element name.

/// Motion at which a force law is undefined. ADAMS stops there too; a line search can instead reduce its step.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Degenerate {
    /// The origins of I and J coincide, so the direction of the line between them is undefined.
    #[error("the I and J origins coincide: the line between them has no direction")]
    ZeroLengthLine,
    /// Both arguments of the arctangent of a projected angle vanish.
    #[error("the projected angle A{} of I about J is undefined at 90 degrees of another angle", ["X", "Y", "Z"][*axis])]
    UndefinedAngle {
        /// Axis of J: 0, 1 or 2 for AX, AY or AZ.
        axis: usize,
    },
}
