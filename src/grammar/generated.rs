//! Written by `cargo run -p grammar` from `grammar/*.grammar`. Do not edit.

use super::{FunctionDef, StatementDef};

/// Every statement and command.
pub static STATEMENTS: &[StatementDef] = &[];
/// Every function of expressions.
pub static FUNCTIONS: &[FunctionDef] = &[];
