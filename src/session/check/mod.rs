//! Complete checks of one file by the reader, the lint rules and the model. Each fault is reported once, unless a comment of the file
//! suppresses it.
//!
//! The module locates the files next to a deck, and is independent of the output of the diagnostics.

mod command_file;
mod dataset;
mod settings;

pub use command_file::command_file;
pub use dataset::{DiagnosticSource, Found, dataset};
pub use settings::code_named;
pub use settings::table_above;
pub use settings::{Settings, Solver};

use std::path::Path;

use crate::FilePolicy;

/// Returns true for `.acf` files, in upper or lower case.
pub fn is_command_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("acf"))
}

/// Returns the policy for files named in a folder's files. They may be read below the folder, below the working directory, and in the folders
/// of ADMIRE_ALLOW_PATH.
pub fn policy(folder: &Path) -> FilePolicy {
    let mut policy = FilePolicy::new(Path::new(""));
    policy.allow(folder);
    policy.confine();
    policy
}
