//! Foreign clients: MATLAB scripts under GNU Octave, and readers of results written by others.
//!
//! The clients know only `mdi` and the files that it writes. A client that is not installed is skipped with a notice; under CI this is a
//! failure.

mod client;
#[path = "../common/mod.rs"]
mod common;
mod identification;
mod octave;
mod python;
