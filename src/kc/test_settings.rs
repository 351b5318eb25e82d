use serde::Deserialize;

/// What is held while a load grows.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hold {
    /// The height of the wheel centre.
    Height,
    /// The vertical load; of a roll the sum of both wheels.
    Load,
}

impl Hold {
    /// `height` or `load`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Height => "height",
            Self::Load => "load",
        }
    }
}

/// Where loads act.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoadPoint {
    /// The wheel centre.
    Centre,
    /// The contact point with the road.
    Patch,
}

impl LoadPoint {
    /// `centre` or `patch`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Patch => "patch",
        }
    }
}

/// Which ways a test is driven.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Branches {
    /// From the lowest value to the highest.
    Up,
    /// Up, and down again.
    #[default]
    Both,
}

/// Settings of one test.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TestSettings {
    /// Lowest and highest value of what is driven.
    pub range: [f64; 2],
    /// Points from the lowest to the highest.
    pub points: usize,
    /// Half the width of the window that gradients are fitted in.
    pub window: f64,
    /// Where loads act.
    pub point: LoadPoint,
    /// What is held.
    pub hold: Hold,
    /// False if the steering is free.
    pub steering_locked: bool,
}
