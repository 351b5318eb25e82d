//! Formatting of the numbers of a tuned deck, with units and rounded to a few digits.

use admire_syntax::units::short_unit;

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

/// Formats a value with its unit.
pub(super) fn with_unit(value: f64, unit: &str) -> String {
    let unit = short_unit(unit);
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    format!("{}{unit}", rounded(value, DIGITS))
}
