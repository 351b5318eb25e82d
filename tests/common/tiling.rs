//! Checks that reading loses nothing: real files, and properties that hold for every file.

use admire_syntax::{CommandFile, Dataset, Statement, Token};

use super::{files_below, shared};

/// Returns all real files with this extension and their bytes; empty if the shared material is missing.
pub fn real_files(ending: &str) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for folder in ["real-decks", "reference"]
        .iter()
        .filter_map(|name| shared(name))
    {
        for path in files_below(&folder, ending) {
            files.push((path.display().to_string(), std::fs::read(&path).unwrap()));
        }
    }
    files
}

/// Asserts that tokens tile the bytes without gaps, and that each significant token is in exactly one statement.
///
/// `own` returns the tokens of a statement lexed separately, which must be the same ones.
pub fn assert_tiled(
    bytes: &[u8],
    tokens: &[Token],
    statements: &[Statement],
    own: impl Fn(&Statement) -> Vec<Token>,
) {
    let mut at = 0;
    for token in tokens {
        assert_eq!(token.span.start(), at, "a gap or overlap before {token:?}");
        assert!(token.span.end() > at, "an empty token at {at}");
        at = token.span.end();
    }
    assert_eq!(at, bytes.len());
    let owned: Vec<Token> = statements.iter().flat_map(own).collect();
    let meant = |tokens: &[Token]| -> Vec<Token> {
        tokens
            .iter()
            .copied()
            .filter(|token| !token.kind.is_trivia())
            .collect()
    };
    assert_eq!(meant(tokens), meant(&owned));
}

pub fn assert_dataset(dataset: &Dataset, bytes: &[u8]) {
    assert_eq!(dataset.bytes(), bytes);
    let tokens: Vec<Token> = dataset.tokens().collect();
    assert_tiled(bytes, &tokens, dataset.statements(), |statement| {
        dataset.statement_tokens(statement).collect()
    });
}

pub fn assert_commands(file: &CommandFile, bytes: &[u8]) {
    assert_eq!(file.bytes(), bytes);
    let tokens: Vec<Token> = file.tokens().collect();
    assert_tiled(bytes, &tokens, file.commands(), |command| {
        let (start, end) = (command.span.start(), command.span.end());
        let within = |token: &&Token| (start..end).contains(&token.span.start());
        tokens.iter().filter(within).copied().collect()
    });
}
