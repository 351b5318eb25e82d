use std::path::PathBuf;

use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::diff::{DiffKind, DiffTolerance, Difference, diff};
use admire_syntax::property::PropertyFile;
use admire_syntax::text::Source;

use super::Outcome;
use super::format::Format;
use super::shell::{Exit, Shell};
use super::tolerance::tolerance;

/// Show what changed between two datasets, object by object, or between two files of Adams/Car, value by value.
///
/// Layout, order, comments, the spelling of keywords and numbers, and default values that are written out are ignored. The exit code is 1
/// if anything changed.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire diff before.adm after.adm\n  admire diff front.sub new.sub"
)]
pub(super) struct Arguments {
    /// Dataset or file of Adams/Car before the change.
    a: PathBuf,
    /// Dataset or file of Adams/Car after the change.
    b: PathBuf,
    /// Numbers that differ by at most this fraction count as equal.
    #[arg(long, default_value_t = 0.0, value_parser = tolerance, allow_negative_numbers = true)]
    rel: f64,
    /// Numbers that differ by at most this amount count as equal.
    #[arg(long, default_value_t = 0.0, value_parser = tolerance, allow_negative_numbers = true)]
    abs: f64,
}

/// Prints one line for each change and returns the exit code.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let (a, b) = (shell.read(&arguments.a)?, shell.read(&arguments.b)?);
    let tolerance = DiffTolerance {
        absolute: arguments.abs,
        relative: arguments.rel,
    };
    let changes = match [&a, &b].map(|source| PropertyFile::is_one(source.bytes())) {
        [true, true] => {
            let parse = |source: Source| PropertyFile::parse(source).value;
            admire_car::diff(&parse(a), &parse(b), tolerance)
        }
        [false, false] => {
            let parse = |source: Source| Dataset::parse(source).value;
            diff(&parse(a), &parse(b), tolerance)
        }
        [car, _] => {
            let (car, other) = if car { (a, b) } else { (b, a) };
            let message = format!(
                "`{}` is a file of Adams/Car, but `{}` is not",
                car.name(),
                other.name()
            );
            let wrong = Diagnostic::error(Code::WrongType, message);
            return Err(shell.fail(wrong.help("compare two datasets, or two files of Adams/Car")));
        }
    };
    shell.tell(&match shell.format {
        Format::Json => serde_json::to_string_pretty(&changes).expect("JSON values print") + "\n",
        _ => changes.iter().map(line).collect(),
    });
    Ok(if changes.is_empty() {
        Exit::Fine
    } else {
        Exit::Findings
    })
}

fn line(difference: &Difference) -> String {
    let mut address = difference.address.clone();
    if let Some(name) = &difference.name {
        address += &format!(" ({name})");
    }
    match &difference.change {
        DiffKind::Added => format!("+ {address}\n"),
        DiffKind::Removed => format!("- {address}\n"),
        DiffKind::Number {
            written: [before, after],
            ..
        } => format!("{address}: {before} -> {after}\n"),
        DiffKind::Text { before, after } => match (before.as_deref(), after.as_deref()) {
            (Some(before), Some(after)) => format!("{address}: {before} -> {after}\n"),
            (Some(before), None) => format!("- {address} {before}").trim_end().to_string() + "\n",
            (None, Some(after)) => format!("+ {address} {after}").trim_end().to_string() + "\n",
            (None, None) => String::new(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_change_is_one_line() {
        let read = |text: &str| Dataset::parse(Source::new("x", text.as_bytes())).value;
        let a = "t\n! adams_view_name='b'\nBUSHING/1, I=1, J=2, K=1,2,3\nSFORCE/3, I=1, J=2, ROT, FUNCTION=2*TIME\nPART/1, GROUND\nEND\n";
        let b = "t\n! adams_view_name='b'\nBUSHING/1, I=1, J=2, K=1,2.5,3\nSFORCE/3, I=1, J=2, FUNCTION=3*TIME\nPART/2, GROUND\nEND\n";
        let lines: Vec<String> = diff(&read(a), &read(b), DiffTolerance::default())
            .iter()
            .map(line)
            .collect();
        assert_eq!(
            lines,
            [
                "BUSHING/1.K.2 (b): 2 -> 2.5\n",
                "- SFORCE/3.ROTATIONAL\n",
                "SFORCE/3.FUNCTION: 2*TIME -> 3*TIME\n",
                "- PART/1\n",
                "+ PART/2\n",
            ]
        );
    }
}
