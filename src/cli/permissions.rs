//! Who may read and run the files `admire` writes: the one place with an interface that only Unix has.

use std::path::Path;

/// A temporary file is private; one that takes the place of a user's file is as readable as any new file.
#[cfg(unix)]
pub(super) fn as_new_files<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    use std::os::unix::fs::PermissionsExt;
    // The system takes off what the user's mask forbids.
    builder.permissions(std::fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
pub(super) fn as_new_files<'a, 'b>(
    builder: &'a mut tempfile::Builder<'b, 'b>,
) -> &'a mut tempfile::Builder<'b, 'b> {
    builder
}

/// Lets a file be run as a command.
#[cfg(unix)]
pub(super) fn make_executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
pub(super) fn make_executable(_: &Path) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::FileTypeExt;

    use crate::cli::shell::replace_file;

    #[test]
    fn what_is_no_file_is_never_replaced_by_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
        // As root, `-o /dev/null` once made a file of the device.
        assert!(replace_file(&path, b"text").is_err());
        let kind = std::fs::metadata(&path).unwrap().file_type();
        assert!(kind.is_socket());
    }
}
