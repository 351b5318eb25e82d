use std::path::{Path, PathBuf};
use std::process::Command;

/// Output of a command: standard output, standard error, exit code.
pub struct Said {
    pub out: String,
    pub err: String,
    pub code: i32,
}

/// Runs `admire` in a folder, without questions.
pub fn admire(folder: &Path, arguments: &[&str]) -> Said {
    let run = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(arguments)
        .current_dir(folder)
        .stdin(std::process::Stdio::null())
        .output()
        .expect("admire runs");
    Said {
        out: String::from_utf8_lossy(&run.stdout).into_owned(),
        err: String::from_utf8_lossy(&run.stderr).into_owned(),
        code: run.status.code().expect("an exit code"),
    }
}

/// Returns the path of a file or folder of the corpus.
pub fn corpus(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(path)
}

/// Copies a study of the corpus into a folder of its own.
pub fn copied(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let study = folder.path().join("study");
    std::fs::create_dir(&study).expect("a folder");
    for entry in std::fs::read_dir(corpus(name)).expect("a study") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            std::fs::copy(&path, study.join(path.file_name().expect("a name"))).expect("a copy");
        }
    }
    (folder, study)
}

/// Replaces a text in a file that contains it.
pub fn change(path: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(path).expect("readable file");
    assert!(text.contains(from), "{from}");
    std::fs::write(path, text.replacen(from, to, 1)).expect("writable file");
}
