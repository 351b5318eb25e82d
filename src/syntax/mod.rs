//! The text of datasets and command files, losslessly.
//!
//! The truth is source text + spans + edits: tokens tile the bytes, every statement keeps where its parts stand, and a change is
//! a list of [`Edit`](crate::text::Edit)s. Knows nothing about what a model means: references are numbers here.

mod address;
mod dataset;
pub mod expression;

pub use address::Address;
pub use dataset::{Argument, Number, Statement, Token, TokenKind, Value};
pub use expression::Expression;
