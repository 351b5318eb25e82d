//! Progress of a running simulation.

/// Progress of a simulation at one of its output times.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Moment {
    /// Output time whose values were just written.
    pub time: f64,
    /// Time at which the simulation started.
    pub start: f64,
    /// Time at which the simulation will end.
    pub end: f64,
    /// Current size of the integration step; if nothing is integrated, the time between outputs.
    pub step: f64,
}

impl Moment {
    /// Returns the completed fraction of the simulation, from 0 to 1.
    pub fn share(&self) -> f64 {
        let span = self.end - self.start;
        if span > 0.0 {
            ((self.time - self.start) / span).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }
}

/// Callback that is called at every output. If it returns false, the run stops there.
pub(super) type Watcher<'a> = Box<dyn FnMut(Moment) -> bool + 'a>;
