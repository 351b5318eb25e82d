//! Study folders: a deck, load cases and measurements.
//!
//! [`Study`] is the content of `study.toml` together with the tables that it names. [`settings`] holds the sections of `study.toml` with their
//! defaults. A [`Measurement`] holds the readings, with all names resolved in the model: marks (measured points) on parts, the wheel, scalar
//! sensors, curves, and summaries of curves.
//!
//! [`orientation`] computes the pose of a part from its marks, and [`deflection`](mod@deflection) the deflection of a bushing. [`solver`]
//! creates the solver backend of a study, and [`permission`] decides which programs the backend may start. Inference from the readings is in
//! `admire-identify`.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod available;
mod car;
mod car_link;
mod check;
mod constant;
pub mod deflection;
/// SHA-256 digest of files.
pub mod digest;
mod frame_place;
mod kc_curves;
mod kc_readings;
mod kc_starter;
pub mod leftover;
mod load;
mod measurement;
mod missing;
pub mod noise;
pub mod orientation;
mod part_name;
pub mod permission;
mod priors;
mod quantity;
pub mod resolve;
mod rigidity;
mod rows;
mod schema;
/// Typed queries of the sections of a TOML file, with diagnostics for keys that no query uses.
pub mod section;
mod sensors;
/// Sections of `study.toml` with their defaults.
pub mod settings;
pub mod solver;
mod starter;
mod stated;
mod study;
mod summary;
mod summary_readings;
mod table;
mod target_settings;
#[cfg(test)]
mod tests;
mod unknown_settings;
pub mod wheel;
mod wheel_readings;

pub use available::{Available, LoadRange, Places};
pub use car::CarSettings;
pub use car_link::CarLink;
pub use constant::Constant;
pub use digest::digest;
pub use frame_place::FramePlace;
pub use kc_curves::Curve;
pub use load::programme;
pub use measurement::MarkReading;
pub use measurement::MarkedPart;
pub use measurement::{Case, Channel, Measurement, Reference, Wheel};
pub use missing::missing;
pub use noise::Noise;
pub use part_name::part;
pub use permission::NamedProgram;
pub use priors::CausePriors;
pub use quantity::Quantity;
pub use rigidity::ForeignMarks;
pub use rigidity::foreign_marks;
pub use schema::schema;
pub use section::did_you_mean;
pub use sensors::Channels;
pub use sensors::with_channels;
pub use starter::Kind;
pub use starter::Starter;
pub use stated::PriorSetting;
pub use stated::ToleranceSettings;
pub use study::Study;
pub use summary::Over;
pub use summary::Summary;
pub use summary_readings::written;
pub use table::{Cell, Table, split};
pub use target_settings::{GoalPlace, GoalScope, GoalSettings, TargetSettings, Wanted};
pub use unknown_settings::{UnknownForm, UnknownSettings};
pub use wheel::WheelReading;
