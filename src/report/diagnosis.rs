use crate::discrepancy::{Outcome, Verdict};
use crate::identify::global::Row;

use super::{Align, HeatMap, Page, Table, number};

/// What a diagnosis shows a person.
pub struct DiagnosisReport<'a> {
    /// The diagnosis and the fits behind it.
    pub outcome: &'a Outcome<'a>,
    /// What changed in the deck.
    pub diff: &'a str,
}

impl DiagnosisReport<'_> {
    /// The page.
    pub fn html(&self) -> String {
        let diagnosis = &self.outcome.diagnosis;
        let lead = match diagnosis.verdict {
            Verdict::Consistent => "The model explains the data to their noise.",
            Verdict::Discrepancy => "The model is wrong in what is listed below.",
            Verdict::Unexplained => "Structure remains that no known cause explains.",
        };
        let mut page = Page::new("Diagnosis", lead);
        page.paragraph(&format!(
            "Before any extension chi-square per degree of freedom is {:.2}; {} hypotheses were tried.",
            diagnosis.baseline.chi2_per_dof, self.outcome.places
        ));
        if !diagnosis.findings.is_empty() {
            page.heading("Findings");
            page.table(&self.findings());
        }
        page.heading("Residuals, case by mark");
        for (title, svg) in [("before", self.map(false)), ("after", self.map(true))] {
            page.figure(
                &svg,
                &format!("Largest coordinate of prediction minus reading {title} the extension, in sigmas."),
            );
        }
        page.heading("Tests of structure");
        page.table(&self.structure());
        if !self.diff.is_empty() {
            page.heading("The extension");
            page.verbatim(self.diff);
        }
        page.finish("admire diagnose")
    }

    fn findings(&self) -> Table {
        let mut table = Table::new(&[
            ("cause", Align::Left),
            ("address", Align::Left),
            ("numbers", Align::Left),
            ("BIC gain", Align::Right),
            ("held-out rms before", Align::Right),
            ("after", Align::Right),
            ("or", Align::Left),
        ]);
        let rms = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.4}"));
        for finding in &self.outcome.diagnosis.findings {
            let numbers: Vec<String> = finding
                .parameters
                .iter()
                .map(|(name, value)| {
                    let error = finding.std_error.get(name).copied();
                    format!("{name} = {}", number(*value, error))
                })
                .collect();
            let rivals: Vec<String> = finding
                .indistinguishable_from
                .iter()
                .map(|rival| format!("{} {}", rival.cause, rival.address))
                .collect();
            table.row([
                finding.cause.to_string(),
                finding.address.clone(),
                numbers.join(", "),
                format!("{:.1}", finding.evidence.bic_gain),
                rms(finding.gain.held_out_rms_before),
                rms(finding.gain.held_out_rms_after),
                rivals.join("; "),
            ]);
        }
        table
    }

    fn structure(&self) -> Table {
        let mut table = Table::new(&[
            ("where", Align::Left),
            ("p before", Align::Right),
            ("p after", Align::Right),
        ]);
        let [before, after] = &self.outcome.structure;
        for test in before.iter().take(12) {
            let later = after.iter().find(|other| other.what == test.what);
            table.row([
                test.what.clone(),
                format!("{:.1e}", test.p_value),
                later.map_or_else(String::new, |later| format!("{:.1e}", later.p_value)),
            ]);
        }
        table
    }

    /// Case by mark.
    fn map(&self, after: bool) -> String {
        let outcome = self.outcome;
        let fitted = if after {
            &outcome.extended
        } else {
            &outcome.baseline
        };
        let measurement = outcome.subject.problem.measurement;
        let mut columns = Vec::new();
        let mut first = Vec::new();
        for part in &measurement.parts {
            first.push(columns.len());
            columns.extend(
                part.marks
                    .iter()
                    .map(|m| format!("{} {}", part.name, m.label)),
            );
        }
        let mut values = vec![vec![None; columns.len()]; measurement.cases.len()];
        for (k, row) in outcome.subject.rows.iter().enumerate() {
            let Row::Mark { case, reading, .. } = *row else {
                continue;
            };
            let read = measurement.cases[case].marks[reading];
            let value = fitted.minimum.evaluation.residual[k];
            let cell: &mut Option<f64> = &mut values[case][first[read.part] + read.mark];
            if cell.is_none_or(|old| old.abs() < value.abs()) {
                *cell = Some(value);
            }
        }
        HeatMap {
            title: if after { "after" } else { "before" }.to_string(),
            rows: measurement
                .cases
                .iter()
                .map(|c| format!("case {}", c.label))
                .collect(),
            columns,
            values,
            limit: 6.0,
            what: "residual, sigmas".to_string(),
        }
        .svg()
    }
}
