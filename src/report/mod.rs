//! Self-contained HTML pages with tables and SVG pictures.
//!
//! Knows results and how a person reads them; neither solvers nor files. Every text that comes from a study is escaped.

mod agreement;
mod axis;
mod bars;
mod chart;
mod check;
mod convergence;
mod diagnosis;
mod diagnosis_view;
mod escape;
mod figure;
mod frame_place;
mod headline;
mod heat_map;
mod identification;
mod interval;
mod kc;
mod limits;
mod load_table;
mod mark_scatter;
mod mirrored_marks;
mod number;
mod page;
mod plausibility;
mod ranking;
mod repeats;
mod reproduction;
pub mod scene;
mod slips;
mod study_figures;
mod study_view;
mod table;
mod topology_graph;

pub(crate) use bars::Bars;
pub use chart::Mark;
pub(crate) use chart::{Chart, Series};
pub use check::Verdict;
pub(crate) use diagnosis::DiagnosisReport;
pub(crate) use diagnosis_view::fit_in_words;
pub use escape::escape;
pub use figure::Figure;
pub(crate) use heat_map::HeatMap;
pub(crate) use identification::IdentificationReport;
pub use identification::{lead, status};
pub(crate) use kc::{KcReport, MeasuredCurve};
pub use number::number;
pub(crate) use page::Page;
pub(crate) use plausibility::Plausibility;
pub(crate) use ranking::sizes;
pub use reproduction::ReproductionReport;
pub(crate) use scene::Scene;
pub use study_view::Positions;
pub(crate) use study_view::study_scene;
pub(crate) use table::Align;
pub use table::Table;
pub use topology_graph::Body;
pub(crate) use topology_graph::TopologyGraph;

pub(crate) use crate::units::short_unit;

/// The version of this program with the commit it was built from.
pub(crate) const VERSION: &str =
    concat!(env!("CARGO_PKG_VERSION"), " (", env!("ADMIRE_COMMIT"), ")");

/// Why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the picture '{title}': {reason}")]
pub struct DrawingError {
    /// Title of the picture.
    pub title: String,
    /// What the drawing library said.
    pub reason: String,
}
