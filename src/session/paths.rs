use std::path::{Component, Path, PathBuf};

use crate::diagnostic::{Checked, Code, Diagnostic};

/// The file that a dataset, a command file or a command line names, looked up in `folders` in their order.
///
/// Quotes and blanks around the name are dropped, backslashes separate folders, `.{extension}` is added where it is missing
/// (ADAMS-FORMATS 5.1). What only differs in upper and lower case is found with a warning, and so is the base name of a path
/// of another computer (a drive letter, or a folder that is not here).
pub fn find_file(
    written: &str,
    extension: &str,
    folders: &[impl AsRef<Path>],
) -> Checked<Option<PathBuf>> {
    let spelled = native_spelling(written);
    let candidates = with_extension(&spelled, extension);
    let all =
        |name: &Path| -> Vec<PathBuf> { folders.iter().map(|f| f.as_ref().join(name)).collect() };
    for candidate in &candidates {
        if let Some(path) = all(candidate).into_iter().find(|path| path.is_file()) {
            return Checked::clean(Some(path));
        }
    }
    for candidate in &candidates {
        if let Some(path) = all(candidate).iter().find_map(|p| ignoring_case(p)) {
            let warning = Diagnostic::warning(
                Code::FileNameCase,
                format!("`{written}` is found as `{}`", path.display()),
            )
            .help("some computers tell upper from lower case in file names");
            return Checked {
                value: Some(path),
                diagnostics: vec![warning],
            };
        }
    }
    if spelled.components().count() > 1 {
        let base = spelled.file_name().map(PathBuf::from).unwrap_or_default();
        for candidate in &with_extension(&base, extension) {
            let paths = all(candidate);
            let here = paths.iter().find(|path| path.is_file()).cloned();
            if let Some(path) = here.or_else(|| paths.iter().find_map(|p| ignoring_case(p))) {
                let warning = Diagnostic::warning(
                    Code::ForeignPath,
                    format!("`{written}` does not exist; `{}` is used", path.display()),
                );
                return Checked {
                    value: Some(path),
                    diagnostics: vec![warning],
                };
            }
        }
    }
    Checked::clean(None)
}

/// A file name as this computer spells it: no quotes around it, and on a Unix-like computer `/` for `\` and no drive letter.
pub fn native_spelling(written: &str) -> PathBuf {
    let text = written
        .trim()
        .trim_matches(|c| c == '"' || c == '\'')
        .trim()
        .replace('\0', "");
    if cfg!(windows) {
        return PathBuf::from(text);
    }
    let slashed = text.replace('\\', "/");
    let bytes = slashed.as_bytes();
    let rest = if bytes.len() >= 2 && bytes[0].is_ascii_alphabetic() && bytes[1] == b':' {
        &slashed[2..]
    } else {
        &slashed
    };
    PathBuf::from(rest)
}

/// The name with and without the extension, the likelier spelling first.
fn with_extension(name: &Path, extension: &str) -> Vec<PathBuf> {
    let mut longer = name.as_os_str().to_owned();
    longer.push(".");
    longer.push(extension);
    let longer = PathBuf::from(longer);
    match name.extension() {
        Some(found) if found.eq_ignore_ascii_case(extension) => vec![name.to_path_buf()],
        Some(_) => vec![name.to_path_buf(), longer],
        None => vec![longer, name.to_path_buf()],
    }
}

/// The file with this path but for upper and lower case, if there is one.
fn ignoring_case(path: &Path) -> Option<PathBuf> {
    let mut found = PathBuf::new();
    for component in path.components() {
        let Component::Normal(name) = component else {
            found.push(component);
            continue;
        };
        let exact = found.join(name);
        if exact.exists() {
            found = exact;
            continue;
        }
        let folder = if found.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &found
        };
        let mut alike: Vec<_> = std::fs::read_dir(folder)
            .ok()?
            .filter_map(|entry| Some(entry.ok()?.file_name()))
            .filter(|entry| entry.eq_ignore_ascii_case(name))
            .collect();
        alike.sort();
        found.push(alike.first()?);
    }
    found.is_file().then_some(found)
}

/// Where a command file may write. Datasets and command files are not trusted: they name output files, so they are held to the
/// folders of the run.
#[derive(Clone, Debug)]
pub struct WritePolicy {
    /// Real paths of folders; what is below them may be written.
    folders: Vec<PathBuf>,
}

