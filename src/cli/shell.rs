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
use super::pager;
use super::render;
use super::width::{WIDTH, wrapped};

/// Use of colours.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub(super) enum ColorChoice {
    /// On a terminal, unless NO_COLOR is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// Amount of output besides the result of a command.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Verbosity {
    /// Diagnostics only.
    Quiet,
    /// Usual remarks.
    Usual,
    /// Every stage, even without a terminal.
    Verbose,
}

/// Exit code of the process.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Exit {
    /// Success.
    Fine = 0,
    /// The input has errors, a file cannot be read or written, or a comparison found differences.
    Findings = 1,
    /// The command line is wrong.
    Usage = 2,
    /// There is no equilibrium, or no fit.
    NoAnswer = 3,
    /// Ctrl-C ended the run; the results so far are written.
    Interrupted = 130,
}

impl Exit {
    /// Returns the exit with this code.
    pub(super) fn of_code(code: u8) -> Self {
        match code {
            0 => Self::Fine,
            1 => Self::Findings,
            2 => Self::Usage,
            _ => Self::NoAnswer,
        }
    }
}

/// State shared by all subcommands: output settings, and the files read so far.
pub(super) struct Shell {
    pub(super) format: Format,
    color: ColorChoice,
    verbosity: Verbosity,
    pub(super) sources: Sources,
    /// Encoding of output that does not go to a terminal, as a code page.
    page: CodePage,
    /// First error in writing to standard output, because of which output was lost.
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

    /// Sets the encoding of output to the code page that the environment requests.
    pub(super) fn obey_code_page(&mut self) -> Result<(), Exit> {
        let page = CodePage::of_environment();
        self.page = page.map_err(|why| self.usage(Diagnostic::error(Code::CannotWrite, why)))?;
        Ok(())
    }

    /// Encodes a text for a stream; a terminal always gets UTF-8.
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

    /// Prints diagnostics on standard error; a quiet command omits notes and prints only warnings and errors.
    pub(super) fn complain(&self, diagnostics: &[Diagnostic]) {
        let counts = |found: &&Diagnostic| !self.is_quiet() || found.severity > Severity::Note;
        let diagnostics: Vec<Diagnostic> = diagnostics.iter().filter(counts).cloned().collect();
        let diagnostics = diagnostics.as_slice();
        if diagnostics.is_empty() {
            return;
        }
        let terminal = std::io::stderr().is_terminal();
        let sources = self.with_streamed(diagnostics);
        let (colours, width) = (self.colours(terminal), width_of(terminal));
        let text = render::diagnostics(diagnostics, &sources, self.format, colours, width);
        // Errors are ignored, because the reader may have closed the stream.
        let _ = std::io::stderr().write_all(&self.encoded(&text, terminal));
    }

    /// Returns the sources with the files that the diagnostics name, so that places can be shown in files that were read step by step and
    /// not kept. Huge files are not read again.
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

