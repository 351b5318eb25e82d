//! Pages in a real browser: no error, every picture drawn, controls that move it, nothing wider than a telephone.
//!
//! Runs headless Chromium where it is installed and says so where it is not; with ADMIRE_REQUIRE_CHROMIUM=1 its absence is a failure.

#[path = "../common/mod.rs"]
mod common;

mod browser;
mod reports;
mod views;
