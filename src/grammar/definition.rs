use crate::units::Dimension;

/// One statement of the dataset, one command of the command file, or both.
#[derive(Debug, PartialEq)]
pub struct StatementDef {
    /// The whole keyword in capitals, for example `BUSHING`.
    pub name: &'static str,
    /// How many letters must be typed.
    pub minimum: usize,
    /// Where it may stand.
    pub role: Role,
    /// The id space its id belongs to (`"marker"`, `"force.bushing"`, ...), or `None` if it takes no id.
    pub id: Option<&'static str>,
    /// Arguments in canonical order.
    pub arguments: &'static [ArgumentDef],
    /// Rules on which arguments stand together.
    pub presence: &'static [Presence],
    /// Who can solve it.
    pub solved: Solved,
    /// One line for people.
    pub doc: &'static str,
    /// The page that documents it; `grammar/NOTES.md` says which pages were read.
    pub source: &'static str,
    /// What could not be compared with a page of the documentation, so that it may be wrong or lack something; empty if nothing.
    pub unchecked: &'static str,
}

/// Where a statement may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// In a dataset only.
    Dataset,
    /// In a command file only.
    Command,
    /// In a dataset, and in a command file to redefine.
    Both,
}

/// One argument of a statement.
#[derive(Debug, PartialEq)]
pub struct ArgumentDef {
    /// The whole keyword in capitals, for example `REULER`.
    pub name: &'static str,
    /// How many letters must be typed.
    pub minimum: usize,
    /// What stands after the equals sign.
    pub kind: ValueKind,
    /// How many values.
    pub count: Count,
    /// Default values; empty if the argument has none.
    pub default: &'static [f64],
    /// Physical dimension of real values.
    pub dimension: Dimension,
    /// Lower bound of numeric values.
    pub lower: Bound,
    /// Upper bound of numeric values.
    pub upper: Bound,
    /// True if the statement must have it.
    pub required: bool,
    /// One line for people.
    pub doc: &'static str,
}

/// What kind of value an argument takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueKind {
    /// No value: the word alone.
    Flag,
    /// Real numbers; angular ones may carry the degree suffix.
    Real,
    /// Integers.
    Integer,
    /// Ids of statements of that id space; ids may be shared by spaces (`"force"` holds all `"force.*"`).
    Reference(&'static str),
    /// One of several words, or several joined by colons when the count allows it.
    Choice(&'static [Choice]),
    /// A FUNCTION expression, to a backslash, a comma at depth 0, or the end of the statement.
    Function,
    /// Free text to the next delimiter, or quoted.
    Text,
    /// Several texts separated by colons (or commas when quoted).
    TextList,
    /// A file name.
    File,
}

/// A word an argument may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The whole word in capitals.
    pub name: &'static str,
    /// How many letters must be typed.
    pub minimum: usize,
}

/// How many values an argument takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// At least so many.
    pub min: usize,
    /// At most so many; `None` for no limit.
    pub max: Option<usize>,
}

/// A bound on a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// None.
    Open,
    /// The bound itself is allowed.
    Inclusive(f64),
    /// The bound itself is not allowed.
    Exclusive(f64),
}

/// A rule on which arguments stand together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// At most one of these.
    Exclusive(&'static [&'static str]),
    /// All or none of these.
    Together(&'static [&'static str]),
    /// The first needs all the others.
    Requires(&'static [&'static str]),
    /// Exactly one of these.
    OneOf(&'static [&'static str]),
}

/// Who can solve a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solved {
    /// The built-in solver, as the named element, constraint or data.
    Native(&'static str),
    /// It has no effect on statics; it is read and kept.
    NoEffect(&'static str),
    /// Only real ADAMS; the text says why.
    External(&'static str),
}

/// One function of FUNCTION expressions.
#[derive(Debug, PartialEq, Eq)]
pub struct FunctionDef {
    /// The name in capitals; functions are never abbreviated.
    pub name: &'static str,
    /// How many arguments.
    pub count: Count,
    /// The arguments as shown, for example `i[,j][,k]`.
    pub arguments: &'static str,
    /// Who can evaluate it.
    pub solved: Solved,
    /// One line for people.
    pub doc: &'static str,
    /// The page that documents it; `grammar/NOTES.md` says which pages were read.
    pub source: &'static str,
}