    /// Prints a remark on standard error.
    pub(super) fn say(&self, text: &str) {
        if self.format == Format::Text && self.verbosity != Verbosity::Quiet {
            // Errors are ignored, because the reader may have closed the stream.
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

    /// Prints a remark on standard error if the command is verbose.
    pub(super) fn detail(&self, text: &str) {
        if self.is_verbose() {
            self.say(text);
        }
    }

    /// Returns true if progress is shown: standard error is a terminal and the command is not quiet.
    pub(super) fn shows_progress(&self) -> bool {
        self.format == Format::Text
            && self.verbosity != Verbosity::Quiet
            && std::io::stderr().is_terminal()
    }

    /// Returns true if only diagnostics and the result are printed.
    pub(super) fn is_quiet(&self) -> bool {
        self.verbosity == Verbosity::Quiet
    }

    /// Returns true if every stage is printed.
    pub(super) fn is_verbose(&self) -> bool {
        self.verbosity == Verbosity::Verbose
    }

    /// Prints diagnostics on standard output, for commands whose result consists of diagnostics.
    pub(super) fn findings(&self, diagnostics: &[Diagnostic]) {
        let terminal = std::io::stdout().is_terminal();
        let sources = self.with_streamed(diagnostics);
        let (colours, width) = (self.colours(terminal), width_of(terminal));
        let text = render::diagnostics(diagnostics, &sources, self.format, colours, width);
        self.put(&self.encoded(&text, terminal));
    }

    /// Prints a text on standard output. Control sequences that come from files are made harmless.
    pub(super) fn print(&self, text: &str) {
        let text = printable(text);
        self.put(&self.encoded(&text, std::io::stdout().is_terminal()));
    }

    /// Prints a long text: on a terminal with the pager of the user.
    pub(super) fn page(&self, text: &str) {
        if !pager::shows(&printable(text)) {
            self.print(text);
        }
    }

    /// Prints sentences on standard output. On a terminal they are wrapped to its width; elsewhere they are not wrapped.
    pub(super) fn tell(&self, text: &str) {
        if self.format == Format::Text && std::io::stdout().is_terminal() {
            self.print(&wrapped(text));
        } else {
            self.print(text);
        }
    }

    /// Writes bytes to standard output. A closed pipe is ignored; any other error changes the exit code.
    fn put(&self, bytes: &[u8]) {
        let mut out = std::io::stdout().lock();
        self.printed(out.write_all(bytes).and_then(|()| out.flush()));
    }

    /// Records the outcome of writing to standard output. A closed pipe does not count as an error.
    pub(super) fn printed(&self, outcome: std::io::Result<()>) {
        if let Err(error) = outcome
            && error.kind() != ErrorKind::BrokenPipe
        {
            self.lost.borrow_mut().get_or_insert(error);
        }
    }

    /// Returns the exit code of the process, which indicates failure if output was lost.
    pub(super) fn exit(&self, exit: Exit) -> Exit {
        let Some(error) = self.lost.take() else {
            return exit;
        };
        let message = format!("standard output cannot be written: {error}");
        exit.max(self.fail(Diagnostic::error(Code::CannotWrite, message)))
    }

    /// Reports a fault of the input and returns the exit code.
    pub(super) fn fail(&self, diagnostic: Diagnostic) -> Exit {
        self.complain(&[diagnostic]);
        Exit::Findings
    }

    /// Reports a fault of the command line and returns the exit code.
    pub(super) fn usage(&self, diagnostic: Diagnostic) -> Exit {
        self.complain(&[diagnostic]);
        Exit::Usage
    }

    /// Reads a file and stores it, so that diagnostics can show places in it. `-` is standard input.
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

    /// Reads a file that may be replaced afterwards. With `in_place`, a device or a pipe is refused, because reading a pipe would wait for
    /// a writer.
    pub(super) fn read_for(&mut self, path: &Path, in_place: bool) -> Result<Source, Exit> {
        if in_place && std::fs::metadata(path).is_ok_and(|there| !there.is_file()) {
            return Err(self.fail(Diagnostic::error(
                Code::CannotWrite,
                format!(
                    "`{}` is not a regular file, so it cannot be replaced in place",
                    path.display()
                ),
            )));
        }
        self.read(path)
    }

    /// Reads the files that a dataset names and stores them, so that diagnostics can show places in them. The files must be below the
    /// dataset's own folder, the working directory or a folder in ADMIRE_ALLOW_PATH.
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

    /// Writes bytes to a file, or to standard output if no file is given. On a terminal, control sequences are made harmless.
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

    /// Writes a file atomically: the bytes go to a temporary file in the same folder, which then replaces the file.
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

/// Returns the width in columns for diagnostics: [`WIDTH`] on a terminal, 100 elsewhere.
fn width_of(terminal: bool) -> usize {
    if terminal { WIDTH } else { 100 }
}

/// Returns true if the terminal supports colours: it is neither a "dumb" terminal nor a Windows console without colour codes.
fn takes_colours() -> bool {
    if cfg!(windows) {
        return anstyle_query::windows::enable_ansi_colors() == Some(true);
    }
    std::env::var_os("TERM").is_none_or(|kind| kind != "dumb")
}

/// Returns the exit code for diagnostics: [`Exit::Findings`] if one of them is an error, otherwise [`Exit::Fine`].
pub(super) fn exit_of(diagnostics: &[Diagnostic]) -> Exit {
    if diagnostics.iter().any(|d| d.severity == Severity::Error) {
        Exit::Findings
    } else {
        Exit::Fine
    }
}
