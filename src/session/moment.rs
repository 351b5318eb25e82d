//! Progress of a running simulation.

/// Progress of a simulation at an output.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Moment {
    /// Time of the output just written.
    pub time: f64,
    /// Start time of the simulation.
    pub start: f64,
    /// End time of the simulation.
    pub end: f64,
    /// Current integration step; the output step if nothing is integrated.
    pub step: f64,
}

impl Moment {
    /// Returns the completed fraction of the simulation, 0 to 1.
    pub fn share(&self) -> f64 {
        let span = self.end - self.start;
        if span > 0.0 {
            ((self.time - self.start) / span).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }
}

/// Callback at every output; the result false stops the run there.
pub(super) type Watcher<'a> = Box<dyn FnMut(Moment) -> bool + 'a>;
