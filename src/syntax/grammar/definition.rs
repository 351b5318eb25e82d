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
    /// Arguments that real ADAMS follows and the built-in solver does not.
    pub left_out: &'static [LeftOut],
    /// The force laws between its markers I and J; empty if it is no such force.
    pub laws: &'static [LawDef],
    /// Who can solve it.
    pub solved: Solved,
    /// One line for people.
    pub doc: &'static str,
    /// The page that documents it; `grammar/NOTES.md` says which pages were read.
    pub source: &'static str,
    /// What could not be compared with a page of the documentation, so that it may be wrong or lack something; empty if nothing.
    pub unchecked: &'static str,
}

impl StatementDef {
    /// An argument by its whole keyword.
    pub fn argument(&self, name: &str) -> Option<&'static ArgumentDef> {
        self.arguments.iter().find(|argument| argument.name == name)
    }

    /// True for an argument that stands several times, each of them a row: Y of a SPLINE with two variables. Of any other argument that
    /// is repeated the last one counts.
    pub(crate) fn adds_rows(&self, argument: &str) -> bool {
        self.name == "SPLINE" && argument == "Y"
    }
}

/// Arguments that real ADAMS follows and the built-in solver does not: the answer is another one with them.
#[derive(Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Whole keywords in capitals.
    pub arguments: &'static [&'static str],
    /// What real ADAMS makes of them.
    pub effect: &'static str,
}

/// A force law between two markers, and where a statement has its numbers.
#[derive(Debug, PartialEq, Eq)]
pub struct LawDef {
    /// Its name in the registry of laws.
    pub name: &'static str,
    /// The type of its objects in result files.
    pub entity: &'static str,
    /// The arguments that hold its numbers, in its order.
    pub arguments: &'static [&'static str],
    /// The flag of the statement that chooses it; `None` if the statement has one law only.
    pub flag: Option<&'static str>,
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
    /// Physical dimension of real values, if they are alike.
    pub dimension: Dimension,
    /// Whether they are alike.
    pub components: Components,
    /// Lower bound of numeric values.
    pub lower: Bound,
    /// Upper bound of numeric values.
    pub upper: Bound,
    /// True if the statement must have it.
    pub required: bool,
    /// One line for people.
    pub doc: &'static str,
}

impl ArgumentDef {
    /// Physical dimension of value `k`, from 0.
    pub fn dimension_of(&self, k: usize) -> Dimension {
        self.components.of(k).unwrap_or(self.dimension)
    }

    /// True if a number lies between its bounds.
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

    /// Its bounds in words, `more than 0 and 1 or less`; empty without any.
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

    /// The least value it may have; minus infinity if it has no lower bound.
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
    /// They are alike.
    Alike,
    /// Three lengths and three angles, repeated.
    Motion,
    /// Three forces and three torques, repeated.
    Wrench,
    /// The 36 numbers of wrench per motion, column by column.
    Stiffness,
    /// The same of wrench per rate of motion.
    Damping,
}

impl Components {
    /// The dimension of value `k`, from 0; `None` if all are alike.
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
    /// Only real ADAMS with a user-written subroutine; the text says what is in it.
    Subroutine(&'static str),
}

impl Solved {
    /// Why only real ADAMS solves it, if that is so.
    #[must_use]
    pub fn only_adams(self) -> Option<&'static str> {
        match self {
            Self::External(why) | Self::Subroutine(why) => Some(why),
            Self::Native(_) | Self::NoEffect(_) => None,
        }
    }
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
