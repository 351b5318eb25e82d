//! The blind harness: a seed draws what is wrong with an axle, a virtual rig measures it, the diagnosis sees the study folder alone,
//! then the sealed truth is opened.
//!
//! Nothing here is chosen by its outcome: seeds are counted from zero, and sizes are drawn before anything is diagnosed. A size is
//! stated as the rms shift of the readings, in units of their noise, that neither stiffnesses nor nuisances can follow.

pub mod axle;
pub mod detect;
pub mod draw;
pub mod judge;
pub mod sized;
pub mod trial;

pub use draw::Axle;
pub use judge::{Score, Tally};
pub use trial::{Trial, run};
