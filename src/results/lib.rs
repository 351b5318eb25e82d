//! Readers and writers of results files: XRF (`.res`), formatted results, requests (`.req`), graphics (`.gra`) and tabular output (`.out`).
//!
//! [`XrfReader`] reads an XRF file of any size step by step, and [`XrfWriter`] writes an XRF file. [`open_any`] recognises the kind of a
//! file from its content and opens it. A [`Catalogue`] contains the names of all columns. A [`Selection`] picks columns by patterns such as
//! `*/front_arm.X`.
//!
//! The layouts of the files are described in sections 6 and 12 of the guide's page `formats`; they were determined from files written by
//! ADAMS.
//!
//! The crate contains neither models nor solvers: writers receive names, units and values, and readers return them. The id of a column is
//! the 1-based position of its value in every output step.
//!
//! ```
//! use admire_results::{
//!     Catalogue, Component, Entity, Header, StepKind, Style, XrfReader, XrfWriter,
//! };
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let column = |name: &str, id| Component {
//!     name: name.to_string(),
//!     units: None,
//!     plot_label: None,
//!     id,
//! };
//! let entity = Entity {
//!     name: "front_arm".to_string(),
//!     entity: None,
//!     ent_type: None,
//!     object_id: None,
//!     comment: None,
//!     components: vec![column("TIME", 1), column("X", 2)],
//! };
//! let mut file = Vec::new();
//! let catalogue = Catalogue::new(vec![entity]);
//! let mut writer = XrfWriter::create(&mut file, &Header::default(), &catalogue, Style::default())?;
//! writer.step(StepKind::Dynamic, &[0.0, 12.5])?;
//! writer.step(StepKind::Dynamic, &[0.1, 13.5])?;
//! writer.finish("finished")?;
//!
//! // Read one column.
//! let mut reader = XrfReader::open("run.res", file.as_slice())?;
//! let entity = reader.catalogue().entities.iter().find(|e| e.name == "front_arm");
//! let id = entity.and_then(|e| e.component("X")).expect("a column").id;
//! let mut x = Vec::new();
//! while let Some(step) = reader.next_step()? {
//!     step.pick(&[id], &mut x)?;
//! }
//! assert_eq!(x, [12.5, 13.5]);
//! # Ok(())
//! # }
//! ```
#![warn(unreachable_pub)]
// Private modules link to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod blocks;
mod catalogue;
mod comparison;
mod difference_floor;
mod entity_kind;
mod error;
mod formatted;
mod fortran;
mod graphics_file;
mod graphics_reader;
mod groups;
mod header;
mod message_file;
mod number;
mod numbering;
mod open;
mod reader;
mod request_file;
mod results_table;
mod rewrite;
mod selection;
mod step;
mod step_filter;
mod step_kind;
mod table_reader;
mod tabular_file;
mod timestamp;
mod writer;
mod xml;
mod xrf_reader;
mod xrf_writer;

pub(crate) use catalogue::Column;
pub use catalogue::{Catalogue, Component, Entity};

pub use comparison::{ColumnDifference, Comparison, Tolerance, Worst, compare, compare_above};
pub use difference_floor::DifferenceFloor;
pub use entity_kind::EntityKind;
pub use error::ResultsError;
pub use formatted::FormattedResults;

pub use graphics_file::{
    GraphicsHead, GraphicsJoint, GraphicsMarker, GraphicsShape, GraphicsWriter,
};
pub use graphics_reader::GraphicsFile;
pub use groups::Groups;
pub use header::{Header, ResultUnits};
pub use message_file::{Analysis, Frame, MessageFile};
pub use number::NumberStyle;
pub(crate) use number::write_number;
pub use numbering::{Numbering, Stored};
pub use open::AnyResults;
pub use open::open_any;
pub use reader::ResultsReader;
pub use request_file::{RequestEntry, RequestFile, RequestWriter};
pub use results_table::ResultsTable;
pub use rewrite::{Change, rewrite};
pub use selection::{SelectedColumn, Selection};
pub use step::Step;
use step::Values;
pub use step_filter::StepFilter;
pub use step_kind::StepKind;
pub use tabular_file::Tabular;
pub use tabular_file::TabularRequest;
pub use tabular_file::write_tabular;
pub use timestamp::Timestamp;
pub use writer::ResultsWriter;
pub use xrf_reader::XrfReader;
pub use xrf_writer::{LineEnd, Style, XrfWriter};
