//! Inputs that a study still lacks before anything can be computed from it.

use super::study::Study;
use super::table::Table;
use admire_syntax::Dataset;

/// Returns the steps that remain to complete the study, in order, one sentence each. The list is empty if the study is complete.
pub fn missing(study: &Study) -> Vec<String> {
    let mut steps = Vec::new();
    let toml = study.source.name();
    if study.target.is_some() && study.columns.is_empty() {
        // The tests of kc.toml load an axle that has a target.
        return steps;
    }
    if study.columns.is_empty() {
        steps.push(format!(
            "{toml}: `loads.columns` names no load; state what each column of the load cases drives"
        ));
    }
    let mut empty = |table: &Table, what: &str| {
        if table.rows().is_empty() {
            steps.push(format!("{}: {what}", table.source.name()));
        }
    };
    empty(
        &study.loads,
        "one row per load case, in the order they were applied",
    );
    if let Some(marks) = &study.marks {
        empty(
            &marks.on_parts,
            "where each mark sits on its part, three or more a part",
        );
        empty(&marks.measured, "where each mark was in each load case");
    }
    if let Some((_, Some(wheel))) = &study.wheel {
        empty(wheel, "place and angles of the wheel in each load case");
    }
    if let Some((readings, _)) = &study.readings {
        empty(readings, "what each channel read in each load case");
    }
    if let Some((_, curves)) = &study.kc {
        empty(curves, "what the rig read of the wheel in each load case");
    }
    if let Some(summary) = &study.kc_summary {
        empty(summary, "gradients and widths of loops, one a row");
    }
    let measured = study.marks.is_some()
        || study.readings.is_some()
        || study.kc.is_some()
        || study
            .wheel
            .as_ref()
            .is_some_and(|(_, table)| table.is_some());
    if !measured {
        steps.push(format!(
            "{toml}: nothing is measured; give [marks], [kc], a measured [wheel] or [readings]"
        ));
    }
    // A diagnosis needs no parameters to identify, so this step is listed only together with other steps.
    if !steps.is_empty() && study.identify.stiffnesses.is_empty() && !has_bushings(study) {
        steps.push(format!(
            "{toml}: the deck has no BUSHING; name the numbers to identify in `identify.stiffnesses`"
        ));
    }
    steps
}

fn has_bushings(study: &Study) -> bool {
    let deck = Dataset::parse(study.deck.clone()).value;
    let mut statements = deck.statements().iter();
    statements.any(|statement| statement.kind() == Some("BUSHING"))
}
