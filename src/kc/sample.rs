use super::bench::Observation;
use super::inputs::Inputs;
use super::reading::Reading;

/// Driving direction of a test at a sample.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Branch {
    /// Towards the highest value.
    Up,
    /// Back towards the lowest value.
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

/// One point of a test.
#[derive(Clone, PartialEq, Debug)]
pub struct Sample {
    /// Driving direction.
    pub branch: Branch,
    /// Value of the test's variable.
    pub value: f64,
    /// Inputs of the rig.
    pub inputs: Inputs,
    /// Solved state of the axle.
    pub seen: Observation,
    /// All characteristics, the loads of the rig first.
    pub readings: Vec<Reading>,
}
