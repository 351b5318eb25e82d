//! Helpers shared by several test files.
#![allow(dead_code)] // Each test binary uses its own part.

pub mod tiling;

use std::io::Write;
use std::path::PathBuf;

/// Reports why a test was skipped, bypassing the output capture of the test harness.
pub fn skipped(what: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {what}");
}

/// Reports that something is missing and the test is skipped; under CI the test fails instead.
pub fn missing(what: &str) {
    assert!(
        std::env::var_os("CI").is_none_or(|value| value.is_empty()),
        "{what} is missing, and CI skips nothing"
    );
    skipped(&format!("{what} is missing"));
}

/// Returns a folder or file of the shared reference material beside the project, or `None` if it is absent, as on a user's machine.
///
/// See [`missing`].
pub fn shared(path: &str) -> Option<PathBuf> {
    let full = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../shared")
        .join(path);
    if full.exists() {
        return Some(full);
    }
    missing(&full.display().to_string());
    None
}

/// Returns all files below a folder whose name ends in `.extension`, sorted.
pub fn files_below(folder: &std::path::Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).expect("readable folder") {
            let path = entry.expect("readable entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path
                .extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(extension))
            {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
