//! Clients that nobody here made the rules for: MATLAB scripts under GNU Octave, and readers of results written by others.
//!
//! They know `mdi` and the files it writes, nothing else of this project. A client that is not installed is skipped with a
//! notice; under CI that is a failure.

mod client;
#[path = "../common/mod.rs"]
mod common;
mod identification;
mod octave;
mod python;
