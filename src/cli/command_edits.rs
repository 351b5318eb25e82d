//! `get` and `set` on command files, with addresses such as `SIMULATE#2.END` and `SFORCE/3.FUNCTION`.

use std::collections::BTreeSet;

use crate::front::edits;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::grammar::{Lookup, Role, find_statement};
use admire_syntax::text::{Source, Span, apply_edits};
use admire_syntax::{Address, CommandFile, Dataset, Statement, lint};

use super::assignment::{Assignment, evaluated};
use super::counted::counted;
use super::shell::{Exit, Shell};

/// Finds the commands of a file that match an address or a pattern. Each match consists of its name (such as `SIMULATE#2.END`), a dataset
/// with the command as its only statement, and the address within this dataset.
///
/// # Errors
/// `undefined-id` if no command matches; `ambiguous-keyword` if an address without an index (such as `#2`) fits several commands.
pub(super) fn places(
    file: &CommandFile,
    text: &str,
) -> Result<Vec<(String, Dataset, Address)>, Diagnostic> {
    let (head, rest) = text.split_once('.').unwrap_or((text, ""));
    let (head, which) = match head.split_once('#') {
        Some((head, which)) => (head, Some(which.trim())),
        None => (head, None),
    };
    let (keyword, id) = match head.split_once('/') {
        Some((keyword, id)) => (keyword.trim(), id.trim()),
        None => (head.trim(), ""),
    };
    let refuse = |code, message: String, help: String| {
        Err(Diagnostic::error(code, message)
            .label("address", Span::new(0, text.len()), "")
            .help(help))
    };
    let Lookup::Found(def) = find_statement(keyword.as_bytes(), Role::Command) else {
        return refuse(
            Code::UnknownStatement,
            format!("`{keyword}` is not a command of ADAMS"),
            "an address is COMMAND.ARGUMENT, COMMAND/ID.ARGUMENT, or COMMAND#2.ARGUMENT for the second command of several, such as `SIMULATE#2.END`"
                .into(),
        );
    };
    let found: Vec<usize> = file
        .commands()
        .iter()
        .enumerate()
        .filter(|(_, command)| command.kind() == Some(def.name))
        .filter(|(_, command)| {
            id.is_empty() || id == "*" || command.number().is_some_and(|n| n.to_string() == id)
        })
        .map(|(at, _)| at)
        .collect();
    let chosen: Vec<(usize, usize)> = match which {
        Some("*") => found.iter().copied().enumerate().collect(),
        Some(number) => {
            let at = number.parse::<usize>().ok().and_then(|n| n.checked_sub(1));
            match at.and_then(|at| Some((at, *found.get(at)?))) {
                Some(one) => vec![one],
                None => {
                    return refuse(
                        Code::UndefinedId,
                        format!("the command file has no {head}#{number}"),
                        format!(
                            "it has {}",
                            counted(found.len(), &format!("{head} command"))
                        ),
                    );
                }
            }
        }
        None if found.len() > 1 && id != "*" => {
            return refuse(
                Code::AmbiguousKeyword,
                format!(
                    "{head} is ambiguous: the command file has {} of these commands",
                    found.len()
                ),
                format!(
                    "write {head}#1 to {head}#{}, or {head}#* for all",
                    found.len()
                ),
            );
        }
        None => found.iter().copied().enumerate().collect(),
    };
    if chosen.is_empty() {
        let kinds: BTreeSet<&str> = file.commands().iter().filter_map(Statement::kind).collect();
        let kinds: Vec<&str> = kinds.into_iter().collect();
        let help = match kinds.as_slice() {
            [] => "the file has no commands".to_string(),
            kinds => format!("its commands are {}", kinds.join(", ")),
        };
        let message = format!("the command file has no {head} command");
        return refuse(Code::UndefinedId, message, help);
    }
    let mut all = Vec::new();
    for (count, at) in chosen {
        let one = Dataset::of_command(file, at);
        let number = file.commands()[at].number();
        let address = Address::of_kind(def, number, rest, text)?;
        let object = match number {
            Some(id) => format!("{}/{id}", def.name),
            None => def.name.to_string(),
        };
        let behind = if rest.is_empty() { "" } else { "." };
        all.push((
            format!("{object}#{}{behind}{rest}", count + 1),
            one,
            address,
        ));
    }
    Ok(all)
}

/// Applies assignments to a command file and returns its new text. An assignment that causes a new fault is refused unless `force` is set.
/// An assignment that makes the file unreadable is always refused.
pub(super) fn set(
    source: Source,
    assignments: &[String],
    force: bool,
    degrees: bool,
    shell: &mut Shell,
) -> Result<Vec<u8>, Exit> {
    let mut file = source;
    for text in assignments {
        let assignment = Assignment::of(text, shell)?;
        let commands = CommandFile::parse(file.clone());
        let places = places(&commands.value, assignment.left).map_err(|mut refused| {
            refused.labels.clear();
            shell.fail(refused)
        })?;
        let mut all = Vec::new();
        for (_, one, address) in &places {
            for (address, value) in
                evaluated(&assignment, vec![address.clone()], one, degrees, shell)?
            {
                all.extend(
                    edits(one, &address, &value, &BTreeSet::new()).map_err(|refused| {
                        shell
                            .sources
                            .add(Source::new("expression", value.as_bytes()));
                        shell.fail(refused)
                    })?,
                );
            }
        }
        let bytes = apply_edits(file.bytes(), &all).map_err(|conflict| {
            shell.fail(Diagnostic::error(Code::CannotWrite, conflict.to_string()))
        })?;
        let new = Source::new(file.name(), bytes);
        let worse = |errors: fn(&Source) -> Vec<Diagnostic>| -> Vec<Diagnostic> {
            let before = errors(&file);
            errors(&new)
                .into_iter()
                .filter(|found| !before.iter().any(|old| old.message == found.message))
                .collect()
        };
        let (unreadable, faults) = (worse(errors_of_reader), worse(errors));
        if !faults.is_empty() {
            shell.sources.add(new.clone());
            shell.complain(&faults);
        }
        if !unreadable.is_empty() || !faults.is_empty() && !force {
            let refused = if unreadable.is_empty() {
                let message = format!("nothing is written: `{text}` causes the error above");
                Diagnostic::error(Code::WrongType, message).help("--force writes the file anyway")
            } else {
                let message = format!("nothing is written: `{text}` makes the file unreadable");
                Diagnostic::error(Code::WrongType, message)
            };
            return Err(shell.fail(refused));
        }
        file = new;
    }
    Ok(file.bytes().to_vec())
}

fn errors_of_reader(source: &Source) -> Vec<Diagnostic> {
    let mut found = CommandFile::parse(source.clone()).diagnostics;
    found.retain(|found| found.severity == Severity::Error);
    found
}

fn errors(source: &Source) -> Vec<Diagnostic> {
    let file = CommandFile::parse(source.clone());
    let mut found = file.diagnostics;
    found.extend(lint::check_commands(&file.value));
    found.retain(|found| found.severity == Severity::Error);
    found
}
