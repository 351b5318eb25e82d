use clap_complete::Shell as Kind;
use clap_complete::env::Shells;

use super::Outcome;
use super::shell::Exit;

/// Print a completion script for a shell: commands, options, files, and the addresses inside of a deck (`BUSHING/1.K.2`).
///
/// In bash `source <(admire completions bash)`; in zsh the same with zsh; in fish `admire completions fish | source`. The script asks
/// `admire` itself what may follow, so that it never grows old.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  source <(admire completions bash)")]
pub(super) struct Arguments {
    /// Which shell.
    #[arg(value_enum)]
    shell: Kind,
}

/// Prints the script.
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
