//! A whole new file in the place of another.

use std::io::Result;
use std::path::Path;

use admire_syntax::text::patiently;
use tempfile::NamedTempFile;

/// Puts a whole new file in the place of `path`. On Windows attributes of the old one (read-only, hidden) stay; elsewhere the caller
/// gives the new file its permissions before.
///
/// # Errors
/// When it cannot take the place; the old file is as it was.
pub(super) fn persist(new: NamedTempFile, path: &Path) -> Result<()> {
    let before = std::fs::metadata(path)
        .ok()
        .filter(|_| cfg!(windows))
        .map(|there| there.permissions());
    if let Some(before) = before.as_ref().filter(|before| before.readonly()) {
        // Windows replaces no file that is read-only.
        let mut writable = before.clone();
        #[allow(clippy::permissions_set_readonly_false)]
        // An attribute, not a mode: this is Windows.
        writable.set_readonly(false);
        std::fs::set_permissions(path, writable)?;
    }
    let mut new = Some(new);
    let outcome = patiently(|| {
        let file = new.take().expect("given back by each failure");
        file.persist(path).map(|_| ()).map_err(|failed| {
            new = Some(failed.file);
            failed.error
        })
    });
    if let Some(before) = before {
        let kept = std::fs::set_permissions(path, before);
        return outcome.and(kept);
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_of_a_replaced_file_stay_on_windows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.adm");
        std::fs::write(&path, "before").unwrap();
        let mut permissions = std::fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&path, permissions).unwrap();
        let new = NamedTempFile::new_in(folder.path()).unwrap();
        std::fs::write(new.path(), "after").unwrap();
        persist(new, &path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"after");
        let kept = std::fs::metadata(&path).unwrap().permissions().readonly();
        assert_eq!(kept, cfg!(windows));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
