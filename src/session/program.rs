//! The file of this program, for scripts and messages that name it.

use std::io;
use std::path::PathBuf;
use std::sync::OnceLock;

/// File that the user started, where the process itself runs another one.
static STARTED: OnceLock<PathBuf> = OnceLock::new();

/// States which file the user started. The commands of the Python package call it, because their process is the Python interpreter.
pub fn started_by(file: PathBuf) {
    // The first statement counts; a process is started once.
    let _ = STARTED.set(file);
}

/// Returns the file that the user started: `admire` or `mdi`.
///
/// # Errors
/// An error of the operating system if it does not give the path of the process.
pub fn own_program() -> io::Result<PathBuf> {
    STARTED
        .get()
        .map_or_else(std::env::current_exe, |file| Ok(file.clone()))
}
