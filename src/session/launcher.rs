use std::path::Path;

use admire_syntax::diagnostic::{Code, Diagnostic};

/// A parsed command line in the style of the ADAMS launcher.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Launch {
    /// Source of the commands.
    pub input: LaunchInput,
    /// Warnings about words that were skipped.
    pub warnings: Vec<Diagnostic>,
}

/// Source of the commands of a run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum LaunchInput {
    /// Commands are read from a command file. Its name is as written on the command line, but without quotes; the extension `.acf` may be
    /// missing.
    CommandFile(String),
    /// Commands are read from standard input.
    StandardInput,
    /// No commands: the word `--help` requests the help text.
    Help,
    /// No commands: the word `--version` requests the version.
    Version,
}

impl Launch {
    /// Parses the words of the command line after the name of the program. The name itself is ignored, because shims and copies may be
    /// called `mdi`, `mdi.bat`, `adams2024_1` and so on.
    ///
    /// These forms are in use (guide/formats.md 5.4): `-c ru-standard i run.acf exit`, `ru-s b run.acf`, `ru-standard stem`,
    /// `ru-solver run.acf`, `acar ru-solver run.acf`, a bare `stem`, and no words at all (commands on standard input). Words without a
    /// meaning here (`n`, `-t 4`, memory sizes) are skipped with a warning.
    ///
    /// # Errors
    /// Returns an error for forms that only a full ADAMS installation can run. These forms are `ru-user` (a user-written solver library),
    /// products such as `acar` without a solver word after them, and command files of ADAMS/View (`.cmd`).
    pub(crate) fn parse(words: &[String]) -> Result<Self, Diagnostic> {
        let mut warnings = Vec::new();
        let mut file: Option<String> = None;
        let mut runs = false;
        let mut words = words.iter().map(|word| unquote(word)).peekable();
        while let Some(word) = words.next() {
            let lower = word.to_ascii_lowercase();
            match lower.as_str() {
                "" | "-c" | "i" | "b" => {}
                "exit" | "quit" => break,
                "--help" | "-h" | "/?" => return Ok(Self::of(LaunchInput::Help)),
                "--version" => return Ok(Self::of(LaunchInput::Version)),
                // A product name followed by a solver word only starts the solver.
                _ if is_product(&lower) && words.peek().is_some_and(|next| is_run_word(&next.to_ascii_lowercase())) => {}
                "acar" | "aview" | "acarrt" | "atruck" | "adriveline" | "amachinery"
                | "achassis" | "aengine" | "arail" | "aflex" | "aplugin" | "ppt" | "python"
                | "vibration" | "controls" | "durability" | "cr-user" | "cr-u"
                    // After `ru-standard`, the word may be the name of a command file.
                    if !runs =>
                {
                    return Err(refused(
                        word,
                        "that product of the ADAMS installation is not part of admire; \
                        write the dataset and the command file with it, then run them with `ru-standard`",
                    ));
                }
                _ if lower.len() >= 4 && "ru-user".starts_with(lower.as_str())
                    || lower.starts_with("ru-user") =>
                {
                    return Err(refused(
                        word,
                        "a user-written solver library can only be run by ADAMS itself; use `ru-standard`",
                    ));
                }
                _ if is_run_word(&lower) => runs = true,
                _ if lower.starts_with("ru-") || lower.starts_with("cr-") => {
                    return Err(refused(
                        word,
                        "only the standard solver can be run: `ru-standard` or `ru-solver`",
                    ));
                }
                _ if file.is_none() && takes_value(&lower) => {
                    let value = words.next_if(|next| next.bytes().all(|b| b.is_ascii_digit()));
                    warnings.push(skipped(
                        &value.map_or_else(|| word.to_string(), |value| format!("{word} {value}")),
                    ));
                }
                _ if file.is_none() && Path::new(&lower).extension().is_some_and(|e| e == "cmd") => {
                    return Err(refused(
                        word,
                        "it is a command file of ADAMS/View; the solver runs command files that end in .acf",
                    ));
                }
                // The command file itself names its dataset, so a dataset that is also on the command line is skipped.
                _ if file.as_deref().is_some_and(is_dataset) && !is_noise(&lower) && !is_dataset(word) => {
                    warnings.extend(file.replace(word.to_string()).map(|deck| skipped(&deck)));
                }
                _ if is_noise(&lower) || file.is_some() => warnings.push(skipped(word)),
                _ => file = Some(word.to_string()),
            }
        }
        let input = match file {
            Some(file) => {
                if !runs && !file.to_ascii_lowercase().ends_with(".acf") {
                    // FAST-era wrapper scripts give only the name of the program and the stem of the command file.
                    warnings.push(Diagnostic::note(
                        Code::LauncherWord,
                        format!("no `ru-standard` on the command line: `{file}` is taken as the command file"),
                    ));
                }
                LaunchInput::CommandFile(file)
            }
            None => LaunchInput::StandardInput,
        };
        Ok(Self { input, warnings })
    }

