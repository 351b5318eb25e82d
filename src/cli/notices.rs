//! What lower floors log while a command runs, such as that it waits for a licence: a line each on standard error.

use std::io::IsTerminal as _;

/// Goes to the start of the line and clears it: progress may stand there.
const CLEAR: &str = "\r\x1b[2K";

struct Lines;

impl log::Log for Lines {
    fn enabled(&self, about: &log::Metadata<'_>) -> bool {
        about.target().starts_with(env!("CARGO_CRATE_NAME"))
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            let clear = if std::io::stderr().is_terminal() {
                CLEAR
            } else {
                ""
            };
            eprintln!("{clear}{}", record.args());
        }
    }

    fn flush(&self) {}
}

/// Shows warnings from here on.
pub(super) fn show() {
    // A second call finds the first in its place.
    if log::set_logger(&Lines).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}
