//! Contents of a study, and the contents that it still lacks before anything can be computed from it.

use super::study::Study;
use super::table::Table;
use admire_syntax::Dataset;

impl Study {
    /// Returns true if the study has measured data: marks, curves, readings or the wheel.
    pub fn is_measured(&self) -> bool {
        let wheel = self.wheel.as_ref().and_then(|(_, table)| table.as_ref());
        self.marks.is_some() || self.readings.is_some() || self.kc.is_some() || wheel.is_some()
    }

    /// Returns true if the study has a target but no readings for an identification.
    pub fn is_target_alone(&self) -> bool {
        self.target.is_some() && (self.columns.is_empty() || !self.is_measured())
    }
}

/// Returns the steps that remain to complete the study, in order, one sentence each. The list is empty if the study is complete.
pub fn missing(study: &Study) -> Vec<String> {
    let mut steps = Vec::new();
    let toml = study.source.name();
    if study.is_target_alone() {
        // Goals need no readings.
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
            "position of each mark on its part, at least three marks per part",
        );
        empty(&marks.measured, "position of each mark in each load case");
    }
    if let Some((_, Some(wheel))) = &study.wheel {
        empty(wheel, "position and angles of the wheel in each load case");
    }
    if let Some((readings, _)) = &study.readings {
        empty(readings, "reading of each channel in each load case");
    }
    if let Some((_, curves)) = &study.kc {
        empty(curves, "readings of the rig at the wheel in each load case");
    }
    if let Some(summary) = &study.kc_summary {
        empty(summary, "gradients and loop widths, one per row");
    }
    if !study.is_measured() {
        steps.push(format!(
            "{toml}: nothing is measured; add a section [marks], [kc] or [readings], or `measured` in [wheel]"
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
