//! Command files that a program reads or creates.

use std::path::Path;
use std::time::Instant;

use admire_diagnosis::{ProgressObserver, SharedProgress};
use admire_session::Sources;
use admire_syntax::CommandFile;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::text::Source;

use super::deck::Deck;
use super::error::{Complaint, Error, ErrorKind};
use super::run::Run;
use super::writing::{may_replace, replace_file};

/// A command file (`.acf`): the dataset that it loads, and its commands in order.
///
/// ```
/// use admire::{Commands, Deck};
///
/// # fn main() -> Result<(), admire::Error> {
/// let mut commands = Commands::new("");
/// commands.push("SIMULATE/STATICS")?.push("DEACTIVATE/SFORCE, ID=1")?.push("SIMULATE/STATICS")?;
/// assert_eq!(commands.list()[1].arguments[1], ("ID".to_string(), Some("1".to_string())));
///
/// let run = Deck::open("corpus/pseudo-mcpherson/model.adm")?.execute(&commands);
/// run.succeeded()?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Commands {
    file: Checked<CommandFile>,
}

/// One command of a [`Commands`] file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Command {
    /// Keyword in capitals, for example `SIMULATE`; as typed if it is unknown.
    pub keyword: String,
    /// Arguments in order: the keyword in capitals, and the text of the value; a flag has no value.
    pub arguments: Vec<(String, Option<String>)>,
    /// The whole command as typed.
    pub text: String,
    /// Line of the file, from 1.
    pub line: usize,
}

impl Commands {
    /// Reads a command file. Syntax errors are reported by [`check`](Self::check) and by a run that executes the command.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let source = Source::read(path).map_err(|error| Error::unreadable(path, &error))?;
        let file = CommandFile::parse(source);
        Ok(Self { file })
    }

    /// Creates a file without commands. `head` is the first line of the file: the dataset and the prefix of the output files, for example `model.adm
    /// run1`. If `head` is empty, the file contains only commands, which is enough for [`Deck::execute`].
    pub fn new(head: &str) -> Self {
        let head = head.trim();
        let mut text = String::new();
        for word in head.splitn(2, char::is_whitespace).map(str::trim) {
            if !word.is_empty() {
                text += word;
                text.push('\n');
            }
        }
        Self {
            file: read("commands.acf", text.into_bytes(), head.is_empty()),
        }
    }

    /// Returns the name of the dataset that the file loads, as typed; `None` if the file has no first line.
    pub fn model(&self) -> Option<String> {
        let file = &self.file.value;
        file.head()
            .map(|head| file.source().text(head.model).into_owned())
    }

    /// Returns the prefix of the output files, as typed; `None` if there is none.
    pub fn prefix(&self) -> Option<String> {
        let file = &self.file.value;
        let prefix = file.head()?.prefix?;
        Some(file.source().text(prefix).into_owned())
    }

    /// Returns the commands in order.
    pub fn list(&self) -> Vec<Command> {
        let file = &self.file.value;
        let source = file.source();
        let typed = |span| source.text(span).into_owned();
        let command = |statement: &admire_syntax::Statement| Command {
            keyword: statement
                .kind()
                .map_or_else(|| typed(statement.keyword), str::to_string),
            arguments: statement
                .arguments
                .iter()
                .map(|argument| {
                    let name = argument
                        .kind()
                        .map_or_else(|| typed(argument.name), str::to_string);
                    let value = argument.value_span();
                    let flag = value.start() == value.end();
                    (name, (!flag).then(|| typed(value)))
                })
                .collect(),
            text: typed(statement.span),
            line: source.line_column(statement.span.start()).line,
        };
        file.commands().iter().map(command).collect()
    }

    /// Appends one command, for example `SIMULATE/STATICS, END=1, STEPS=10`.
    ///
    /// # Errors
    /// When the text is not exactly one command, or has an error. The file is then unchanged.
    pub fn push(&mut self, text: &str) -> Result<&mut Self, Error> {
        let mut bytes = self.bytes().to_vec();
        if bytes.last().is_some_and(|last| *last != b'\n') {
            bytes.push(b'\n');
        }
        bytes.extend_from_slice(text.trim().as_bytes());
        bytes.push(b'\n');
        let alone = self.file.value.head().is_none();
        let new = read(self.file.value.source().name(), bytes, alone);
        let count = self.file.value.commands().len();
        let fresh: Vec<Diagnostic> = new
            .diagnostics
            .iter()
            .filter(|found| {
                found.severity == Severity::Error && !self.file.diagnostics.contains(found)
            })
            .cloned()
            .collect();
        if !fresh.is_empty() {
            let mut sources = Sources::default();
            sources.add(new.value.source().clone());
            return Err(Error::new(ErrorKind::Usage, &fresh, &sources));
        }
        if new.value.commands().len() != count + 1 {
            let message = format!("`{}` is not exactly one command", text.trim());
            let refused = Diagnostic::error(Code::SyntaxError, message);
            return Err(Error::plain(ErrorKind::Usage, &refused));
        }
        self.file = new;
        Ok(self)
    }

    /// Returns the bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        self.file.value.bytes()
    }

    /// Returns syntax errors and warnings, in the order of the file.
    pub fn check(&self) -> Vec<Complaint> {
        let mut sources = Sources::default();
        sources.add(self.file.value.source().clone());
        let found = self.file.diagnostics.iter();
        found.map(|found| Complaint::new(found, &sources)).collect()
    }

    /// Writes the file. An existing file is replaced only with `replace`.
    ///
    /// # Errors
    /// When the path exists and `replace` is false, or when the file cannot be written.
    pub fn save_as(&self, path: impl AsRef<Path>, replace: bool) -> Result<(), Error> {
        let path = path.as_ref();
        may_replace(path, replace)?;
        replace_file(path, self.bytes()).map_err(|error| Error::unwritable(path, &error))
    }
}

