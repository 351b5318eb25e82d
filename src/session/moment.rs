//! What a run tells of itself while it goes on.

/// Where a simulation stands.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Moment {
    /// The time of the output that was just written.
    pub time: f64,
    /// Where the simulation began.
    pub start: f64,
    /// Where it ends.
    pub end: f64,
    /// The step of the integrator; the output step where nothing is integrated.
    pub step: f64,
}

impl Moment {
    /// The share of the simulation that is done, 0 to 1.
    pub fn share(&self) -> f64 {
        let span = self.end - self.start;
        if span > 0.0 {
            ((self.time - self.start) / span).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }
}

/// Told of every output; false asks the run to stop there.
pub(super) type Watcher<'a> = Box<dyn FnMut(Moment) -> bool + 'a>;
