use admire_lsp::{Ended, serve_stdio};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::shell::{Exit, Shell};

/// Serve an editor over the Language Server Protocol on standard input and output.
///
/// Complaints as you type, hover, definitions and references, rename, quick fixes, completion and more for datasets (.adm) and command
/// files (.acf). `admire guide editors` says how to set up VS Code, Neovim and Emacs.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire lsp            # an editor starts it; see admire guide editors"
)]
pub(super) struct Arguments {
    /// Standard input and output, as editors ask for by name; there is nothing else.
    #[arg(long)]
    stdio: bool,
}

/// Serves the editor until it disconnects.
pub(super) fn run(_: &Arguments, shell: &mut Shell) -> Outcome {
    match serve_stdio() {
        Ok(Ended::Orderly) => Ok(Exit::Fine),
        Ok(Ended::Abruptly) => Err(Exit::Findings),
        Err(error) => {
            let message = format!("the language server ended: {error}");
            Err(shell.fail(Diagnostic::error(Code::CannotRead, message)))
        }
    }
}
