//! Real decks of ADAMS and its users: the server's document while they are edited.

use admire_lsp::Document;
use admire_session::check;
use admire_session::check::DiagnosticSource;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::Code;
use admire_syntax::files::Files;
use admire_syntax::lint::Options;
use admire_syntax::text::{Source, Span};
use rayon::prelude::*;

use crate::common::{files_below, shared};

/// Returns every real deck as text, as an editor would send it, with its path.
fn decks() -> Vec<(String, String)> {
    let folders = ["real-decks", "reference"].into_iter().filter_map(shared);
    folders
        .flat_map(|folder| files_below(&folder, "adm"))
        .map(|path| {
            let bytes = std::fs::read(&path).expect("readable");
            let text = String::from_utf8(bytes)
                .unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect());
            (path.display().to_string(), text)
        })
        .collect()
}

#[test]
fn edits_of_real_decks_are_told_as_a_fresh_reading_tells_them() {
    decks().into_par_iter().for_each(|(name, mut text)| {
        let mut document = Document::open(&Source::new(name.as_str(), text.as_bytes()), false);
        compare(&mut document, &text, &name);
        // At each of a dozen positions, a key and a line are typed, and the edits are undone.
        for k in 0..12 {
            let mut at = text.len() * k / 12;
            while !text.is_char_boundary(at) {
                at += 1;
            }
            for (from, old, new) in [
                (at, 0, "7"),
                (at, 1, "\nMARKER/1, PART=77777\n"),
                (at, 22, ""),
            ] {
                document.edit(Span::new(from, from + old), new.as_bytes());
                text.replace_range(from..from + old, new);
                compare(&mut document, &text, &format!("{name}, byte {at}, {new:?}"));
            }
        }
    });
}

fn compare(document: &mut Document, text: &str, place: &str) {
    assert_eq!(document.pieces().bytes(), text.as_bytes(), "{place}");
    let read = Dataset::parse(Source::new(document.name(), text.as_bytes()));
    let statements = |spans: &mut dyn Iterator<Item = Span>| spans.collect::<Vec<_>>();
    let held = statements(&mut document.statements().map(|(_, base, statement)| {
        Span::new(base + statement.span.start(), base + statement.span.end())
    }));
    assert_eq!(
        held,
        statements(
            &mut read
                .value
                .statements()
                .iter()
                .map(|statement| statement.span)
        ),
        "{place}"
    );
    let files = admire_syntax::diagnostic::Checked::clean(Files::default());
    let found = check::dataset(read, files, &Options::default(), || false).expect("never outdated");
    // For a file with thousands of diagnostics, only a part is reported, and the two parts may differ.
    if found
        .iter()
        .any(|found| found.diagnostic.code == Code::LimitExceeded)
    {
        return;
    }
    let shown = |found: Vec<check::Found>| {
        let near = found
            .into_iter()
            .filter(|found| found.told != DiagnosticSource::File && !found.silenced);
        let mut all: Vec<String> = near
            .map(|found| format!("{:?}", found.diagnostic))
            .collect();
        all.sort();
        all
    };
    // For a large deck, the rules for neighbouring statements run only on the edited pieces. The check of the whole file has reported the rest.
    if document.pieces().pieces().len() > 64 {
        document.store_findings(found.clone());
    }
    let (held, fresh) = (shown(document.complaints()), shown(found));
    let missing: Vec<_> = fresh
        .iter()
        .filter(|found| !held.contains(found))
        .take(3)
        .collect();
    let extra: Vec<_> = held
        .iter()
        .filter(|found| !fresh.contains(found))
        .take(3)
        .collect();
    assert!(
        held == fresh,
        "{place}\nmissing: {missing:#?}\nextra: {extra:#?}"
    );
}
