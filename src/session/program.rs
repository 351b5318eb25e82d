//! The program file that the user started, for scripts and messages that name it.

use std::io;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Program file that the user started, if the process itself runs another file.
static STARTED: OnceLock<PathBuf> = OnceLock::new();

/// Sets the program file that the user started. The commands of the Python package call this function, because their process is the Python
/// interpreter.
pub fn started_by(file: PathBuf) {
    // Only the first call has an effect, because a process is started once.
    let _ = STARTED.set(file);
}

/// Returns the program file that the user started: `admire` or `mdi`.
///
/// # Errors
/// Returns the error of the operating system if it does not give the path of the process.
pub fn own_program() -> io::Result<PathBuf> {
    STARTED
        .get()
        .map_or_else(std::env::current_exe, |file| Ok(file.clone()))
}
