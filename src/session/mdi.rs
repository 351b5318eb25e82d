use std::io::{BufWriter, Read};
use std::path::Path;
use std::process::ExitCode;

use crate::text::Source;

use super::launcher::{Launch, LaunchInput};
use super::run::{Ending, Session};

const HELP: &str = "\
mdi: solves ADAMS datasets for static equilibrium, with ADAMS' own command line

  mdi -c ru-standard i run.acf exit     executes the command file run.acf
  mdi ru-s b run.acf                    the same
  mdi ru-standard stem                  executes stem.acf
  mdi < commands                        executes the commands on standard input

Files are written in the working directory under the prefix that FILE/MODEL or the first lines of the command file give.
Environment: MDI_STRICT=1 exits with 1 for errors in the input, 2 for files, 3 for a failed simulation, where ADAMS exits
with 0; ADMIRE_ALLOW_PATH lists further folders that may be written.
";

/// Runs `mdi`, under whatever name, on the arguments of the process.
pub fn mdi() -> ExitCode {
    let words: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let console = || Box::new(BufWriter::with_capacity(1 << 16, std::io::stdout().lock()));
    let launch = match Launch::parse(&words) {
        Ok(launch) => launch,
        Err(refusal) => {
            let mut session = Session::new(console(), Path::new(""));
            session.complain(&refusal);
            return ExitCode::from(2);
        }
    };
    let name = match launch.input {
        LaunchInput::Help => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        LaunchInput::Version => {
            println!("mdi (admire {})", env!("CARGO_PKG_VERSION"));
            return ExitCode::SUCCESS;
        }
        LaunchInput::CommandFile(name) => Some(name),
        LaunchInput::StandardInput => None,
    };
    let mut session = Session::new(console(), Path::new(""));
    for warning in &launch.warnings {
        session.complain(warning);
    }
    let ending: Ending = if let Some(name) = name {
        session.run_file(&name)
    } else {
        let mut bytes = Vec::new();
        // What could be read is executed.
        let _ = std::io::stdin().read_to_end(&mut bytes);
        session.run_commands(&Source::new("standard input", bytes))
    };
    let strict =
        std::env::var_os("MDI_STRICT").is_some_and(|value| !value.is_empty() && value != "0");
    ExitCode::from(ending.exit_code(strict))
}
