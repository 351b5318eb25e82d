//! The pager of the user, for long texts on a terminal.

use std::io::{IsTerminal, Write};
use std::process::{Command, Stdio};

/// Shows a text with the program that `PAGER` names, or with `less`. On Windows, only `PAGER` counts. Returns false if standard output is no
/// terminal or no pager starts; the text is then not shown.
pub(super) fn shows(text: &str) -> bool {
    if !std::io::stdout().is_terminal() {
        return false;
    }
    let named = std::env::var("PAGER").unwrap_or_default();
    let mut words = named.split_whitespace();
    let program = match words.next() {
        Some(program) => program,
        None if cfg!(windows) => return false,
        None => "less",
    };
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::piped());
    if std::env::var_os("LESS").is_none() {
        // A text of one screen is printed; a longer one stays on the screen at the end.
        command.env("LESS", "FRX");
    }
    let Ok(mut pager) = command.spawn() else {
        return false;
    };
    // Ctrl-C is for the pager. Without a handler it would end this process, and the pager would lose its terminal.
    let _ = ctrlc::set_handler(|| {});
    if let Some(mut input) = pager.stdin.take() {
        // The reader may leave before the end of the text.
        let _ = input.write_all(text.as_bytes());
    }
    pager.wait().is_ok()
}
