//! The commands `admire` and `mdi` of the wheel.

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

use pyo3::prelude::*;

/// Runs `admire` with a command line, whose first word is the program, and returns its exit code.
#[pyfunction]
pub(super) fn run_admire(py: Python<'_>, words: Vec<OsString>) -> u8 {
    as_program(py, words, crate::cli::run)
}

/// Runs `mdi` with a command line, whose first word is the program, and returns its exit code.
#[pyfunction]
pub(super) fn run_mdi(py: Python<'_>, words: Vec<OsString>) -> u8 {
    as_program(py, words, admire_session::mdi)
}

fn as_program(py: Python<'_>, words: Vec<OsString>, run: fn(Vec<OsString>) -> u8) -> u8 {
    if let Some(program) = words.first() {
        admire_session::started_by(PathBuf::from(program));
    }
    py.detach(|| {
        let code = run(words);
        // Only the end of a Rust program flushes this stream by itself. Errors are ignored, because the reader may have closed the stream.
        let _ = std::io::stdout().flush();
        code
    })
}
