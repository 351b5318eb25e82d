use std::path::{Path, PathBuf};

use crate::diagnostic::{Code, Diagnostic};

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
        if self.in_place && deck == Path::new("-") {
            return Err(shell.usage(
                Diagnostic::error(Code::CannotWrite, "standard input cannot be replaced")
                    .help("without --in-place the new deck goes to standard output"),
            ));
        }
        let target = if self.in_place {
            Some(deck)
        } else {
            self.out.as_deref()
        };
        shell.deliver(target, bytes)
    }
}
