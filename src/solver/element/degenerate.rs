//! Reasons why a force law is undefined at a relative motion. The caller adds the element name.

/// Reason why a force law is undefined at a relative motion. ADAMS stops at such a motion; here a line search can reduce its step instead.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Degenerate {
    /// The origins of I and J coincide, so the direction of the line between them is undefined.
    #[error("the I and J origins coincide: the line between them has no direction")]
    ZeroLengthLine,
    /// Both arguments of the arctangent of a projected angle vanish, so the angle is undefined.
    #[error("the projected angle A{} of I about J is undefined, because another of the three angles is 90 degrees", ["X", "Y", "Z"][*axis])]
    UndefinedAngle {
        /// Index of the undefined angle: 0, 1 or 2 for AX, AY or AZ, about the x, y or z axis of J.
        axis: usize,
    },
}
