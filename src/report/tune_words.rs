//! Formatting of the numbers of a tuned deck, with units and rounded to a few digits.

use admire_syntax::units::short_unit;
use admire_tune::GoalOutcome;

/// Number of significant digits in sentences and tables.
pub(super) const DIGITS: i32 = 4;

/// Formats a value with this number of significant digits; empty if it is not finite.
pub(super) fn rounded(value: f64, digits: i32) -> String {
    if value == 0.0 {
        "0".to_string()
    } else if value.is_finite() {
        super::number::rounded(value, digits)
    } else {
        String::new()
    }
}

/// Fraction of a goal's tolerance below which a miss is not stated as a number.
const SMALL_MISS: f64 = 1e-3;

/// Formats a miss of a goal with three digits. A miss of less than a thousandth of the tolerance is only bounded.
pub(super) fn missed(value: f64, goal: &GoalOutcome) -> String {
    let least = SMALL_MISS * goal.tolerance;
    if value != 0.0 && value.abs() < least {
        format!("< {}", rounded(least, 1))
    } else {
        rounded(value, 3)
    }
}

/// Returns the words for the kind of a goal: its scope, such as a curve or a value, and whether it is a minimax goal or a limit.
pub(super) fn kind(goal: &GoalOutcome) -> String {
    // The only reading of a load case has the scope of a curve.
    let scope = match goal.scope {
        "curve" if goal.rows.len() == 1 => "value",
        scope => scope,
    };
    match goal.kind {
        "squares" => scope.to_string(),
        "minimax" => format!("{scope}, largest miss"),
        "limit" => format!("{scope}, limits"),
        other => format!("{scope}, {other}"),
    }
}

/// Appends a unit to a formatted value.
pub(super) fn with_unit(value: &str, unit: &str) -> String {
    let unit = short_unit(unit);
    format!("{value} {unit}").trim_end().to_string()
}
