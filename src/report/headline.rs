use super::number::change;
use crate::identify::{Fit, FitTest, LoadedStudy, Status, Verdict};

/// The answer of an identification in a sentence or two for someone who decides.
pub(super) fn identification(loaded: &LoadedStudy, fit: &Fit, before: Option<f64>) -> String {
    let length = loaded.model.units.length.word;
    let all = fit.parameters.len();
    let known: Vec<f64> = fit
        .parameters
        .iter()
        .filter(|parameter| parameter.status == Status::Identified)
        .filter_map(|parameter| Some(parameter.std_error? / parameter.value.abs()))
        .filter(|share| share.is_finite())
        .collect();
    let count = fit
        .parameters
        .iter()
        .filter(|parameter| parameter.status == Status::Identified)
        .count();
    let misfit = |test: &FitTest| test.verdict == Verdict::Misfit;
    if !fit.converged {
        return format!(
            "The fit did not converge: the {all} stiffnesses below are where it stopped, and should not be used yet."
        );
    }
    let mut shares = known;
    shares.sort_by(f64::total_cmp);
    let half = shares.get(shares.len() / 2);
    let precision = half.map_or_else(String::new, |share| {
        format!(", half of them to {} or better", percent(*share))
    });
    let mut text = if count == all {
        format!("The measurement determines all {all} stiffnesses that were sought{precision}.")
    } else {
        format!(
            "The measurement determines {count} of the {all} stiffnesses that were sought{precision}; the other {} it says too little about.",
            all - count
        )
    };
    let held = &fit.held_out;
    for curve in &held.curves {
        let unit = curve.unit.as_deref().unwrap_or("");
        text += &format!(
            " Of {}, which the fit did not see, the error {} {unit}.",
            curve.name,
            change(curve.rms_before, curve.rms_after)
        );
    }
    if let (Some(from), Some(to)) = (held.marks_rms_before, held.marks_rms_after) {
        text += &format!(
            " On {} load cases that the fit did not see, the error of the model {} {length}.",
            held.cases.len(),
            change(from, to)
        );
    } else if let Some(after) = fit.marks.and_then(|marks| marks.rms) {
        text += &match before {
            Some(before) => format!(
                " With them the error of the model {} {length}.",
                change(before, after)
            ),
            None => format!(
                " With them the model follows the measured marks to {} {length}.",
                digits(after)
            ),
        };
    }
    if fit.fit_test.as_ref().is_some_and(misfit) {
        text += " What is left is more than noise: the model lacks something, and `admire diagnose` looks for it.";
    }
    text
}

/// Two digits.
fn digits(value: f64) -> String {
    super::number(value, Some(value.abs() * 0.1))
}

fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share))
}
