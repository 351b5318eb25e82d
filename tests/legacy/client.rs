//! Helpers for all foreign clients: `mdi` on the PATH, copied decks, and a notice if a client is missing.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Returns the path of a file or folder of the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Returns the PATH with our `mdi` before all other programs.
pub fn path_with_mdi() -> OsString {
    let mdi = Path::new(env!("CARGO_BIN_EXE_mdi"));
    let mut folders = vec![mdi.parent().expect("a folder").to_path_buf()];
    if let Some(path) = std::env::var_os("PATH") {
        folders.extend(std::env::split_paths(&path));
    }
    std::env::join_paths(folders).expect("folders without separators")
}

/// Runs a client to its end and returns its output. A failure prints all output.
pub fn run(command: &mut Command) -> String {
    let output = command
        .env("PATH", path_with_mdi())
        .stdin(std::process::Stdio::null())
        .output()
        .expect("the client starts");
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{command:?} gave {}\n{shown}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    shown
}

/// Line ends of the files that a client gets.
#[derive(Clone, Copy, PartialEq)]
pub enum LineEnds {
    Lf,
    CrLf,
}

/// Copies a text file, changing its line ends.
pub fn copy(from: &Path, to: &Path, line_ends: LineEnds) {
    let text = fs::read_to_string(from).expect("a readable file");
    let text = match line_ends {
        LineEnds::Lf => text,
        LineEnds::CrLf => text.replace('\n', "\r\n"),
    };
    fs::write(to, text).expect("a writable folder");
}

/// Returns the command file of table 1 of the paper, for the deck `run.adm`.
pub fn load_cases(line_ends: LineEnds) -> String {
    let table = fs::read_to_string(project("corpus/pseudo-mcpherson/load_cases.csv"))
        .expect("the load cases of the corpus");
    let mut lines = vec![String::new(), "file/model=run".to_string()];
    for row in table.lines().skip(1) {
        let numbers: Vec<&str> = row.split(',').collect();
        for (sforce, column) in [(1, 3), (2, 2), (3, 1)] {
            lines.push(format!("SFORCE/{sforce}, FUNCTION = {}", numbers[column]));
        }
        lines.push("SIMULATE/STATIC".to_string());
    }
    lines.push("STOP".to_string());
    let end = match line_ends {
        LineEnds::Lf => "\n",
        LineEnds::CrLf => "\r\n",
    };
    lines.join(end) + end
}
