use crate::diagnostic::{Code, Diagnostic};

/// What a command line in ADAMS' style asks for.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Launch {
    /// Where the commands come from.
    pub input: LaunchInput,
    /// Words that were skipped.
    pub warnings: Vec<Diagnostic>,
}

/// Where the commands of a run come from.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum LaunchInput {
    /// A command file, as written on the command line, quotes removed; `.acf` may be missing.
    CommandFile(String),
    /// Commands on standard input.
    StandardInput,
    /// `--help`.
    Help,
    /// `--version`.
    Version,
}

impl Launch {
    /// Reads the words after the program's name. The program's own name says nothing: shims and copies are called `mdi`,
    /// `mdi.bat`, `adams2024_1` and so on.
    ///
    /// Forms in the wild (ADAMS-FORMATS 5.4): `-c ru-standard i run.acf exit`, `ru-s b run.acf`, `ru-standard stem`,
    /// `ru-solver run.acf`, a bare `stem`, and nothing at all (commands on standard input). Words nobody knows (`n`, `-t 4`,
    /// memory sizes) are skipped with a warning.
    ///
    /// # Errors
    /// A form only a full ADAMS installation can run: `ru-user` (a user-written solver library) and products such as `acar`.
    pub fn parse(words: &[String]) -> Result<Self, Diagnostic> {
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
                "acar" | "aview" | "acarrt" | "atruck" | "adriveline" | "amachinery"
                | "achassis" | "aengine" | "arail" | "aflex" | "aplugin" | "ppt" | "python"
                | "vibration" | "controls" | "durability" | "cr-user" | "cr-u"
                    // After `ru-standard` it is a command file of that name.
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
                _ if is_noise(&lower) || file.is_some() => warnings.push(skipped(word)),
                _ => file = Some(word.to_string()),
            }
        }
        let input = match file {
            Some(file) => {
                if !runs && !file.to_ascii_lowercase().ends_with(".acf") {
                    // FAST-era wrappers: the program's name, then the stem of the command file.
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

    fn of(input: LaunchInput) -> Self {
        Self {
            input,
            warnings: Vec::new(),
        }
    }
}

/// Without the quotes that a Windows `system()` call may leave around a word.
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

/// `ru-standard` and its abbreviations down to `ru-s`, and `ru-solver`.
fn is_run_word(lower: &str) -> bool {
    lower.len() >= 4
        && ["ru-standard", "ru-solver"]
            .iter()
            .any(|whole| whole.starts_with(lower))
}

/// Options of the launcher that carry a number.
fn takes_value(lower: &str) -> bool {
    matches!(lower, "-t" | "-n" | "-nt" | "-m" | "-mem" | "-memory")
}

/// Answers to old menus and memory sizes: options, single letters, numbers, `16mb`, `large`.
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
        format!("the word `{word}` of the command line is not known here and is skipped"),
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
        // ADAMS-FORMATS 5.4.
        for line in [
            &["-c", "ru-standard", "i", "run.acf", "exit"][..],
            &["ru-s", "b", "run.acf"],
            &["ru-s", "i", "run.acf"],
            &["ru-s", "\"run.acf\""],
            &["ru-st", "run.acf", "exit"],
            &["ru-solver", "run.acf"],
            &["RU-STANDARD", "I", "run.acf", "EXIT"],
            &["run.acf"],
        ] {
            assert_eq!(file(line), "run.acf", "{line:?}");
            assert!(parse(line).unwrap().warnings.is_empty(), "{line:?}");
        }
        assert_eq!(file(&["ru-standard", "stem"]), "stem");
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
    fn user_libraries_and_other_products_are_refused_by_name() {
        for line in [
            &["-c", "ru-user", "i", "my.so", "run.acf", "exit"][..],
            &["acar", "ru-solver", "run.acf"],
            &["acar", "ru-acar", "b", "x.cmd"],
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
