//! Progress reports of a running session, and its interruption by a callback.

use super::ending::Stop;
use super::moment::Moment;
use super::run_state::Session;
use admire_syntax::diagnostic::{Code, Diagnostic};

impl<'a> Session<'a> {
    /// Sets a callback that is called at every output of a simulation over time. If it returns false, the run ends there, and the files
    /// contain everything up to that output.
    #[must_use]
    pub fn watched(mut self, watcher: impl FnMut(Moment) -> bool + 'a) -> Self {
        self.watcher = Some(Box::new(watcher));
        self
    }

    /// Reports an output to the callback that watches the run.
    ///
    /// # Errors
    /// Returns [`Stop::Interrupted`] if the callback stops the run.
    pub(super) fn tell(&mut self, moment: Moment) -> Result<(), Stop> {
        let goes_on = self.watcher.as_mut().is_none_or(|watcher| watcher(moment));
        if goes_on {
            return Ok(());
        }
        self.complain(&Diagnostic::warning(
            Code::NoMotion,
            format!(
                "the run was interrupted at time {}; the files contain all output up to this time",
                moment.time
            ),
        ));
        Err(Stop::Interrupted)
    }
}
