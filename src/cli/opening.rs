//! Opens a written page with the system's default program.

use std::path::Path;
use std::process::{Command, Stdio};

use super::shell::Shell;

/// Option that opens the written page.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Opening {
    /// Open the written page with the system's default program.
    #[arg(long)]
    open: bool,
}

/// Command that opens a file with the user's default program for its type.
const OPENER: &str = if cfg!(windows) {
    "explorer"
} else if cfg!(target_os = "macos") {
    "open"
} else {
    "xdg-open"
};

impl Opening {
    /// Opens a page if `--open` is set. The command does not fail if the page cannot be opened; a remark names the reason.
    pub(super) fn open(self, page: &Path, shell: &Shell) {
        if !self.open {
            return;
        }
        // An absolute path cannot be mistaken for an option.
        let page = std::path::absolute(page).unwrap_or_else(|_| page.to_path_buf());
        let started = Command::new(OPENER)
            .arg(&page)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        if let Err(error) = started {
            shell.say(&format!("`{OPENER}` could not open the page: {error}\n"));
        }
    }
}
