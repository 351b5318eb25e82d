//! The grammar of the dataset language as a file people read, and the generator that turns it into tables.
//!
//! `*.grammar` files declare statements, commands and functions; [`read`] parses them and [`emit`] prints the Rust tables of
//! `src/syntax/grammar/generated.rs`. Knows nothing about the crate it writes for, except the names of its types.
//!
//! # The format
//!
//! One line per fact; `#` begins a documentation comment of the line, `##` a remark that goes nowhere. In keywords the letters
//! that must be typed are capitals: `BUshing` may be cut to `BU`.
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
//! `/ id` gives the statement ids of the space with its own name in lower case; `/ id space` names another one. Types are
//! `flag real int ref<space> word<..> function text texts file`; a count is `[3]`, `[3..6]` or `[1..]`. Functions stand in blocks:
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

pub use declaration::{
    Argument, Count, Function, Grammar, Keyword, LeftOut, Presence, Range, Solved, Statement, Value,
};
pub use emit::{coverage, emit, with_coverage};
pub use parse::{ParseError, Problem, parse};

use std::path::{Path, PathBuf};

/// Why the grammar could not be read.
#[derive(Debug)]
pub enum ReadError {
    /// A file or folder could not be read.
    File(PathBuf, std::io::Error),
    /// A line that does not follow the format.
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

/// Reads every `*.grammar` file of a folder, in the order of their names.
///
/// # Errors
/// When a file cannot be read, or the first line that does not follow the format.
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
