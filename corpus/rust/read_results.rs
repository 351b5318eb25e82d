//! Reads a results file: `cargo run --example read_results [FILE.res]`. Without a file, the example solves a deck and reads the results
//! file of that run.

use admire::{Deck, Error, Results, SharedProgress};

fn main() -> Result<(), Error> {
    let file = match std::env::args().nth(1) {
        Some(file) => file.into(),
        None => written()?,
    };
    let results = Results::open(&file)?;
    println!(
        "{}: {} columns",
        results.path().display(),
        results.columns().len()
    );
    for column in results.columns().iter().take(5) {
        let values = results.column(&column.path, &SharedProgress::default())?;
        println!("{:24} {values:?}", column.path);
    }
    Ok(())
}

/// Solves a deck and returns the path of the results file.
fn written() -> Result<std::path::PathBuf, Error> {
    let run = Deck::open("corpus/pseudo-mcpherson/model.adm")?.solve()?;
    let file = std::env::temp_dir().join("admire-read-results.res");
    run.write(&file, true)?;
    Ok(file)
}
