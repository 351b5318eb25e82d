//! Benchmark of reading large and hostile decks: rates of the lossless document and of the typed model.
//!
//! `cargo bench --bench decks -- [MEGABYTES]`; the goals (150 MB/s for the document, 60 MB/s for the model) apply to 100 MB. A hostile file
//! is read at two sizes, the second one doubled; the time must not grow faster than the size. With `--write FILE` the large deck is only
//! written to a file, which `tests/bench/large.py` passes to the commands.

#[path = "large_deck.rs"]
mod large_deck;
#[path = "process.rs"]
mod process;

use std::time::Instant;

use admire_solver::model::Model;
use admire_syntax::text::Source;
use admire_syntax::{CommandFile, Dataset};
use large_deck::deck;
use process::{peak, rate, seconds};

fn main() {
    let megabytes = std::env::args()
        .skip(1)
        .find_map(|word| word.parse::<usize>().ok())
        .unwrap_or(100);
    let bytes = deck(megabytes << 20);
    if let Some(at) = std::env::args().position(|word| word == "--write") {
        let path = std::env::args().nth(at + 1).expect("the name of a file");
        std::fs::write(path, bytes).expect("room for the deck");
        return;
    }
    println!("{} processors", rayon::current_num_threads());
    let size = bytes.len();
    println!("memory before reading: {}", peak());
    let source = Source::new("large.adm", bytes);
    for round in 1..=3 {
        let start = Instant::now();
        let read = rate(
            "lossless document",
            || size,
            || Dataset::parse(source.clone()),
        );
        assert_eq!(
            (read.value.bytes().len(), read.diagnostics.len()),
            (size, 0)
        );
        let statements = read.value.statements().len();
        let model = rate("its typed model", || size, || Model::lower(&read.value));
        assert!(model.diagnostics.is_empty());
        let seconds = start.elapsed().as_secs_f64();
        let megabytes = size as f64 / 1e6;
        println!(
            "round {round}, bytes to typed model   {megabytes:.0} MB: {:>6.0} MB/s; {statements} statements, {} markers",
            megabytes / seconds,
            model.value.markers.len()
        );
    }
    println!("peak memory: {}", peak());
    for (what, piece) in [
        ("one line of (", &b"("[..]),
        ("one line of ,", b","),
        ("lines of ,", b",\n"),
        ("one line of letters", b"A"),
        ("unmatched quotes", b"\"a\n"),
        ("quotes on one line", b"\""),
        ("statement heads", b"PART/"),
        ("nested calls", b"VARIABLE/1,FUNCTION=SIN("),
        ("equals signs", b"A="),
        ("backslashes", b"\\"),
        ("continued lines", b"&\n"),
        ("semicolons", b";"),
        ("NUL", b"\0"),
    ] {
        let once = time(piece, 10 << 20);
        let twice = time(piece, 20 << 20);
        println!(
            "hostile, {what:<22} 10 MB: {once:>6.2} s of processor, 20 MB: {twice:>6.2} s, ratio {:.1}",
            twice / once
        );
    }
}

/// Returns the processor time, in seconds, for reading `size` bytes of a repeated pattern as a dataset and as a command file.
fn time(piece: &[u8], size: usize) -> f64 {
    let mut bytes = b"title\n".to_vec();
    while bytes.len() < size {
        bytes.extend_from_slice(piece);
    }
    let source = Source::new("hostile", bytes);
    seconds(|| {
        let dataset = Dataset::parse(source.clone());
        let commands = CommandFile::parse(source.clone());
        assert_eq!(dataset.value.bytes(), commands.value.bytes());
    })
}
