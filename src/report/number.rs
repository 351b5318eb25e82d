/// Makes a short text unbreakable: blanks become non-breaking spaces.
pub(super) fn unbroken(text: &str) -> String {
    text.replace(' ', "\u{a0}")
}

/// Formats a value down to the second digit of its standard error. Without an error, the value has six digits.
pub fn number(value: f64, std_error: Option<f64>) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = match std_error.filter(|error| *error > 0.0 && error.is_finite()) {
        Some(error) => {
            (libm::log10(value.abs()).floor() - libm::log10(error).floor() + 2.0).clamp(1.0, 8.0)
        }
        None => 6.0,
    };
    rounded(value, digits as i32)
}

/// Describes the change of an error in words, with three digits per value: `falls from 0.48 to 0.05`, or `stays at 0.05` for a negligible
/// change.
pub(super) fn change(before: f64, after: f64) -> String {
    let digits = |value: f64| number(value, Some(value.abs() * 0.1));
    let (from, to) = (digits(before), digits(after));
    if from == to || (after / before - 1.0).abs() < 0.01 {
        format!("stays at {to}")
    } else if after < before {
        format!("falls from {from} to {to}")
    } else {
        format!("rises from {from} to {to}")
    }
}

pub(super) fn rounded(value: f64, digits: i32) -> String {
    let exponent = libm::log10(value.abs()).floor() as i32;
    let decimals = digits - 1 - exponent;
    if !(-5..=9).contains(&exponent) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    if decimals >= 0 {
        let text = format!("{value:.*}", decimals as usize);
        return if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            text
        };
    }
    let unit = 10f64.powi(-decimals);
    format!("{:.0}", (value / unit).round() * unit)
}

/// Returns a count with its noun: `1 case`, `3 cases`.
pub(super) fn counted(count: usize, what: &str) -> String {
    let end = if count == 1 { "" } else { "s" };
    format!("{count} {what}{end}")
}

/// Makes the first letter of a text a capital.
pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}
