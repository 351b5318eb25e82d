use std::path::{Path, PathBuf};

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::real_path;

use super::windows_names::check_name;

/// Rules for the files that datasets and command files may name. Their contents are not trusted, so the files they name must lie in the
/// folders of the run.
#[derive(Clone, Debug)]
pub struct FilePolicy {
    /// Real paths of folders; files in these folders and in their subfolders may be written.
    folders: Vec<PathBuf>,
    /// Real paths of folders; files in these folders may be written, but not in their subfolders.
    beside: Vec<PathBuf>,
    /// True if files outside of `folders` must not be read either.
    confined: bool,
}

impl FilePolicy {
    /// Creates a policy that allows writing in the working directory, in the folders of the environment variable `ADMIRE_ALLOW_PATH`, and
    /// in their subfolders. Any file may be read.
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

    /// Restricts reading to the folders in which files may be written.
    pub const fn confine(&mut self) {
        self.confined = true;
    }

    /// Allows writing in a folder and its subfolders, for example in the folder of the command file that the command line names.
    pub fn allow(&mut self, folder: &Path) {
        if let Ok(real) = real_path(or_here(folder))
            && !self.folders.contains(&real)
        {
            self.folders.push(real);
        }
    }

    /// Allows writing in the folder of a model, but not in its subfolders.
    ///
    /// The name of the model comes from a command file. Only a name that ends in `.adm` therefore has this effect.
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

    /// Checks that a file may be read.
    ///
    /// # Errors
    /// Returns `read-outside` if the file lies outside of the allowed folders, and `cannot-read` if Windows does not treat the name as a
    /// file.
    pub fn check_read(&self, path: &Path) -> Result<(), Diagnostic> {
        check_name(&path.to_string_lossy())
            .map_err(|why| Diagnostic::error(Code::CannotRead, why))?;
        let inside = |real: PathBuf| self.folders.iter().any(|folder| real.starts_with(folder));
        if !self.confined || real_path(path).is_ok_and(inside) {
            return Ok(());
        }
        Err(Diagnostic::error(
            Code::ReadOutside,
            format!("`{}` is outside the folders that this run may use", path.display()),
        )
        .help("a named file is read only if it lies below the folder of the file that names it, or below the working directory; ADMIRE_ALLOW_PATH, or `--allow-path` of `admire solve`, adds folders"))
    }

    /// Checks that the file `path` may be written.
    ///
    /// With symbolic links resolved, the file must lie in an allowed folder. If the file exists, it must be a plain file.
    ///
    /// # Errors
    /// Returns `write-outside` if the file lies outside of the allowed folders, and `cannot-write` if it cannot be written for another
    /// reason.
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
                format!("`{}` is outside the folders that this run may use", path.display()),
            )
            .help("a command file may write beside itself, beside its model and in the working directory; ADMIRE_ALLOW_PATH adds folders"));
        }
        if real.exists() && !real.is_file() {
            return Err(cannot("it is not a plain file".into()));
        }
        Ok(())
    }
}

/// Returns the folder, or `.` if the path is empty.
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
        // Writing is allowed in the folder of a model but not in its subfolders, and only a name that ends in `.adm` is a model.
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
