use crate::units::Dimension;

/// Definition of a statement of the dataset, a command of the command file, or both.
#[derive(Debug, PartialEq)]
pub struct StatementDef {
    /// Full keyword in capitals, for example `BUSHING`.
    pub name: &'static str,
    /// Number of leading letters that must be typed.
    pub minimum: usize,
    /// Files in which the statement may appear.
    pub role: Role,
    /// Id space of the statement (`"marker"`, `"force.bushing"`, ...), or `None` if it has no id.
    pub id: Option<&'static str>,
    /// Arguments in canonical order.
    pub arguments: &'static [ArgumentDef],
    /// Rules about which arguments may or must appear together.
    pub presence: &'static [Presence],
    /// Arguments that real ADAMS uses and the built-in solver ignores.
    pub left_out: &'static [LeftOut],
    /// Force laws between the markers I and J; empty if the statement is not such a force.
    pub laws: &'static [LawDef],
    /// Which solver handles the statement.
    pub solved: Solved,
    /// Description in one line.
    pub doc: &'static str,
    /// Documentation page of the statement; `grammar/NOTES.md` lists the pages that were read.
    pub source: &'static str,
    /// Facts that no documentation page confirms and that may be wrong or incomplete; empty if there are none.
    pub unchecked: &'static str,
}

impl StatementDef {
    /// Returns the argument with this full keyword.
    pub fn argument(&self, name: &str) -> Option<&'static ArgumentDef> {
        self.arguments.iter().find(|argument| argument.name == name)
    }

    /// Returns true if the argument may be repeated and each occurrence adds a row: Y of a SPLINE with two variables.
    ///
    /// For any other argument the last occurrence counts.
    pub(crate) fn adds_rows(&self, argument: &str) -> bool {
        self.name == "SPLINE" && argument == "Y"
    }
}

/// Arguments that real ADAMS uses and the built-in solver ignores, so that their results differ.
#[derive(Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Full keywords of the arguments in capitals.
    pub arguments: &'static [&'static str],
    /// Effect of the arguments in real ADAMS.
    pub effect: &'static str,
}

/// A force law between two markers, with the arguments of a statement that hold its parameters.
#[derive(Debug, PartialEq, Eq)]
pub struct LawDef {
    /// Name of the law in the registry of laws.
    pub name: &'static str,
    /// Type of the law's objects in results files.
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
    /// Number of leading letters that must be typed.
    pub minimum: usize,
    /// Type of the value.
    pub kind: ValueKind,
    /// Allowed number of values.
    pub count: Count,
    /// Default values; empty if the argument has none.
    pub default: &'static [f64],
    /// Physical dimension of real values, if all have the same.
    pub dimension: Dimension,
    /// Whether all values have the same dimension, and how the dimensions differ otherwise.
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
    /// Returns the physical dimension of value `k`, from 0.
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

    /// Describes the bounds in words, such as `more than 0 and 1 or less`; empty if there are none.
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

    /// Returns the lower bound, or minus infinity if there is none.
    pub fn minimum(&self) -> f64 {
        match self.lower {
            Bound::Open => f64::NEG_INFINITY,
            Bound::Inclusive(bound) | Bound::Exclusive(bound) => bound,
        }
    }
}

/// How the dimensions of the values of one argument differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// All values have the same dimension.
    Alike,
    /// Three lengths and three angles, repeated.
    Motion,
    /// Three forces and three torques, repeated.
    Wrench,
    /// The 36 stiffnesses (wrench per motion), column by column.
    Stiffness,
    /// The 36 damping coefficients (wrench per rate of motion), column by column.
    Damping,
}

impl Components {
    /// Returns the dimension of value `k`, from 0; `None` if all values have the same dimension.
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
    /// Ids of statements of this id space. A space may contain others: `"force"` contains all `"force.*"`.
    Reference(&'static str),
    /// One of several words, or several of them joined by colons if the count allows it.
    Choice(&'static [Choice]),
    /// A FUNCTION expression, up to a backslash, a comma outside of parentheses, or the end of the statement.
    Function,
    /// Free text up to the next delimiter, or quoted text.
    Text,
    /// Several texts separated by colons (or commas when quoted).
    TextList,
    /// A file name.
    File,
}

/// A word that an argument may have as its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Full word in capitals.
    pub name: &'static str,
    /// Number of leading letters that must be typed.
    pub minimum: usize,
}

/// Allowed number of values.
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
    /// A bound that is itself allowed.
    Inclusive(f64),
    /// A bound that is itself not allowed.
    Exclusive(f64),
}

/// A rule about which arguments may or must appear together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// At most one of these arguments.
    Exclusive(&'static [&'static str]),
    /// All or none of these arguments.
    Together(&'static [&'static str]),
    /// The first argument requires all the others.
    Requires(&'static [&'static str]),
    /// Exactly one of these arguments.
    OneOf(&'static [&'static str]),
}

/// Which solver handles a statement or function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solved {
    /// The built-in solver, as the named element, constraint or data.
    Native(&'static str),
    /// No effect on statics, for the given reason; the statement is read and kept.
    NoEffect(&'static str),
    /// Only real ADAMS, for the given reason.
    External(&'static str),
    /// Only real ADAMS with a user-written subroutine; the text describes the content of the subroutine.
    Subroutine(&'static str),
}

impl Solved {
    /// Returns the reason why only real ADAMS handles it; `None` otherwise.
    #[must_use]
    pub fn only_adams(self) -> Option<&'static str> {
        match self {
            Self::External(why) | Self::Subroutine(why) => Some(why),
            Self::Native(_) | Self::NoEffect(_) => None,
        }
    }
}

/// Definition of a function of FUNCTION expressions.
#[derive(Debug, PartialEq, Eq)]
pub struct FunctionDef {
    /// Name in capitals; functions are never abbreviated.
    pub name: &'static str,
    /// Allowed number of arguments.
    pub count: Count,
    /// Argument list as shown to users, for example `i[,j][,k]`.
    pub arguments: &'static str,
    /// Which solver evaluates the function.
    pub solved: Solved,
    /// Description in one line.
    pub doc: &'static str,
    /// Documentation page of the function; `grammar/NOTES.md` lists the pages that were read.
    pub source: &'static str,
}
