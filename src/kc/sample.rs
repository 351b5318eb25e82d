use super::bench::Observation;
use super::inputs::Inputs;
use super::reading::Reading;

/// Which way a test went when it came by.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Branch {
    /// Towards the highest value.
    Up,
    /// Back.
    Down,
}

impl Branch {
    /// `up` or `down`.
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
    /// Which way.
    pub branch: Branch,
    /// Value of the test's own variable.
    pub value: f64,
    /// What the rig did.
    pub inputs: Inputs,
    /// What was seen.
    pub seen: Observation,
    /// All characteristics, the loads of the rig first.
    pub readings: Vec<Reading>,
}
