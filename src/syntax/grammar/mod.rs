//! The dataset language as data: statements, commands and functions with their arguments.
//!
//! The tables in `generated` are written by `cargo run -p grammar` from `grammar/*.grammar`. This module defines the types of the tables
//! and functions to look up their entries. It is independent of texts, models and solvers.

mod definition;
mod generated;
mod lookup;

pub use definition::ArgumentDef;
pub use definition::Choice;
pub use definition::Components;
pub use definition::LawDef;
pub(crate) use definition::{Bound, Count, Presence};
pub use definition::{FunctionDef, Role, Solved, StatementDef, ValueKind};
pub use generated::{FUNCTIONS, STATEMENTS};
pub use lookup::Lookup;
pub use lookup::find_argument;
pub use lookup::find_function;
pub use lookup::find_statement;
pub(crate) use lookup::{all_nearest, find_choice};
pub use lookup::{nearest, statement};
