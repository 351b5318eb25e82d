use std::path::Path;

use admire_session::file_below;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Diagnostics of a SWEEP.toml, each at its place in the file.
#[derive(Default)]
pub(super) struct CollectedDiagnostics {
    pub(super) file: String,
    pub(super) all: Vec<Diagnostic>,
}

impl CollectedDiagnostics {
    /// Adds an error at a place of SWEEP.toml.
    pub(super) fn wrong(&mut self, code: Code, span: std::ops::Range<usize>, message: &str) {
        let diagnostic =
            Diagnostic::error(code, message).label(self.file.as_str(), Span::from(span), "");
        self.all.push(diagnostic);
    }

    /// Adds a diagnostic from another reader. Its label is moved to the place in SWEEP.toml that contains the text.
    pub(super) fn refused(&mut self, span: std::ops::Range<usize>, mut why: Diagnostic) {
        why.labels.clear();
        self.all
            .push(why.label(self.file.as_str(), Span::from(span), ""));
    }

    /// Adds help to the last diagnostic.
    pub(super) fn help(&mut self, text: &str) {
        if let Some(last) = self.all.pop() {
            self.all.push(last.help(text));
        }
    }

    /// Resolves the path of a file or folder that is named in SWEEP.toml. The path must be below the folder of SWEEP.toml.
    pub(super) fn below(
        &mut self,
        folder: &Path,
        name: &toml::Spanned<String>,
    ) -> Option<std::path::PathBuf> {
        let found = file_below(folder, name.get_ref(), "sweep");
        for told in found.diagnostics {
            self.all
                .push(told.label(self.file.as_str(), Span::from(name.span()), ""));
        }
        found.value
    }

    /// Reads a file that is named in SWEEP.toml. The file must be below the folder of SWEEP.toml.
    pub(super) fn file(&mut self, folder: &Path, name: &toml::Spanned<String>) -> Option<Source> {
        let path = self.below(folder, name)?;
        self.source(&path, Some(name.span()))
    }

    /// Reads a file from any folder. Errors are reported at `span` in SWEEP.toml, or without a place if `span` is `None`.
    pub(super) fn source(
        &mut self,
        path: &Path,
        span: Option<std::ops::Range<usize>>,
    ) -> Option<Source> {
        match Source::read(path) {
            Ok(source) => Some(source),
            Err(error) => {
                let message = format!("`{}` cannot be read: {error}", path.display());
                match span {
                    Some(span) => self.wrong(Code::CannotRead, span, &message),
                    None => self.all.push(Diagnostic::error(Code::CannotRead, message)),
                }
                None
            }
        }
    }
}
