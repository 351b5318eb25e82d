//! The text of ADAMS datasets (`.adm`) and command files (`.acf`), which is read and edited without loss of a byte.
//!
//! [`Dataset`] and [`CommandFile`] hold a file as tokens and statements with their locations. A change is a list of [`Edit`](text::Edit)s
//! that touch only the bytes of the changed values. An [`Address`] such as `BUSHING/12.K.2` names one value. [`lint`] checks a dataset, and
//! every problem found is a [`Diagnostic`](diagnostic::Diagnostic) with its location. [`grammar`] contains tables of statements, commands
//! and functions, and [`units`] the units of a dataset. References between objects are kept as ids; `admire-solver` resolves them into a
//! model.
//!
//! ```
//! use admire_syntax::text::Source;
//! use admire_syntax::{Address, Dataset};
//!
//! let deck = "A small deck\nPART/1, GROUND\nPART/2, MASS = 2.5, CM = 3\nMARKER/3, PART = 2\nEND\n";
//! let read = Dataset::parse(Source::new("small.adm", deck));
//! assert!(!read.has_errors());
//! let dataset = read.value;
//!
//! // Read a number, change it, write the text: all other bytes stay.
//! let mass = Address::parse("PART/2.MASS", &dataset).expect("an address");
//! assert_eq!(dataset.value_at(&mass), Some(2.5));
//! let edits = dataset.set(&mass, 3.0).expect("a mass may be 3");
//! let changed = dataset.text_after(&edits).expect("edits of one value do not overlap");
//! assert_eq!(changed.bytes(), deck.replace("2.5", "3.0").as_bytes());
//! ```
#![warn(unreachable_pub)]
// Private modules link to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod address;
pub mod car_field;
pub mod catalogue;
mod command_file;
mod dataset;
pub mod describe;
pub mod diagnostic;
pub mod diff;
mod editor;
pub mod expression;
mod fault;
pub mod files;
mod fix;
mod floating;
pub mod grammar;
pub mod hash;
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
pub mod text;
mod token;
mod topology;
mod typed;
pub mod units;
mod value;

/// Components of a force and torque between two markers, in the words of a GFORCE and of results.
pub const FORCE_COMPONENTS: [&str; 6] = ["FX", "FY", "FZ", "TX", "TY", "TZ"];

pub use address::Address;
pub use command_file::CommandFile;
pub(crate) use command_file::Head;
pub use dataset::Dataset;
pub use dataset::missing_end;
pub use expression::Expression;
pub use fault::Fault;
pub use fault::Wrong;
pub use fix::all_fixes;
pub use fix::safe_fixes;
pub use floating::floating_faults;
pub use marker_points::MarkerPoints;
pub use new_statement::NewStatement;
pub use overlay::Overlay;
pub use overlay::Stated;
pub use overlay::excludes;
pub(crate) use shared::Shared;
pub use spelling::spell_like;
pub use statement::{Argument, Statement, Value};
pub(crate) use token::TokenKind;
pub use token::as_id;
pub use token::{Number, Token};
pub use topology::Removal;
pub use topology::Topology;
pub use topology::{ObjectId, Reference};
