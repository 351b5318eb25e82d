use std::ffi::OsString;
use std::io::{BufWriter, IsTerminal, Read};
use std::path::Path;

use admire_solver::model::Ignore;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{CodePage, Encoded, Source};

use super::ending::{EXIT_CODES, Ending};
use super::launcher::{Launch, LaunchInput};
use super::run_state::Session;

const HELP: &str = "\
mdi: solves ADAMS datasets (statics and motion), with the command line of ADAMS

  mdi -c ru-standard i run.acf exit     executes the command file run.acf
  mdi ru-s b run.acf                    the same
  mdi ru-standard stem                  executes stem.acf
  mdi acar ru-solver run.acf            the same as mdi ru-solver run.acf
  mdi < commands                        executes the commands on standard input

Files are written in the working directory under the prefix that FILE/MODEL or the first lines of the command file give.
Environment: MDI_STRICT=1 exits with 3 where an equilibrium was not found; ADMIRE_ALLOW_PATH lists further folders that may be
written; ADMIRE_IGNORE=CONTACT,FRICTION/3 leaves out statements that are not solved, where a simulation would be refused;
ADMIRE_CODE_PAGE=1252 prints in that code page on a pipe.

Exit codes:
";

/// Runs the program `mdi` with a command line and returns its exit code. The first word, which is the name of the program, is ignored.
pub fn mdi(words: Vec<OsString>) -> u8 {
    let words: Vec<String> = words
        .into_iter()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let page = CodePage::of_environment();
    let shown = match page {
        Ok(page) if !std::io::stdout().is_terminal() => page,
        _ => CodePage::Utf8,
    };
    let console = || {
        let out = BufWriter::with_capacity(1 << 16, std::io::stdout().lock());
        Box::new(Encoded::new(out, shown))
    };
    let refuse = |refusal: &Diagnostic, words: &[String]| {
        let mut session = Session::new(console(), Path::new(""));
        session.complain(refusal);
        session.refuse(&Launch::stem(words));
        2
    };
    if let Err(why) = page {
        return refuse(&Diagnostic::error(Code::LauncherRefused, why), &words);
    }
    let mut stem = Launch::stem(&words);
    let mut launch = match Launch::parse(&words) {
        Ok(launch) => launch,
        Err(refusal) => return refuse(&refusal, &words),
    };
    let mut bytes = Vec::new();
    if launch.input == LaunchInput::StandardInput {
        // After a read error, the commands that were read so far are executed.
        let _ = std::io::stdin().read_to_end(&mut bytes);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        match Launch::of_menu(&text) {
            None => {}
            Some(Ok(answered)) => {
                if let LaunchInput::CommandFile(file) = &answered.input {
                    stem = Launch::stem(std::slice::from_ref(file));
                }
                launch = answered;
            }
            Some(Err(refusal)) => {
                let words: Vec<String> = text.lines().map(str::to_string).collect();
                return refuse(&refusal, &words);
            }
        }
    }
    let name = match launch.input {
        LaunchInput::Help => {
            print!("{HELP}{EXIT_CODES}");
            return 0;
        }
        LaunchInput::Version => {
            println!("mdi (admire {})", env!("CARGO_PKG_VERSION"));
            return 0;
        }
        LaunchInput::CommandFile(name) => Some(name),
        LaunchInput::StandardInput => None,
    };
    let ignored = std::env::var("ADMIRE_IGNORE").unwrap_or_default();
    let ignored = match Ignore::parse(&ignored) {
        Ok(ignored) => ignored,
        Err(why) => {
            let message = format!("ADMIRE_IGNORE: {why}");
            let refusal = Diagnostic::error(Code::LauncherRefused, message);
            return refuse(&refusal, &words);
        }
    };
    let mut session = Session::new(console(), Path::new(""))
        .named(&stem)
        .ignoring(ignored);
    for warning in &launch.warnings {
        session.complain(warning);
    }
    let ending: Ending = if let Some(name) = name {
        session.run_file(&name)
    } else {
        session.run_commands(&Source::new("standard input", bytes))
    };
    let strict =
        std::env::var_os("MDI_STRICT").is_some_and(|value| !value.is_empty() && value != "0");
    ending.exit_code(strict)
}
