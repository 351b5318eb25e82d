//! Display of log messages from lower layers, such as waiting for a licence, as single lines on standard error.

use std::io::IsTerminal as _;

/// Terminal sequence that moves to the start of the line and clears it, because the line may show progress.
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
    // If a logger is already installed, this call changes nothing.
    if log::set_logger(&Lines).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}
