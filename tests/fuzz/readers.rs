//! Table of the fuzzed readers by name, for the mutations of `cargo test` and for a coverage-guided fuzzer.

use crate::{decks, expressions, laboratories, results, studies};

type Reader = fn(&[u8]);

/// Readers by name. Each panics if a checked property is violated.
const READERS: [(&str, Reader); 19] = [
    ("dataset", decks::deck),
    ("command-file", decks::commands),
    ("property-file", decks::property),
    ("expression", expressions::expression),
    ("address", expressions::address),
    ("xrf", results::xrf_or_other),
    ("request-file", results::requests),
    ("graphics-file", results::graphics),
    ("formatted-file", results::formatted),
    ("message-file", results::messages),
    ("study.toml", studies::study_file),
    ("load-cases", studies::load_cases),
    ("marks-on-parts", studies::marks_on_parts),
    ("marks-measured", studies::marks_measured),
    ("wheel", studies::wheel),
    ("table", studies::table),
    ("kc.toml", studies::settings),
    ("lab-table", laboratories::table),
    ("lab-mapping", laboratories::mapping),
];

/// Returns the reader with this name.
pub fn reader(name: &str) -> Reader {
    let found = READERS.iter().find(|(known, _)| *known == name);
    let known = READERS.map(|(known, _)| known);
    found
        .unwrap_or_else(|| panic!("{name} is none of {known:?}"))
        .1
}
