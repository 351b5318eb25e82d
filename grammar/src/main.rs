//! Rewrites `src/syntax/grammar/generated.rs`, the coverage table of the guide and the TextMate grammar of the editor extension from the
//! files `grammar/*.grammar` (`cargo run -p grammar`).
//!
//! With the option `--coverage`, the program prints the coverage table instead.

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
    let path = folder.join("../src/syntax/grammar/generated.rs");
    let statements = grammar.statements.len();
    let functions = grammar.functions.len();
    let page = folder.join("../src/guide/coverage.md");
    let colours = folder.join("../src/lsp/vscode/syntaxes/adams.tmLanguage.json");
    let written = std::fs::write(&path, grammar::emit(&grammar)).and_then(|()| {
        std::fs::write(&colours, grammar::textmate(&grammar))?;
        let text = std::fs::read_to_string(&page)?;
        match grammar::with_coverage(&text, &grammar) {
            Some(fresh) => std::fs::write(&page, fresh),
            None => Err(std::io::Error::other(
                "src/guide/coverage.md has no place for the coverage table",
            )),
        }
    });
    match written {
        Ok(()) => {
            println!(
                "src/syntax/grammar/generated.rs, src/guide/coverage.md, src/lsp/vscode/syntaxes/adams.tmLanguage.json: {statements} statements and commands, {functions} functions"
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
