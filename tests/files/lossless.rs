//! Tests that bytes, tokens and statements of every real deck and command file are preserved.

use std::collections::BTreeMap;

use admire_syntax::text::Source;
use admire_syntax::{CommandFile, Dataset};

pub use crate::common::tiling::{assert_commands, assert_dataset, real_files};

#[test]
fn every_real_deck_is_tiled_by_its_statements() {
    for (name, bytes) in real_files("adm") {
        let checked = Dataset::parse(Source::new(name.as_str(), bytes.clone()));
        assert_dataset(&checked.value, &bytes);
        assert_eq!(checked.diagnostics, [], "{name}");
    }
}

#[test]
fn every_real_command_file_is_tiled_by_its_commands() {
    for (name, bytes) in real_files("acf") {
        let checked = CommandFile::parse(Source::new(name.as_str(), bytes.clone()));
        let file = &checked.value;
        assert_commands(file, &bytes);
        assert_eq!(checked.diagnostics, [], "{name}");
        // Every command belongs to exactly one line, the line that completes it.
        let mut happened = Vec::new();
        for line in file.lines() {
            happened.extend(line.commands.clone());
        }
        assert_eq!(happened, (0..file.commands().len()).collect::<Vec<_>>());
    }
}

/// Counts statements in a simple independent way: by lines that begin with a letter and do not follow a continued line.
fn crude_counts(bytes: &[u8]) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    let mut continued = false;
    for line in bytes.split(|byte| *byte == b'\n').skip(1) {
        let line = String::from_utf8_lossy(line);
        let line = line.trim_end();
        let starts = !continued && line.starts_with(|c: char| c.is_ascii_alphabetic());
        continued = line.ends_with('&');
        if starts {
            let word: String = line.chars().take_while(char::is_ascii_alphabetic).collect();
            let word = line[..line.find('/').unwrap_or(word.len())].to_ascii_uppercase();
            *counts.entry(word.clone()).or_insert(0) += 1;
            if word == "END" {
                break;
            }
        }
    }
    counts
}

#[test]
fn statement_counts_equal_an_independent_count() {
    for (name, bytes) in real_files("adm") {
        let dataset = Dataset::parse(Source::new(name.as_str(), bytes.clone())).value;
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for statement in dataset.statements() {
            let kind = statement.kind().expect("real decks hold known statements");
            *counts.entry(kind.to_string()).or_insert(0) += 1;
        }
        assert_eq!(counts, crude_counts(&bytes), "{name}");
    }
}

#[test]
fn command_files_begin_in_three_ways() {
    let parse = |text: &str| {
        let parsed = CommandFile::parse(Source::new("t.acf", text.as_bytes().to_vec()));
        assert_eq!(parsed.diagnostics, []);
        let file = parsed.value;
        assert_commands(&file, text.as_bytes());
        let head = file.head().map(|head| {
            let text = |span| file.source().text(span).into_owned();
            (text(head.model), head.prefix.map(text))
        });
        let echoes: Vec<(String, usize)> = file
            .lines()
            .iter()
            .map(|line| {
                (
                    file.source().text(line.echo).into_owned(),
                    line.commands.len(),
                )
            })
            .collect();
        (head, echoes)
    };
    let line = |text: &str, commands| (text.to_string(), commands);
    assert_eq!(
        parse("\nfile/model=a\nVARIABLE/1 &\n! c\n, FUNCTION=1\n\nSTOP; STOP\n"),
        (
            None,
            vec![
                line("", 0),
                line("file/model=a", 1),
                line("VARIABLE/1 &", 0),
                line("! c", 0),
                line(", FUNCTION=1", 1),
                line("", 0),
                line("STOP; STOP", 2),
            ]
        )
    );
    assert_eq!(
        parse("file/model=a\nsim/stat"),
        (None, vec![line("file/model=a", 1), line("sim/stat", 1)])
    );
    assert_eq!(
        parse("dir/deck\r\n out \r\nSTOP\r\n"),
        (
            Some(("dir/deck".into(), Some("out".into()))),
            vec![line("STOP", 1)]
        )
    );
    assert_eq!(parse("deck\n\n"), (Some(("deck".into(), None)), vec![]));
}
