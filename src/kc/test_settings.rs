use serde::Deserialize;

/// Quantity held while the test's variable changes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hold {
    /// Height of the wheel centre.
    Height,
    /// Vertical load of each wheel; in a roll test, the sum over both wheels.
    Load,
}

impl Hold {
    /// Returns `height` or `load`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Height => "height",
            Self::Load => "load",
        }
    }
}

/// Point where loads act.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoadPoint {
    /// Wheel centre.
    Centre,
    /// Contact point with the road.
    Patch,
}

impl LoadPoint {
    /// Returns `centre` or `patch`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Patch => "patch",
        }
    }
}

/// Directions in which the variable of a test is driven.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Branches {
    /// From the lowest value to the highest.
    Up,
    /// From the lowest value to the highest and back.
    #[default]
    Both,
}

/// Settings of one test.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TestSettings {
    /// Lowest and highest value of the test's variable.
    pub range: [f64; 2],
    /// Number of points from the lowest to the highest value.
    pub points: usize,
    /// Half the width of the window around ride height in which gradients are fitted.
    pub window: f64,
    /// Point where loads act.
    pub point: LoadPoint,
    /// Quantity held during the test.
    pub hold: Hold,
    /// True if the steering is locked, false if it is free.
    pub steering_locked: bool,
}
