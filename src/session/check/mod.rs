//! Complete checks of a single file by the parser, the lint rules and the model. Each problem is reported once, unless a comment in the
//! file suppresses it.
//!
//! The module finds the files that a deck names. It does not depend on the way in which diagnostics are shown.

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

/// Returns true for files with the extension `.acf`, in upper or lower case.
pub fn is_command_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("acf"))
}

/// Returns the policy for reading the files that decks and command files in a folder name.
///
/// Such files may be read in the folder, in the working directory, in their subfolders, and in the folders that ADMIRE_ALLOW_PATH lists.
pub fn policy(folder: &Path) -> FilePolicy {
    let mut policy = FilePolicy::new(Path::new(""));
    policy.allow(folder);
    policy.confine();
    policy
}
