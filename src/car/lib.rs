//! Property, subsystem and assembly files of Adams/Car in TeimOrbit format.
//!
//! [`PropertyFile`](admire_syntax::property::PropertyFile) is the lossless reader of every such file. This crate adds the addresses of its
//! values ([`entries`], [`select`]), edits of single values ([`set`]), differences ([`diff`](fn@diff)) and complaints ([`check`](fn@check)).
//! Typed views exist for subsystems, assemblies, springs, tyres and bushings; all other files are text. [`WriteBack`] writes results into a
//! subsystem: hardpoints, scale factors and preloads of bushings, and property files with learned curves.
//!
//! The basis for each interpretation of a file is listed in grammar/NOTES.md.
//!
//! Modules import in one direction only: `settings`, `side`, `file_units` <- `entry` <- `edit`, `diff`, `hardpoint`, `parameter`, `bushing`, `spring`,
//! `tire` <- `subsystem`, `assembly` <- `check`, `names`, `block_edit`, `word_change` <- `hardpoint_rows` <-
//! `write_back`.
//!
//! ```
//! use admire_car::{select, set};
//! use admire_syntax::property::PropertyFile;
//! use admire_syntax::text::{Source, apply_edits};
//!
//! let text = "[MDI_HEADER]\nFILE_TYPE = 'sub'\n[UNITS]\nLENGTH = 'mm'\n[HARDPOINT]\n\
//!     {hardpoint_name symmetry x_value y_value z_value}\n'lca_outer  ' 'left/right' 10.0 -600.0 150.0\n";
//! let file = PropertyFile::parse(Source::new("front.sub", text)).value;
//! let found = select(&file, "HARDPOINT/lca_outer.y_value").expect("one value");
//! let edits = set(&file, &found[0], "-601.5").expect("a number");
//! let changed = apply_edits(text.as_bytes(), &edits).expect("one place");
//! assert_eq!(changed, text.replace("-600.0", "-601.5").as_bytes());
//! ```
#![warn(unreachable_pub)]
// Private modules link to private items.
#![allow(rustdoc::private_intra_doc_links)]

mod assembly;
mod block_edit;
mod bushing;
mod check;
mod diff;
mod edit;
mod entry;
mod file_units;
mod hardpoint;
mod hardpoint_rows;
mod names;
mod parameter;
mod settings;
mod side;
mod spring;
mod subsystem;
mod tire;
mod word_change;
mod write_back;

pub use assembly::Assembly;
pub use bushing::{BushingProperty, Curve, OddLaw, OddTerm};
pub use check::check;
pub use diff::diff;
pub use edit::{set, set_number};
pub use entry::{Entry, entries, select};
pub use hardpoint::Hardpoint;
pub use hardpoint_rows::HardpointMove;
pub use names::{BushingName, bushing_name};
pub use parameter::Parameter;
pub use settings::HARDPOINT_MATCH_MM;
pub use side::{Side, Symmetry};
pub use spring::Spring;
pub use subsystem::{BushingAssembly, Subsystem};
pub use tire::Tire;
pub use word_change::{LearnedFile, NotWritten, WordChange};
pub use write_back::{BushingChange, WriteBack};
