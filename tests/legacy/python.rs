//! Foreign readers of results, in a separate Python environment (created by `.ci/run`).

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::client::{LineEnds, copy, load_cases, project, run};
use crate::common::{missing, shared};

/// Returns the Python with the readers: READERS_PYTHON, or the one that `.ci/run` created.
fn python() -> Option<PathBuf> {
    let found = std::env::var_os("READERS_PYTHON")
        .map(PathBuf::from)
        .or_else(|| {
            ["bin/python", "Scripts/python.exe"]
                .map(|python| project("target/readers-venv").join(python))
                .into_iter()
                .find(|python| python.exists())
        });
    if found.is_none() {
        missing("the Python environment target/readers-venv");
    }
    found
}

/// Checks that adamspy starts `mdi` in its own way and reads the results, and that XML parsers read the same. All must agree with the equilibria
/// of an independent implementation: the marks of the corpus, and the reference beside the project if it is available.
#[test]
fn readers_of_others_agree_with_the_reference() {
    let Some(python) = python() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let deck = project("corpus/pseudo-mcpherson/reference.adm");
    copy(&deck, &folder.path().join("run.adm"), LineEnds::Lf);
    fs::write(folder.path().join("run.acf"), load_cases(LineEnds::Lf)).expect("a writable folder");
    let mut command = Command::new(python);
    command
        .arg(project("tests/readers/check.py"))
        .arg(folder.path())
        .arg(project("corpus/pseudo-mcpherson"));
    command.args(shared("reference/pseudo-mcpherson/mcph_ref.expected.json"));
    println!("{}", run(&mut command));
}
