//! Recorded runs of an external program. Each run is found by the hash of its input files.

use std::path::{Path, PathBuf};

use super::run_folder::{RunFiles, STEM};

/// A folder of recorded runs.
///
/// Each run has a subfolder with the files `run.adm`, `run.acf`, `run.res` and `run.msg`. The name of the subfolder is derived from the
/// SHA-256 hash of the input files.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Recording {
    /// Path of the folder that contains the recorded runs.
    pub folder: PathBuf,
}

/// Number of digits of the hash in the name of a subfolder. The input files themselves are compared as well.
const DIGITS: usize = 24;

impl Recording {
    /// Returns the recording in a folder; the folder need not exist yet.
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

    /// Returns the folder of the recorded run that has exactly these input files, if there is one.
    pub(super) fn find(&self, files: &RunFiles) -> Option<PathBuf> {
        let folder = self.place(files);
        files.are_in(&folder).then_some(folder)
    }

    /// Copies the input files and results of a run into the recording.
    ///
    /// # Errors
    /// Returns an error if the files cannot be copied.
    pub(super) fn keep(&self, files: &RunFiles, run: &Path) -> std::io::Result<()> {
        let folder = self.place(files);
        std::fs::create_dir_all(&folder)?;
        for extension in ["res", "msg"] {
            let name = format!("{STEM}.{extension}");
            if run.join(&name).exists() {
                std::fs::copy(run.join(&name), folder.join(&name))?;
            }
        }
        // The deck and the command file are written last. Without them, an incomplete recording is never found.
        files.write(&folder)
    }
}
