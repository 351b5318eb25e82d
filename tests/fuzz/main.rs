//! Mutations of real files, of a fixed seed, through every reader: no panic, no hang, nothing lost, complaints inside the file, edits
//! local, and what is written is read back.
//!
//! `guided.sh` runs the same readers under libFuzzer. `FUZZ_CASES=20000 cargo test --test fuzz` runs as many cases for every reader; `FUZZ_FROM=N` begins with case N.

#[path = "../common/mod.rs"]
mod common;
mod decks;
mod expressions;
mod findings;
mod harness;
mod mutation;
mod readers;
mod results;
mod seeds;
mod studies;
