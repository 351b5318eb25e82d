use super::bench::Observation;
use super::inputs::Inputs;
use super::reading::Reading;

/// Direction in which the test's variable was driven to a sample.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Branch {
    /// Upward, to the highest value.
    Up,
    /// Downward, back to the lowest value.
    Down,
}

impl Branch {
    /// Returns `up` or `down`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Down => "down",
        }
    }
}

/// One solved point of a test.
#[derive(Clone, PartialEq, Debug)]
pub struct Sample {
    /// Direction in which the variable was driven.
    pub branch: Branch,
    /// Value of the test's variable.
    pub value: f64,
    /// Inputs that the rig imposes on the axle.
    pub inputs: Inputs,
    /// Solved state of the axle.
    pub seen: Observation,
    /// All characteristics, preceded by the loads of the rig.
    pub readings: Vec<Reading>,
}
