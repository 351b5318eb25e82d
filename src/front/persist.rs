//! Atomic replacement of a file.

use std::io::Result;
use std::path::Path;

use admire_syntax::text::patiently;
use tempfile::NamedTempFile;

/// Replaces the file at `path` by a complete new file. On Windows, the attributes of the old file (read-only, hidden) are preserved. On
/// other systems, the caller sets the permissions of the new file beforehand.
///
/// # Errors
/// When the file cannot be replaced; the old file is then unchanged.
pub(super) fn persist(new: NamedTempFile, path: &Path) -> Result<()> {
    let before = std::fs::metadata(path)
        .ok()
        .filter(|_| cfg!(windows))
        .map(|there| there.permissions());
    if let Some(before) = before.as_ref().filter(|before| before.readonly()) {
        // Windows does not replace a read-only file.
        let mut writable = before.clone();
        #[allow(clippy::permissions_set_readonly_false)]
        // On Windows, `readonly` is a file attribute, not a permission mode.
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
