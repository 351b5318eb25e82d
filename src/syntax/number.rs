//! Reading numbers as the dataset language spells them (ADAMS-FORMATS 1.6).

/// A number literal: its value, and whether it carries the degree suffix `D`. A value in degrees is returned in radians.
///
/// Accepts an optional sign, digits with an optional point, an optional exponent `E` with an optional sign, an optional `D`. `D` is
/// never an exponent. Returns `None` for anything else, and for numbers too large for a double.
pub fn parse_number(text: &[u8]) -> Option<(f64, bool)> {
    let (digits, degrees) = match text.split_last() {
        Some((b'D' | b'd', front)) => (front, true),
        _ => (text, false),
    };
    // The standard parser takes words (inf, nan) too; numbers of the language hold these bytes only.
    if !digits
        .iter()
        .all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'E' | b'e'))
    {
        return None;
    }
    let value: f64 = std::str::from_utf8(digits).ok()?.parse().ok()?;
    let value = if degrees { value.to_radians() } else { value };
    value.is_finite().then_some((value, degrees))
}

/// Length of the unsigned number at the start of `text`, degree suffix included; 0 if none stands there.
pub fn number_length(text: &[u8]) -> usize {
    let digits = |from: usize| {
        text[from..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count()
    };
    let whole = digits(0);
    let mut at = whole;
    if text.get(at) == Some(&b'.') {
        let fraction = digits(at + 1);
        if whole + fraction == 0 {
            return 0;
        }
        at += 1 + fraction;
    } else if whole == 0 {
        return 0;
    }
    if matches!(text.get(at), Some(b'E' | b'e')) {
        let sign = usize::from(matches!(text.get(at + 1), Some(b'+' | b'-')));
        let exponent = if at + 1 + sign <= text.len() {
            digits(at + 1 + sign)
        } else {
            0
        };
        if exponent > 0 {
            at += 1 + sign + exponent;
        }
    }
    if matches!(text.get(at), Some(b'D' | b'd')) {
        at += 1;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_real_decks_are_read() {
        // ADAMS-FORMATS 1.6: three-digit exponents, bare points, signs, the degree suffix.
        for (text, value) in [
            ("1", 1.0),
            ("1.", 1.0),
            (".5", 0.5),
            ("+10", 10.0),
            ("-0.5", -0.5),
            ("2.07E+005", 2.07e5),
            ("1e-7", 1e-7),
            ("0201", 201.0),
        ] {
            assert_eq!(
                parse_number(text.as_bytes()),
                Some((value, false)),
                "{text}"
            );
        }
        let (value, degrees) = parse_number(b"90D").unwrap();
        assert!(degrees && (value - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        for text in [
            "", "D", ".", "inf", "NaN", "1e999", "1E", "1+2", "1D5", "3R5.0", "0x1",
        ] {
            assert_eq!(parse_number(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn a_number_ends_where_its_spelling_ends() {
        for (text, length) in [
            ("12+3", 2),
            ("1.E5*2", 4),
            (".5D)", 3),
            ("1E+", 1),
            ("3.DX", 3),
            (".", 0),
            ("x", 0),
            ("2E", 1),
        ] {
            assert_eq!(number_length(text.as_bytes()), length, "{text}");
        }
    }
}
