//! What `admire check` shows: the table of `admire.toml` and the flags of the command line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::grammar::nearest;
use crate::text::{Source, Span};

use super::shell::{Exit, Shell};

/// Who is to solve a deck.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Solver {
    /// ADAMS: what only the built-in solver lacks is not told, nor files that only graphics read.
    Adams,
    /// The built-in solver: what it does not solve is told, files that only graphics read are not.
    Admire,
}

/// Which complaints are shown, and which make the check fail.
#[derive(clap::Args, Clone, Debug, Default)]
pub(super) struct Flags {
    /// Who is to solve the decks. Without it everything is told.
    #[arg(long = "for", value_enum, value_name = "SOLVER")]
    solver: Option<Solver>,
    /// Tell only complaints of these codes: `--select undefined-id,tab`.
    #[arg(long, value_delimiter = ',', value_name = "CODE")]
    select: Vec<String>,
    /// Do not tell complaints of these codes.
    #[arg(long, value_delimiter = ',', value_name = "CODE")]
    ignore: Vec<String>,
    /// Tell errors only.
    #[arg(long, short)]
    quiet: bool,
    /// Warnings make the check fail, too.
    #[arg(long)]
    strict: bool,
    /// The decks are for the FORTRAN solver: also report lines it would cut off.
    #[arg(long)]
    fortran: bool,
    /// Settings to read in place of the `admire.toml` of a file's folder or one above it.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// The file of settings beside decks.
const NAME: &str = "admire.toml";

#[derive(Deserialize, Default, Debug)]
#[serde(deny_unknown_fields)]
struct Table {
    #[serde(default)]
    check: CheckTable,
}

#[derive(Deserialize, Default, Debug)]
#[serde(deny_unknown_fields, default)]
struct CheckTable {
    r#for: Option<Solver>,
    select: Vec<Spanned<String>>,
    ignore: Vec<Spanned<String>>,
    exclude: Vec<Spanned<String>>,
    quiet: bool,
    strict: bool,
    fortran: bool,
}

/// What is shown of the complaints about one file.
#[derive(Clone, Debug, Default)]
pub(super) struct Settings {
    solver: Option<Solver>,
    select: Vec<Code>,
    ignore: Vec<Code>,
    exclude: Vec<glob::Pattern>,
    /// The folder the patterns start from.
    folder: PathBuf,
    quiet: bool,
    pub(super) strict: bool,
    pub(super) fortran: bool,
}

/// The settings of every folder met so far.
pub(super) struct AllSettings<'a> {
    flags: &'a Flags,
    known: BTreeMap<PathBuf, Settings>,
}

impl<'a> AllSettings<'a> {
    pub(super) fn new(flags: &'a Flags) -> Self {
        Self {
            flags,
            known: BTreeMap::new(),
        }
    }

    /// The settings for a file: those of the nearest `admire.toml` above it, and the flags, which come first.
    pub(super) fn of(&mut self, file: &Path, shell: &mut Shell) -> Result<Settings, Exit> {
        let table = match &self.flags.config {
            Some(path) => Some(path.clone()),
            None => above(file),
        };
        let key = table.clone().unwrap_or_default();
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let mut settings = match table {
            Some(path) => read(&path, shell)?,
            None => Settings::default(),
        };
        let flags = self.flags;
        let codes = |words: &[String]| -> Result<Vec<Code>, Exit> {
            words
                .iter()
                .map(|word| code(word).map_err(|refused| shell.usage(refused)))
                .collect()
        };
        let (select, ignore) = (codes(&flags.select)?, codes(&flags.ignore)?);
        if !select.is_empty() {
            settings.ignore.retain(|code| !select.contains(code));
            settings.select = select;
        }
        settings.ignore.extend(ignore);
        settings.solver = flags.solver.or(settings.solver);
        settings.quiet |= flags.quiet;
        settings.strict |= flags.strict;
        settings.fortran |= flags.fortran;
        self.known.insert(key, settings.clone());
        Ok(settings)
    }
}

