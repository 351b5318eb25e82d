//! Tables of a diagnosis: cases predicted from other cases, and residuals of channels.

use admire_diagnosis::{ChannelMiss, CrossValidation, HoldOut};

use super::{Align, Scene, Table, number};

/// Formats a number with three significant digits.
fn three(value: f64) -> String {
    number(value, Some(0.1 * value.abs()))
}

/// Formats a p-value for the report.
pub(super) fn probability(p: f64) -> String {
    match p {
        0.0 => "< 1e-300".to_string(),
        p if p < 1e-3 => format!("{p:.0e}"),
        p => format!("{p:.3}"),
    }
}

/// Creates the empty table for the errors in cases that are predicted from other cases. `of` is `mark` for errors in the length unit `length`.
/// It is `noise` for errors in standard deviations of the noise.
fn predicted(of: &str, length: &str) -> Table {
    let unit = if of == "mark" {
        length
    } else {
        "standard deviations"
    };
    let (before, after) = (
        format!("rms error without causes, {unit}"),
        format!("rms error with the causes, {unit}"),
    );
    Table::new(&[
        ("cases predicted", Align::Left),
        ("causes in the model", Align::Left),
        (before.as_str(), Align::Right),
        (after.as_str(), Align::Right),
    ])
}

/// Creates one row of the table of predictions.
fn prediction(cases: &[String], causes: &[String], rms: [f64; 2], scene: &Scene) -> [String; 4] {
    let cases = match cases {
        [first, .., last] if cases.len() > 6 => format!("{} from {first} to {last}", cases.len()),
        few => few.join(", "),
    };
    let causes = if causes.is_empty() {
        "none".to_string()
    } else {
        scene.naming(&causes.join(", "))
    };
    let [before, after] = rms.map(three);
    [cases, causes, before, after]
}

/// Tabulates the rms errors of the channels.
pub(super) fn missed(channels: &[ChannelMiss]) -> Table {
    let mut table = Table::new(&[
        ("channel", Align::Left),
        ("unit", Align::Left),
        ("rms error, identified", Align::Right),
        ("rms error, extended", Align::Right),
        ("noise of a reading", Align::Right),
    ]);
    for miss in channels {
        let value = |x: f64| number(x, Some(0.1 * miss.noise));
        table.row([
            miss.name.clone(),
            miss.behind.trim().to_string(),
            value(miss.before),
            value(miss.after),
            value(miss.noise),
        ]);
    }
    table
}

/// Tabulates the prediction of the held-out cases.
pub(super) fn hold_out(found: &HoldOut, length: &str, scene: &Scene) -> Table {
    let mut table = predicted(found.of, length);
    let rms = [found.rms_before, found.rms_after];
    table.row(prediction(&found.cases, &found.causes, rms, scene));
    table
}

/// Tabulates the prediction of each group of cases from the other groups.
pub(super) fn groups(found: &CrossValidation, length: &str, scene: &Scene) -> Table {
    let mut table = predicted(found.of, length);
    for group in &found.groups {
        let rms = [group.rms_before, group.rms_after];
        table.row(prediction(&group.cases, &group.causes, rms, scene));
    }
    table.row([
        "all".to_string(),
        String::new(),
        three(found.rms_before),
        three(found.rms_after),
    ]);
    table
}
