//! Temporary folder with a deck in it, and runs of the `admire` program in that folder.

use std::path::Path;
use std::process::Command;

/// Temporary folder, deleted on drop.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// Creates a folder with this text as `d.adm`.
    pub fn with(deck: &str) -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        folder.write("d.adm", deck);
        folder
    }

    /// Writes a file and creates its parent folders.
    pub fn write(&self, name: &str, text: &str) {
        let path = self.0.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("written");
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Returns the text of a file.
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.path().join(name)).expect("readable")
    }

    /// Runs `admire` in the folder and returns the exit code, standard output and standard error.
    pub fn run(&self, words: &[&str]) -> (i32, String, String) {
        run(self.0.path(), words)
    }
}

/// Runs `admire` in a folder and returns the exit code, standard output and standard error.
pub fn run(folder: &Path, words: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_admire"))
        .current_dir(folder)
        .args(words)
        .env("NO_COLOR", "1")
        .output()
        .expect("admire runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code().expect("no signal"),
        text(&output.stdout),
        text(&output.stderr),
    )
}
