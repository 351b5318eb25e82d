//! Permission to start a program named by a study or a sweep.

use std::io::IsTerminal;

use admire_study::permission::NamedProgram;

use super::new::answer;
use super::shell::{Exit, Shell};

#[derive(clap::Args, Clone, Copy, Debug)]
pub(super) struct Permission {
    /// Start the program that the study or the sweep names, without asking. Otherwise the user is asked once, unless `admire new` created
    /// the study here.
    #[arg(long)]
    allow_command: bool,
}

impl Permission {
    /// Asks the user whether a program may be started, unless it is already allowed. Without a terminal, the program is refused.
    pub(super) fn ask(self, program: Option<&NamedProgram>, shell: &Shell) -> Result<(), Exit> {
        let Some(program) = program.filter(|program| !self.allow_command && !program.is_allowed())
        else {
            return Ok(());
        };
        let help = "allow the program by --allow-command; on a terminal, you are asked once";
        if !std::io::stdin().is_terminal() || !std::io::stderr().is_terminal() {
            return Err(shell.usage(program.refusal(help)));
        }
        if !matches!(answer(&program.question(), shell).as_str(), "y" | "yes") {
            return Err(shell.usage(program.refusal(help)));
        }
        if let Err(error) = program.allow() {
            shell.say(&format!(
                "the permission was not saved, so you will be asked again: {error}\n"
            ));
        }
        Ok(())
    }
}
