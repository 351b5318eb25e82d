//! Runs of an external solver, kept under the content of the deck and command file they were given.

use std::path::{Path, PathBuf};

use super::run_folder::{RunFiles, STEM};

/// A folder of recorded runs. Each is a folder of its own, called after the SHA-256 of deck and command file, with `run.adm`,
/// `run.acf`, `run.res` and `run.msg`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Recording {
    /// The folder.
    pub folder: PathBuf,
}

/// So many digits of the content hash name a run; the files themselves are compared too.
const DIGITS: usize = 24;

impl Recording {
    /// The recording in a folder, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    /// How many runs there are.
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

    /// The folder of the run with these files.
    pub(super) fn find(&self, files: &RunFiles) -> Option<PathBuf> {
        let folder = self.place(files);
        files.are_in(&folder).then_some(folder)
    }

    /// Keeps a run that gave an answer.
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
        // Deck and commands last: without them the run is not found.
        files.write(&folder)
    }
}
