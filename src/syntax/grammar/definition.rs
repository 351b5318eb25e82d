use crate::units::Dimension;

/// Definition of a statement of the dataset, a command of the command file, or both.
#[derive(Debug, PartialEq)]
pub struct StatementDef {
    /// Full keyword in capitals, for example `BUSHING`.
    pub name: &'static str,
    /// Number of letters in the shortest legal abbreviation of the keyword.
    pub minimum: usize,
    /// Files in which the statement may appear.
    pub role: Role,
    /// Id space of the statement (`"marker"`, `"force.bushing"`, ...), within which its ids are unique; `None` if the statement has no id.
    pub id: Option<&'static str>,
    /// Arguments in canonical order.
    pub arguments: &'static [ArgumentDef],
    /// Rules on which arguments exclude or require each other.
    pub presence: &'static [Presence],
    /// Arguments that affect the results of real ADAMS but are ignored by the built-in solver.
    pub left_out: &'static [LeftOut],
    /// Force laws that the statement can select; each law acts between the markers I and J. Empty if the statement is not a force of this kind.
    pub laws: &'static [LawDef],
    /// The solver that handles the statement: built-in or real ADAMS.
    pub solved: Solved,
    /// Description in one line.
    pub doc: &'static str,
    /// Documentation page of the statement; `grammar/NOTES.md` lists the pages that were read.
    pub source: &'static str,
    /// Facts about the statement that no documentation page confirms and that may be wrong or incomplete; empty if there are none.
    pub unchecked: &'static str,
}

impl StatementDef {
    /// Returns the argument with this full keyword, or `None` if the statement has no such argument.
    pub fn argument(&self, name: &str) -> Option<&'static ArgumentDef> {
        self.arguments.iter().find(|argument| argument.name == name)
    }

    /// Returns true if the argument may be repeated and each occurrence adds a row of values, as Y does in a SPLINE with two variables.
    ///
    /// For any other argument, only the last occurrence counts.
    pub(crate) fn adds_rows(&self, argument: &str) -> bool {
        self.name == "SPLINE" && argument == "Y"
    }
}

/// Arguments that real ADAMS uses and the built-in solver ignores. The results of the two then differ.
#[derive(Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Full keywords of the arguments in capitals.
    pub arguments: &'static [&'static str],
    /// Effect that the arguments have in real ADAMS.
    pub effect: &'static str,
}

/// A force law between two markers, with the arguments of the statement from which its parameters are read.
#[derive(Debug, PartialEq, Eq)]
pub struct LawDef {
    /// Name of the law in the registry of laws.
    pub name: &'static str,
    /// Type of the objects with this law in results files.
    pub entity: &'static str,
    /// Arguments that hold the parameters of the law, in the order the law expects.
    pub arguments: &'static [&'static str],
    /// Flag of the statement that selects this law; `None` if the statement has only one law.
    pub flag: Option<&'static str>,
}

/// Files in which a statement may appear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Only in a dataset.
    Dataset,
    /// Only in a command file.
    Command,
    /// In a dataset, and in a command file to redefine the statement.
    Both,
}

/// Definition of an argument of a statement.
#[derive(Debug, PartialEq)]
pub struct ArgumentDef {
    /// Full keyword in capitals, for example `REULER`.
    pub name: &'static str,
    /// Number of letters in the shortest legal abbreviation of the keyword.
    pub minimum: usize,
    /// Type of the value.
    pub kind: ValueKind,
    /// Allowed number of values.
    pub count: Count,
    /// Default values; empty if the argument has none.
    pub default: &'static [f64],
    /// Physical dimension of the real values, if all of them have the same dimension.
    pub dimension: Dimension,
    /// Rule for the dimensions of the individual values, if they differ.
    pub components: Components,
    /// Lower bound of numeric values.
    pub lower: Bound,
    /// Upper bound of numeric values.
    pub upper: Bound,
    /// True if the statement must give this argument.
    pub required: bool,
    /// Description in one line.
    pub doc: &'static str,
}

impl ArgumentDef {
    /// Returns the physical dimension of the value at index `k`, from 0.
    pub fn dimension_of(&self, k: usize) -> Dimension {
        self.components.of(k).unwrap_or(self.dimension)
    }

    /// Returns true if a number is within the bounds of the argument.
    pub fn admits(&self, value: f64) -> bool {
        let above = match self.lower {
            Bound::Open => true,
            Bound::Inclusive(bound) => value >= bound,
            Bound::Exclusive(bound) => value > bound,
        };
        let below = match self.upper {
            Bound::Open => true,
            Bound::Inclusive(bound) => value <= bound,
            Bound::Exclusive(bound) => value < bound,
        };
        above && below
    }

    /// Describes the bounds in words, such as `more than 0 and 1 or less`; empty if the argument has no bounds.
    pub fn wanted(&self) -> String {
        let lower = match self.lower {
            Bound::Open => None,
            Bound::Inclusive(bound) => Some(format!("{bound} or more")),
            Bound::Exclusive(bound) => Some(format!("more than {bound}")),
        };
        let upper = match self.upper {
            Bound::Open => None,
            Bound::Inclusive(bound) => Some(format!("{bound} or less")),
            Bound::Exclusive(bound) => Some(format!("less than {bound}")),
        };
        let both: Vec<String> = lower.into_iter().chain(upper).collect();
        both.join(" and ")
    }

