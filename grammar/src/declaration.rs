/// A keyword, with the length of its shortest legal abbreviation.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Keyword {
    /// Full keyword in capitals.
    pub name: String,
    /// Number of letters in the shortest legal abbreviation of the keyword.
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

/// Type of the value that follows the equals sign of an argument.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// No value: the argument consists of its keyword.
    Flag,
    /// Real numbers.
    Real,
    /// Integers.
    Integer,
    /// Ids of statements in the id space with this name.
    Reference(String),
    /// One of several words.
    Word(Vec<Keyword>),
    /// A FUNCTION expression.
    Function,
    /// Free text, up to the next delimiter.
    Text,
    /// Several texts, separated by colons.
    Texts,
    /// A file name.
    File,
}

/// Allowed range of a number. Each bound is paired with a flag that is true if the bound itself is allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Range {
    /// Lower bound, if there is one, and whether the bound itself is allowed.
    pub lower: Option<(f64, bool)>,
    /// Upper bound, if there is one, and whether the bound itself is allowed.
    pub upper: Option<(f64, bool)>,
}

/// One argument of a statement or command.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// Keyword of the argument.
    pub keyword: Keyword,
    /// Type of the value.
    pub value: Value,
    /// Allowed number of values.
    pub count: Count,
    /// Default values; empty if the argument has no default.
    pub default: Vec<f64>,
    /// Physical dimension, as exponents of force, mass, length, time and angle.
    pub dimension: [i8; 5],
    /// Rule for the dimensions of the values. `Alike` means that all values have the same dimension; `Motion`, `Wrench`, `Stiffness` and
    /// `Damping` name patterns of different dimensions.
    pub components: &'static str,
    /// Allowed range of the values.
    pub range: Range,
    /// True if every statement in a dataset must give this argument.
    pub required: bool,
    /// Description in one line.
    pub doc: String,
}

/// A rule on which arguments exclude or require each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presence {
    /// Name of the rule: `Exclusive`, `Together`, `Requires` or `OneOf`.
    pub rule: &'static str,
    /// Full names of the arguments to which the rule applies.
    pub names: Vec<String>,
}

/// A force law between the markers I and J, with the arguments from which its parameters are read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Law {
    /// Name of the law in the registry of laws.
    pub name: String,
    /// Arguments that hold the parameters of the law, in the order the law expects.
    pub arguments: Vec<String>,
    /// Flag that selects this law; `None` if the statement has only one law.
    pub flag: Option<String>,
}

/// Arguments that affect results in ADAMS but are ignored by the built-in solver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Full names of the arguments to which the rule applies.
    pub names: Vec<String>,
    /// Effect that the arguments have in ADAMS.
    pub effect: String,
}

impl Law {
    /// Parses `NAME ARGUMENT...`, optionally followed by `for FLAG` if the statement has several laws; returns `None` if there is no name.
    pub(crate) fn read(words: &[&str]) -> Option<Self> {
        let (words, flag) = match words {
            [words @ .., "for", flag] => (words, Some((*flag).to_string())),
            words => (words, None),
        };
        let [name, arguments @ ..] = words else {
            return None;
        };
        Some(Self {
            name: (*name).to_string(),
            arguments: arguments.iter().map(ToString::to_string).collect(),
            flag,
        })
    }
}

impl LeftOut {
    /// Builds an entry from the names of the arguments, separated by blanks, and from their effect in ADAMS.
    pub(crate) fn new(names: &str, effect: String) -> Self {
        Self {
            names: names.split_whitespace().map(str::to_string).collect(),
            effect,
        }
    }
}

/// The solver that handles a statement or function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Solved {
    /// The built-in solver; the text names the kind of element, constraint, data or function value.
    Native(String),
    /// The statement has no effect on built-in solutions, for the given reason.
    NoEffect(String),
    /// Only real ADAMS handles it, for the given reason.
    External(String),
    /// Only real ADAMS with a user-written subroutine handles it; the text says what the subroutine contains.
    Subroutine(String),
}

/// One statement or command.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Keyword of the statement.
    pub keyword: Keyword,
    /// Files in which the statement may appear: `Dataset`, `Command` or `Both`.
    pub role: &'static str,
    /// Id space of the statement; `None` if the statement has no id.
    pub id: Option<String>,
    /// Arguments in canonical order.
    pub arguments: Vec<Argument>,
    /// Rules on which arguments exclude or require each other.
    pub presence: Vec<Presence>,
    /// Arguments that affect results in ADAMS but are ignored by the built-in solver.
    pub left_out: Vec<LeftOut>,
    /// Force laws that the statement can select.
    pub laws: Vec<Law>,
    /// The solver that handles the statement.
    pub solved: Solved,
    /// Description in one line.
    pub doc: String,
    /// Documentation page of the statement.
    pub source: String,
    /// Facts about the statement that no documentation page confirms; empty if there are none.
    pub unchecked: String,
    /// File name and line number (from 1) of the declaration.
    pub place: (String, usize),
}

/// Declaration of a function that may occur in FUNCTION expressions.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Name of the function in capitals.
    pub name: String,
    /// Allowed number of arguments.
    pub count: Count,
    /// Argument list as declared, for example `i[,j][,k]`; empty for a function without arguments.
    pub arguments: String,
    /// The solver that evaluates the function.
    pub solved: Solved,
    /// Description in one line.
    pub doc: String,
    /// Documentation page of the function.
    pub source: String,
    /// File name and line number (from 1) of the declaration.
    pub place: (String, usize),
}

/// All declared statements and functions, in the order of the grammar files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grammar {
    /// Statements and commands.
    pub statements: Vec<Statement>,
    /// Functions of FUNCTION expressions.
    pub functions: Vec<Function>,
}
