//! Coverage-guided fuzzing of the readers under libFuzzer: `tests/fuzz/guided.sh dataset`.
//!
//! In an ordinary build, the program runs the reader on the files named as arguments, which reproduces a finding.
#![cfg_attr(fuzzing, no_main)]
#![allow(dead_code, unused_imports)] // Seeds, words and tests are those of `cargo test --test fuzz`.

#[path = "../common/mod.rs"]
mod common;
mod decks;
mod expressions;
mod harness;
mod laboratories;
mod mutation;
mod readers;
mod results;
mod seeds;
mod studies;

/// The reader named by the environment variable `FUZZ_READER`.
static READER: std::sync::LazyLock<fn(&[u8])> = std::sync::LazyLock::new(|| {
    readers::reader(&std::env::var("FUZZ_READER").expect("FUZZ_READER names a reader"))
});

#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| READER(bytes));

#[cfg(not(fuzzing))]
fn main() {
    for path in std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with('-'))
    {
        READER(&std::fs::read(&path).expect("a readable file"));
        println!("{path}: fine");
    }
}
