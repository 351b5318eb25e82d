use std::borrow::Cow;
use std::cell::RefCell;
use std::io::{ErrorKind, IsTerminal, Read, Write};
use std::path::Path;

use crate::front::replace_file;
use admire_session::{FilePolicy, Sources, check_name, folder_of, read_files};
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::files::Files;
use admire_syntax::text::{CodePage, Source, check_size, printable};

use super::format::Format;
use super::render;
use super::width::{WIDTH, wrapped};

/// When to colour.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub(super) enum ColorChoice {
    /// On a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// How much is said beside the answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Verbosity {
    /// Complaints only.
    Quiet,
    /// What a person wants to know.
    Usual,
    /// Every stage, also where no terminal is.
    Verbose,
}

/// What the process returns.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Exit {
    /// All went well.
    Fine = 0,
    /// The input has errors, a file cannot be read or written, or a comparison found differences.
    Findings = 1,
    /// The command line is wrong.
    Usage = 2,
    /// There is no equilibrium, or no fit.
    NoAnswer = 3,
    /// Ctrl-C ended the run; what it had found is written.
    Interrupted = 130,
}

impl Exit {
    /// The exit with this code.
    pub(super) fn of_code(code: u8) -> Self {
        match code {
            0 => Self::Fine,
            1 => Self::Findings,
            2 => Self::Usage,
            _ => Self::NoAnswer,
        }
    }
}

/// What every subcommand shares: how to print, and the files read so far.
pub(super) struct Shell {
    pub(super) format: Format,
    color: ColorChoice,
    verbosity: Verbosity,
    pub(super) sources: Sources,
    /// How text is printed where there is no terminal.
    page: CodePage,
    /// Why some of the answer did not reach standard output.
    lost: RefCell<Option<std::io::Error>>,
}

impl Shell {
    pub(super) fn new(format: Format, color: ColorChoice, verbosity: Verbosity) -> Self {
        Self {
            format,
            color,
            verbosity,
            sources: Sources::default(),
            page: CodePage::Utf8,
            lost: RefCell::default(),
        }
    }

    /// Prints in the code page that the environment asks for.
    pub(super) fn obey_code_page(&mut self) -> Result<(), Exit> {
        let page = CodePage::of_environment();
        self.page = page.map_err(|why| self.usage(Diagnostic::error(Code::CannotWrite, why)))?;
        Ok(())
    }

