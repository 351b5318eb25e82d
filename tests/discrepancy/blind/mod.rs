//! Blind test harness: a seed draws what is wrong with an axle, a virtual rig measures it, and the diagnosis sees only the study folder.
//!
//! The sealed truth is opened afterwards. Nothing is selected by its outcome: seeds count from zero, and sizes are drawn before any
//! diagnosis. The size of an effect is the rms shift of the readings, in units of their noise, that neither stiffnesses nor nuisances can
//! follow.

pub mod axle;
pub mod detect;
pub mod draw;
pub mod judge;
pub mod sized;
pub mod trial;
pub mod usual_errors;

pub use draw::Axle;
pub use judge::{Score, Tally};
pub use trial::{Trial, run};
