//! The test rig: what was measured on it, and a virtual one that measures a deck.
//!
//! Study folders, marks and absolute orientation, bushing deflections, wheel angles, measuring noise, and effects that can be
//! planted. Knows nothing about what is inferred from the measurements: that is identification and diagnosis.

mod check;
pub mod deflection;
pub mod effect;
mod kc_curves;
mod kc_readings;
mod kc_starter;
mod load;
mod load_table;
mod measurement;
mod missing;
pub mod noise;
pub mod orientation;
mod readings;
mod resolve;
mod rest;
mod rig_options;
mod rigidity;
mod rows;
mod scatter;
mod schema;
mod section;
mod sensors;
/// Sections of `study.toml` with their defaults.
pub mod settings;
mod starter;
mod stated;
mod study;
mod study_folder;
mod summary;
mod summary_readings;
mod table;
#[cfg(test)]
mod tests;
mod tolerances;
mod virtual_rig;
pub mod wheel;
mod wheel_readings;

pub use kc_curves::{Curve, CurveSettings, Helper, KcSettings, with_helpers};
pub use load::programme;
pub use load_table::LoadTable;
pub use measurement::{
    Case, Channel, MarkReading, MarkedPart, Measurement, PartMark, Reference, Wheel,
};
pub use missing::missing;
pub use resolve::part;
pub use rigidity::{ForeignMarks, foreign_marks};
pub use scatter::Scatter;
pub use schema::schema;
pub use section::{Holds, Key, Spelled, meant};
pub use sensors::{Channels, with_channels};

pub use rig_options::RigOptions;
pub use starter::{Kind, Starter};
pub use stated::{Stated, ToleranceSettings};
pub use study::{MarkFiles, Study, study_keys};
pub use summary::{Over, Summary, SummaryKind, Taken};
pub use table::{Cell, Table};
pub use tolerances::Tolerances;
pub use virtual_rig::{RigRun, virtual_rig, virtual_rig_watched};
