//! What a run tells of itself while it goes on, and how it is asked to stop.

use super::ending::Stop;
use super::moment::Moment;
use super::run_state::Session;
use admire_syntax::diagnostic::{Code, Diagnostic};

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