impl Settings {
    /// True if a complaint is to be told.
    pub(super) fn shows(&self, diagnostic: &Diagnostic) -> bool {
        let code = diagnostic.code;
        let selected = self.select.is_empty() || self.select.contains(&code);
        let loud = !self.quiet || diagnostic.severity == Severity::Error;
        selected && loud && !self.ignore.contains(&code) && self.concerns(diagnostic)
    }

    /// True if a file is to be looked at.
    pub(super) fn includes(&self, file: &Path) -> bool {
        let inside = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        let inside = inside.strip_prefix(&self.folder).unwrap_or(&inside);
        !self
            .exclude
            .iter()
            .any(|pattern| pattern.matches_path(inside))
    }

    /// True if a complaint concerns who is to solve the deck.
    fn concerns(&self, diagnostic: &Diagnostic) -> bool {
        let code = diagnostic.code;
        let of_pictures = code == Code::CannotRead && diagnostic.severity == Severity::Note;
        let of_ours = matches!(
            code,
            Code::NotSolvedNatively | Code::InactiveInStatics | Code::UserSubroutine
        );
        match self.solver {
            None => true,
            Some(Solver::Adams) => !of_pictures && !of_ours,
            Some(Solver::Admire) => !of_pictures && code != Code::LineTooLong,
        }
    }
}

/// The nearest table above a file.
fn above(file: &Path) -> Option<PathBuf> {
    let file = std::path::absolute(file).ok()?;
    file.ancestors()
        .skip(1)
        .map(|folder| folder.join(NAME))
        .find(|path| path.is_file())
}

fn code(word: &str) -> Result<Code, Diagnostic> {
    Code::parse(word.trim()).ok_or_else(|| {
        let capitals: Vec<String> = Code::ALL
            .iter()
            .map(|code| code.as_str().to_uppercase())
            .collect();
        let near = nearest(word, capitals.iter().map(String::as_str));
        let unknown = Diagnostic::error(
            Code::UnknownKey,
            format!("`{word}` is not a code of a complaint"),
        );
        unknown.help(match near {
            Some(near) => format!("did you mean {}?", near.to_lowercase()),
            None => "a complaint shows its code: error[undefined-id]".to_string(),
        })
    })
}

/// Reads a table; says what is wrong with it.
fn read(path: &Path, shell: &mut Shell) -> Result<Settings, Exit> {
    let source = shell.read(path)?;
    let text = source.text(Span::new(0, source.bytes().len()));
    let table = toml::from_str::<Table>(&text).map_err(|error| {
        let span = error
            .span()
            .map_or(Span::at(0), |span| Span::new(span.start, span.end));
        let message = error.message().to_string();
        shell.fail(Diagnostic::error(Code::StudySyntax, message).label(source.name(), span, ""))
    })?;
    let check = table.check;
    let mut wrong = Vec::new();
    let mut codes = |words: &[Spanned<String>]| -> Vec<Code> {
        words
            .iter()
            .filter_map(|word| match code(word.get_ref()) {
                Ok(code) => Some(code),
                Err(refused) => {
                    wrong.push(placed(refused, &source, word));
                    None
                }
            })
            .collect()
    };
    let (select, ignore) = (codes(&check.select), codes(&check.ignore));
    let mut exclude = Vec::new();
    for word in &check.exclude {
        match glob::Pattern::new(word.get_ref()) {
            Ok(pattern) => exclude.push(pattern),
            Err(error) => {
                let message = format!("`{}` is not a pattern: {error}", word.get_ref());
                wrong.push(placed(
                    Diagnostic::error(Code::BadSetting, message),
                    &source,
                    word,
                ));
            }
        }
    }
    if !wrong.is_empty() {
        shell.complain(&wrong);
        return Err(Exit::Findings);
    }
    let folder = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    Ok(Settings {
        solver: check.r#for,
        select,
        ignore,
        exclude,
        folder: folder.parent().map(Path::to_path_buf).unwrap_or_default(),
        quiet: check.quiet,
        strict: check.strict,
        fortran: check.fortran,
    })
}

fn placed(diagnostic: Diagnostic, source: &Source, word: &Spanned<String>) -> Diagnostic {
    let span = word.span();
    diagnostic.label(source.name(), Span::new(span.start, span.end), "")
}
