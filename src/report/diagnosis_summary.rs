//! Summary of a diagnosis for a terminal.

use admire_diagnosis::{Finding, Outcome, Verdict};
use admire_identify::LoadedStudy;

use super::diagnosis_phrases::{fallen_by, next_text, percent};
use super::diagnosis_text::Text;
use super::number::change;
use super::sizes;
use super::summary::{Summary, fall};

/// Largest number of channels whose gain is stated.
const MAX_STATED_CHANNELS: usize = 2;

/// Returns the summary of a diagnosis. `study` is the folder of the study as the user named it.
pub fn diagnosis_summary(loaded: &LoadedStudy, outcome: &Outcome<'_>, study: &str) -> Summary {
    let text = Text { outcome };
    let findings = &outcome.diagnosis.findings;
    let (main, minor): (Vec<&Finding>, Vec<&Finding>) = findings.iter().partition(|f| !f.minor);
    Summary {
        verdict: verdict(outcome),
        items: main
            .into_iter()
            .chain(minor)
            .map(|finding| item(finding, loaded))
            .collect(),
        held_out: text.held_out_gain(),
        next: text.next_step(study),
    }
}

/// Returns the verdict in one sentence.
fn verdict(outcome: &Outcome<'_>) -> String {
    let verdict = match outcome.diagnosis.verdict {
        Verdict::Consistent => format!(
            "consistent: the model explains the readings within their noise and tolerances; the probability that no cause acts is {}",
            percent(outcome.diagnosis.none_of_these)
        ),
        Verdict::Discrepancy => "discrepancy: the model lacks the following causes".to_string(),
        Verdict::Unexplained => {
            "unexplained: the residuals have structure that no known cause explains".to_string()
        }
    };
    let mut text = if outcome.is_stopped() {
        format!("interrupted, so far {verdict}")
    } else if outcome.is_late {
        format!("stopped by the time limit, so far {verdict}")
    } else {
        verdict
    };
    let sigma = outcome.subject.mark_sigma();
    let solver = outcome.diagnosis.solver.as_ref();
    if let Some(solver) = solver.filter(|solver| !solver.is_negligible(sigma)) {
        let length = outcome.subject.problem.model.units.length.word;
        text += &format!(
            "; mark positions from the solver of the study and from the built-in solver differ by {:.2e} {length} rms, and the findings may be due to this difference",
            solver.rms
        );
    }
    text
}

/// Describes a finding with its probability, its rivals and its parameters.
fn item(finding: &Finding, loaded: &LoadedStudy) -> String {
    let minor = if finding.minor { " (minor)" } else { "" };
    let name = loaded.model.car_name(&finding.address);
    let name = name.map_or_else(String::new, |name| format!(" ({name})"));
    let mut text = format!(
        "{} {}{name}{minor}, probability {:.2}",
        finding.cause, finding.address, finding.probability
    );
    for rival in &finding.indistinguishable_from {
        text += &format!(
            ", or {} {} ({:.2})",
            rival.cause, rival.address, rival.probability
        );
    }
    format!("{text}: {}", sizes(finding, loaded))
}

