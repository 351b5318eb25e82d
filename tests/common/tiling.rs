//! What reading loses: nothing. Real files, and what holds of every file that is read.

use admire_syntax::{CommandFile, Dataset, Statement, Token};

use super::{files_below, shared};

/// Every real file with this ending, with its bytes; empty if the shared material is not there.
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

/// Tokens start where the one before ends, from the first byte to the last, and each one that means something lies in exactly
/// one statement, which reads the same tokens by itself.
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
