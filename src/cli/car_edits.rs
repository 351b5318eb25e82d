//! `get`, `set` and `diff` on files of Adams/Car, with addresses such as `HARDPOINT/lca_outer.x_value` and `UNITS.LENGTH`.

use admire_car::{Entry, entries, select, set as new_value};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::property::PropertyFile;
use admire_syntax::text::{Source, apply_edits};
use serde_json::Value;

use super::assignment::Assignment;
use super::shell::{Exit, Shell};

/// Returns the values at an address, at all addresses that match a pattern, or in a block or row. Several values are named by their own
/// addresses, a single one by the requested text.
pub(super) fn values(
    file: &PropertyFile,
    text: &str,
    shell: &Shell,
) -> Result<Vec<(String, Value)>, Exit> {
    let found = select(file, text).map_err(|refused| of_text(refused, text, shell))?;
    let one = found.len() == 1 && found[0].address.eq_ignore_ascii_case(text.trim());
    let value = |entry: &Entry| match entry.cell.number() {
        Some(number) => Value::from(number),
        None => Value::from(entry.text(file.source()).into_owned()),
    };
    Ok(found
        .iter()
        .map(|entry| {
            let name = if one { text } else { &entry.address };
            (name.to_string(), value(entry))
        })
        .collect())
}

/// Applies assignments to a file and returns its new bytes. With `force`, a file that has new errors is returned too.
pub(super) fn set(
    source: Source,
    assignments: &[String],
    force: bool,
    shell: &mut Shell,
) -> Result<Vec<u8>, Exit> {
    let name = source.name().to_string();
    let before = admire_car::check(source.clone());
    let mut file = PropertyFile::parse(source).value;
    let mut refused = None;
    for assignment in assignments {
        // The remaining assignments are still checked, so that all faults are reported at once.
        match changed(&file, assignment, shell) {
            Ok(new) => file = new,
            Err(exit) => refused = Some(exit.max(refused.unwrap_or(exit))),
        }
    }
    if let Some(exit) = refused {
        return Err(exit);
    }
    shell.sources.add(file.source().clone());
    let after = admire_car::check(file.source().clone());
    let found: Vec<Diagnostic> = crate::front::beyond(&before, &after)
        .into_iter()
        .cloned()
        .collect();
    shell.complain(&found);
    match found.first() {
        Some(first) if !force => Err(shell.fail(
            Diagnostic::error(
                first.code,
                format!("nothing is written: `{name}` would have a new error, shown above"),
            )
            .help("change the dependent values in the same command, or write the file anyway with --force"),
        )),
        _ => Ok(file.source().bytes().to_vec()),
    }
}

/// Applies one assignment, which may set several values.
fn changed(file: &PropertyFile, text: &str, shell: &Shell) -> Result<PropertyFile, Exit> {
    let assignment = Assignment::of(text, shell)?;
    let found = select(file, assignment.left)
        .map_err(|refused| of_text(refused, assignment.left, shell))?;
    if found.len() > 1 && !assignment.left.contains('*') {
        let message = format!("`{}` names {} values", assignment.left, found.len());
        return Err(shell.fail(
            Diagnostic::error(Code::AmbiguousKeyword, message)
                .help(format!("name one of them, such as `{}`", found[0].address)),
        ));
    }
    let mut edits = Vec::new();
    for entry in &found {
        let written = file.source().slice(entry.cell.span());
        let value = assignment.reckoned(&entry.address, entry.cell.number(), written, shell)?;
        edits.extend(new_value(file, entry, &value).map_err(|refused| shell.fail(refused))?);
    }
    let conflict = |message: String| shell.fail(Diagnostic::error(Code::CannotWrite, message));
    let bytes =
        apply_edits(file.source().bytes(), &edits).map_err(|error| conflict(error.to_string()))?;
    let new = PropertyFile::parse(Source::new(file.source().name(), bytes)).value;
    if entries(&new).len() != entries(file).len() {
        return Err(conflict(format!(
            "`{text}` would change more than the named value"
        )));
    }
    Ok(new)
}

/// Reports a faulty address without a place, because the command line is not a file with places.
fn of_text(mut refused: Diagnostic, text: &str, shell: &Shell) -> Exit {
    refused.labels.clear();
    refused.message = format!("`{text}`: {}", refused.message);
    shell.fail(refused)
}
