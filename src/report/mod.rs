//! Self-contained HTML pages with tables and SVG pictures.
//!
//! Knows results and how a person reads them; neither solvers nor files. Every text that comes from a study is escaped.

mod agreement;
mod axis;
mod bars;
mod chart;
mod convergence;
mod diagnosis;
mod diagnosis_view;
mod escape;
mod figure;
mod headline;
mod heat_map;
mod identification;
mod interval;
mod kc;
mod limits;
mod number;
mod page;
mod plausibility;
mod ranking;
mod repeats;
mod reproduction;
pub mod scene;
mod study_figures;
mod study_view;
mod table;
mod topology_graph;

pub use bars::Bars;
pub use chart::{Chart, Mark, Series};
pub use diagnosis::DiagnosisReport;
pub use escape::escape;
pub use figure::Figure;
pub use heat_map::HeatMap;
pub use identification::{IdentificationReport, lead, status};
pub use kc::{KcReport, MeasuredCurve};
pub use number::{number, short_unit};
pub use page::Page;
pub use plausibility::{Check, Plausibility, Verdict};
pub use reproduction::ReproductionReport;
pub use scene::Scene;
pub use study_view::{Positions, study_scene};
pub use table::{Align, Table};
pub use topology_graph::{Body, Link, TopologyGraph};

/// The version of this program with the commit it was built from.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("ADMIRE_COMMIT"), ")");

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the picture '{title}': {reason}")]
pub struct DrawingError {
    /// Title of the picture.
    pub title: String,
    /// What the drawing library said.
    pub reason: String,
}
