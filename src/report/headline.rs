use super::number::{change, rounded};
use admire_identify::{Fit, FitTest, FitVerdict, LoadedStudy, Status};

/// Returns the result of an identification for decision makers, in one or two sentences.
pub(super) fn identification(loaded: &LoadedStudy, fit: &Fit) -> String {
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
    let misfit = |test: &FitTest| test.verdict == FitVerdict::Misfit;
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
    } else if let Some(written) = &fit.written {
        text += &format!(
            " With them in the deck its error at the marks {} {length}.",
            change(written.marks_rms_before, written.marks_rms_after)
        );
    }
    if let Some(strained) = strained(fit) {
        return format!("{strained} {text}");
    }
    if fit.fit_test.as_ref().is_some_and(misfit) {
        text += " What is left is more than noise: the model lacks something, and `admire diagnose` looks for it.";
    }
    text
}

/// Describes the tolerances and noise levels that exceed their priors. Returns `None` if there are none.
pub(super) fn strained(fit: &Fit) -> Option<String> {
    let mut strained: Vec<_> = fit
        .tolerances
        .iter()
        .filter(|(_, size)| size.strained)
        .collect();
    strained.sort_by(|a, b| (b.1.sd / b.1.usual).total_cmp(&(a.1.sd / a.1.usual)));
    let each = strained.iter().map(|(name, size)| {
        let times = rounded(size.sd / size.usual, 2);
        format!(
            "{name} of {} {}, {times} times the usual size",
            rounded(size.sd, 2),
            size.unit
        )
    });
    let listed: Vec<String> = each.collect();
    (!listed.is_empty()).then(|| {
        format!(
            "The model follows the readings only with {}: axle and rig are as far off as that, or the model lacks something. Do not trust the \
             intervals.",
            listed.join(", and ")
        )
    })
}

/// Formats a number with three significant digits.
fn digits(value: f64) -> String {
    super::number(value, Some(value.abs() * 0.1))
}

fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share))
}

#[cfg(test)]
mod tests {
    use super::strained;
    use crate::lead;
    use admire_identify::{Fit, ToleranceFound};

    /// A fit with a tolerance at twenty times its usual size does not count as an explanation of the readings.
    #[test]
    fn sizes_beyond_their_priors_come_first() {
        let mut fit = Fit {
            converged: true,
            fit_test: admire_identify::FitTest::new(98.0, 100.0, Vec::new()),
            ..Fit::default()
        };
        assert_eq!(strained(&fit), None);
        assert!(lead(&fit).contains("explains the readings as well as their noise allows"));
        let pose = ToleranceFound {
            sd: 0.06,
            usual: 0.003,
            unit: "mm",
            strained: true,
        };
        fit.tolerances.insert("pose-noise".to_string(), pose);
        let lead = lead(&fit);
        let first = "The model follows the readings only with pose-noise of 0.06 mm, 20 times the usual size: axle and rig are";
        assert!(lead.starts_with(first), "{lead}");
        assert!(!lead.contains("explain"), "{lead}");
        assert!(lead.contains("admire diagnose"), "{lead}");
    }
}
