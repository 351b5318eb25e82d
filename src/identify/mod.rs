//! From measurements to stiffnesses: the paper's loop, a direct solution, and a fit of everything that was read.
//!
//! Knows no files and prints nothing.

pub mod global;
