//! Decks rebuilt from results: planted decks are recovered, and results of a real axle are reproduced.

mod planted;
mod real;

#[path = "../common/mod.rs"]
mod common;