    /// Returns the lower bound of the values, or minus infinity if there is none.
    pub fn minimum(&self) -> f64 {
        match self.lower {
            Bound::Open => f64::NEG_INFINITY,
            Bound::Inclusive(bound) | Bound::Exclusive(bound) => bound,
        }
    }
}

/// Rule for the dimensions of the values of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// All values have the same dimension.
    Alike,
    /// Three lengths, then three angles; this group of six may be repeated.
    Motion,
    /// Three forces, then three torques; this group of six may be repeated.
    Wrench,
    /// The 36 entries of a stiffness matrix (wrench per displacement), column by column.
    Stiffness,
    /// The 36 entries of a damping matrix (wrench per velocity), column by column.
    Damping,
}

impl Components {
    /// Returns the dimension of the value at index `k`, from 0; `None` if all values have the same dimension.
    pub fn of(self, k: usize) -> Option<Dimension> {
        let wrench = |row: usize| {
            if row < 3 {
                Dimension::FORCE
            } else {
                Dimension::TORQUE
            }
        };
        match self {
            Self::Alike => None,
            Self::Wrench => Some(wrench(k % 6)),
            Self::Motion if k % 6 < 3 => Some(Dimension::LENGTH),
            Self::Motion => Some(Dimension::ANGLE),
            Self::Stiffness | Self::Damping => {
                let mut dimension = wrench(k % 6);
                if k / 6 < 3 {
                    dimension.length -= 1;
                } else {
                    dimension.angle -= 1;
                }
                dimension.time += i8::from(self == Self::Damping);
                Some(dimension)
            }
        }
    }
}

/// Type of the values of an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueKind {
    /// No value: the keyword alone.
    Flag,
    /// Real numbers; angular ones may carry the degree suffix.
    Real,
    /// Integers.
    Integer,
    /// Ids of statements in this id space. A space may contain others: `"force"` contains all spaces `"force.*"`.
    Reference(&'static str),
    /// One of several words. Several words joined by colons are allowed if the count permits it.
    Choice(&'static [Choice]),
    /// A FUNCTION expression, which ends at a backslash, at a comma outside of parentheses, or at the end of the statement.
    Function,
    /// Free text up to the next delimiter, or text in quotes.
    Text,
    /// Several texts separated by colons; texts in quotes may also be separated by commas.
    TextList,
    /// A file name.
    File,
}

/// A word that an argument can have as its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Full word in capitals.
    pub name: &'static str,
    /// Number of letters in the shortest legal abbreviation of the word.
    pub minimum: usize,
}

/// Range of the allowed number of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// Smallest allowed number of values.
    pub min: usize,
    /// Largest allowed number of values; `None` for no limit.
    pub max: Option<usize>,
}

/// A bound on a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// No bound.
    Open,
    /// A bound that belongs to the allowed range.
    Inclusive(f64),
    /// A bound that does not belong to the allowed range.
    Exclusive(f64),
}

/// A rule on which arguments exclude or require each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// At most one of these arguments may be present.
    Exclusive(&'static [&'static str]),
    /// Either all of these arguments or none of them must be present.
    Together(&'static [&'static str]),
    /// If the first argument is present, all the others must be present.
    Requires(&'static [&'static str]),
    /// Exactly one of these arguments must be present.
    OneOf(&'static [&'static str]),
}

/// The solver that handles a statement or function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solved {
    /// The built-in solver handles the statement or function. The text names the kind of element, constraint, data or function value.
    Native(&'static str),
    /// The statement has no effect on built-in solutions, for the given reason; it is read and kept.
    NoEffect(&'static str),
    /// Only real ADAMS handles the statement or function. The text gives the reason.
    External(&'static str),
    /// Only real ADAMS with a user-written subroutine handles the statement or function. The text says what the subroutine contains.
    Subroutine(&'static str),
}

impl Solved {
    /// Returns the reason why only real ADAMS handles the statement or function; `None` if the built-in solver handles it or can ignore it.
    #[must_use]
    pub fn only_adams(self) -> Option<&'static str> {
        match self {
            Self::External(why) | Self::Subroutine(why) => Some(why),
            Self::Native(_) | Self::NoEffect(_) => None,
        }
    }
}

/// Definition of a function that may occur in FUNCTION expressions.
#[derive(Debug, PartialEq, Eq)]
pub struct FunctionDef {
    /// Name in capitals; names of functions are never abbreviated.
    pub name: &'static str,
    /// Allowed number of arguments.
    pub count: Count,
    /// Argument list as shown to users, for example `i[,j][,k]`.
    pub arguments: &'static str,
    /// The solver that evaluates the function: built-in or real ADAMS.
    pub solved: Solved,
    /// Description in one line.
    pub doc: &'static str,
    /// Documentation page of the function; `grammar/NOTES.md` lists the pages that were read.
    pub source: &'static str,
}
