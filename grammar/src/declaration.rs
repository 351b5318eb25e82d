/// A keyword with the number of letters that must be typed.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Keyword {
    /// The whole keyword in capitals.
    pub name: String,
    /// How many letters must be typed.
    pub minimum: usize,
}

/// How many values: at least, at most (`None` for no limit).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// At least so many.
    pub min: usize,
    /// At most so many.
    pub max: Option<usize>,
}

/// What stands after the equals sign.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// The word alone.
    Flag,
    /// Real numbers.
    Real,
    /// Integers.
    Integer,
    /// Ids of a space.
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

/// One argument.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// Its keyword.
    pub keyword: Keyword,
    /// What it takes.
    pub value: Value,
    /// How many values.
    pub count: Count,
    /// Default values.
    pub default: Vec<f64>,
    /// Exponents of force, mass, length, time, angle.
    pub dimension: [i8; 5],
    /// `Alike`, or how the dimensions of its values differ: `Motion`, `Wrench`, `Stiffness`, `Damping`.
    pub components: &'static str,
    /// Bounds.
    pub range: Range,
    /// True if a dataset statement must have it.
    pub required: bool,
    /// One line for people.
    pub doc: String,
}

/// A rule on which arguments stand together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presence {
    /// `Exclusive`, `Together`, `Requires` or `OneOf`.
    pub rule: &'static str,
    /// The whole argument names.
    pub names: Vec<String>,
}

/// A force law between the markers I and J, and its numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Law {
    /// Its name in the registry of laws.
    pub name: String,
    /// The arguments it takes its numbers from, in its order.
    pub arguments: Vec<String>,
    /// The flag that chooses it, where a statement has several laws.
    pub flag: Option<String>,
}

/// Arguments that ADAMS follows and the built-in solver does not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The whole argument names.
    pub names: Vec<String>,
    /// What ADAMS makes of them.
    pub effect: String,
}

impl Law {
    /// `NAME ARGUMENT...`, and `for FLAG` behind it where a statement has several laws; `None` without a name.
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
    /// From names with blanks between them.
    pub(crate) fn new(names: &str, effect: String) -> Self {
        Self {
            names: names.split_whitespace().map(str::to_string).collect(),
            effect,
        }
    }
}

/// Who can solve it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Solved {
    /// The built-in solver, as the named thing.
    Native(String),
    /// No effect on statics, and why.
    NoEffect(String),
    /// Only real ADAMS, and why.
    External(String),
    /// Only real ADAMS with a user-written subroutine, and what is in it.
    Subroutine(String),
}

/// One statement or command.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Its keyword.
    pub keyword: Keyword,
    /// `Dataset`, `Command` or `Both`.
    pub role: &'static str,
    /// The id space, if it takes an id.
    pub id: Option<String>,
    /// Arguments in canonical order.
    pub arguments: Vec<Argument>,
    /// Presence rules.
    pub presence: Vec<Presence>,
    /// Arguments that only real ADAMS follows.
    pub left_out: Vec<LeftOut>,
    /// Its force laws.
    pub laws: Vec<Law>,
    /// Who can solve it.
    pub solved: Solved,
    /// One line for people.
    pub doc: String,
    /// The page that documents it.
    pub source: String,
    /// What no page could be compared with; empty if nothing.
    pub unchecked: String,
    /// File and line of its declaration.
    pub place: (String, usize),
}

/// One function of expressions.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Its name in capitals.
    pub name: String,
    /// How many arguments.
    pub count: Count,
    /// The arguments as shown.
    pub arguments: String,
    /// Who can evaluate it.
    pub solved: Solved,
    /// One line for people.
    pub doc: String,
    /// The page that documents it.
    pub source: String,
    /// File and line of its declaration.
    pub place: (String, usize),
}

/// Everything that was declared, in the order of the files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grammar {
    /// Statements and commands.
    pub statements: Vec<Statement>,
    /// Functions.
    pub functions: Vec<Function>,
}
