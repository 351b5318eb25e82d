use std::path::{Component, Path, PathBuf};

use crate::diagnostic::{Checked, Code, Diagnostic};

/// The file that a dataset, a command file or a command line names, looked up in `folders` in their order.
///
/// Quotes and blanks around the name are dropped, backslashes separate folders, `.{extension}` is added where it is missing
/// (guide/formats.md 5.1). What only differs in upper and lower case is found with a warning, and so is the base name of a path
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
            let mut here: Vec<&PathBuf> = paths.iter().filter(|path| path.is_file()).collect();
            let others: Vec<PathBuf> = paths.iter().filter_map(|p| ignoring_case(p)).collect();
            if here.is_empty() {
                here.extend(&others);
            }
            if !here.is_empty() {
                return in_place_of(written, &here);
            }
        }
    }
    Checked::clean(None)
}

/// The one file of the same name that is here, with a warning; several are refused.
fn in_place_of(written: &str, here: &[&PathBuf]) -> Checked<Option<PathBuf>> {
    let whole = |path: &PathBuf| std::fs::canonicalize(path).unwrap_or_else(|_| path.clone());
    let mut found: Vec<PathBuf> = here.iter().map(|path| whole(path)).collect();
    found.sort();
    found.dedup();
    let written = written.trim();
    let (value, diagnostic) = match found.as_slice() {
        [one] => (
            Some(here[0].clone()),
            Diagnostic::warning(
                Code::ForeignPath,
                format!(
                    "`{}` is read in place of `{written}`, which does not exist",
                    one.display()
                ),
            ),
        ),
        several => {
            let names: Vec<String> = several
                .iter()
                .map(|p| format!("`{}`", p.display()))
                .collect();
            let refusal = Diagnostic::error(
                Code::ForeignPath,
                format!(
                    "`{written}` does not exist, and several files could be meant: {}",
                    names.join(", ")
                ),
            );
            (
                None,
                refusal.help("write the path of the one that is meant"),
            )
        }
    };
    Checked {
        value,
        diagnostics: vec![diagnostic],
    }
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

/// Which files a command file may name. Datasets and command files are not trusted: what they name is held to the folders of the
/// run.
#[derive(Clone, Debug)]
pub struct FilePolicy {
    /// Real paths of folders; what is below them may be written.
    folders: Vec<PathBuf>,
    /// Real paths of folders; what is in them may be written, not what is in folders of theirs.
    beside: Vec<PathBuf>,
    /// Nothing outside of `folders` may be read either.
    confined: bool,
}

impl FilePolicy {
    /// The working directory, and the folders that the environment variable `ADMIRE_ALLOW_PATH` lists, may be written. Anything may
    /// be read.
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

    /// Lets nothing be read either that may not be written.
    pub const fn confine(&mut self) {
        self.confined = true;
    }

    /// Allows a folder and all below: where the command file of the command line is.
    pub fn allow(&mut self, folder: &Path) {
        if let Ok(real) = or_here(folder).canonicalize()
            && !self.folders.contains(&real)
        {
            self.folders.push(real);
        }
    }

    /// Allows to write beside a model. Its name comes out of a command file: only a dataset by name opens its folder, and nothing
    /// below.
    pub fn allow_beside(&mut self, model: &Path) {
        let is_adm = model
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("adm"));
        if let (true, Some(folder)) = (is_adm, model.parent())
            && let Ok(real) = or_here(folder).canonicalize()
            && !self.beside.contains(&real)
        {
            self.beside.push(real);
        }
    }

    /// True if a file that was found may be read.
    ///
    /// # Errors
    /// `read-outside`.
    pub fn check_read(&self, path: &Path) -> Result<(), Diagnostic> {
        let inside = |real: PathBuf| self.folders.iter().any(|folder| real.starts_with(folder));
        if !self.confined || path.canonicalize().is_ok_and(inside) {
            return Ok(());
        }
        Err(Diagnostic::error(
            Code::ReadOutside,
            format!("`{}` lies outside of the folders of this run", path.display()),
        )
        .help("what a file names is read below its own folder and the working directory; ADMIRE_ALLOW_PATH, and `--allow-path` of `admire solve`, add folders"))
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

/// The folder, or `.` for the empty path.
fn or_here(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    }
}

/// The base name of a model: what its output files are called unless a prefix is given.
pub(super) fn default_prefix(model: &str) -> PathBuf {
    let path = native_spelling(model);
    let is_adm = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("adm"));
    let base = if is_adm {
        path.file_stem()
    } else {
        path.file_name()
    };
    PathBuf::from(base.unwrap_or_default())
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
        let mut policy = FilePolicy::new(&run);
        assert!(policy.check(&run.join("a.res")).is_ok());
        let outside = policy.check(&model.join("a.res")).unwrap_err();
        assert_eq!(outside.code, Code::WriteOutside);
        let climbing = policy.check(&run.join("../model/a.res")).unwrap_err();
        assert_eq!(climbing.code, Code::WriteOutside);
        // Beside a model, but not below; and only a dataset by name is one.
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
