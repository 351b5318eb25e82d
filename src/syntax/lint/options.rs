/// What is looked for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Options {
    /// The deck is for the FORTRAN solver: lines have at most 80 columns.
    pub fortran: bool,
}
