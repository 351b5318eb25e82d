use std::path::{Component, Path, PathBuf};

use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::real_path;

use super::paths::{ignoring_case, native_spelling, told_of_case};

/// A file or folder that a file in `folder` names; whose folder it is says `what`: a study, a sweep. It must lie in that folder or below
/// it, links followed, whether it exists or not. What only differs in upper and lower case is found with a warning.
///
/// The complaints have no place.
pub fn file_below(folder: &Path, written: &str, what: &str) -> Checked<Option<PathBuf>> {
    // Written on Windows it may have backslashes.
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
            "every file of a {what} lies in its folder or below it"
        ))],
    }
}

/// True if no link on the way leads out of the folder, not even one to what does not exist yet.
fn is_below(folder: &Path, path: &Path) -> bool {
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let Ok(real) = real_path(here) else {
        // Where there is no folder there are no links in it.
        return true;
    };
    let mut on_the_way = path.ancestors().take_while(|part| *part != folder);
    let there = on_the_way.find(|part| part.symlink_metadata().is_ok());
    there.is_none_or(|part| real_path(part).is_ok_and(|part| part.starts_with(&real)))
}
