//! The real decks of ../shared/real-decks: each reaches equilibrium or is refused with a reason, as recorded in the table.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use admire_solver::model::Model;
use admire_solver::statics::{Continuation, SolveError, Solver, StaticSettings};
use admire_solver::system::System;
use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Diagnostic, Severity};
use admire_syntax::text::Source;

use crate::common::{files_below, shared};

fn errors(what: &str, diagnostics: &[Diagnostic]) -> Option<String> {
    let errors: Vec<&Diagnostic> = diagnostics
        .iter()
        .filter(|d| d.severity == Severity::Error)
        .collect();
    if errors.is_empty() {
        return None;
    }
    let mut reasons: BTreeMap<String, usize> = BTreeMap::new();
    let mut users = None;
    for error in errors {
        let message = error.message.as_str();
        if message.contains(" statements need user-written subroutines: ") {
            users = message.split(": ").next();
            continue;
        }
        // The text after the name of the statement is the reason.
        let marks = [" is not solved: ", " calls a ", " has ", "': ", ": "];
        let cut = marks.iter().find_map(|m| Some((message.find(m)?, m)));
        let (kind, reason) = match cut {
            Some((at, mark)) => (&message[..at], message[at + mark.len()..].to_string()),
            None => ("", message.to_string()),
        };
        let kind = kind.split('/').next().unwrap_or_default();
        let reason = match reason.split_once("user-written subroutine: ") {
            Some(_) => "user-written subroutine".to_string(),
            None => reason,
        };
        *reasons.entry(format!("{kind}: {reason}")).or_default() += 1;
    }
    let mut lines: Vec<String> = users.iter().map(ToString::to_string).collect();
    lines.extend(reasons.iter().map(|(reason, n)| format!("{n} x {reason}")));
    Some(format!("{what}\n    {}", lines.join("\n    ")))
}

/// Returns the outcome for a deck, in one line.
fn outcome(path: &Path) -> String {
    let parsed = Dataset::parse(Source::new("deck", fs::read(path).unwrap()));
    if let Some(told) = errors("not read", &parsed.diagnostics) {
        return told;
    }
    let lowered = Model::lower(&parsed.value);
    if let Some(told) = errors("refused", &lowered.diagnostics) {
        return told;
    }
    let compiled = System::compile(&lowered.value);
    if let Some(told) = errors("refused", &compiled.diagnostics) {
        return told;
    }
    let system = compiled.value;
    let mut state = system.state();
    let settings = StaticSettings::from(system.settings());
    match Solver::new(&system).solve(&system, &system.parameters(), &mut state, &settings) {
        Ok(report) => {
            let mut out = String::from("equilibrium");
            match report.continuation {
                None => {}
                Some(Continuation::Damped) => out += ", by damping",
                Some(Continuation::Load { .. }) => out += ", by releasing the load in steps",
            }
            if !report.free_motions.is_empty() {
                _ = write!(out, ", {} free motions", report.free_motions.len());
            }
            if !report.redundant.is_empty() {
                _ = write!(out, ", {} redundant equations", report.redundant.len());
            }
            let left_out = lowered.value.unsolved.len();
            if left_out > 0 {
                _ = write!(out, ", {left_out} statements left out");
            }
            out
        }
        Err(SolveError::NotConverged { worst, causes, .. }) => {
            let cause = causes.first().map(|c| format!("; {c}")).unwrap_or_default();
            format!("no equilibrium: largest imbalance at {worst}{cause}")
        }
        Err(error) => format!("no equilibrium: {error}"),
    }
}

#[test]
fn reach_equilibrium_or_say_why_not() {
    let Some(folder) = shared("real-decks") else {
        return;
    };
    let mut table = String::new();
    for path in files_below(&folder, "adm") {
        let name = path.strip_prefix(&folder).unwrap().display();
        let start = std::time::Instant::now();
        let outcome = outcome(&path);
        println!("{name}: {:.2} s", start.elapsed().as_secs_f64());
        _ = writeln!(table, "{name}: {outcome}");
    }
    insta::assert_snapshot!(table);
}
