//! Result files: XRF (`.res`), its older formatted form, requests (`.req`), graphics (`.gra`) and tabular output (`.out`).
//!
//! Layouts and numbers are those of guide/formats.md 6 and 12, measured on files that ADAMS wrote. Knows nothing about
//! models and solvers: a writer is told names, units and values; a reader gives back the same. A component's id is the
//! 1-based position of its value in every step, and nothing else ever decides which number belongs to which name.

mod blocks;
mod catalogue;
mod comparison;
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

pub use comparison::{Comparison, Tolerance, Worst, compare};
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
pub(crate) use open::AnyResults;
pub use open::open_any;
pub use reader::ResultsReader;
pub use request_file::{RequestEntry, RequestFile, RequestWriter};
pub(crate) use results_table::ResultsTable;
pub use rewrite::{Change, rewrite, rewrite_file};
pub use selection::{SelectedColumn, Selection};
pub use step::Step;
use step::Values;
pub use step_filter::StepFilter;
pub use step_kind::StepKind;
pub(crate) use tabular_file::write_tabular;
pub(crate) use tabular_file::{Tabular, TabularRequest};
pub use timestamp::Timestamp;
pub(crate) use writer::ResultsWriter;
pub use xrf_reader::XrfReader;
pub use xrf_writer::{LineEnd, Style, XrfWriter};
