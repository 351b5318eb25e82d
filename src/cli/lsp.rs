use admire_lsp::{Ended, serve_stdio};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::shell::{Exit, Shell};

/// Serve an editor over the Language Server Protocol on standard input and output.
///
/// Provides messages as you type, hover texts, definitions and references, renaming, quick fixes, completion and more, for datasets
/// (.adm) and command files (.acf). `admire guide editors` describes the setup of VS Code, Neovim and Emacs.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire lsp            # an editor starts it; see admire guide editors"
)]
pub(super) struct Arguments {
    /// Use standard input and output. Editors pass this option; there is no other connection.
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
