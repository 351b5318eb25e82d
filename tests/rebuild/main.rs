//! Decks rebuilt from results: planted decks come back, and results of a real axle are repeated.

mod planted;
mod real;

#[path = "../common/mod.rs"]
mod common;
