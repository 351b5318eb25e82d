/// Side of the vehicle as seen by the driver.
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Left: y < 0 in this crate's axes.
    Left,
    /// Right: y > 0.
    Right,
}

impl Side {
    /// Both sides: left, then right.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// Returns 0 for left, 1 for right.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Returns the sign of y in the outboard direction: -1 for left, +1 for right.
    pub const fn outboard_sign(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }

    /// Returns the opposite side.
    #[must_use]
    pub(crate) const fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// Returns `left` or `right`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}
