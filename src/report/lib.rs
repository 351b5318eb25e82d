//! Self-contained HTML pages with tables and SVG pictures.
//!
//! [`Page`] is assembled from [`Table`]s and [`Figure`]s. [`IdentificationReport`], [`DiagnosisReport`] and [`KcReport`] are complete pages.
//! [`scene`] is the three-dimensional view of a model. This crate only displays results: it does not solve models, and it writes no files.
//! All text from a study is escaped.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod agreement;
mod axis;
mod bars;
mod chart;
mod check;
mod convergence;
mod diagnosis;
mod diagnosis_phrases;
mod diagnosis_summary;
mod diagnosis_tables;
mod diagnosis_text;
mod diagnosis_view;
mod escape;
mod figure;
mod frame_place;
mod headline;
mod heat_map;
mod identification;
mod identification_summary;
mod interval;
mod kc;
mod kc_summary;
mod legend;
mod limits;
mod load_run;
mod load_table;
mod mark_scatter;
mod mirrored_marks;
mod number;
mod page;
mod parameter_name;
mod plausibility;
mod ranking;
mod repeats;
mod reproduction;
pub mod scene;
mod series;
mod slips;
mod study_figures;
mod study_view;
mod summary;
mod table;
mod tolerance_text;
mod topology_graph;
mod tune;
mod tune_spread;
mod tune_words;

pub use axis::axis_label;
pub use bars::Bars;
pub use chart::Chart;
pub use check::Verdict;
pub use diagnosis::DiagnosisReport;
pub use diagnosis_summary::diagnosis_summary;
pub use diagnosis_text::diagnosis_sentences;
pub use diagnosis_view::fit_in_words;
pub use escape::escape;
pub use figure::Figure;
pub(crate) use heat_map::HeatMap;
pub use identification::IdentificationReport;
pub use identification::{lead, status};
pub use identification_summary::identification_summary;
pub use kc::KcReport;
pub use kc::MeasuredCurve;
pub use number::number;
pub use page::Page;
pub use parameter_name::parameter_name;
pub use plausibility::Plausibility;
pub use ranking::sizes;
pub use reproduction::{
    Comparison, Curve, ReproducedCurves, ReproducedSection, ReproductionReport,
};
pub use scene::Scene;
pub use series::{Series, SeriesStyle};
pub use study_view::Positions;
pub(crate) use study_view::study_scene;
pub use summary::Summary;
pub use table::Align;
pub use table::Table;
pub use topology_graph::GraphBody;
pub use topology_graph::TopologyGraph;
pub use tune::{TuneReport, tune_summary};
pub use tune_spread::front_table;

pub use admire_syntax::units::short_unit;

/// Version of this program, and the commit from which it was built.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("ADMIRE_COMMIT"), ")");

/// Reason why a picture could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the picture '{title}': {reason}")]
pub struct DrawingError {
    /// Title of the picture.
    pub title: String,
    /// Message of the drawing library.
    pub reason: String,
}
