//! Log messages of lower layers during a command, such as waiting for a licence: one line each on standard error.

use std::io::IsTerminal as _;

/// Moves to the start of the line and clears it, because it may show progress.
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

/// Enables the display of warnings.
pub(super) fn show() {
    // A second call changes nothing.
    if log::set_logger(&Lines).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}
