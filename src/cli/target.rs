use std::path::{Path, PathBuf};

use super::shell::{Exit, Shell};

/// Where a changed deck goes; to standard output if nothing is said.
#[derive(clap::Args, Debug)]
pub(super) struct Target {
    /// Where to write the new deck.
    #[arg(long, short, conflicts_with = "in_place")]
    out: Option<PathBuf>,
    /// Replace the deck itself.
    #[arg(long)]
    in_place: bool,
}

impl Target {
    /// Writes the changed deck; `deck` is where it was read from.
    pub fn deliver(&self, deck: &Path, bytes: &[u8], shell: &mut Shell) -> Result<(), Exit> {
        let target = if self.in_place {
            Some(deck)
        } else {
            self.out.as_deref()
        };
        shell.deliver(target, bytes)
    }
}
