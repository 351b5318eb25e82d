//! Self-contained HTML pages with tables and SVG pictures.
//!
//! Knows results and how a person reads them; neither solvers nor files. Every text that comes from a study is escaped.

mod chart;
mod diagnosis;
mod heat_map;
mod identification;
mod page;
mod reproduction;
mod table;

pub use chart::{Chart, Mark, Series};
pub use diagnosis::DiagnosisReport;
pub use heat_map::HeatMap;
pub use identification::{IdentificationReport, lead, number, status};
pub use page::{Page, escape};
pub use reproduction::ReproductionReport;
pub use table::{Align, Table};

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the picture '{title}': {reason}")]
pub struct DrawingError {
    /// Title of the picture.
    pub title: String,
    /// What the drawing library said.
    pub reason: String,
}
