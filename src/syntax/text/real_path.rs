use std::io::Result;
use std::path::{Path, PathBuf};

/// Returns the full path of an existing file or folder, with links resolved.
///
/// On Windows, the path begins with `\\?\` and may be longer than 260 characters.
///
/// # Errors
/// Returns an error if the path does not exist.
pub fn real_path(path: &Path) -> Result<PathBuf> {
    path.canonicalize().or_else(|error| {
        // Wine 8 fails with ERROR_MORE_DATA for long paths; Windows never returns this error here.
        if !cfg!(windows) || error.raw_os_error() != Some(234) {
            return Err(error);
        }
        let whole = std::path::absolute(path)?;
        if whole.to_string_lossy().starts_with(r"\\?\") {
            return Ok(whole);
        }
        let mut verbatim = std::ffi::OsString::from(r"\\?\");
        verbatim.push(whole);
        Ok(PathBuf::from(verbatim))
    })
}
