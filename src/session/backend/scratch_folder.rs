//! Folder of one run of an external program.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use admire_syntax::text::patiently;

/// Beginning of the names of temporary run folders.
const PREFIX: &str = "admire-run-";

/// Name of a marker file. It is written into a run folder that could not be deleted, and a later process then deletes the folder.
const LEFTOVER: &str = "admire-leftover";

/// Temporary folders of all current runs, which must be deleted at the end.
static GOING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A folder of a run. It is deleted when this value is dropped, unless it is kept.
#[derive(Debug)]
pub(super) struct ScratchFolder {
    path: PathBuf,
    kept: bool,
}

impl ScratchFolder {
    /// Creates a temporary folder. The first call in a process also deletes the folders that earlier processes could not delete.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be created.
    pub(crate) fn temporary() -> std::io::Result<Self> {
        static FIRST: Once = Once::new();
        let all = std::env::temp_dir();
        FIRST.call_once(|| sweep(&all));
        let mut folder = tempfile::Builder::new();
        let path = folder.prefix(PREFIX).tempdir_in(all)?.keep();
        going().push(path.clone());
        Ok(Self { path, kept: false })
    }

    /// Creates a folder inside `folder` that is kept. `folder` is created if it does not exist.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be created.
    pub(crate) fn lasting(folder: &Path, prefix: &str) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let mut new = tempfile::Builder::new();
        let path = new.prefix(prefix).tempdir_in(folder)?.keep();
        Ok(Self { path, kept: true })
    }

    /// Returns the path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Keeps the folder on disk and returns its path.
    pub(crate) fn keep(mut self) -> PathBuf {
        self.kept = true;
        self.path.clone()
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        if !self.kept {
            remove(&self.path);
        }
        going().retain(|path| *path != self.path);
    }
}

/// Deletes the temporary folders of all current runs; called before the process of `admire` ends.
pub(super) fn remove_all() {
    for path in going().iter() {
        remove(path);
    }
}

/// Deletes a folder and retries for some time: a process that is just ending or a virus scanner may hold it open.
fn remove(path: &Path) {
    if patiently(|| std::fs::remove_dir_all(path)).is_err() {
        // If the folder is already gone, this fails without harm.
        let _ = std::fs::write(path.join(LEFTOVER), "");
    }
}

fn going() -> MutexGuard<'static, Vec<PathBuf>> {
    GOING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Deletes the folders that earlier processes could not delete.
fn sweep(all: &Path) {
    let Ok(entries) = std::fs::read_dir(all) else {
        return;
    };
    for entry in entries.flatten() {
        let is_run = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if is_run && entry.path().join(LEFTOVER).is_file() {
            // A folder that another process still holds open is deleted by a later process.
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_goes_unless_it_is_kept_and_what_was_left_behind_goes_later() {
        let folder = ScratchFolder::temporary().unwrap();
        let path = folder.path().to_path_buf();
        std::fs::write(path.join("run.adm"), "").unwrap();
        drop(folder);
        assert!(!path.exists());

        let all = tempfile::tempdir().unwrap();
        let lasting = ScratchFolder::lasting(&all.path().join("runs"), "run-0001-").unwrap();
        let path = lasting.path().to_path_buf();
        drop(lasting);
        assert!(path.is_dir());

        for (name, left) in [
            ("admire-run-a", true),
            ("admire-run-b", false),
            ("other", true),
        ] {
            std::fs::create_dir(all.path().join(name)).unwrap();
            if left {
                std::fs::write(all.path().join(name).join(LEFTOVER), "").unwrap();
            }
        }
        sweep(all.path());
        let there = |name: &str| all.path().join(name).exists();
        assert!(!there("admire-run-a") && there("admire-run-b") && there("other"));
    }

    #[cfg(windows)]
    #[test]
    fn a_folder_that_is_held_for_a_while_goes_too() {
        use std::os::windows::fs::OpenOptionsExt;
        let folder = ScratchFolder::temporary().unwrap();
        let path = folder.path().to_path_buf();
        let mut options = std::fs::File::options();
        // Other processes may not delete the file while it is open.
        options.write(true).create(true).share_mode(1);
        let file = options.open(path.join("console.log")).unwrap();
        let holder = std::thread::spawn(move || {
            std::thread::sleep(std::time::Duration::from_millis(500));
            drop(file);
        });
        drop(folder);
        assert!(!path.exists());
        holder.join().unwrap();
    }
}
