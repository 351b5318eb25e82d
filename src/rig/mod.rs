//! The test rig: what was measured on it, and a virtual one that measures a deck.
//!
//! Study folders, marks and absolute orientation, bushing deflections, wheel angles, measuring noise, and effects that can be
//! planted. Knows nothing about what is inferred from the measurements: that is identification and diagnosis.

mod check;
pub mod deflection;
pub mod effect;
mod frame_motion;
mod frame_place;
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
mod spin;
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

pub(crate) use frame_place::FramePlace;
pub use kc_curves::Curve;

pub use load::programme;
pub use load_table::LoadTable;
pub(crate) use measurement::MarkReading;
pub use measurement::{Case, Channel, Measurement, Reference, Wheel};
pub use missing::missing;
pub use resolve::part;
pub(crate) use rigidity::ForeignMarks;
pub(crate) use rigidity::foreign_marks;
pub use scatter::Scatter;
pub(crate) use schema::schema;
pub use section::meant;

pub(crate) use sensors::Channels;
pub(crate) use sensors::with_channels;

pub use rig_options::RigOptions;
pub use starter::Kind;
pub(crate) use starter::Starter;
pub(crate) use stated::{Stated, ToleranceSettings};
pub use study::Study;
pub use summary::Over;
pub(crate) use summary::Summary;
pub use table::{Cell, Table};
pub use tolerances::Tolerances;
pub(crate) use virtual_rig::virtual_rig_watched;
pub use virtual_rig::{RigRun, virtual_rig};
