//! Settings of checks from a file `admire.toml`: which diagnostics are shown, and which files are checked.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use crate::toml_file::read_toml;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::grammar::nearest;
use admire_syntax::text::{Source, Span};

/// The solver for which a deck is checked.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Solver {
    /// ADAMS. Limits of the built-in solver are not reported, and neither are missing files that only graphics or subroutines read.
    Adams,
    /// The built-in solver. Statements that it does not solve are reported. Missing files that only graphics or subroutines read are not
    /// reported, and neither are lines too long for FORTRAN.
    Admire,
}

/// Name of the settings file, which lies in the folder of the decks or in a folder above it.
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

/// Settings that determine which files are checked and which diagnostics are shown.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Solver for which decks are checked. If it is `None`, diagnostics are not filtered by solver.
    pub solver: Option<Solver>,
    /// Codes of the diagnostics that are shown; if the list is empty, all codes are shown.
    pub select: Vec<Code>,
    /// Codes of the diagnostics that are not shown.
    pub ignore: Vec<Code>,
    exclude: Vec<glob::Pattern>,
    /// Folder to which the patterns in `exclude` are relative.
    folder: PathBuf,
    /// True if only errors are shown.
    pub quiet: bool,
    /// True if a check also fails because of warnings.
    pub strict: bool,
    /// True if the decks are for the FORTRAN solver, which reads lines of at most 80 columns.
    pub fortran: bool,
}

impl Settings {
    /// Parses a settings file; the name of the source is its path.
    ///
    /// # Errors
    /// Returns all faults of the file, with their positions.
    pub fn parse(source: &Source) -> Result<Self, Vec<Diagnostic>> {
        let table: Table = read_toml(source, Code::StudySyntax).map_err(|wrong| vec![wrong])?;
        let check = table.check;
        let mut wrong = Vec::new();
        let mut codes = |words: &[Spanned<String>]| -> Vec<Code> {
            words
                .iter()
                .filter_map(|word| match code_named(word.get_ref()) {
                    Ok(code) => Some(code),
                    Err(refused) => {
                        wrong.push(placed(refused, source, word));
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
                    let message = format!("`{}` is not a valid pattern: {error}", word.get_ref());
                    wrong.push(placed(
                        Diagnostic::error(Code::BadSetting, message),
                        source,
                        word,
                    ));
                }
            }
        }
        if !wrong.is_empty() {
            return Err(wrong);
        }
        let folder =
            std::path::absolute(source.name()).unwrap_or_else(|_| PathBuf::from(source.name()));
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

    /// Returns true if a diagnostic is to be shown under these settings.
    pub fn shows(&self, diagnostic: &Diagnostic) -> bool {
        let code = diagnostic.code;
        let selected = self.select.is_empty() || self.select.contains(&code);
        let loud = !self.quiet || diagnostic.severity == Severity::Error;
        selected && loud && !self.ignore.contains(&code) && self.concerns(diagnostic)
    }

    /// Returns true if a file is to be checked under these settings.
    pub fn includes(&self, file: &Path) -> bool {
        let inside = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        let inside = inside.strip_prefix(&self.folder).unwrap_or(&inside);
        !self
            .exclude
            .iter()
            .any(|pattern| pattern.matches_path(inside))
    }

    /// Returns true if a diagnostic is relevant for the chosen solver.
    fn concerns(&self, diagnostic: &Diagnostic) -> bool {
        let code = diagnostic.code;
        let of_pictures = code == Code::CannotRead && diagnostic.severity == Severity::Note;
        let of_ours = matches!(
            code,
            Code::NotSolvedNatively
                | Code::NotSolvedInStatics
                | Code::InactiveInStatics
                | Code::UserSubroutine
                | Code::CarBushing
        );
        match self.solver {
            None => true,
            Some(Solver::Adams) => !of_pictures && !of_ours,
            Some(Solver::Admire) => !of_pictures && code != Code::LineTooLong,
        }
    }
}

/// Returns the nearest settings file in the folder of a file or in a folder above it.
pub fn table_above(file: &Path) -> Option<PathBuf> {
    let file = std::path::absolute(file).ok()?;
    file.ancestors()
        .skip(1)
        .map(|folder| folder.join(NAME))
        .find(|path| path.is_file())
}

/// Returns the diagnostic code with this name.
///
/// # Errors
/// Returns `unknown-key`, with the nearest existing name, if there is no such code.
pub fn code_named(word: &str) -> Result<Code, Diagnostic> {
    Code::parse(word.trim()).ok_or_else(|| {
        let capitals: Vec<String> = Code::ALL
            .iter()
            .map(|code| code.as_str().to_uppercase())
            .collect();
        let near = nearest(word, capitals.iter().map(String::as_str));
        let unknown =
            Diagnostic::error(Code::UnknownKey, format!("`{word}` is not a message code"));
        unknown.help(match near {
            Some(near) => format!("did you mean {}?", near.to_lowercase()),
            None => "each message shows its code, as in error[undefined-id]".to_string(),
        })
    })
}

fn placed(diagnostic: Diagnostic, source: &Source, word: &Spanned<String>) -> Diagnostic {
    let span = word.span();
    diagnostic.label(source.name(), Span::new(span.start, span.end), "")
}
