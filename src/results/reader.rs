use admire_syntax::diagnostic::Diagnostic;

use super::{Catalogue, Header, ResultsError, Step};

/// Step-by-step reader of a results file, whatever its format.
pub trait ResultsReader {
    /// Returns the header of the file.
    fn header(&self) -> &Header;

    /// Returns the catalogue, which names the columns.
    fn catalogue(&self) -> &Catalogue;

    /// Returns the next complete output step, or `None` at the end of the file.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read, or if the file is malformed at this step. The steps returned before are valid.
    fn next_step(&mut self) -> Result<Option<Step<'_>>, ResultsError>;

    /// Returns the diagnostics that the reader has collected so far.
    fn diagnostics(&self) -> &[Diagnostic];
}