    /// Parses standard input that answers the menus of the ADAMS launcher: `ru-standard`, `i`, the command file and `exit`, each on a line.
    ///
    /// The first of these words may already be on the command line. Returns `None` if the input begins in another way; it then consists of
    /// solver commands.
    pub(crate) fn of_menu(text: &str) -> Option<Result<Self, Diagnostic>> {
        let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let first = lines.next()?;
        let known = |word: &str| {
            let lower = unquote(word).to_ascii_lowercase();
            is_run_word(&lower) || is_product(&lower) || lower.starts_with("ru-") || lower == "-c"
        };
        // The first line of solver commands may name a dataset, but never a command file.
        let lower = unquote(first).to_ascii_lowercase();
        let goes_on = matches!(lower.as_str(), "i" | "b")
            || Path::new(&lower)
                .extension()
                .is_some_and(|end| end == "acf")
                && !lower.contains('=');
        if !goes_on && !first.split_whitespace().next().is_some_and(known) {
            return None;
        }
        let mut words: Vec<String> = Vec::new();
        for line in std::iter::once(first).chain(lines) {
            // A line that does not begin with a known word is a file name, which may contain blanks.
            let several = line.split_whitespace().next().is_some_and(known);
            if several {
                words.extend(line.split_whitespace().map(str::to_string));
            } else {
                words.push(line.to_string());
            }
        }
        Some(Self::parse(&words))
    }

    /// Returns the stem of the message file that is used until a model gives it another name: the stem of the command file on the command
    /// line.
    pub(crate) fn stem(words: &[String]) -> String {
        let is_file = |word: &&str| {
            let lower = word.to_ascii_lowercase();
            [".acf", ".cmd"].iter().any(|end| lower.ends_with(end))
        };
        let named = match Self::parse(words).map(|launch| launch.input) {
            Ok(LaunchInput::CommandFile(file)) => Some(file),
            _ => words
                .iter()
                .map(|word| unquote(word))
                .find(is_file)
                .map(str::to_string),
        };
        let name = named
            .as_deref()
            .and_then(|name| name.rsplit(['/', '\\']).next());
        let stem = name.map(|name| name.rsplit_once('.').map_or(name, |(stem, _)| stem));
        stem.filter(|stem| !stem.is_empty())
            .unwrap_or("adams")
            .to_string()
    }

    fn of(input: LaunchInput) -> Self {
        Self {
            input,
            warnings: Vec::new(),
        }
    }
}

/// Removes the quotes that a Windows `system()` call may leave around a word.
fn unquote(word: &str) -> &str {
    let word = word.trim();
    for quote in ['"', '\''] {
        if let Some(inner) = word
            .strip_prefix(quote)
            .and_then(|rest| rest.strip_suffix(quote))
        {
            return inner;
        }
    }
    word
}

/// Returns true for the solver words `ru-standard` and `ru-solver`, and for their abbreviations of at least four letters.
fn is_run_word(lower: &str) -> bool {
    lower.len() >= 4
        && ["ru-standard", "ru-solver"]
            .iter()
            .any(|whole| whole.starts_with(lower))
}

/// Returns true for names of ADAMS products that may precede a solver word.
fn is_product(lower: &str) -> bool {
    matches!(
        lower,
        "acar"
            | "aview"
            | "acarrt"
            | "atruck"
            | "adriveline"
            | "amachinery"
            | "achassis"
            | "aengine"
            | "arail"
            | "aflex"
            | "aplugin"
            | "vibration"
            | "controls"
            | "durability"
    )
}

/// Returns true if the name has the extension of a dataset, `.adm`.
pub(super) fn is_dataset(name: &str) -> bool {
    let extension = Path::new(name).extension();
    extension.is_some_and(|end| end.eq_ignore_ascii_case("adm"))
}

/// Returns true for launcher options that are followed by a number.
fn takes_value(lower: &str) -> bool {
    matches!(lower, "-t" | "-n" | "-nt" | "-m" | "-mem" | "-memory")
}

/// Returns true for answers to menus of old launchers and for memory sizes: options, single letters, numbers, `16mb`, `large`.
fn is_noise(lower: &str) -> bool {
    let digits = lower.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let sized = !digits.is_empty()
        && digits.bytes().all(|b| b.is_ascii_digit())
        && matches!(
            &lower[digits.len()..],
            "" | "k" | "kb" | "m" | "mb" | "g" | "gb" | "w" | "mw"
        );
    lower.starts_with('-')
        || matches!(
            lower,
            "n" | "y" | "no" | "yes" | "standard" | "large" | "huge"
        )
        || sized
}

fn skipped(word: &str) -> Diagnostic {
    Diagnostic::warning(
        Code::LauncherWord,
        format!("the word `{word}` of the command line is unknown and is ignored"),
    )
}

