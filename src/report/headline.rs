use super::number::{capitalised, change, counted, rounded};
use admire_identify::lack_of_fit::is_structured;
use admire_identify::{Fit, FitTest, FitVerdict, LoadedStudy, ParameterFit, Status};

/// Largest number of undetermined numbers that are named.
const MAX_NAMED_NUMBERS: usize = 4;

/// Returns the result of an identification in one or two sentences, for readers without knowledge of the method.
pub(super) fn identification(loaded: &LoadedStudy, fit: &Fit) -> String {
    let length = loaded.model.units.length.word;
    let all = fit.parameters.len();
    let known: Vec<f64> = fit
        .parameters
        .iter()
        .filter(|parameter| parameter.status == Status::Identified && parameter.form.is_none())
        .filter_map(|parameter| Some(parameter.std_error? / parameter.value.abs()))
        .filter(|share| share.is_finite())
        .collect();
    let count = fit
        .parameters
        .iter()
        .filter(|parameter| parameter.status == Status::Identified)
        .count();
    let misfit = |test: &FitTest| test.verdict == FitVerdict::Misfit;
    let is_stiffness = |parameter: &ParameterFit| {
        let (_, argument) = parameter.address.split_once('.').unwrap_or_default();
        let name = argument.split('.').next();
        parameter.form.is_none() && matches!(name, Some("K" | "KT"))
    };
    let what = match (fit.parameters.iter().all(is_stiffness), all) {
        (true, 1) => "stiffness",
        (true, _) => "stiffnesses",
        (false, 1) => "parameter",
        (false, _) => "parameters",
    };
    if !fit.converged {
        return format!(
            "The fit did not converge: the values below ({all} {what}) are those of the last iteration. Do not use them."
        );
    }
    let mut shares = known;
    shares.sort_by(f64::total_cmp);
    let half = shares
        .get(shares.len() / 2)
        .filter(|_| shares.len() == count);
    let precision = half.map_or_else(String::new, |share| {
        let error = rounded(100.0 * share, 2);
        if count == 1 {
            format!(", with a standard error of {error} %")
        } else {
            format!(", half of them with a standard error of {error} % or less")
        }
    });
    let mut text = match (count, all) {
        (0, 1) => format!("The measurement does not determine the unknown {what}."),
        (1, 1) => format!("The measurement determines the unknown {what}{precision}."),
        _ if count == all => {
            format!("The measurement determines all {all} unknown {what}{precision}.")
        }
        _ => format!("The measurement determines {count} of the {all} unknown {what}{precision}."),
    };
    let held = &fit.held_out;
    for curve in &held.curves {
        let unit = curve.unit.as_deref().map(|unit| format!(" {unit}"));
        let unit = unit.unwrap_or_default();
        text += &format!(
            " The rms error of the held-out curve {} {}{unit}.",
            curve.name,
            change(curve.rms_before, curve.rms_after)
        );
    }
    if let (Some(from), Some(to)) = (held.marks_rms_before, held.marks_rms_after) {
        text += &format!(
            " In {} held out, the rms error of the marks {} {length}.",
            counted(held.cases.len(), "load case"),
            change(from, to)
        );
    } else if let Some(written) = &fit.written {
        text += &format!(
            " With the identified values in the deck, the rms error of the marks {} {length}.",
            change(written.marks_rms_before, written.marks_rms_after)
        );
    }
    if strained(fit).is_some() {
        return format!(
            "Do not trust the intervals: the model lacks an effect, or axle and rig are far outside their usual tolerances. {text}"
        );
    }
    if fit.fit_test.as_ref().is_some_and(misfit) {
        text += " The residuals are larger than the noise: the model lacks an effect. Run `admire diagnose` to find it.";
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
            "{name} of {} {}, {times} times the usual standard deviation",
            rounded(size.sd, 2),
            size.unit
        )
    });
    let listed: Vec<String> = each.collect();
    (!listed.is_empty()).then(|| {
        format!(
            "The model fits the readings only with {}: axle or rig really deviates so far, or the model lacks an effect. Do not trust the intervals.",
            listed.join(", and ")
        )
    })
}

