use std::path::{Path, PathBuf};

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::real_path;

use super::windows_names::check_name;

/// Restrictions on the files that a command file may name. Datasets and command files are not trusted, so the files they name are restricted
/// to the folders of the run.
#[derive(Clone, Debug)]
pub struct FilePolicy {
    /// Real paths of folders in and below which files may be written.
    folders: Vec<PathBuf>,
    /// Real paths of folders in which files may be written, but not below them.
    beside: Vec<PathBuf>,
    /// True if files outside `folders` may not be read either.
    confined: bool,
}

impl FilePolicy {
    /// Allows writing in the working directory and in the folders listed in the environment variable `ADMIRE_ALLOW_PATH`. Any file may be
    /// read.
    pub fn new(directory: &Path) -> Self {
        let mut policy = Self {
            folders: Vec::new(),
            beside: Vec::new(),
            confined: false,
        };
        policy.allow(directory);
        if let Some(more) = std::env::var_os("ADMIRE_ALLOW_PATH") {
            for folder in std::env::split_paths(&more) {
                if !folder.as_os_str().is_empty() {
                    policy.allow(&folder);
                }
            }
        }
        policy
    }

    /// Restricts reading to the folders that may be written.
    pub const fn confine(&mut self) {
        self.confined = true;
    }

    /// Allows a folder and everything below it, such as the folder of the command file on the command line.
    pub fn allow(&mut self, folder: &Path) {
        if let Ok(real) = real_path(or_here(folder))
            && !self.folders.contains(&real)
        {
            self.folders.push(real);
        }
    }

    /// Allows writing next to a model, but not in subfolders. The name comes from a command file, so only a name that ends in `.adm` opens its
    /// folder.
    pub(crate) fn allow_beside(&mut self, model: &Path) {
        let is_adm = model
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("adm"));
        if let (true, Some(folder)) = (is_adm, model.parent())
            && let Ok(real) = real_path(or_here(folder))
            && !self.beside.contains(&real)
        {
            self.beside.push(real);
        }
    }

    /// Checks that an existing file may be read.
    ///
    /// # Errors
    /// `read-outside`, or `cannot-read` for a name that is no file on Windows.
    pub fn check_read(&self, path: &Path) -> Result<(), Diagnostic> {
        check_name(&path.to_string_lossy())
            .map_err(|why| Diagnostic::error(Code::CannotRead, why))?;
        let inside = |real: PathBuf| self.folders.iter().any(|folder| real.starts_with(folder));
        if !self.confined || real_path(path).is_ok_and(inside) {
            return Ok(());
        }
        Err(Diagnostic::error(
            Code::ReadOutside,
            format!("`{}` lies outside of the folders of this run", path.display()),
        )
        .help("what a file names is read below its own folder and the working directory; ADMIRE_ALLOW_PATH, and `--allow-path` of `admire solve`, add folders"))
    }

    /// Checks that `path` may be written. Its real folder, with links resolved, must be allowed or lie below an allowed one, and an existing
    /// file must be a plain file.
    ///
    /// # Errors
    /// `write-outside` or `cannot-write`.
    pub(crate) fn check(&self, path: &Path) -> Result<(), Diagnostic> {
        let cannot = |why: String| {
            Diagnostic::error(
                Code::CannotWrite,
                format!("`{}` cannot be written: {why}", path.display()),
            )
        };
        check_name(&path.to_string_lossy()).map_err(cannot)?;
        let real = if path.symlink_metadata().is_ok() {
            real_path(path).map_err(|e| cannot(e.to_string()))?
        } else {
            let name = path
                .file_name()
                .ok_or_else(|| cannot("it names no file".into()))?;
            real_path(or_here(path.parent().unwrap_or(Path::new(""))))
                .map_err(|e| cannot(e.to_string()))?
                .join(name)
        };
        let below = self.folders.iter().any(|folder| real.starts_with(folder));
        let beside = !self.confined && self.beside.iter().any(|f| real.parent() == Some(f));
        if !below && !beside {
            return Err(Diagnostic::error(
                Code::WriteOutside,
                format!("`{}` lies outside of the folders of this run", path.display()),
            )
            .help("a command file may write beside itself, beside its model and in the working directory; ADMIRE_ALLOW_PATH adds folders"));
        }
        if real.exists() && !real.is_file() {
            return Err(cannot("it is not a plain file".into()));
        }
        Ok(())
    }
}

/// Returns the folder, or `.` for the empty path.
fn or_here(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writing_is_held_to_the_folders_of_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let model = folder.path().join("model");
        for path in [&run, &model] {
            std::fs::create_dir(path).unwrap();
        }
        let mut policy = FilePolicy::new(&run);
        assert!(policy.check(&run.join("a.res")).is_ok());
        let outside = policy.check(&model.join("a.res")).unwrap_err();
        assert_eq!(outside.code, Code::WriteOutside);
        let climbing = policy.check(&run.join("../model/a.res")).unwrap_err();
        assert_eq!(climbing.code, Code::WriteOutside);
        // Writing is allowed next to a model but not below, and only a name ending in `.adm` is a model.
        policy.allow_beside(&model.join("passwd"));
        assert!(policy.check(&model.join("a.res")).is_err());
        policy.allow_beside(&model.join("a.adm"));
        assert!(policy.check(&run.join("../model/a.res")).is_ok());
        std::fs::create_dir(model.join("deeper")).unwrap();
        assert!(policy.check(&model.join("deeper/a.res")).is_err());
        std::fs::write(model.join("a.adm"), "x").unwrap();
        assert!(policy.check_read(&model.join("a.adm")).is_ok());
        policy.confine();
        assert_eq!(
            policy.check_read(&model.join("a.adm")).unwrap_err().code,
            Code::ReadOutside
        );
        assert!(policy.check(&model.join("a.res")).is_err());
        policy.allow(&model);
        assert!(policy.check_read(&model.join("a.adm")).is_ok());
        std::fs::create_dir(run.join("b.res")).unwrap();
        assert_eq!(
            policy.check(&run.join("b.res")).unwrap_err().code,
            Code::CannotWrite
        );
        assert_eq!(
            policy.check(&run.join("missing/a.res")).unwrap_err().code,
            Code::CannotWrite
        );
    }
}
