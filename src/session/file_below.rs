use std::path::{Component, Path, PathBuf};

use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::real_path;

use super::paths::{ignoring_case, native_spelling, told_of_case};

/// Returns the path of a file or folder that is named in a file of `folder`, whether it exists or not.
///
/// With symbolic links resolved, the path must lie in `folder` or below it. A name that differs only in case is accepted with a warning.
/// `what` is the word for the owner of the folder in messages: study or sweep.
///
/// The returned diagnostics have no location.
pub fn file_below(folder: &Path, written: &str, what: &str) -> Checked<Option<PathBuf>> {
    // A path written on Windows may contain backslashes.
    let relative = native_spelling(written);
    let plain = relative
        .components()
        .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let mut path = folder.join(&relative);
    let mut diagnostics = Vec::new();
    if plain
        && !path.exists()
        && let Some(found) = ignoring_case(&path)
    {
        diagnostics.push(told_of_case(written, &found));
        path = found;
    }
    if plain && is_below(folder, &path) {
        return Checked {
            value: Some(path),
            diagnostics,
        };
    }
    let message = format!("`{written}` lies outside of the {what} folder");
    Checked {
        value: None,
        diagnostics: vec![Diagnostic::error(Code::OutsideStudy, message).help(format!(
            "every file of a {what} must be in its folder or below it"
        ))],
    }
}

/// Returns true if no symbolic link on the path leads out of the folder. A link to a missing target is followed as well.
fn is_below(folder: &Path, path: &Path) -> bool {
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let Ok(real) = real_path(here) else {
        // A folder that does not exist contains no links.
        return true;
    };
    let mut on_the_way = path.ancestors().take_while(|part| *part != folder);
    let there = on_the_way.find(|part| part.symlink_metadata().is_ok());
    there.is_none_or(|part| real_path(part).is_ok_and(|part| part.starts_with(&real)))
}
