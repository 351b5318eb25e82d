//! Phrases for the sentences of a diagnosis.

use admire_diagnosis::{CandidateEffect, ChannelMiss, NextMeasurement, SolverDifference};
use admire_syntax::text::Decimals;

/// Formats a gain with its standard error. For a single case, there is no standard error.
pub(super) fn fallen_by(decimals: Decimals, gain: f64, std_error: f64) -> String {
    let gain = decimals.format(gain);
    if std_error.is_finite() {
        format!("by {gain} ± {}", decimals.format(std_error))
    } else {
        format!("by {gain}, in one case")
    }
}

/// Lists the main causes, each with its site.
pub(super) fn chosen(causes: &[CandidateEffect]) -> String {
    let names: Vec<String> = CandidateEffect::causes(causes)
        .map(ToString::to_string)
        .collect();
    match names.as_slice() {
        [] => "no cause".to_string(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Formats a list of case labels: `case 7`, `8 cases from 1 to 8`, `cases 1, 4, 9`.
pub(super) fn labels(cases: &[String]) -> String {
    match cases {
        [one] => format!("case {one}"),
        [first, .., last] if cases.len() > 6 => {
            format!("{} cases from {first} to {last}", cases.len())
        }
        _ => format!("cases {}", cases.join(", ")),
    }
}

/// Returns a text that lists all loads other than zero.
pub(super) fn loads_text<'a>(loads: impl Iterator<Item = (&'a str, f64)>) -> String {
    let listed: Vec<String> = loads
        .filter(|(_, value)| *value != 0.0)
        .map(|(name, value)| format!("{name} = {value}"))
        .collect();
    if listed.is_empty() {
        "no load".to_string()
    } else {
        listed.join(", ")
    }
}

/// Describes the next measurement and its reason: a load case, or an instrument if no load separates the causes.
pub(super) fn next_text(next: &NextMeasurement) -> String {
    if let Some(instrument) = &next.instead {
        return format!("{instrument}; {}", next.why);
    }
    let loads = next.case.iter().map(|(name, load)| (name.as_str(), *load));
    format!("{}; it {}", loads_text(loads), next.why)
}

/// Formats a probability as a rounded percentage, with open ends below 1 and above 99 percent.
pub(super) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 99.0 => "above 99 %".to_string(),
        p if p < 1.0 => "below 1 %".to_string(),
        p => format!("{p:.0} %"),
    }
}

/// Returns the sentence about the rms errors of one channel.
pub(super) fn channel_sentence(miss: &ChannelMiss) -> String {
    let decimals = Decimals::of_error(miss.noise);
    let [before, after, noise] = [miss.before, miss.after, miss.noise].map(|x| decimals.format(x));
    format!(
        "The rms error of channel {} is {before}{unit} in the identified model and {after}{unit} in the extended model; its noise is {noise}{unit}.",
        miss.name,
        unit = miss.behind
    )
}

/// Returns the sentence about the difference between the study's solver and the built-in solver. `sigma` is the noise of the marks per
/// coordinate, in the length unit `unit`.
pub(super) fn solver_sentence(solver: &SolverDifference, sigma: f64, unit: &str) -> String {
    let mut text = format!(
        "With the fitted stiffnesses, mark positions from the solver of the study ({}) and from the built-in solver differ by {:.2e} {unit} rms per coordinate",
        solver.solver, solver.rms
    );
    if let Some(case) = &solver.case {
        text += &format!(" (at most {:.2e} {unit}, in case {case})", solver.most);
    }
    text += if solver.is_negligible(sigma) {
        ", which is small compared with the noise."
    } else {
        ": the findings below may be due to this difference between the solvers."
    };
    let told = |rms: f64| Decimals::of_error(sigma).finer().format(rms);
    if let Some(both) = solver.residual_rms {
        let [own, other] = both.map(told);
        text += &format!(
            " Without tolerances, the rms error of the marks is {own} {unit} with the built-in solver and {other} {unit} with the solver of the study"
        );
        text += &match solver.held_out_rms {
            Some(both) => {
                let [own, other] = both.map(told);
                format!("; in the cases held out, it is {own} {unit} and {other} {unit}.")
            }
            None => ".".to_string(),
        };
    }
    if let Some(rms) = solver.refitted_rms {
        text += &format!(
            " The parameters below, the extended deck and the gain are fitted with the solver of the study; its rms error of the marks is then {} {unit}.",
            told(rms)
        );
    }
    if !solver.unsolved.is_empty() {
        text += &format!(
            " Only one of the two solvers found an equilibrium in {}.",
            labels(&solver.unsolved)
        );
    }
    text
}
