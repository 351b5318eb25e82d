use admire_syntax::diagnostic::Diagnostic;

use super::{Catalogue, Header, ResultsError, Step};

/// A results file of any format, read step by step.
pub trait ResultsReader {
    /// What the file says of itself.
    fn header(&self) -> &Header;

    /// The names of the columns.
    fn catalogue(&self) -> &Catalogue;

    /// The next whole step, or `None` at the end.
    ///
    /// # Errors
    /// When the input cannot be read, or the file is broken from here on; steps read before are good.
    fn next_step(&mut self) -> Result<Option<Step<'_>>, ResultsError>;

    /// Complaints so far.
    fn diagnostics(&self) -> &[Diagnostic];
}
