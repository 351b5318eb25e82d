//! Summary of an identification for a terminal.

use admire_identify::{Fit, LoadedStudy, ParameterFit, Status};

use super::headline::next_step;
use super::number::counted;
use super::parameter_name::parameter_name;
use super::summary::{Summary, fall};
use super::{lead, number, short_unit};

/// Returns the summary of an identification. `study` is the folder of the study as the user named it.
pub fn identification_summary(loaded: &LoadedStudy, fit: &Fit, study: &str) -> Summary {
    let determined = |parameter: &&ParameterFit| parameter.status != Status::Unidentifiable;
    Summary {
        verdict: verdict(fit),
        items: fit.parameters.iter().filter(determined).map(item).collect(),
        held_out: held_out(loaded, fit),
        next: next_step(fit, study),
    }
}

/// Returns the result in words. Remarks follow if the user requested repetitions.
fn verdict(fit: &Fit) -> String {
    let repeated = fit.bootstrap.is_some() || fit.posterior.is_some();
    let remarks = fit.remarks.iter().filter(|_| repeated);
    let texts = std::iter::once(lead(fit)).chain(remarks.cloned());
    texts.collect::<Vec<_>>().join(" ")
}

/// Returns an identified value with its standard error and unit.
fn item(parameter: &ParameterFit) -> String {
    let value = number(parameter.value, parameter.std_error);
    let unit = short_unit(&parameter.unit);
    let size = match parameter.std_error {
        Some(error) => format!("{value} ± {} {unit}", number(error, Some(error))),
        None => format!("{value} {unit}"),
    };
    let place = if parameter.status == Status::Bound {
        " (at a bound)"
    } else {
        ""
    };
    let again = [
        ("bootstrap", &parameter.bootstrap),
        ("posterior", &parameter.posterior),
    ];
    let again = again.into_iter().filter_map(|(kind, found)| {
        let [low, high] = found
            .as_ref()?
            .interval95
            .map(|end| number(end, parameter.std_error));
        Some(format!(" ({kind} {low} to {high})"))
    });
    format!(
        "{} {size}{place}{}",
        parameter_name(parameter),
        again.collect::<String>()
    )
}

/// Returns the errors in the readings that were held out, with the initial and with the identified parameters.
fn held_out(loaded: &LoadedStudy, fit: &Fit) -> String {
    let held = &fit.held_out;
    let measurement = &loaded.measurement;
    let mut parts = Vec::new();
    if let (Some(before), Some(after)) = (held.marks_rms_before, held.marks_rms_after) {
        let what = format!("marks of {}", counted(held.cases.len(), "case"));
        let length = loaded.model.units.length.word;
        parts.push(fall(&what, [before, after], length, measurement.sigma));
    }
    for curve in &held.curves {
        let channel = measurement.channels.iter().find(|c| c.name == curve.name);
        let Some(channel) = channel else { continue };
        let unit = curve.unit.as_deref().unwrap_or("");
        let rms = [curve.rms_before, curve.rms_after];
        parts.push(fall(&curve.name, rms, unit, channel.sigma));
    }
    if parts.is_empty() {
        return "no cases; list some in `validate.hold_out` to test the fit on them".to_string();
    }
    format!("rms error: {}", parts.join(", "))
}
