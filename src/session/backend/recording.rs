//! Recorded runs of an external solver, stored under the content hash of their input files.

use std::path::{Path, PathBuf};

use super::run_folder::{RunFiles, STEM};

/// A folder of recorded runs. Each run has a folder of its own with `run.adm`, `run.acf`, `run.res` and `run.msg`, named after the SHA-256 of
/// its input files.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Recording {
    /// Path of the folder.
    pub folder: PathBuf,
}

/// Number of hash digits in the name of a run's folder; the files themselves are compared as well.
const DIGITS: usize = 24;

impl Recording {
    /// Returns the recording in a folder, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    /// Returns the number of recorded runs.
    pub fn count(&self) -> usize {
        std::fs::read_dir(&self.folder).map_or(0, |entries| {
            entries
                .flatten()
                .filter(|entry| entry.path().join(format!("{STEM}.res")).is_file())
                .count()
        })
    }

    fn place(&self, files: &RunFiles) -> PathBuf {
        self.folder.join(&files.key()[..DIGITS])
    }

    /// Returns the folder of the recorded run with these input files.
    pub(super) fn find(&self, files: &RunFiles) -> Option<PathBuf> {
        let folder = self.place(files);
        files.are_in(&folder).then_some(folder)
    }

    /// Stores a run that gave an answer.
    ///
    /// # Errors
    /// When its files cannot be copied.
    pub(super) fn keep(&self, files: &RunFiles, run: &Path) -> std::io::Result<()> {
        let folder = self.place(files);
        std::fs::create_dir_all(&folder)?;
        for extension in ["res", "msg"] {
            let name = format!("{STEM}.{extension}");
            if run.join(&name).exists() {
                std::fs::copy(run.join(&name), folder.join(&name))?;
            }
        }
        // Deck and command file are written last: without them an incomplete recording is not found.
        files.write(&folder)
    }
}