/// Returns the lines of findings next to the table of numbers: uncertainty, gain and next step.
pub(super) fn found_lines(loaded: &LoadedStudy, fit: &Fit) -> Vec<(&'static str, Vec<String>)> {
    let length = loaded.model.units.length.word;
    let is_identified = |parameter: &&ParameterFit| parameter.status == Status::Identified;
    let count = fit.parameters.iter().filter(is_identified).count();
    let found = format!(
        "{count} of {} parameters, in the table below",
        fit.parameters.len()
    );
    let strained = strained(fit);
    let sure = match fit.fit_test.as_ref().map(|test| test.verdict) {
        _ if !fit.converged => "none: the fit did not converge",
        _ if strained.is_some() => strained.as_deref().unwrap_or_default(),
        Some(FitVerdict::Misfit) => {
            "the intervals cannot be trusted: the residuals are larger than the noise of the readings"
        }
        _ if is_structured(&fit.structure) => {
            "the residuals have structure, so the model lacks an effect"
        }
        Some(FitVerdict::Noise) => "the residuals look like the noise of the readings",
        Some(FitVerdict::NoiseOverstated) => {
            "the residuals are smaller than the stated noise of the readings"
        }
        None => "there are too few readings for a test",
    };
    let mut gains = Vec::new();
    if let Some(written) = &fit.written {
        let change = change(written.marks_rms_before, written.marks_rms_after);
        gains.push(format!(
            "rms error of the marks {change} {length}, in the fitted cases"
        ));
    }
    if let Some(wheel) = &fit.wheel {
        let camber = change(wheel.camber_deg_rms_before, wheel.camber_deg_rms_after);
        let steer = change(wheel.steer_deg_rms_before, wheel.steer_deg_rms_after);
        gains.push(format!(
            "rms error of camber {camber} deg, of steer {steer} deg"
        ));
    }
    let held = &fit.held_out;
    if let (Some(before), Some(after)) = (held.marks_rms_before, held.marks_rms_after) {
        gains.push(format!(
            "rms error of the marks {} {length}, in {} held out",
            change(before, after),
            counted(held.cases.len(), "load case")
        ));
    }
    gains.extend(held.curves.iter().map(|curve| {
        format!(
            "rms error of {} {}{}, a curve held out of the fit",
            curve.name,
            change(curve.rms_before, curve.rms_after),
            curve
                .unit
                .as_deref()
                .map_or_else(String::new, |unit| format!(" {unit}"))
        )
    }));
    if held.cases.is_empty() && held.curves.is_empty() {
        gains.push(
            "no case was held out; list some in `validate.hold_out` to test the fit on them"
                .to_string(),
        );
    }
    let mut remarks = fit.remarks.clone();
    if fit.interrupted {
        let affected = fit.affected.join(", ");
        remarks.insert(
            0,
            format!("The fit was interrupted. Parameters affected: {affected}."),
        );
    }
    let study = loaded.study.folder.display().to_string();
    let upper = |texts: Vec<String>| texts.iter().map(|text| capitalised(text)).collect();
    vec![
        ("Found", vec![found]),
        ("Confidence", upper(vec![sure.to_string()])),
        ("Improvement", upper(gains)),
        ("To do next", upper(vec![next_step(fit, &study)])),
        ("Remarks", remarks),
    ]
}

/// Returns the recommended next step.
pub(super) fn next_step(fit: &Fit, study: &str) -> String {
    if fit.interrupted {
        return "run the same command again without interrupting it".to_string();
    }
    if !fit.converged {
        return format!(
            "run `admire check {study}`, which forecasts the parameters that these loads determine"
        );
    }
    let misfit = |test: &admire_identify::FitTest| test.verdict == FitVerdict::Misfit;
    let strained = fit.tolerances.values().any(|size| size.strained);
    if fit.fit_test.as_ref().is_some_and(misfit) || strained || is_structured(&fit.structure) {
        return format!("run `admire diagnose {study}` to find what the model lacks");
    }
    let is_identified = |parameter: &ParameterFit| parameter.status == Status::Identified;
    if fit.parameters.iter().all(is_identified) {
        return "continue with identified.adm, which contains these values".to_string();
    }
    let lacking = fit.parameters.iter().filter(|p| !is_identified(p));
    let mut names: Vec<&str> = lacking
        .map(|parameter| parameter.address.as_str())
        .collect();
    let more = names.len().saturating_sub(MAX_NAMED_NUMBERS);
    names.truncate(MAX_NAMED_NUMBERS);
    let and = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    format!(
        "run `admire plan {study}` to rank measurements that determine {}{and}",
        names.join(", ")
    )
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
        let first = "The model fits the readings only with pose-noise of 0.06 mm, 20 times the usual standard deviation: axle or rig";
        assert!(lead.starts_with(first), "{lead}");
        assert!(!lead.contains("explain"), "{lead}");
        assert!(lead.contains("admire diagnose"), "{lead}");
    }
}
