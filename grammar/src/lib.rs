//! The grammar of the dataset language as readable files, and a generator that converts them to Rust tables.
//!
//! The files `*.grammar` declare statements, commands and functions. [`read`] parses them, and [`emit`] prints the Rust tables of
//! `src/syntax/grammar/generated.rs`. The generator does not depend on the crate that contains these tables; it only uses the names of
//! their types.
//!
//! # The format
//!
//! Each line states one fact. `#` begins the description that belongs to the line; `##` begins a remark, which is ignored. The capital
//! letters of a keyword form its shortest legal abbreviation: `BUshing` may be shortened to `BU`.
//!
//! ```text
//! statement BUshing / id                            # what it is, in one line
//!   role     both                                   # dataset, command or both
//!   solved   native bushing                         # native NAME, no-effect "why", external "why" or subroutine "what"
//!   source   adams_solver/state_bushing.html        # the page that documents it
//!   unchecked "K and TYPE"                          # if so: what could not be compared with a page
//!   I        ref<marker>  required                  # one line for people
//!   K        real[3]      = 0 0 0  [force/length]  >= 0  # type, count, default, dimension, range
//!   TYpe     word<Ring|SOlid>                       # one of several words
//!   leftout  K TYPE "what real ADAMS makes of them"   # arguments the built-in solver does not follow
//!   together IXX IYY                                # presence: exclusive, together, requires, oneof
//! ```
//!
//! `/ id` gives the statement an id space with its own name in lower case; `/ id space` gives it an id space with another name. The types
//! are `flag real int ref<space> word<..> function text texts file`. A count has one of the forms `[3]`, `[3..6]` or `[1..]`.
//!
//! A line `law NAME ARGUMENT...`, optionally followed by `for FLAG`, declares a force law of the statement. Functions are declared in
//! blocks:
//!
//! ```text
//! functions displacement measures
//!   solved   native measure
//!   source   adams_solver/cfunc_{}.html             # braces: the name in lower case
//!   DX       i[,j][,k]                              # the count is read off: 1 to 3
//! ```

mod check;
mod declaration;
mod emit;
mod parse;
mod textmate;

pub use declaration::{
    Argument, Count, Function, Grammar, Keyword, LeftOut, Presence, Range, Solved, Statement, Value,
};
pub use emit::{coverage, emit, with_coverage};
pub use parse::{ParseError, Problem, parse};
pub use textmate::textmate;

use std::path::{Path, PathBuf};

/// Reason why the grammar could not be read.
#[derive(Debug)]
pub enum ReadError {
    /// A file or folder could not be read.
    File(PathBuf, std::io::Error),
    /// A line violates the format, or declarations contradict each other.
    Parse(ParseError),
}

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Parse(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ReadError {}

/// Reads all `*.grammar` files of a folder in alphabetical order and checks the whole grammar.
///
/// # Errors
/// Returns an error if a file cannot be read, a line violates the format, or the whole grammar is inconsistent.
pub fn read(folder: &Path) -> Result<Grammar, ReadError> {
    let at = |error| ReadError::File(folder.to_path_buf(), error);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(at)? {
        let path = entry.map_err(at)?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "grammar")
        {
            paths.push(path);
        }
    }
    paths.sort();
    let mut grammar = Grammar::default();
    for path in paths {
        let text =
            std::fs::read_to_string(&path).map_err(|error| ReadError::File(path.clone(), error))?;
        let name = path.file_name().map_or_else(String::new, |name| {
            format!("grammar/{}", name.to_string_lossy())
        });
        parse(&name, &text, &mut grammar).map_err(ReadError::Parse)?;
    }
    check::check(&grammar).map_err(ReadError::Parse)?;
    Ok(grammar)
}
