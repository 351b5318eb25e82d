//! `cargo run -p grammar` rewrites `src/grammar/generated.rs` from `grammar/*.grammar`; with `--coverage` it prints the
//! coverage table of the README instead.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let grammar = match grammar::read(folder) {
        Ok(grammar) => grammar,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if std::env::args().any(|argument| argument == "--coverage") {
        print!("{}", grammar::coverage(&grammar));
        return ExitCode::SUCCESS;
    }
    let path = folder.join("../src/grammar/generated.rs");
    let statements = grammar.statements.len();
    let functions = grammar.functions.len();
    match std::fs::write(&path, grammar::emit(&grammar)) {
        Ok(()) => {
            println!(
                "src/grammar/generated.rs: {statements} statements and commands, {functions} functions"
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}
