//! Random edits: an edited document must have the same content and diagnostics as one that is read anew.

use admire_lsp::Document;
use admire_session::check;
use admire_session::check::{DiagnosticSource, Found};
use admire_syntax::diagnostic::Checked;
use admire_syntax::files::Files;
use admire_syntax::lint::Options;
use admire_syntax::text::{Source, Span};
use admire_syntax::{Argument, Dataset, Statement};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const NAME: &str = "edited.adm";

/// Returns three shipped decks as one text, in which most ids occur twice or more.
fn deck() -> String {
    let mut all = String::from("three decks\n");
    for name in ["multilink", "pseudo-mcpherson", "kc-experiment"] {
        let path = format!("{}/corpus/{name}/model.adm", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("a shipped deck");
        for line in text.lines().skip(1).take_while(|line| line.trim() != "END") {
            all += line;
            all.push('\n');
        }
    }
    all += "! admire: ignore[duplicate-id]\nMARKER/7\n, QP = 1, 2, 3\nMARKER/8, FLOATING\nEND\n! after\n";
    all
}

/// Typed texts: characters that change the ends of lines and statements, ids to which other statements refer, and text.
const TYPED: [&str; 44] = [
    ",",
    "&",
    "\n",
    "\r\n",
    "\r",
    "!",
    "\"",
    ";",
    "/",
    "=",
    "\\",
    "(",
    ")",
    " ",
    "\t",
    "1",
    "0",
    "7",
    "90D",
    "A",
    "e",
    "é",
    "🚗",
    "END\n",
    "\nEND",
    "END",
    "\n, ",
    " &\n",
    "PART/5\n",
    "PART/9, GROUND\n",
    ", PART = 2",
    "MARKER/21\n",
    "\nMARKER/10, FLOATING\n",
    "! adams_view_name='named'\n",
    "! admire: ignore[undefined-id]\n",
    "! admire: ignore-file[duplicate-id]\n",
    "! admire: ignore[nothing]\n",
    "\nJOINT/3, SPHERICAL, I=7, J=8\n",
    "QP = 1\n",
    "EXACT=X\n",
    "\nBUSHING/7, I=10, J=999\n",
    "\nVARIABLE/1, FUNCTION=DX(7,8)+VARVAL(1)\n",
    "\nSPLINE/1, X=1,2,2, Y=1,2\n",
    "é! admire: ignore\n",
];

#[test]
fn a_thousand_random_edits_leave_the_state_of_a_fresh_reading() {
    random_edits(1_000);
}

#[test]
#[ignore = "minutes: .ci/full"]
fn ten_thousand_random_edits_leave_the_state_of_a_fresh_reading() {
    random_edits(10_000);
}

fn random_edits(count: usize) {
    const ROUND: usize = 125;
    let rounds: Vec<u64> = (0..(count / ROUND) as u64).collect();
    // Rounds are independent and run on all processors.
    std::thread::scope(|scope| {
        for part in rounds.chunks(rounds.len().div_ceil(4)) {
            scope.spawn(move || {
                for seed in part {
                    round(*seed, ROUND);
                }
            });
        }
    });
}

fn round(seed: u64, edits: usize) {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut text = deck();
    if seed % 3 == 1 {
        text = text.replace('\n', "\r\n");
    }
    let original = text.clone();
    let mut document = Document::open(&Source::new(NAME, text.as_bytes()), false);
    for step in 0..edits {
        let (start, end, new) = edit(&mut random, &text, &original);
        document.edit(Span::new(start, end), new.as_bytes());
        text.replace_range(start..end, &new);
        let fresh = Dataset::parse(Source::new(NAME, text.as_bytes()));
        let place = format!("round {seed}, step {step}: {start}..{end} became {new:?}");
        assert_eq!(document.pieces().bytes(), text.as_bytes(), "{place}");
        same_statements(&document, &fresh.value, &place);
        same_complaints(&mut document, fresh, step, &place);
    }
}

/// Returns a random edit: start and end of the replaced range, and the new text.
fn edit(random: &mut Pcg64, text: &str, original: &str) -> (usize, usize, String) {
    let boundary = |at: usize| {
        let at = at.min(text.len());
        (0..=at)
            .rev()
            .find(|at| text.is_char_boundary(*at))
            .unwrap_or(0)
    };
    let start = boundary(random.random_range(0..=text.len()));
    let typed = TYPED[random.random_range(0..TYPED.len())].to_string();
    match random.random_range(0..10) {
        0..=4 => (start, start, typed),
        5 => (start, boundary(start + random.random_range(0..4)), typed),
        6 => (
            start,
            boundary(start + random.random_range(0..40)),
            String::new(),
        ),
        // A larger range is removed. In the next case, whole lines from elsewhere are inserted.
        7 => (
            start,
            boundary(start + random.random_range(0..1500)),
            String::new(),
        ),
        8 => {
            let lines: Vec<&str> = original.split_inclusive('\n').collect();
            let first = random.random_range(0..lines.len());
            let many = random.random_range(1..40).min(lines.len() - first);
            let line = text[..start].rfind('\n').map_or(0, |end| end + 1);
            (line, line, lines[first..first + many].concat())
        }
        // An edit at the start or the end of the text.
        _ => {
            let at = if random.random_bool(0.5) {
                0
            } else {
                text.len()
            };
            (at, at, typed)
        }
    }
}

type Place = (usize, usize);

/// A statement with all its positions.
#[derive(PartialEq, Debug)]
struct Shown {
    kind: Option<&'static str>,
    id: Option<(u32, Place)>,
    keyword: Place,
    span: Place,
    name: Option<Place>,
    arguments: Vec<ShownArgument>,
}

#[derive(PartialEq, Debug)]
struct ShownArgument {
    kind: Option<&'static str>,
    places: [Place; 3],
    /// Numbers: bits, whether given in degrees, and position.
    numbers: Vec<(u64, bool, Place)>,
}

fn shown(statement: &Statement, base: usize) -> Shown {
    let shift = |span: Span| (base + span.start(), base + span.end());
    let argument = |argument: &Argument| {
        let numbers = argument.numbers().iter();
        ShownArgument {
            kind: argument.kind(),
            places: [argument.name, argument.span, argument.value_span()].map(shift),
            numbers: numbers
                .map(|n| (n.value.to_bits(), n.degrees, shift(n.span)))
                .collect(),
        }
    };
    Shown {
        kind: statement.kind(),
        id: statement.id.map(|(id, span)| (id, shift(span))),
        keyword: shift(statement.keyword),
        span: shift(statement.span),
        name: statement.view_name.map(shift),
        arguments: statement.arguments.iter().map(argument).collect(),
    }
}

fn same_statements(document: &Document, fresh: &Dataset, place: &str) {
    let held: Vec<Shown> = document
        .statements()
        .map(|(_, base, statement)| shown(statement, base))
        .collect();
    let read: Vec<Shown> = fresh
        .statements()
        .iter()
        .map(|statement| shown(statement, 0))
        .collect();
    for (held, read) in held.iter().zip(&read) {
        assert_eq!(held, read, "{place}");
    }
    assert_eq!(held.len(), read.len(), "{place}");
    for statement in fresh.statements() {
        let Some(object) = statement.object() else {
            continue;
        };
        let first = document.definitions(object)[0];
        let base = document.pieces().start(first.0);
        let all = fresh
            .statements()
            .iter()
            .filter(|other| other.object() == Some(object));
        assert_eq!(
            document.definitions(object).len(),
            all.clone().count(),
            "{place}"
        );
        assert_eq!(
            shown(document.statement(first), base),
            shown(all.clone().next().expect("itself"), 0),
            "{place}"
        );
    }
}

/// Compares the diagnostics of the reader and of the rules for neighbouring statements. At every twentieth step, also compares those of a check
/// of the whole file.
fn same_complaints(document: &mut Document, fresh: Checked<Dataset>, step: usize, place: &str) {
    let files = Checked::clean(Files::default());
    let found =
        check::dataset(fresh, files, &Options::default(), || false).expect("never outdated");
    let sorted = |found: &[Found], whole: bool| {
        let kept = found
            .iter()
            .filter(|found| !found.silenced && (whole || found.told != DiagnosticSource::File));
        let mut all: Vec<String> = kept
            .map(|found| format!("{:?}", found.diagnostic))
            .collect();
        all.sort();
        all
    };
    compare(
        &sorted(&document.complaints(), false),
        &sorted(&found, false),
        place,
    );
    if step.is_multiple_of(20) {
        document.store_findings(found.clone());
        compare(
            &sorted(&document.complaints(), true),
            &sorted(&found, true),
            place,
        );
    }
}

fn compare(held: &[String], fresh: &[String], place: &str) {
    let missing: Vec<_> = fresh.iter().filter(|found| !held.contains(found)).collect();
    let extra: Vec<_> = held.iter().filter(|found| !fresh.contains(found)).collect();
    assert!(
        missing.is_empty() && extra.is_empty(),
        "{place}\nmissing: {missing:#?}\nextra: {extra:#?}"
    );
    assert_eq!(held.len(), fresh.len(), "{place}");
}
