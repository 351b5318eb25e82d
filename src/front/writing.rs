//! Atomic writing of files.

use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use admire_session::check_name;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{patiently, real_path};

use super::error::{Error, ErrorKind};
use super::permissions::{as_new_files, can_be_replaced};
use super::persist::persist;
use admire_study::leftover;

/// Refuses to replace an existing file unless `replace` is set.
pub(super) fn may_replace(path: &Path, replace: bool) -> Result<(), Error> {
    if replace || path.symlink_metadata().is_err() {
        return Ok(());
    }
    let message = format!("`{}` already exists", path.display());
    let refused = Diagnostic::error(Code::CannotWrite, message);
    let kind = ErrorKind::File(std::io::ErrorKind::AlreadyExists);
    Err(Error::plain(
        kind,
        &refused.help("name another file, or allow the replacement of this one"),
    ))
}

/// Writes a file atomically: the bytes go to a temporary file in the same folder, which then replaces the file.
pub(crate) fn replace_file(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    check_name(&path.to_string_lossy()).map_err(std::io::Error::other)?;
    let path = whole(path);
    // A device or a pipe is written to directly, because replacing it would destroy it.
    if std::fs::metadata(&path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        let mut device = std::fs::OpenOptions::new().write(true).open(&path)?;
        return device.write_all(bytes).and_then(|()| device.flush());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    leftover::remove(folder);
    let mut file = as_new_files(builder.prefix(&leftover::prefix())).tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    take_place(file, &path)
}

/// Replaces a file by a complete new file, and keeps the owner, permissions and hard links of the old file.
pub(crate) fn take_place(new: NamedTempFile, path: &Path) -> std::io::Result<()> {
    let path = whole(path);
    if let Ok(before) = std::fs::metadata(&path) {
        if !can_be_replaced(&path, new.path()) {
            return overwrite(&path, new);
        }
        if cfg!(unix) {
            std::fs::set_permissions(new.path(), before.permissions())?;
        }
    }
    persist(new, &path)
}

/// Returns the absolute path of a file that may not exist yet. Links are followed, so that the target is replaced and the link is kept. On
/// Windows, an absolute path of the returned form may be longer than 260 characters.
fn whole(path: &Path) -> PathBuf {
    let beside = || {
        let folder = path.parent().filter(|it| !it.as_os_str().is_empty());
        let folder = real_path(folder.unwrap_or(Path::new("."))).ok()?;
        Some(folder.join(path.file_name()?))
    };
    let real = real_path(path).ok();
    real.or_else(beside).unwrap_or_else(|| path.to_path_buf())
}

/// Overwrites a file that cannot be replaced because it has other hard links or an owner that cannot be set. `new` is kept if its bytes
/// cannot be copied, or if the process ends before they are copied.
fn overwrite(path: &Path, new: NamedTempFile) -> std::io::Result<()> {
    // If the kept file had the name of a temporary file, other runs would delete it once this process has ended.
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".whole-{}", std::process::id()));
    let whole = path.with_file_name(name);
    new.persist(&whole)?;
    let copy = || {
        let mut from = std::fs::File::open(&whole)?;
        let mut file = patiently(|| std::fs::OpenOptions::new().write(true).open(path))?;
        let length = std::io::copy(&mut from, &mut file)?;
        file.set_len(length)?;
        file.sync_all()
    };
    copy().map_err(|error| {
        let message = format!("{error}; the complete new file is `{}`", whole.display());
        std::io::Error::new(error.kind(), message)
    })?;
    std::fs::remove_file(&whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.adm");
        std::fs::write(&path, "before").unwrap();
        replace_file(&path, b"after").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"after");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(replace_file(&folder.path().join("missing/a.adm"), b"x").is_err());
    }
}