impl Text<'_> {
    /// Describes the gain in the readings that were held out of the fits, in their units and in standard deviations of their noise.
    fn held_out_gain(&self) -> String {
        let diagnosis = &self.outcome.diagnosis;
        if diagnosis.findings.is_empty() {
            return "no cause was found, so there is no gain".to_string();
        }
        let (Some(unseen), Some(found)) = (&self.outcome.unseen, &diagnosis.hold_out) else {
            return "no case was held out, so the gain is not known".to_string();
        };
        let mut parts = Vec::new();
        let [before, after] = &unseen.tests;
        let length = self.length();
        if let (Some(a), Some(b)) = (before.marks_rms, after.marks_rms) {
            let by = fallen_by(self.decimals().finer(), found.gain, found.gain_std_error);
            let marks = fall("marks", [a, b], length, self.outcome.subject.mark_sigma());
            parts.push(if found.of == "mark" {
                format!("{marks}, {by} {length}")
            } else {
                marks
            });
        } else if found.of == "noise" {
            let by = fallen_by(self.compared_decimals(), found.gain, found.gain_std_error);
            let decimals = self.compared_decimals();
            parts.push(format!(
                "readings from {} to {} sigmas, {by}",
                decimals.format(found.rms_before),
                decimals.format(found.rms_after)
            ));
        }
        let wheel = self.outcome.subject.problem.measurement.wheel.as_ref();
        if let (Some(a), Some(b), Some(wheel)) = (before.wheel_deg_rms, after.wheel_deg_rms, wheel)
        {
            for (what, k) in [("camber", 0), ("steer", 1)] {
                parts.push(fall(what, [a[k], b[k]], "deg", wheel.sigma_angle_deg));
            }
        }
        let mut channels = self.channel_gains();
        let gain = |channel: &super::diagnosis_text::ChannelGain| {
            (channel.rms[0] - channel.rms[1]) / channel.sigma
        };
        channels.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
        parts.extend(
            channels
                .iter()
                .take(MAX_STATED_CHANNELS)
                .map(|c| fall(&c.name, c.rms, c.behind.trim(), c.sigma)),
        );
        let (count, what) = match found.cases.len() {
            0 => (found.curves.len(), "curve"),
            count => (count, "case"),
        };
        let end = if count == 1 { "" } else { "s" };
        format!("rms error in {count} {what}{end}: {}", parts.join(", "))
    }

    /// Returns the recommended next step.
    fn next_step(&self, study: &str) -> String {
        self.next_steps(study).join("; ")
    }

    /// Returns the recommended next steps, in order.
    pub(super) fn next_steps(&self, study: &str) -> Vec<String> {
        let diagnosis = &self.outcome.diagnosis;
        if self.outcome.is_stopped() {
            return vec!["run the same command again without interrupting it".to_string()];
        }
        if self.outcome.is_late {
            return vec!["run the same command again with a larger `--budget`".to_string()];
        }
        let mut steps = Vec::new();
        match (diagnosis.verdict, &diagnosis.unexplained.remainder) {
            (Verdict::Consistent, _) => {
                steps.push("nothing in the model needs to be changed".to_string());
            }
            (Verdict::Discrepancy, _) => {
                steps.push("continue with extended.adm, which contains these causes".to_string());
            }
            (Verdict::Unexplained, Some(remainder)) => steps.push(format!(
                "look at {}: an extra force there explains most of the remaining residuals",
                remainder.address
            )),
            (Verdict::Unexplained, None) => {}
        }
        match &diagnosis.next_measurement {
            Some(next) => {
                steps.push(format!("measure {}", next_text(next)));
            }
            None if diagnosis.verdict == Verdict::Unexplained => {
                steps.push(format!(
                    "run `admire plan {study}` to rank the possible measurements"
                ));
            }
            None => {}
        }
        steps
    }

    /// Returns the gains by the causes in the readings that no fit saw, one line for each kind of reading.
    pub(super) fn gains(&self) -> Vec<String> {
        let diagnosis = &self.outcome.diagnosis;
        if diagnosis.findings.is_empty() {
            return Vec::new();
        }
        let (Some(unseen), Some(found)) = (&self.outcome.unseen, &diagnosis.hold_out) else {
            return vec!["no case was held out, so the gain is not known".to_string()];
        };
        let [before, after] = &unseen.tests;
        let mut out = Vec::new();
        if let (Some(a), Some(b)) = (before.marks_rms, after.marks_rms) {
            out.push(format!(
                "rms error of the marks {} {}",
                change(a, b),
                self.length()
            ));
        }
        if let (Some(a), Some(b)) = (before.wheel_deg_rms, after.wheel_deg_rms) {
            for (what, k) in [("camber", 0), ("steer", 1)] {
                out.push(format!("rms error of {what} {} deg", change(a[k], b[k])));
            }
        }
        let channels = self.channel_gains().into_iter();
        out.extend(channels.map(|channel| {
            let [before, after] = channel.rms;
            format!(
                "rms error of {} {}{}",
                channel.name,
                change(before, after),
                channel.behind
            )
        }));
        if out.is_empty() {
            let change = change(found.rms_before, found.rms_after);
            out.push(format!(
                "rms error of the readings {change} times the noise"
            ));
        }
        let count = found.cases.len().max(found.curves.len());
        let what = if found.cases.is_empty() {
            "curve"
        } else {
            "load case"
        };
        let end = if count == 1 { "" } else { "s" };
        out[0] += &format!(", in {count} {what}{end} held out of all fits");
        out
    }
}
