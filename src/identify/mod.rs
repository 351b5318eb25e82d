//! Identification: numbers of the deck from what was measured on the rig.
//!
//! The paper's loop, a direct solution and a fit of everything that was read, with what every method shares: the unknowns, how
//! well a sweep explains the readings, and the result as `identification.json` and edits. Knows no effect a model may lack: that
//! is diagnosis.

mod bounded;
pub mod direct;
mod evaluation;
mod fit;
mod free_motions;
pub mod global;
mod goodness;
mod loaded;
mod noise;
mod problem;
pub mod regression;
mod repeated;
pub mod reproduction;
pub(crate) mod slips;
pub mod structure;
mod unknowns;

pub(crate) use evaluation::written;
pub use evaluation::{Discrepancy, compare};
pub use fit::{
    CurveHeldOut, Fit, HeldOut, Marks, NOT_CONVERGED, NoiseFound, OffsetFit, ParameterFit, Status,
    ToleranceFound, UnidentifiableDirection, WheelFit, Written,
};
pub(crate) use free_motions::{meet_marks, meet_marks_of_all};
pub use goodness::{FitTest, ReadingsLeft, Verdict};
pub use loaded::LoadedStudy;
pub use noise::estimate_noise;
pub(crate) use problem::IdentifyError;
pub use problem::{Problem, Progress};
pub use repeated::{BootstrapMade, PosteriorMade, Repeated};
pub use structure::StructureTest;
pub use unknowns::{Place, Unknown, unknowns};
