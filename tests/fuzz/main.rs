//! Fuzz tests of all readers with mutations of real files, reproducible from fixed random seeds. They check:
//!
//! - no panic and no hang;
//! - lossless reading, and diagnostics inside the file;
//! - local edits, and output that reads back as written.
//!
//! `guided.sh` runs the same readers under libFuzzer. `FUZZ_CASES=20000 cargo test --test fuzz` runs 20000 cases for each reader.
//! `FUZZ_FROM=N` begins with case N.

#[path = "../common/mod.rs"]
mod common;
mod decks;
mod expressions;
mod findings;
mod harness;
mod laboratories;
mod mutation;
mod readers;
mod results;
mod seeds;
mod studies;
