//! Values of loads in candidate load cases.

use admire_session::backend::LoadProgramme;
use admire_study::{Available, LoadRange};

/// Returns the usual value of each load: its most frequent value in the study. Among equally frequent values, the value nearest to zero is
/// used.
pub(super) fn usual(programme: &LoadProgramme) -> Vec<f64> {
    let of = |load: usize| {
        let values: Vec<f64> = programme.cases.iter().map(|c| c.values[load]).collect();
        let count = |v: f64| values.iter().filter(|w| **w == v).count();
        let better = |a: &f64, b: &f64| {
            let by_count = count(*a).cmp(&count(*b));
            by_count.then(b.abs().total_cmp(&a.abs()))
        };
        values.iter().copied().max_by(better).unwrap_or_default()
    };
    (0..programme.loads.len()).map(of).collect()
}

/// Returns the values at the ends of the range of a load, the upper end first. Ends at the usual value are left out. `usual` holds the usual
/// values of all loads.
///
/// If a load may exceed its range in the study, its ends deviate from the usual value by `factor` times its largest deviation in the study.
/// For any other load, the result is empty if `factor` exceeds 1.
pub(super) fn ends(
    programme: &LoadProgramme,
    available: &Available,
    usual: &[f64],
    load: usize,
    factor: f64,
) -> Vec<f64> {
    let values = || programme.cases.iter().map(|case| case.values[load]);
    let usual = usual[load];
    let ends = match available.load(&programme.loads[load].name) {
        LoadRange::Beyond => {
            let far = values().fold(0.0_f64, |most, v| most.max((v - usual).abs()));
            // Loads are rounded to four digits, so that a rig can set them.
            [1.0, -1.0].map(|side| round(programme, load, usual + side * factor * far))
        }
        // A stated range is a limit of the rig, so no value beyond it is returned.
        _ if factor > 1.0 => return Vec::new(),
        LoadRange::Fixed => return Vec::new(),
        LoadRange::Applied => [
            values().fold(f64::NEG_INFINITY, f64::max),
            values().fold(f64::INFINITY, f64::min),
        ],
        LoadRange::Between([low, high]) => {
            let of = |value: f64| {
                if in_degrees(programme, load) {
                    value.to_radians()
                } else {
                    value
                }
            };
            [of(high), of(low)]
        }
    };
    ends.into_iter().filter(|value| *value != usual).collect()
}

/// Rounds the value of a load to four significant digits in the unit of the study's file.
pub(super) fn round(programme: &LoadProgramme, load: usize, value: f64) -> f64 {
    let shown = in_the_file(programme, load, value);
    let digits: f64 = format!("{shown:.3e}").parse().unwrap_or(shown);
    if in_degrees(programme, load) {
        digits.to_radians()
    } else {
        digits
    }
}

fn in_degrees(programme: &LoadProgramme, load: usize) -> bool {
    programme.loads[load].name.ends_with("_deg")
}

/// Returns the value of a load in the unit of the study's file.
pub(super) fn in_the_file(programme: &LoadProgramme, load: usize, value: f64) -> f64 {
    if in_degrees(programme, load) {
        // Ten digits are kept, because the conversion to radians and back has rounding errors.
        let degrees = value.to_degrees();
        format!("{degrees:.9e}").parse().unwrap_or(degrees)
    } else {
        value
    }
}

/// Formats the value of a load in the unit of the study's file, with four digits.
pub(super) fn plain(programme: &LoadProgramme, load: usize, value: f64) -> String {
    let value = in_the_file(programme, load, value);
    let digits: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{digits}")
}

/// Formats a load with its name and value.
pub(super) fn shown(programme: &LoadProgramme, load: usize, value: f64) -> String {
    format!(
        "{} {}",
        programme.loads[load].name,
        plain(programme, load, value)
    )
}
