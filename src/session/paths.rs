use std::path::{Component, Path, PathBuf};

use admire_syntax::diagnostic::{Checked, Code, Diagnostic};

use super::windows_names;

/// Finds the file that a dataset, a command file or a command line names, in several folders in turn.
///
/// Quotes and blanks around the name are dropped, backslashes separate folders, and `.{extension}` is added if it is missing
/// (guide/formats.md 5.1). On Windows, names of devices are rejected.
///
/// A name that differs only in case is accepted with a warning. If a path with folders is not found, a file with the same base name in
/// `folders` is used instead, with a warning; several such files are an error. The value is `None` if no file is found.
pub fn find_file(
    written: &str,
    extension: &str,
    folders: &[impl AsRef<Path>],
) -> Checked<Option<PathBuf>> {
    if let Err(why) = windows_names::check_name(written) {
        let message = format!("`{}` cannot be read: {why}", written.trim());
        return Checked {
            value: None,
            diagnostics: vec![Diagnostic::error(Code::CannotRead, message)],
        };
    }
    let spelled = native_spelling(written);
    let mut candidates = with_extension(&spelled, extension);
    // Windows drops trailing dots from names, so the file may have been written without them.
    let undotted = windows_names::undotted(&spelled.to_string_lossy());
    if !undotted.is_empty() && Path::new(&undotted) != spelled {
        candidates.extend(with_extension(Path::new(&undotted), extension));
    }
    let all =
        |name: &Path| -> Vec<PathBuf> { folders.iter().map(|f| f.as_ref().join(name)).collect() };
    for candidate in &candidates {
        if let Some(path) = all(candidate).into_iter().find(|path| path.is_file()) {
            return Checked::clean(Some(path));
        }
    }
    for candidate in &candidates {
        if let Some(path) = all(candidate).iter().find_map(|p| ignoring_case(p)) {
            return Checked {
                diagnostics: vec![told_of_case(written, &path)],
                value: Some(path),
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

/// Returns the warning about a file whose name differs from the written name in case.
pub(crate) fn told_of_case(written: &str, found: &Path) -> Diagnostic {
    Diagnostic::warning(
        Code::FileNameCase,
        format!(
            "`{written}` is read from `{}`, whose name differs in case",
            found.display()
        ),
    )
    .help("some systems distinguish upper and lower case in file names")
}

/// Returns the only local file with the same base name, and a warning. If there are several such files, returns an error.
fn in_place_of(written: &str, here: &[&PathBuf]) -> Checked<Option<PathBuf>> {
    let whole = |path: &PathBuf| dunce::canonicalize(path).unwrap_or_else(|_| path.clone());
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
            (None, refusal.help("write the path of the intended file"))
        }
    };
    Checked {
        value,
        diagnostics: vec![diagnostic],
    }
}

/// Converts a file name to the form of this operating system, without quotes.
///
/// On Windows, the form has backslashes and no trailing dots. Elsewhere, it has `/` in place of `\` and no drive letter.
pub(crate) fn native_spelling(written: &str) -> PathBuf {
    PathBuf::from(if cfg!(windows) {
        windows_names::of_windows(written)
    } else {
        windows_names::of_unix(written)
    })
}

/// Returns the name with and without the extension; the form that is more likely comes first.
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

/// Returns the file whose path equals the given path if case is ignored; `None` if there is no such file.
pub(crate) fn ignoring_case(path: &Path) -> Option<PathBuf> {
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
        let found = find(r"\\server\share\runs\other.adm");
        assert_eq!(found.value, Some(folder.path().join("other.adm")));
        assert_eq!(codes(&found), [Code::ForeignPath]);
        // These names contain mixed separators, repeated separators, and trailing dots that Windows drops.
        for written in [
            r"Sub Folder/\Model.adm",
            r".\Sub Folder\Model.",
            "Sub Folder/Model.adm. .",
        ] {
            assert_eq!(
                find(written).value.as_deref(),
                Some(deck.as_path()),
                "{written}"
            );
        }
        let device = find(r"Sub Folder\AUX.adm");
        assert_eq!(device.value, None);
        assert_eq!(device.has_errors(), cfg!(windows));
        assert_eq!(find("nowhere").value, None);
        assert_eq!(find("").value, None);
    }
}
