//! The test rig: what was measured on it, and a virtual one that measures a deck.
//!
//! Study folders, marks and absolute orientation, bushing deflections, wheel angles, measuring noise, and effects that can be
//! planted. Knows nothing about what is inferred from the measurements: that is identification and diagnosis.

mod check;
pub mod deflection;
mod load;
mod measurement;
pub mod noise;
pub mod orientation;
mod resolve;
mod section;
/// Sections of `study.toml` with their defaults.
pub mod settings;
mod study;
mod table;
#[cfg(test)]
mod tests;
pub mod wheel;

pub use load::programme;
pub use measurement::{Case, Channel, MarkReading, MarkedPart, Measurement, PartMark, Wheel};
pub use resolve::part;
pub use section::Spelled;
pub use study::{MarkFiles, Study};
pub use table::{Cell, Table};
