//! What a run tells of itself while it goes on, and how it is asked to stop.

use super::ending::Stop;
use super::run::Session;
use crate::diagnostic::{Code, Diagnostic};

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

impl<'a> Session<'a> {
    /// Tells of every output of a simulation over time. When the answer is false the run ends there, its files whole up to that output.
    #[must_use]
    pub fn watched(mut self, watcher: impl FnMut(Moment) -> bool + 'a) -> Self {
        self.watcher = Some(Box::new(watcher));
        self
    }

    /// Tells of an output.
    ///
    /// # Errors
    /// [`Stop::Interrupted`] if the run is to stop.
    pub(super) fn tell(&mut self, moment: Moment) -> Result<(), Stop> {
        let goes_on = self.watcher.as_mut().is_none_or(|watcher| watcher(moment));
        if goes_on {
            return Ok(());
        }
        self.complain(&Diagnostic::warning(
            Code::NoMotion,
            format!(
                "the run was interrupted at time {}; the files hold everything up to there",
                moment.time
            ),
        ));
        Err(Stop::Interrupted)
    }
}