    /// What is sent to a stream to show a text.
    fn encoded<'a>(&self, text: &'a str, terminal: bool) -> Cow<'a, [u8]> {
        let page = if terminal { CodePage::Utf8 } else { self.page };
        page.encode(text)
    }

    fn colours(&self, terminal: bool) -> bool {
        match self.color {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => {
                terminal
                    && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
                    && takes_colours()
            }
        }
    }

    /// Prints complaints on standard error; of a quiet command no notes.
    pub(super) fn complain(&self, diagnostics: &[Diagnostic]) {
        let counts = |found: &&Diagnostic| !self.is_quiet() || found.severity > Severity::Note;
        let diagnostics: Vec<Diagnostic> = diagnostics.iter().filter(counts).cloned().collect();
        let diagnostics = diagnostics.as_slice();
        if diagnostics.is_empty() {
            return;
        }
        let terminal = std::io::stderr().is_terminal();
        let sources = self.with_streamed(diagnostics);
        let how = (self.colours(terminal), width_of(terminal));
        let text = render::diagnostics(diagnostics, &sources, self.format, how);
        // Nobody may be listening.
        let _ = std::io::stderr().write_all(&self.encoded(&text, terminal));
    }

    /// The files of complaints, those too that are read step by step and not kept: to show the place in them. Huge ones are not
    /// read again for that.
    fn with_streamed(&self, diagnostics: &[Diagnostic]) -> Sources {
        let mut sources = self.sources.clone();
        for label in diagnostics.iter().flat_map(|found| &found.labels) {
            let path = Path::new(&*label.file);
            let small = || {
                std::fs::metadata(path)
                    .is_ok_and(|m| m.is_file() && m.len() < render::LARGEST_SHOWN as u64)
            };
            if sources.get(&label.file).is_none()
                && small()
                && let Ok(source) = Source::read(path)
            {
                sources.add(source.in_utf8());
            }
        }
        sources
    }

    /// Says something on standard error, beside the answer.
    pub(super) fn say(&self, text: &str) {
        if self.format == Format::Text && self.verbosity != Verbosity::Quiet {
            // Nobody may be listening.
            let terminal = std::io::stderr().is_terminal();
            let text = printable(text);
            let text = if terminal {
                Cow::Owned(wrapped(&text))
            } else {
                text
            };
            let _ = std::io::stderr().write_all(&self.encoded(&text, terminal));
        }
    }

    /// True if a person watches standard error.
    pub(super) fn shows_progress(&self) -> bool {
        self.format == Format::Text
            && self.verbosity != Verbosity::Quiet
            && std::io::stderr().is_terminal()
    }

    /// True if nothing but complaints and the answer is wanted.
    pub(super) fn is_quiet(&self) -> bool {
        self.verbosity == Verbosity::Quiet
    }

    /// True if every stage is wanted.
    pub(super) fn is_verbose(&self) -> bool {
        self.verbosity == Verbosity::Verbose
    }

    /// Prints complaints on standard output: where they are what was asked for.
    pub(super) fn findings(&self, diagnostics: &[Diagnostic]) {
        let terminal = std::io::stdout().is_terminal();
        let sources = self.with_streamed(diagnostics);
        let how = (self.colours(terminal), width_of(terminal));
        let text = render::diagnostics(diagnostics, &sources, self.format, how);
        self.put(&self.encoded(&text, terminal));
    }

    /// Prints on standard output. What files brought cannot command the terminal.
    pub(super) fn print(&self, text: &str) {
        let text = printable(text);
        self.put(&self.encoded(&text, std::io::stdout().is_terminal()));
    }

    /// Prints sentences on standard output: on a terminal in lines of its width, elsewhere each in one line.
    pub(super) fn tell(&self, text: &str) {
        if self.format == Format::Text && std::io::stdout().is_terminal() {
            self.print(&wrapped(text));
        } else {
            self.print(text);
        }
    }

    /// Bytes on standard output. A closed pipe ends nothing; what a full disk swallowed is remembered for the exit code.
    fn put(&self, bytes: &[u8]) {
        let mut out = std::io::stdout().lock();
        self.printed(out.write_all(bytes).and_then(|()| out.flush()));
    }

    /// Remembers that something could not be printed.
    pub(super) fn printed(&self, outcome: std::io::Result<()>) {
        if let Err(error) = outcome
            && error.kind() != ErrorKind::BrokenPipe
        {
            self.lost.borrow_mut().get_or_insert(error);
        }
    }

    /// What the process returns: a lost answer is never fine.
    pub(super) fn exit(&self, exit: Exit) -> Exit {
        let Some(error) = self.lost.take() else {
            return exit;
        };
        let message = format!("standard output cannot be written: {error}");
        exit.max(self.fail(Diagnostic::error(Code::CannotWrite, message)))
    }

    /// Says what is wrong with the input, and gives up.
    pub(super) fn fail(&self, diagnostic: Diagnostic) -> Exit {
        self.complain(&[diagnostic]);
        Exit::Findings
    }

    /// Says what is wrong with the command line, and gives up.
    pub(super) fn usage(&self, diagnostic: Diagnostic) -> Exit {
        self.complain(&[diagnostic]);
        Exit::Usage
    }

    /// Reads a file and remembers it for showing places in it; `-` is standard input.
    pub(super) fn read(&mut self, path: &Path) -> Result<Source, Exit> {
        let source = if path == Path::new("-") {
            let mut bytes = Vec::new();
            let most = Source::LARGEST + 1;
            std::io::Read::take(std::io::stdin(), most)
                .read_to_end(&mut bytes)
                .and_then(|size| check_size(size as u64, Source::LARGEST))
                .map(|()| Source::new("-", bytes))
        } else {
            check_name(&path.to_string_lossy())
                .map_err(std::io::Error::other)
                .and_then(|()| Source::read(path))
        };
        match source {
            Ok(source) => {
                self.sources.add(source.clone());
                Ok(source)
            }
            Err(error) => Err(self.fail(Diagnostic::error(
                Code::CannotRead,
                format!("`{}` cannot be read: {error}", path.display()),
            ))),
        }
    }

    /// Reads a file that may be replaced afterwards: with `in_place`, what is no file (a pipe, which would wait for a writer, or a
    /// device) is refused.
    pub(super) fn read_for(&mut self, path: &Path, in_place: bool) -> Result<Source, Exit> {
        if in_place && std::fs::metadata(path).is_ok_and(|there| !there.is_file()) {
            return Err(self.fail(Diagnostic::error(
                Code::CannotWrite,
                format!(
                    "`{}` is no file that could be replaced in place",
                    path.display()
                ),
            )));
        }
        self.read(path)
    }

    /// Reads the files a dataset names, below its own folder, the working directory and where ADMIRE_ALLOW_PATH says, and remembers
    /// them for showing places in them.
    pub(super) fn read_files(&mut self, dataset: &Dataset) -> Checked<Files> {
        let folder = folder_of(dataset.source());
        let mut policy = FilePolicy::new(Path::new(""));
        policy.allow(&folder);
        policy.confine();
        let read = read_files(dataset, &folder, &policy);
        for source in read.value.sources() {
            self.sources.add(source.clone());
        }
        read
    }

    /// Writes bytes to a file, or to standard output if there is none. What they hold cannot command a terminal.
    pub(super) fn deliver(&self, target: Option<&Path>, bytes: &[u8]) -> Result<(), Exit> {
        if let Some(path) = target.filter(|path| *path != Path::new("-")) {
            return self.write(path, bytes);
        }
        if std::io::stdout().is_terminal() {
            self.print(&String::from_utf8_lossy(bytes));
        } else {
            self.put(bytes);
        }
        Ok(())
    }

    /// Writes a file whole or not at all: through a temporary file beside it that takes its place.
    pub(super) fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Exit> {
        if path == Path::new("-") {
            let message = "standard input cannot be replaced";
            return Err(self.usage(
                Diagnostic::error(Code::CannotWrite, message).help("name a file to write to"),
            ));
        }
        replace_file(path, bytes).map_err(|error| {
            self.fail(Diagnostic::error(
                Code::CannotWrite,
                format!("`{}` cannot be written: {error}", path.display()),
            ))
        })
    }
}

/// In which width complaints are shown: a terminal may have no more columns than [`WIDTH`].
fn width_of(terminal: bool) -> usize {
    if terminal { WIDTH } else { 100 }
}

/// True if the terminal understands colours: it is no "dumb" one, and no console of Windows that would show their codes as text.
fn takes_colours() -> bool {
    if cfg!(windows) {
        return anstyle_query::windows::enable_ansi_colors() == Some(true);
    }
    std::env::var_os("TERM").is_none_or(|kind| kind != "dumb")
}

/// Findings when any complaint is an error.
pub(super) fn exit_of(diagnostics: &[Diagnostic]) -> Exit {
    if diagnostics.iter().any(|d| d.severity == Severity::Error) {
        Exit::Findings
    } else {
        Exit::Fine
    }
}
