use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::json;

use admire_solver::model::Model;
use admire_solver::model::summary::{Summary, summary};
use admire_solver::statics::FreedomCount;
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::property::{PropertyFile, PropertyKind};
use admire_syntax::text::Source;

use super::Outcome;
use super::counted::counted;
use super::format::Format;
use super::shell::{Exit, Shell};

/// Summarise a model: objects per kind, units, mass and centre of mass, degrees of freedom, unused markers.
///
/// Masses and lengths are in the deck's units. The centre of mass is for the positions of the parts in the dataset.
#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:\n  admire summary front.adm")]
pub(super) struct Arguments {
    /// The dataset.
    deck: PathBuf,
    /// List every unused marker and every redundant equation, not only their counts.
    #[arg(long)]
    all: bool,
}

/// Largest number of names shown; further names are only counted.
const SHOWN: usize = 8;

/// Prints the summary.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    let source = shell.read(&arguments.deck)?;
    if PropertyFile::is_one(source.bytes()) {
        return Err(shell.fail(not_a_dataset(source)));
    }
    let parsed = Dataset::parse(source);
    let dataset = &parsed.value;
    let files = shell.read_files(dataset);
    let lowered = Model::lower_with(dataset, &files.value);
    let summary = summary(dataset, &lowered.value);
    let errors = parsed
        .diagnostics
        .iter()
        .chain(&lowered.diagnostics)
        .filter(|diagnostic| diagnostic.severity == Severity::Error)
        .count();
    let system = System::compile(&lowered.value).value;
    let freedoms = FreedomCount::of(&system, &system.parameters(), &system.state());
    let missing: Vec<&str> = files
        .diagnostics
        .iter()
        .filter(|diagnostic| diagnostic.code == Code::CannotRead)
        .map(|diagnostic| diagnostic.message.as_str())
        .collect();
    shell.print(&match shell.format {
        Format::Json => {
            let mut all = json!(summary);
            all["degrees_of_freedom"] = json!({
                "gruebler": freedoms.gruebler(),
                "actual": freedoms.actual(),
                "redundant": freedoms.redundant,
                "without_value": freedoms.without_value,
                "errors": errors,
            });
            all["files"] = json!(missing);
            serde_json::to_string_pretty(&all).expect("JSON values print") + "\n"
        }
        _ => text(
            &summary,
            &freedoms,
            errors,
            &missing,
            arguments.all,
            dataset,
        ),
    });
    Ok(if errors == 0 {
        Exit::Fine
    } else {
        Exit::Findings
    })
}

/// Creates the diagnostic for an Adams/Car file that was given instead of a dataset. It names the kind of the file.
fn not_a_dataset(source: Source) -> Diagnostic {
    let name = source.name().to_string();
    let file = PropertyFile::parse(source).value;
    let what = match &file.kind {
        PropertyKind::Bushing => "a bushing property file",
        PropertyKind::Spring => "a spring property file",
        PropertyKind::Stop => "the property file of a bump or rebound stop",
        PropertyKind::Damper => "a damper property file",
        PropertyKind::Other(word) => match word.as_str() {
            "sub" => "a subsystem file",
            "asy" => "an assembly file",
            "tpl" => "a template file",
            "tir" => "a tire property file",
            _ => "a property file",
        },
    };
    Diagnostic::error(
        Code::WrongType,
        format!("`{name}` is {what} of Adams/Car, not a dataset"),
    )
    .help("Adams/Car writes the dataset (.adm) of an assembly when it is submitted to the solver")
}

fn text(
    summary: &Summary,
    freedoms: &FreedomCount,
    errors: usize,
    missing: &[&str],
    all: bool,
    dataset: &Dataset,
) -> String {
    let mut out = format!("{}\n", summary.title);
    let [force, mass, length, time] = summary.units;
    _ = writeln!(
        out,
        "units: {force}, {mass}, {length}, {time}{}; units consistency factor (UCF) {}",
        if summary.units_stated {
            ""
        } else {
            " (assumed, because the deck states none)"
        },
        summary.ucf
    );
    _ = writeln!(
        out,
        "{}, {}",
        counted(dataset.bytes().len(), "byte"),
        counted(dataset.statements().len(), "statement")
    );
    for (kind, count) in &summary.statements {
        _ = writeln!(out, "  {kind:24} {count}");
    }
    _ = write!(out, "mass: {} {mass}", rounded(summary.mass));
    if let Some(centre) = summary.centre_of_mass {
        let [x, y, z] = centre.map(rounded);
        _ = write!(out, " at {x}, {y}, {z} {length}");
    }
    out.push('\n');
    _ = writeln!(
        out,
        "degrees of freedom: {} (Gruebler count {}: {} of the parts less {} constraint\n  equations, {} of which are redundant)",
        freedoms.actual(),
        freedoms.gruebler(),
        freedoms.of_parts,
        freedoms.equations,
        freedoms.redundant.len()
    );
    listed(&mut out, "redundant", &freedoms.redundant, all);
    if let Some(what) = &freedoms.without_value {
        _ = writeln!(out, "  not defined at the design position: {what}");
    }
    if errors > 0 {
        let word = if errors == 1 { "error" } else { "errors" };
        _ = writeln!(
            out,
            "  the deck has {errors} {word}, so some objects are not counted; see `admire check`"
        );
    }
    let markers: Vec<String> = summary
        .unused_markers
        .iter()
        .map(|(id, name)| format!("MARKER/{id} ({name})"))
        .collect();
    _ = writeln!(
        out,
        "unused markers: {}{}",
        markers.len(),
        if summary.calls_subroutines && !markers.is_empty() {
            " (the user subroutines of the deck may use them)"
        } else {
            ""
        }
    );
    listed(&mut out, "unused", &markers, all);
    let mut unsolved: BTreeMap<(&str, &str), Vec<String>> = BTreeMap::new();
    for (kind, id, why) in &summary.unsolved {
        unsolved
            .entry((kind, why))
            .or_default()
            .push(format!("{kind}/{id}"));
    }
    for ((kind, why), objects) in unsolved {
        _ = writeln!(
            out,
            "not solved by the built-in solver: {} {kind}, {why}",
            objects.len()
        );
        listed(&mut out, "unsolved", &objects, all);
    }
    for file in missing {
        _ = writeln!(out, "{file}");
    }
    out
}

fn listed(out: &mut String, what: &str, names: &[String], all: bool) {
    let shown = if all { names.len() } else { SHOWN };
    for name in names.iter().take(shown) {
        _ = writeln!(out, "  {what}: {name}");
    }
    if names.len() > shown {
        _ = writeln!(
            out,
            "  ... and {} more (list them with --all)",
            names.len() - shown
        );
    }
}

/// Rounds to ten significant digits, to hide the round-off of sums.
fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}
