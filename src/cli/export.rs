use std::path::PathBuf;

use admire_syntax::{Dataset, json};

use super::Outcome;
use super::shell::{Exit, Shell};

/// Print a dataset as JSON; `admire import` applies changes in the JSON to the dataset.
///
/// The JSON contains `title`, and `statements` with `kind`, `id`, `name` and `arguments`. Numbers are in the deck's units, angles in
/// radians.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  admire export front.adm --json > front.json")]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// Print JSON; no other format exists yet.
    #[arg(long)]
    json: bool,
    /// File to write; by default, standard output.
    #[arg(long, short)]
    out: Option<PathBuf>,
}

/// Prints or writes the JSON.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    let dataset = Dataset::parse(source).value;
    let text = serde_json::to_string_pretty(&json::export(&dataset)).expect("JSON values print");
    match &arguments.out {
        Some(path) => shell.write(path, (text + "\n").as_bytes())?,
        None => shell.print(&(text + "\n")),
    }
    Ok(Exit::Fine)
}
