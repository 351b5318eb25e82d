//! Pages in a real browser: no errors, all pictures drawn, working controls, and no content wider than a phone.
//!
//! The tests run headless Chromium. Without it, they are skipped with a notice; with ADMIRE_REQUIRE_CHROMIUM=1, its absence is a failure.

#[path = "../common/mod.rs"]
mod common;

mod browser;
mod reports;
mod views;