impl WritePolicy {
    /// The working directory, and the folders that the environment variable `ADMIRE_ALLOW_PATH` lists.
    pub fn new(directory: &Path) -> Self {
        let mut policy = Self {
            folders: Vec::new(),
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

    /// Allows a folder too: where the command file or the model is.
    pub fn allow(&mut self, folder: &Path) {
        if let Ok(real) = or_here(folder).canonicalize()
            && !self.folders.contains(&real)
        {
            self.folders.push(real);
        }
    }

    /// True if `path` may be written: its real folder, links followed, is one of the allowed ones or below, and what stands
    /// there already is a plain file.
    ///
    /// # Errors
    /// `write-outside` or `cannot-write`.
    pub fn check(&self, path: &Path) -> Result<(), Diagnostic> {
        let cannot = |why: String| {
            Diagnostic::error(
                Code::CannotWrite,
                format!("`{}` cannot be written: {why}", path.display()),
            )
        };
        let real = if path.symlink_metadata().is_ok() {
            path.canonicalize().map_err(|e| cannot(e.to_string()))?
        } else {
            let name = path
                .file_name()
                .ok_or_else(|| cannot("it names no file".into()))?;
            or_here(path.parent().unwrap_or(Path::new("")))
                .canonicalize()
                .map_err(|e| cannot(e.to_string()))?
                .join(name)
        };
        if !self.folders.iter().any(|folder| real.starts_with(folder)) {
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

/// The folder, or `.` for the empty path.
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

    fn codes(found: &Checked<Option<PathBuf>>) -> Vec<Code> {
        found.diagnostics.iter().map(|d| d.code).collect()
    }

    #[test]
    fn names_are_found_as_scripts_write_them() {
        let folder = tempfile::tempdir().unwrap();
        let deck = folder.path().join("Sub Folder").join("Model.adm");
        std::fs::create_dir(deck.parent().unwrap()).unwrap();
        std::fs::write(&deck, "x").unwrap();
        std::fs::write(folder.path().join("other.adm"), "x").unwrap();
        let find = |written: &str| find_file(written, "adm", &[folder.path()]);

        for written in [
            "Sub Folder/Model.adm",
            r"Sub Folder\Model",
            r#""Sub Folder\Model""#,
        ] {
            let found = find(written);
            assert_eq!(found.value.as_deref(), Some(deck.as_path()), "{written}");
            assert!(found.diagnostics.is_empty());
        }
        if cfg!(target_os = "linux") {
            let found = find(r"sub folder\MODEL.ADM");
            assert_eq!(found.value.as_deref(), Some(deck.as_path()));
            assert_eq!(codes(&found), [Code::FileNameCase]);
        }
        let found = find(r"C:\Users\somebody\runs\other");
        assert_eq!(found.value, Some(folder.path().join("other.adm")));
        assert_eq!(codes(&found), [Code::ForeignPath]);
        assert_eq!(find("nowhere").value, None);
        assert_eq!(find("").value, None);
    }

    #[test]
    fn writing_is_held_to_the_folders_of_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let model = folder.path().join("model");
        for path in [&run, &model] {
            std::fs::create_dir(path).unwrap();
        }
        let mut policy = WritePolicy::new(&run);
        assert!(policy.check(&run.join("a.res")).is_ok());
        let outside = policy.check(&model.join("a.res")).unwrap_err();
        assert_eq!(outside.code, Code::WriteOutside);
        let climbing = policy.check(&run.join("../model/a.res")).unwrap_err();
        assert_eq!(climbing.code, Code::WriteOutside);
        policy.allow(&model);
        assert!(policy.check(&run.join("../model/a.res")).is_ok());
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

    #[cfg(unix)]
    #[test]
    fn a_link_out_of_the_folder_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        std::fs::create_dir(&run).unwrap();
        let victim = folder.path().join("victim");
        std::fs::write(&victim, "x").unwrap();
        std::os::unix::fs::symlink(&victim, run.join("a.res")).unwrap();
        let policy = WritePolicy::new(&run);
        assert_eq!(
            policy.check(&run.join("a.res")).unwrap_err().code,
            Code::WriteOutside
        );
    }
}