/// Reads the bytes of a command file; `alone` is true if its first line is a command.
fn read(name: &str, bytes: Vec<u8>, alone: bool) -> Checked<CommandFile> {
    let source = Source::new(name, bytes);
    if alone {
        CommandFile::parse_commands(source)
    } else {
        CommandFile::parse(source)
    }
}

impl Deck {
    /// Executes commands on this deck, whichever model they name. No file is written: the run contains the contents of all output files.
    pub fn execute(&self, commands: &Commands) -> Run {
        self.execute_watched(commands, &SharedProgress::default())
    }

    /// Executes commands on this deck as [`execute`](Self::execute) does. The run stops early when `watch` requests it.
    pub fn execute_watched(&self, commands: &Commands, watch: &dyn ProgressObserver) -> Run {
        Run::execute(&self.read, &commands.file, Instant::now(), watch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_file_is_made_saved_and_read_back() {
        let mut commands = Commands::new("model.adm run1");
        commands.push("SIMULATE/STATICS, END=1, STEPS=2").unwrap();
        commands.push("STOP").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.acf");
        commands.save_as(&path, false).unwrap();
        assert_eq!(
            std::fs::read(&path).unwrap(),
            b"model.adm\nrun1\nSIMULATE/STATICS, END=1, STEPS=2\nSTOP\n"
        );
        let kind = commands.save_as(&path, false).unwrap_err().kind;
        assert_eq!(kind, ErrorKind::File(std::io::ErrorKind::AlreadyExists));

        let again = Commands::open(&path).unwrap();
        assert_eq!(again.model().as_deref(), Some("model.adm"));
        assert_eq!(again.prefix().as_deref(), Some("run1"));
        assert!(again.check().is_empty());
        let first = &again.list()[0];
        assert_eq!((first.keyword.as_str(), first.line), ("SIMULATE", 3));
        let value = |text: &str| Some(text.to_string());
        assert_eq!(
            first.arguments,
            [
                ("STATICS".to_string(), None),
                ("END".to_string(), value("1")),
                ("STEPS".to_string(), value("2"))
            ]
        );
    }

    #[test]
    fn what_is_not_one_command_is_refused() {
        let mut commands = Commands::new("");
        for text in [
            "SIMULTE/STATICS",
            "",
            "STOP\nSTOP",
            "SIMULATE/STATICS, ENDD=1",
        ] {
            let refused = commands.push(text).unwrap_err();
            assert_eq!(refused.kind, ErrorKind::Usage, "{text}");
            assert!(commands.list().is_empty());
        }
    }
}