fn refused(word: &str, why: &str) -> Diagnostic {
    Diagnostic::error(
        Code::LauncherRefused,
        format!("`{word}` cannot be run by this solver"),
    )
    .help(why)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &[&str]) -> Result<Launch, Diagnostic> {
        Launch::parse(&line.iter().map(ToString::to_string).collect::<Vec<_>>())
    }

    fn file(line: &[&str]) -> String {
        match parse(line).unwrap().input {
            LaunchInput::CommandFile(file) => file,
            other => panic!("{line:?}: {other:?}"),
        }
    }

    #[test]
    fn the_forms_in_the_wild_name_their_command_file() {
        // These forms are listed in guide/formats.md 5.4.
        for line in [
            &["-c", "ru-standard", "i", "run.acf", "exit"][..],
            &["ru-s", "b", "run.acf"],
            &["ru-s", "i", "run.acf"],
            &["ru-s", "\"run.acf\""],
            &["ru-st", "run.acf", "exit"],
            &["ru-solver", "run.acf"],
            &["RU-STANDARD", "I", "run.acf", "EXIT"],
            &["run.acf"],
            &["acar", "ru-solver", "run.acf"],
            &["aview", "ru-st", "b", "run.acf"],
            &["-c", "ACAR", "RU-STANDARD", "I", "run.acf", "EXIT"],
        ] {
            assert_eq!(file(line), "run.acf", "{line:?}");
            assert!(parse(line).unwrap().warnings.is_empty(), "{line:?}");
        }
        assert_eq!(file(&["ru-standard", "stem"]), "stem");
        for both in [["x.adm", "x.acf"], ["x.acf", "x.adm"], ["X.ADM", "x.acf"]] {
            let line = [&["ru-standard", "b"][..], &both].concat();
            assert_eq!(file(&line), "x.acf");
            assert_eq!(parse(&line).unwrap().warnings.len(), 1);
        }
        assert_eq!(
            file(&["-c", "ru-standard", "i", r"C:\my runs\a b.acf", "exit"]),
            r"C:\my runs\a b.acf"
        );
    }

    #[test]
    fn unknown_words_are_skipped_with_a_warning() {
        let launch = parse(&[
            "-t",
            "4",
            "-c",
            "ru-standard",
            "n",
            "16mb",
            "i",
            "run.acf",
            "more",
            "exit",
        ])
        .unwrap();
        assert_eq!(launch.input, LaunchInput::CommandFile("run.acf".into()));
        let said: Vec<_> = launch.warnings.iter().map(|w| w.message.as_str()).collect();
        assert_eq!(said.len(), 4, "{said:?}");
        for (word, message) in ["`-t 4`", "`n`", "`16mb`", "`more`"].iter().zip(&said) {
            assert!(message.contains(word), "{message}");
        }
    }

    #[test]
    fn no_file_means_standard_input() {
        for line in [
            &[][..],
            &["-c"],
            &["-c", "ru-standard", "i", "exit"],
            &["ru-s"],
        ] {
            assert_eq!(
                parse(line).unwrap().input,
                LaunchInput::StandardInput,
                "{line:?}"
            );
        }
    }

    #[test]
    fn answers_to_menus_are_a_command_line_one_word_to_a_line() {
        let menu = |text: &str| Launch::of_menu(text).map(|launch| launch.unwrap().input);
        let run = Some(LaunchInput::CommandFile("my run.acf".into()));
        assert_eq!(menu("ru-standard\ni\nmy run.acf\nexit\n"), run);
        assert_eq!(menu("\r\nacar\r\nRU-SOLVER\r\nI\r\nmy run.acf\r\n"), run);
        assert_eq!(menu("-c ru-s i\nmy run.acf\n"), run);
        assert_eq!(menu("i\nmy run.acf\nexit\n"), run);
        assert_eq!(menu("my run.acf\nexit\n"), run);
        for commands in [
            "file/model=a\nsimulate/statics\n",
            "a\na\nSTOP\n",
            "",
            "! a comment\n",
            "file/command=other.acf\n",
        ] {
            assert_eq!(menu(commands), None, "{commands}");
        }
        assert!(
            Launch::of_menu("ru-user\ni\nlib\nrun.acf\n")
                .unwrap()
                .is_err()
        );
    }

    #[test]
    fn user_libraries_and_other_products_are_refused_by_name() {
        for line in [
            &["-c", "ru-user", "i", "my.so", "run.acf", "exit"][..],
            &["acar", "ru-acar", "b", "x.cmd"],
            &["aview", "ru-st", "b", "x.cmd"],
            &["acar", "run.acf"],
            &["ru-u", "lib", "run.acf"],
            &["ru-acar", "x.acf"],
        ] {
            let refusal = parse(line).unwrap_err();
            assert_eq!(refusal.code, Code::LauncherRefused);
            let named = line.iter().find(|w| refusal.message.contains(**w));
            assert!(named.is_some(), "{}", refusal.message);
        }
    }
}
