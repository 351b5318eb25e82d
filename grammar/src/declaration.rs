/// A keyword with the number of its leading letters that must be typed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Keyword {
    /// Full keyword in capitals.
    pub name: String,
    /// Number of leading letters that must be typed.
    pub minimum: usize,
}

/// Allowed number of values: a minimum and a maximum (`None` for no limit).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// Smallest allowed number of values.
    pub min: usize,
    /// Largest allowed number of values; `None` for no limit.
    pub max: Option<usize>,
}

/// Type of the value after an argument's equals sign.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// No value: the keyword alone.
    Flag,
    /// Real numbers.
    Real,
    /// Integers.
    Integer,
    /// Statement ids of the named id space.
    Reference(String),
    /// One of several words.
    Word(Vec<Keyword>),
    /// A FUNCTION expression.
    Function,
    /// Free text.
    Text,
    /// Several texts.
    Texts,
    /// A file name.
    File,
}

/// Bounds of a number: the bound and whether it is itself allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Range {
    /// Lower bound.
    pub lower: Option<(f64, bool)>,
    /// Upper bound.
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
    /// Exponents of force, mass, length, time and angle.
    pub dimension: [i8; 5],
    /// `Alike` if all values have the same dimension; otherwise `Motion`, `Wrench`, `Stiffness` or `Damping`, which say how the dimensions
    /// differ.
    pub components: &'static str,
    /// Allowed range of the values.
    pub range: Range,
    /// True if a dataset statement must give this argument.
    pub required: bool,
    /// Description in one line.
    pub doc: String,
}

/// A rule about which arguments may or must appear together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presence {
    /// `Exclusive`, `Together`, `Requires` or `OneOf`.
    pub rule: &'static str,
    /// Full names of the arguments.
    pub names: Vec<String>,
}

/// A force law between the markers I and J, with the arguments that hold its parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Law {
    /// Name of the law in the registry of laws.
    pub name: String,
    /// Arguments that hold the parameters of the law, in the order the law expects.
    pub arguments: Vec<String>,
    /// Flag that selects this law, for a statement with several laws.
    pub flag: Option<String>,
}

/// Arguments that ADAMS uses and the built-in solver ignores.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Full names of the arguments.
    pub names: Vec<String>,
    /// Effect of the arguments in ADAMS.
    pub effect: String,
}

impl Law {
    /// Parses `NAME ARGUMENT...`, optionally followed by `for FLAG` for a statement with several laws; returns `None` without a name.
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
    /// Builds the entry from argument names separated by blanks and the effect of the arguments.
    pub(crate) fn new(names: &str, effect: String) -> Self {
        Self {
            names: names.split_whitespace().map(str::to_string).collect(),
            effect,
        }
    }
}

/// Which solver handles a statement or function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Solved {
    /// Built-in solver, with the name of the implementation.
    Native(String),
    /// No effect on statics, with the reason.
    NoEffect(String),
    /// Real ADAMS only, with the reason.
    External(String),
    /// Real ADAMS with a user-written subroutine only, with the content of the subroutine.
    Subroutine(String),
}

/// One statement or command.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Keyword of the statement.
    pub keyword: Keyword,
    /// `Dataset`, `Command` or `Both`.
    pub role: &'static str,
    /// Id space of the statement; `None` if the statement has no id.
    pub id: Option<String>,
    /// Arguments in canonical order.
    pub arguments: Vec<Argument>,
    /// Rules about which arguments appear together.
    pub presence: Vec<Presence>,
    /// Arguments that only real ADAMS uses.
    pub left_out: Vec<LeftOut>,
    /// Force laws of the statement.
    pub laws: Vec<Law>,
    /// Which solver handles the statement.
    pub solved: Solved,
    /// Description in one line.
    pub doc: String,
    /// Documentation page of the statement.
    pub source: String,
    /// Facts that no documentation page confirms; empty if there are none.
    pub unchecked: String,
    /// File and line (from 1) of the declaration.
    pub place: (String, usize),
}

/// One function of FUNCTION expressions.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Name of the function in capitals.
    pub name: String,
    /// Allowed number of arguments.
    pub count: Count,
    /// Argument list as declared, for example `i[,j][,k]`; empty for a function without arguments.
    pub arguments: String,
    /// Which solver evaluates the function.
    pub solved: Solved,
    /// Description in one line.
    pub doc: String,
    /// Documentation page of the function.
    pub source: String,
    /// File and line (from 1) of the declaration.
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
