use clap_complete::Shell as Kind;
use clap_complete::env::Shells;

use super::Outcome;
use super::shell::Exit;

/// Print a completion script for a shell: commands, options, files, and the addresses in a deck (`BUSHING/1.K.2`).
///
/// In bash, use `source <(admire completions bash)`, and in zsh the same with zsh. In fish, use `admire completions fish | source`. The
/// script asks `admire` for the completions, so that it is never out of date.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  source <(admire completions bash)")]
pub(super) struct Arguments {
    /// Shell for which the script is printed.
    #[arg(value_enum)]
    shell: Kind,
}

/// Prints the completion script.
#[allow(clippy::unnecessary_wraps)] // All subcommands return an outcome.
pub(super) fn run(arguments: &Arguments) -> Outcome {
    let shells = Shells::builtins();
    let completer = shells
        .completer(&arguments.shell.to_string())
        .expect("every shell of the list has a completer");
    // Errors are ignored, because the reader may have closed the stream.
    let _ = completer.write_registration(
        "COMPLETE",
        "admire",
        "admire",
        "admire",
        &mut std::io::stdout(),
    );
    Ok(Exit::Fine)
}
