//! Permissions of the files that `admire` writes. Interfaces that exist only on Unix are confined to this module.

use std::path::Path;

/// Gives a temporary file the permissions of an ordinary new file, because it will replace a user's file. Without this call, the temporary
/// file would be private.
#[cfg(unix)]
pub(crate) fn as_new_files<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    use std::os::unix::fs::PermissionsExt;
    // The operating system removes the permissions that the user's umask excludes.
    builder.permissions(std::fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
pub(crate) fn as_new_files<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    builder
}

/// Returns true if a new file can replace an old file. The old file must have no other hard links, and it must be possible to give its
/// owner to the new file.
#[cfg(unix)]
pub(crate) fn can_be_replaced(path: &Path, new: &Path) -> bool {
    use std::os::unix::fs::{MetadataExt, chown};
    let Ok(old) = std::fs::metadata(path) else {
        return true;
    };
    let same =
        std::fs::metadata(new).is_ok_and(|new| (new.uid(), new.gid()) == (old.uid(), old.gid()));
    old.nlink() < 2 && (same || chown(new, Some(old.uid()), Some(old.gid())).is_ok())
}

/// Returns true if a new file can replace an old file: the old file must have no other hard links. The function `persist` restores its
/// attributes.
#[cfg(windows)]
pub(crate) fn can_be_replaced(path: &Path, _: &Path) -> bool {
    let opened = winapi_util::Handle::from_path_any(path);
    let told = opened.and_then(winapi_util::file::information);
    told.map_or(true, |told| told.number_of_links() < 2)
}

/// Makes a file executable.
#[cfg(unix)]
pub(crate) fn make_executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
pub(crate) fn make_executable(_: &Path) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::FileTypeExt;

    use crate::front::replace_file;

    #[test]
    fn what_is_no_file_is_never_replaced_by_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
        // With `-o /dev/null`, run as root, an earlier version replaced the device by a regular file.
        assert!(replace_file(&path, b"text").is_err());
        let kind = std::fs::metadata(&path).unwrap().file_type();
        assert!(kind.is_socket());
    }

    #[test]
    fn all_names_of_a_file_keep_being_its_names() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt};
        let folder = tempfile::tempdir().unwrap();
        let (path, other) = (folder.path().join("a.adm"), folder.path().join("b.adm"));
        std::fs::write(&path, "a long text").unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).unwrap();
        std::fs::hard_link(&path, &other).unwrap();
        replace_file(&path, b"short").unwrap();
        assert_eq!(std::fs::read(&other).unwrap(), b"short");
        let data = std::fs::metadata(&path).unwrap();
        assert_eq!((data.nlink(), data.mode() & 0o777), (2, 0o640));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
        // The owner is preserved. This is tested only as root, because only root can change the owner.
        let third = folder.path().join("c.adm");
        std::fs::write(&third, "text").unwrap();
        if std::os::unix::fs::chown(&third, Some(4242), Some(4243)).is_ok() {
            replace_file(&third, b"new").unwrap();
            let data = std::fs::metadata(&third).unwrap();
            assert_eq!((data.uid(), data.gid()), (4242, 4243));
        }
    }
}

#[cfg(all(test, windows))]
mod names_on_windows {
    #[test]
    fn all_names_of_a_file_show_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let (first, second) = (folder.path().join("a.adm"), folder.path().join("b.adm"));
        std::fs::write(&first, "before, and longer").unwrap();
        std::fs::hard_link(&first, &second).unwrap();
        crate::front::replace_file(&first, b"after").unwrap();
        assert_eq!(std::fs::read(&first).unwrap(), b"after");
        assert_eq!(std::fs::read(&second).unwrap(), b"after");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
