use clap_complete::Shell as Kind;

use super::Outcome;
use super::shell::Exit;

/// Print a completion script for a shell.
///
/// For completion of addresses inside of a deck (`BUSHING/1.K.2`) load the dynamic one instead, for example
/// `source <(COMPLETE=bash admire)`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Which shell.
    #[arg(value_enum)]
    shell: Kind,
}

/// Prints the script.
#[allow(clippy::unnecessary_wraps)] // Every subcommand has an outcome.
pub(super) fn run(arguments: &Arguments, command: &mut clap::Command) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, command, "admire", &mut script);
    // Nobody may be listening.
    let _ = std::io::Write::write_all(&mut std::io::stdout(), &script);
    Ok(Exit::Fine)
}
