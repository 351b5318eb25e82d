use std::path::{Path, PathBuf};

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;

use super::shell::{Exit, Shell};

/// Destination of a changed file; standard output without options.
#[derive(clap::Args, Debug)]
pub(super) struct Target {
    /// File to write; by default, standard output.
    #[arg(long, short, conflicts_with = "in_place")]
    out: Option<PathBuf>,
    /// Replace the input file.
    #[arg(long)]
    in_place: bool,
}

impl Target {
    /// Reads the deck that is to be changed.
    pub(crate) fn read(&self, deck: &Path, shell: &mut Shell) -> Result<Source, Exit> {
        shell.read_for(deck, self.in_place)
    }

    /// Writes the changed deck; `deck` is the path it was read from.
    pub(crate) fn deliver(&self, deck: &Path, bytes: &[u8], shell: &mut Shell) -> Result<(), Exit> {
        if self.in_place && deck == Path::new("-") {
            return Err(shell.usage(
                Diagnostic::error(Code::CannotWrite, "standard input cannot be replaced")
                    .help("without --in-place the new deck goes to standard output"),
            ));
        }
        shell.deliver(self.file(deck), bytes)
    }

    /// Returns the output file: the named file, or with --in-place the input file; `None` means standard output.
    pub(crate) fn file<'a>(&'a self, read: &'a Path) -> Option<&'a Path> {
        if self.in_place {
            Some(read)
        } else {
            self.out.as_deref()
        }
    }
}
