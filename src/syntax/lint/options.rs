/// Options of the lint rules.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Options {
    /// True if the deck is for the FORTRAN solver, which reads lines of at most 80 columns.
    pub fortran: bool,
}
