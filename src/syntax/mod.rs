//! The text of datasets and command files, losslessly.
//!
//! The truth is source text + spans + edits: tokens tile the bytes, every statement keeps where its parts stand, and a change is
//! a list of [`Edit`](crate::text::Edit)s. Knows nothing about what a model means: references are numbers here.

mod address;
pub mod catalogue;
mod command_file;
mod dataset;
pub mod describe;
pub mod diff;
mod editor;
pub mod expression;
mod fault;
pub mod files;
mod fix;
mod floating;
pub(crate) mod hash;
pub mod json;
mod keywords;
pub mod layout;
mod lexer;
mod lines;
pub mod lint;
mod marker_points;
mod naming;
mod new_statement;
pub mod number;
mod overlay;
mod parser;
mod pattern;
pub mod pieces;
mod places;
pub mod property;
mod removal;
pub mod renumber;
mod shared;
mod spelling;
mod statement;
mod statements;
mod style;
mod token;
mod topology;
mod typed;
mod value;

pub use address::Address;
pub use command_file::CommandFile;
pub(crate) use command_file::Head;
pub use dataset::Dataset;
pub(crate) use dataset::missing_end;
pub use expression::Expression;
pub(crate) use fault::{Fault, Wrong};
pub use fix::all_fixes;
pub(crate) use fix::safe_fixes;
pub(crate) use floating::floating_faults;
pub(crate) use marker_points::MarkerPoints;
pub use new_statement::NewStatement;
pub use overlay::excludes;
pub(crate) use overlay::{Overlay, Stated};
pub(crate) use shared::Shared;
pub(crate) use spelling::spell_like;
pub use statement::{Argument, Statement, Value};
pub use token::{Number, Token};
pub(crate) use token::{TokenKind, as_id};
pub use topology::{Object, Reference};
pub(crate) use topology::{Removal, Topology};
