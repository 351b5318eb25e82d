//! Shell completion of addresses within a deck.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::PathBuf;

use clap_complete::CompletionCandidate;

use admire_results::{Selection, open_any};
use admire_syntax::grammar::ValueKind;
use admire_syntax::text::Source;
use admire_syntax::{Dataset, Statement};

/// Largest number of candidates offered.
const MOST: usize = 2000;

/// Returns the completions of an address in the deck named on the command line. Objects are completed first, by keyword and id or by view
/// name. After a dot, their arguments follow; after another dot, the indices of the values of an argument.
pub(super) fn complete(current: &OsStr) -> Vec<CompletionCandidate> {
    let Some(typed) = current.to_str() else {
        return Vec::new();
    };
    let deck = std::env::args_os().map(PathBuf::from).find(|word| {
        word.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("adm"))
            && word.is_file()
    });
    let Some(source) = deck.and_then(|deck| Source::read(&deck).ok()) else {
        return Vec::new();
    };
    let dataset = Dataset::parse(source).value;
    candidates(&dataset, typed)
        .into_iter()
        .take(MOST)
        .map(CompletionCandidate::new)
        .collect()
}

/// Returns the completions of a column name in the results file named on the command line.
pub(super) fn complete_columns(current: &OsStr) -> Vec<CompletionCandidate> {
    let typed = current.to_string_lossy();
    let file = std::env::args_os().map(PathBuf::from).find(|word| {
        word.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("res") || e.eq_ignore_ascii_case("req"))
            && word.is_file()
    });
    let Some(opened) = file.and_then(|file| open_any(&file).ok()) else {
        return Vec::new();
    };
    Selection::all(opened.value.catalogue())
        .columns
        .into_iter()
        .map(|column| column.path)
        .filter(|path| {
            path.get(..typed.len())
                .is_some_and(|start| start.eq_ignore_ascii_case(&typed))
        })
        .take(MOST)
        .map(CompletionCandidate::new)
        .collect()
}

fn candidates(dataset: &Dataset, typed: &str) -> BTreeSet<String> {
    let begins = |name: &str| {
        name.get(..typed.len())
            .is_some_and(|start| start.eq_ignore_ascii_case(typed))
    };
    let mut found = BTreeSet::new();
    found.extend(Some("TITLE".to_string()).filter(|title| begins(title)));
    for statement in dataset.statements() {
        for name in names(dataset, statement) {
            if begins(&name) {
                found.insert(name);
                continue;
            }
            let inside = typed
                .get(..name.len())
                .is_some_and(|start| start.eq_ignore_ascii_case(&name))
                && typed[name.len()..].starts_with('.');
            if inside {
                found.extend(arguments(statement, &name).filter(|address| begins(address)));
            }
        }
    }
    found
}

fn names(dataset: &Dataset, statement: &Statement) -> Vec<String> {
    let mut names = Vec::new();
    if let Some(kind) = statement.kind() {
        names.push(match statement.number() {
            Some(id) => format!("{kind}/{id}"),
            None => kind.to_string(),
        });
    }
    if let Some(span) = statement.view_name {
        names.push(dataset.source().text(span).into_owned());
    }
    names
}

fn arguments<'a>(statement: &'a Statement, name: &'a str) -> impl Iterator<Item = String> + 'a {
    let all = statement.def.map_or(&[][..], |def| def.arguments);
    all.iter().flat_map(move |argument| {
        let whole = format!("{name}.{}", argument.name);
        let places = match argument.count.max {
            Some(most) if most > 1 && argument.kind == ValueKind::Real => most,
            _ => 0,
        };
        let single = (1..=places).map({
            let whole = whole.clone();
            move |place| format!("{whole}.{place}")
        });
        std::iter::once(whole).chain(single).collect::<Vec<_>>()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_then_arguments_then_places() {
        let text = "t\n! adams_view_name='front'\nBUSHING/12, I=1, J=2, K=1,2,3\nBUSHING/3, I=1, J=2\nEND\n";
        let dataset = Dataset::parse(Source::new("a.adm", text.as_bytes())).value;
        let found = |typed: &str| candidates(&dataset, typed).into_iter().collect::<Vec<_>>();
        assert_eq!(found("bush"), ["BUSHING/12", "BUSHING/3"]);
        assert_eq!(found("fr"), ["front"]);
        assert_eq!(found("front.K."), ["front.K.1", "front.K.2", "front.K.3"]);
        assert!(found("BUSHING/12.").contains(&"BUSHING/12.KT".to_string()));
        assert_eq!(found("nothing"), Vec::<String>::new());
    }
}
