use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use crate::front::compare_page::compare_page;
use admire_results::{Comparison, DifferenceFloor, Tolerance, compare_above};

use super::Outcome;
use super::counted::counted;
use super::format::Format;
use super::opening::Opening;
use super::output_folder::{Replacing, refuse_replacing, write_folder};
use super::results_file::{open, open_silently, refused};
use super::shell::{Exit, Shell};
use super::tolerance::tolerance;

/// Compare two results files, column by column and step by step.
///
/// Two values count as equal if they differ by at most `abs + rel * max(|a|, |b|)`, or by no more than the floor of their unit. The floor is
/// 1e-12 of the largest value in that unit in both files; for a torque, also of the largest force times the largest length. The exit code is 1 if two values differ by more, or if
/// a column or a step is in only one of the files.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  admire compare before.res after.res\n  admire compare before.res after.res --out difference --open"
)]
pub(super) struct Arguments {
    /// First results file.
    a: PathBuf,
    /// Second results file.
    b: PathBuf,
    /// Absolute tolerance, in the unit of each column.
    #[arg(long, default_value_t = 0.0, value_parser = tolerance, allow_negative_numbers = true)]
    abs: f64,
    /// Relative tolerance.
    #[arg(long, default_value_t = 0.0, value_parser = tolerance, allow_negative_numbers = true)]
    rel: f64,
    /// Fraction of the largest value in a unit up to which a difference counts as round-off; 0 compares exactly and reads each file only once.
    #[arg(long, value_name = "SHARE", default_value_t = DifferenceFloor::DEFAULT_SHARE, value_parser = tolerance, allow_negative_numbers = true)]
    floor: f64,
    /// Show all columns, not only those that differ.
    #[arg(long)]
    all: bool,
    /// Folder for the page `report.html`. Without this option, no page is written.
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    opening: Opening,
    #[command(flatten)]
    replacing: Replacing,
}

/// Compares the files and prints the differences.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if let Some(out) = &arguments.out {
        refuse_replacing(out, &["report.html"], arguments.replacing, shell)?;
    }
    let mut floor = DifferenceFloor::new(arguments.floor);
    if arguments.floor > 0.0 {
        for path in [&arguments.a, &arguments.b] {
            let mut reader = open_silently(path, shell)?.value;
            floor
                .look(reader.as_mut())
                .map_err(|error| refused(error, shell))?;
        }
    }
    let (mut a, mut b) = (open(&arguments.a, shell)?, open(&arguments.b, shell)?);
    let tolerance = Tolerance {
        absolute: arguments.abs,
        relative: arguments.rel,
    };
    let comparison = compare_above(a.as_mut(), b.as_mut(), tolerance, &floor)
        .map_err(|error| refused(error, shell))?;
    shell.complain(a.diagnostics());
    shell.complain(b.diagnostics());
    let text = match shell.format {
        Format::Json => {
            serde_json::to_string_pretty(&comparison).expect("JSON values print") + "\n"
        }
        _ => table(&comparison, arguments.all),
    };
    shell.tell(&text);
    if let Some(out) = &arguments.out {
        let page = compare_page([&arguments.a, &arguments.b], &comparison);
        let page = page.map_err(|error| {
            shell.say(&format!("{error}\n"));
            Exit::Findings
        })?;
        let files = [(PathBuf::from("report.html"), page.into_bytes())];
        write_folder(out, &files, arguments.replacing, shell)?;
        let report = out.join("report.html");
        shell.say(&format!("report: {}\n", report.display()));
        arguments.opening.open(&report, shell);
    }
    Ok(if comparison.agrees() {
        Exit::Fine
    } else {
        Exit::Findings
    })
}

fn table(comparison: &Comparison, all: bool) -> String {
    let mut out = String::new();
    let shown: Vec<_> = comparison
        .columns
        .iter()
        .filter(|column| all || column.beyond > 0)
        .collect();
    let wide = |path: &str| path.chars().count();
    let longest = shown.iter().map(|column| wide(&column.path)).max();
    let width = longest.unwrap_or(0).clamp(20, 48);
    for column in &shown {
        let unit = column.units.as_deref().unwrap_or("");
        let largest = format!("{:.3e} {unit}", column.largest);
        _ = write!(
            out,
            "{:width$} largest difference {} absolute, {:.3e} relative; {} of {} steps beyond the tolerance",
            column.path,
            largest.trim_end(),
            column.largest_relative,
            column.beyond,
            comparison.steps
        );
        if let Some(worst) = &column.worst {
            _ = write!(
                out,
                "; at step {}, time {}: {} and {}",
                worst.step, worst.time, worst.a, worst.b
            );
        }
        out.push('\n');
    }
    let differing = comparison.columns.iter().filter(|c| c.beyond > 0).count();
    for (names, place) in [
        (&comparison.only_in_a, "first"),
        (&comparison.only_in_b, "second"),
    ] {
        for (entity, count) in by_entity(names) {
            _ = match count {
                1 => writeln!(out, "{entity:48} only in the {place} file"),
                _ => writeln!(out, "{entity:48} {count} columns only in the {place} file"),
            };
        }
    }
    for column in &comparison.units_differ {
        let unit = |unit: &Option<String>| match unit {
            Some(unit) => format!("in {unit}"),
            None => "without a unit".to_string(),
        };
        _ = writeln!(
            out,
            "{:48} not compared: {} in the first file, {} in the second",
            column.path,
            unit(&column.a),
            unit(&column.b)
        );
    }
    for (count, place) in [
        (comparison.steps_only_in_a, "first"),
        (comparison.steps_only_in_b, "second"),
    ] {
        if count > 0 {
            _ = writeln!(out, "{} only in the {place} file", counted(count, "step"));
        }
    }
    for step in &comparison.kinds_differ {
        _ = writeln!(out, "the kind of step {step} differs between the two files");
    }
    let alone = comparison.only_in_a.len() + comparison.only_in_b.len();
    let mut said = vec![match differing {
        0 if comparison.columns.is_empty() => "nothing to compare".to_string(),
        0 => "all values within the tolerance".to_string(),
        1 => "1 column differs".to_string(),
        n => format!("{n} columns differ"),
    }];
    for (count, what) in [
        (comparison.units_differ.len(), "with different units"),
        (alone, "in one file only"),
    ] {
        if count > 0 {
            said.push(format!("{count} {what}"));
        }
    }
    _ = writeln!(
        out,
        "{}, {} compared: {}",
        counted(comparison.steps, "step"),
        counted(comparison.columns.len(), "column"),
        said.join(", ")
    );
    out
}

/// Groups columns by entity. Returns the name of each entity with its number of columns; an entity with a single column is named by that
/// column.
fn by_entity(paths: &[String]) -> Vec<(&str, usize)> {
    let mut found: Vec<(&str, &str, usize)> = Vec::new();
    let mut places: HashMap<&str, usize> = HashMap::new();
    for path in paths {
        let entity = path
            .rsplit_once('.')
            .map_or(path.as_str(), |(entity, _)| entity);
        let place = *places.entry(entity).or_insert(found.len());
        match found.get_mut(place) {
            Some((_, _, count)) => *count += 1,
            None => found.push((entity, path, 1)),
        }
    }
    let shown = |(entity, path, count)| (if count == 1 { path } else { entity }, count);
    found.into_iter().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_one_entity_are_one_line() {
        let paths = ["a.b.X", "c.FX", "a.b.Y", "TIME"].map(String::from);
        assert_eq!(by_entity(&paths), [("a.b", 2), ("c.FX", 1), ("TIME", 1)]);
    }
}
