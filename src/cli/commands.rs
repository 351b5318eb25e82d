use std::path::PathBuf;

use admire_session::recorded_commands;
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::Outcome;
use super::shell::{Exit, Shell};

/// Turn the commands that a message file records into a command file.
///
/// When Simulink or another program drives a run, the commands come from outside, and ADAMS writes each of them into its message file. The command
/// file repeats the run without that program. Simulations that the message file does not echo, as in a co-simulation, are reconstructed from their
/// reported end and steps.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire commands plant.msg --out replay.acf\n  admire solve replay.acf"
)]
pub(super) struct Arguments {
    /// The message file (.msg).
    messages: PathBuf,
    /// Dataset to read if no command names one; by default, the name of the message file.
    #[arg(long, value_name = "NAME")]
    model: Option<String>,
    /// File to write; by default, standard output.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Prints or writes the command file.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.messages)?;
    let stem = arguments.messages.file_stem();
    let usual = stem.map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let model = arguments.model.as_deref().unwrap_or(&usual);
    let Some(commands) = recorded_commands(&source, model) else {
        let message = format!("`{}` records no commands", arguments.messages.display());
        shell.complain(&[Diagnostic::error(Code::UnsupportedResults, message)
            .help("the message file of a run contains each command after the word `command:`")]);
        return Err(Exit::Findings);
    };
    if commands.simulations == 0 {
        let message = format!("`{}` records no simulation", arguments.messages.display());
        shell.complain(&[Diagnostic::error(Code::UnsupportedResults, message)
            .help("none of its commands is SIMULATE or LINEAR, and it has no block `Begin Simulation` with a table of times")]);
        return Err(Exit::Findings);
    }
    match &arguments.out {
        Some(path) => shell.write(path, commands.text.as_bytes())?,
        None => shell.print(&commands.text),
    }
    if commands.rebuilt > 0 {
        shell.say(&format!(
            "simulations without an echoed command, rebuilt from their tables of times: {} of {}\n",
            commands.rebuilt, commands.simulations
        ));
    }
    Ok(Exit::Fine)
}
