//! Identification: numbers of the deck from what was measured on the rig.
//!
//! The paper's loop, a direct solution and a fit of everything that was read, with what every method shares: the unknowns, how
//! well a sweep explains the readings, and the result as `identification.json` and edits. Knows no effect a model may lack: that
//! is diagnosis.

mod bounded;
pub mod direct;
mod evaluation;
mod fit;
pub mod global;
mod loaded;
mod problem;
pub mod regression;
pub mod reproduction;
mod unknowns;

pub use evaluation::{Discrepancy, compare};
pub use fit::{
    Fit, HeldOut, Marks, OffsetFit, ParameterFit, Status, UnidentifiableDirection, WheelFit,
};
pub use loaded::LoadedStudy;
pub use problem::{IdentifyError, Problem, Progress};
pub use unknowns::{Place, Unknown, unknowns};
