//! Runs of commands as processes.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs `admire` in a folder.
pub fn admire(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("admire runs")
}

/// Returns the path of a shipped file.
pub fn corpus(name: &str) -> String {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(name);
    path.to_string_lossy().into_owned()
}

/// Returns the error output of a run, which must end with this code.
#[track_caller]
pub fn said(output: &Output, code: i32) -> String {
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{errors}");
    errors
}
