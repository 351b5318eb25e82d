use admire_syntax::diagnostic::Diagnostic;

use super::{Catalogue, Header, ResultsError, Step};

/// A reader of a results file of any format, step by step.
pub trait ResultsReader {
    /// Returns the header of the file.
    fn header(&self) -> &Header;

    /// Returns the catalogue, which names the columns.
    fn catalogue(&self) -> &Catalogue;

    /// Returns the next complete step, or `None` at the end.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read, or if the file is malformed from here on; the steps read before remain valid.
    fn next_step(&mut self) -> Result<Option<Step<'_>>, ResultsError>;

    /// Returns the diagnostics collected so far.
    fn diagnostics(&self) -> &[Diagnostic];
}
