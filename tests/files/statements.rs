//! Tests of one small deck or command file for each statement and command: it is parsed, written back unchanged and edited in place.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::grammar::{Role, STATEMENTS};
use admire_syntax::lint::{self, Options};
use admire_syntax::text::{Edit, Source, apply_edits};
use admire_syntax::{CommandFile, Dataset, Statement, Value};

use crate::common::files_below;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/statements")
}

fn source(path: &Path) -> Source {
    let name = path
        .file_name()
        .expect("a name")
        .to_string_lossy()
        .to_string();
    Source::new(name, std::fs::read(path).expect("readable file"))
}

/// Formats a parsed statement with full keywords and typed values.
fn understood(source: &Source, statement: &Statement) -> String {
    let kind = statement.kind().unwrap_or("?");
    let mut out = match statement.number() {
        Some(id) => format!("{kind}/{id}"),
        None => kind.to_string(),
    };
    if let Some(name) = statement.view_name {
        let _ = write!(out, "  named {}", source.text(name));
    }
    out.push('\n');
    for argument in &statement.arguments {
        let value = match &argument.value {
            Value::Flag => String::new(),
            Value::Numbers(numbers) => {
                let shown: Vec<String> = numbers
                    .iter()
                    .map(|n| {
                        if n.degrees {
                            format!("{} deg", n.value.to_degrees())
                        } else {
                            n.value.to_string()
                        }
                    })
                    .collect();
                format!(" = [{}]", shown.join(", "))
            }
            Value::Words(_) => format!(" = {}", argument.choices(source).join(":")),
            Value::Texts(_) => format!(" = {:?}", argument.texts(source)),
            Value::Function(expression) => format!(" = function {}", expression.text),
            Value::User(span) => format!(" = {}", source.text(*span)),
            Value::Malformed(span) => format!(" MALFORMED {}", source.text(*span)),
        };
        let _ = writeln!(out, "  {}{value}", argument.kind().unwrap_or("?"));
    }
    out
}

/// Returns the diagnostics above note level, except for the diagnostics of elements that only real ADAMS solves.
fn faults(found: Vec<Diagnostic>) -> Vec<String> {
    found
        .into_iter()
        .filter(|d| d.severity > Severity::Note)
        .filter(|d| !matches!(d.code, Code::NotSolvedNatively | Code::UserSubroutine))
        .map(|d| format!("{}: {}", d.code, d.message))
        .collect()
}

/// Checks that setting any number changes only the bytes of that number and reads back as the new value.
fn assert_numbers_are_editable(
    source: &Source,
    statements: &[Statement],
    reread: impl Fn(Source) -> Vec<Statement>,
) {
    for (at, statement) in statements.iter().enumerate() {
        for (k, argument) in statement.arguments.iter().enumerate() {
            for (n, number) in argument.numbers().iter().enumerate() {
                let edit = Edit::new(number.span, "8642");
                let edited = apply_edits(source.bytes(), &[edit]).expect("one edit");
                assert_eq!(
                    edited[..number.span.start()],
                    source.bytes()[..number.span.start()]
                );
                assert_eq!(
                    edited[number.span.start() + 4..],
                    source.bytes()[number.span.end()..]
                );
                let again = reread(Source::new(source.name(), edited));
                assert_eq!(again.len(), statements.len(), "{}", source.name());
                assert_eq!(again[at].arguments[k].numbers()[n].value, 8642.0);
            }
        }
    }
}

#[test]
fn every_statement_has_its_deck_and_every_command_its_file() {
    for def in STATEMENTS {
        let extension = match def.role {
            Role::Command => "acf",
            Role::Dataset | Role::Both => "adm",
        };
        let path = folder()
            .join(def.name.to_lowercase())
            .with_extension(extension);
        assert!(path.exists(), "{} is missing", path.display());
    }
}

#[test]
fn decks_are_understood_and_written_back_unchanged() {
    for path in files_below(&folder(), "adm") {
        let source = source(&path);
        let stem = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .to_uppercase();
        let read = Dataset::parse(source.clone());
        let mut found = read.diagnostics.clone();
        found.extend(lint::check(&read.value, &Options::default()));
        assert_eq!(faults(found), Vec::<String>::new(), "{}", path.display());
        assert_eq!(read.value.bytes(), source.bytes());
        let none = apply_edits(source.bytes(), &[]).expect("no edit");
        assert_eq!(none, source.bytes());
        let statements = read.value.statements();
        if stem != "TITLE" {
            assert!(
                statements.iter().any(|s| s.kind() == Some(stem.as_str())),
                "no {stem} in {}",
                path.display()
            );
        }
        assert_numbers_are_editable(&source, statements, |source| {
            Dataset::parse(source).value.statements().to_vec()
        });
        let mut text = format!("title {}\n", read.value.title());
        // The statements common to all decks are shown only in the snapshots of TITLE and UNITS.
        let skip = if matches!(stem.as_str(), "TITLE" | "UNITS") {
            0
        } else {
            8
        };
        for statement in &statements[skip..] {
            text += &understood(&source, statement);
        }
        insta::assert_snapshot!(format!("statement_{}", stem.to_lowercase()), text);
    }
}

#[test]
fn command_files_are_understood_and_written_back_unchanged() {
    for path in files_below(&folder(), "acf") {
        let source = source(&path);
        let stem = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .to_uppercase();
        let read = CommandFile::parse(source.clone());
        assert_eq!(
            faults(read.diagnostics),
            Vec::<String>::new(),
            "{}",
            path.display()
        );
        assert_eq!(read.value.bytes(), source.bytes());
        let commands = read.value.commands();
        assert!(commands.iter().any(|c| c.kind() == Some(stem.as_str())));
        assert_numbers_are_editable(&source, commands, |source| {
            CommandFile::parse(source).value.commands().to_vec()
        });
        let text: String = commands.iter().map(|c| understood(&source, c)).collect();
        insta::assert_snapshot!(format!("command_{}", stem.to_lowercase()), text);
    }
}
