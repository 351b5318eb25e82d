//! Everything there is to say of one file: what the reader, the lint rules and the model complain of, each fault once, without what
//! comments of the file silence.
//!
//! Knows where the files beside a deck are, not who is told.

mod command_file;
mod dataset;
mod settings;

pub use command_file::command_file;
pub use dataset::{Found, Told, dataset};
pub use settings::code_named;
pub use settings::table_above;
pub use settings::{Settings, Solver};

use std::path::Path;

use crate::FilePolicy;

/// True for `.acf` files, in any case of letters.
pub fn is_command_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("acf"))
}

/// What a file in a folder may make this program read: files below the folder and the working directory, and where ADMIRE_ALLOW_PATH
/// says.
pub fn policy(folder: &Path) -> FilePolicy {
    let mut policy = FilePolicy::new(Path::new(""));
    policy.allow(folder);
    policy.confine();
    policy
}
