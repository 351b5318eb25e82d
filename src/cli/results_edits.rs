//! Assignments to a results file. The whole file is written again, but only changed numbers get a new spelling.

use std::io::{BufReader, BufWriter};
use std::path::Path;

use crate::front::{permissions::as_new_files, take_place};
use admire_results::{Change, ResultsError, StepFilter, rewrite};
use admire_study::leftover;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::open_to_read;

use super::Outcome;
use super::results_file::{open, refused, selection};
use super::shell::{Exit, Shell};
use super::target::Target;

/// Assignment `COLUMN=VALUE` to columns, with the operator before the equals sign.
struct ColumnAssignment {
    ids: Vec<usize>,
    operator: Option<char>,
    operand: f64,
}

/// Writes a copy of the results file with the assignments applied.
pub(super) fn run(
    file: &Path,
    assignments: &[String],
    filter: &StepFilter,
    target: &Target,
    shell: &mut Shell,
) -> Outcome {
    let to = target.file(file).filter(|path| *path != Path::new("-"));
    let Some(to) = to else {
        return Err(shell.usage(
            Diagnostic::error(
                Code::CannotWrite,
                "changed results cannot be printed on standard output",
            )
            .help("name a file with -o FILE, or use --in-place"),
        ));
    };
    let mut reader = open(file, shell)?;
    let mut all = Vec::new();
    for text in assignments {
        all.push(read(text, reader.as_ref(), shell)?);
    }
    let time = reader
        .catalogue()
        .columns()
        .find(|column| column.component.name.eq_ignore_ascii_case("TIME"))
        .map(|column| column.component.id);
    let (mut changes, mut last_step) = (Vec::new(), Vec::new());
    let (mut values, mut now) = (Vec::new(), Vec::new());
    while let Some(step) = reader.next_step().map_err(|error| refused(error, shell))? {
        now.clear();
        if let Some(time) = time {
            step.pick(&[time], &mut now)
                .map_err(|error| refused(error, shell))?;
        }
        if !filter.takes(step.index, step.kind, now.first().copied()) {
            continue;
        }
        last_step.clear();
        for assignment in &all {
            values.clear();
            step.pick(&assignment.ids, &mut values)
                .map_err(|error| refused(error, shell))?;
            for (id, old) in assignment.ids.iter().zip(&values) {
                let operand = assignment.operand;
                let value = match assignment.operator {
                    None => operand,
                    Some('*') => old * operand,
                    Some('/') => old / operand,
                    Some('+') => old + operand,
                    Some(_) => old - operand,
                };
                last_step.push(Change {
                    step: step.index,
                    id: *id,
                    value,
                });
            }
        }
        if !filter.last {
            changes.append(&mut last_step);
        }
    }
    changes.append(&mut last_step);
    let cannot = |error: std::io::Error| {
        let message = format!("`{}` cannot be written: {error}", to.display());
        shell.fail(Diagnostic::error(Code::CannotWrite, message))
    };
    let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    let mut scratch = as_new_files(builder.prefix(&leftover::prefix()))
        .tempfile_in(folder.unwrap_or(Path::new(".")))
        .map_err(cannot)?;
    let again = || open_to_read(file).map_err(cannot);
    let text = BufReader::with_capacity(1 << 16, again()?);
    let out = BufWriter::with_capacity(1 << 16, scratch.as_file_mut());
    let name = file.display().to_string();
    let written = rewrite(&name, again()?, text, out, &changes).map_err(|error| match error {
        ResultsError::Io(error) => cannot(error),
        refusal @ ResultsError::Refused(_) => refused(refusal, shell),
    })?;
    take_place(scratch, to).map_err(cannot)?;
    shell.complain(&written.diagnostics);
    shell.say(&format!("changed values: {}\n", written.changed));
    Ok(Exit::Fine)
}

fn read(
    text: &str,
    reader: &dyn admire_results::ResultsReader,
    shell: &Shell,
) -> Result<ColumnAssignment, Exit> {
    let wrong = |message: String| {
        shell.usage(
            Diagnostic::error(Code::BadNumber, message)
                .help("write COLUMN=VALUE, or COLUMN*=FACTOR, +=, -=, /="),
        )
    };
    let Some((left, value)) = text.split_once('=') else {
        return Err(wrong(format!("`{text}` has no `=`")));
    };
    let Some(operand) = value
        .trim()
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite())
    else {
        return Err(wrong(format!("`{}` is not a number", value.trim())));
    };
    let left = left.trim();
    // After a dot, a star is not an operator: it matches any component.
    let operator = left
        .chars()
        .next_back()
        .filter(|last| "*/+-".contains(*last) && !left.ends_with(".*"));
    let column = operator.map_or(left, |last| left[..left.len() - last.len_utf8()].trim_end());
    let selection = selection(reader, &[column.to_string()], shell)?;
    Ok(ColumnAssignment {
        ids: selection.ids(),
        operator,
        operand,
    })
}
