use std::io::Result;
use std::path::{Path, PathBuf};

/// The whole path of what is there, links followed. On Windows it begins with `\\?\`, and may be longer than 260 characters.
///
/// # Errors
/// When there is nothing.
pub fn real_path(path: &Path) -> Result<PathBuf> {
    path.canonicalize().or_else(|error| {
        // Wine 8 has no room for the longer ones (ERROR_MORE_DATA), which Windows never says here.
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
