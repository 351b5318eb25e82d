//! The dataset language as data: statements, commands and functions with their arguments.
//!
//! The tables in `generated` are written by `cargo run -p grammar` from `grammar/*.grammar`; this module looks things up
//! in them. Knows nothing about texts, models or solving.

mod definition;
mod generated;
mod lookup;

pub(crate) use definition::{ArgumentDef, Bound, Choice, Components, Count, LawDef, Presence};
pub use definition::{FunctionDef, Role, Solved, StatementDef, ValueKind};
pub use generated::{FUNCTIONS, STATEMENTS};
pub(crate) use lookup::Lookup;
pub(crate) use lookup::{all_nearest, find_argument, find_choice, find_function, find_statement};
pub use lookup::{nearest, statement};
