//! Parsing of numbers in the spelling of the dataset language (guide/formats.md 1.6).

/// Parses a number literal. Returns its value, converted to radians if the number is in degrees, and true if it has the degree suffix `D`.
///
/// A number consists of an optional sign, digits with an optional point, an optional exponent `E` with an optional sign, and an optional
/// `D`. The letter `D` never begins an exponent. Returns `None` for any other text and for numbers too large for a double.
pub fn parse_number(text: &[u8]) -> Option<(f64, bool)> {
    let (digits, degrees) = match text.split_last() {
        Some((b'D' | b'd', front)) => (front, true),
        _ => (text, false),
    };
    if let Some(value) = plain(digits) {
        let value = if degrees { value.to_radians() } else { value };
        return Some((value, degrees));
    }
    // Rust's parser also accepts words such as `inf` and `nan`, so other bytes are rejected first.
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

/// Parses an unsigned number exactly, if its digits form an integer up to 2^53 and the power of ten lies between 10^-22 and 10^22.
///
/// The integer and the power of ten are then exact doubles, so one multiplication or division is correctly rounded (Clinger 1990). Returns
/// `None` for other texts.
fn plain(text: &[u8]) -> Option<f64> {
    const POWERS: [f64; 23] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
        1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
    ];
    // The longest accepted text has 18 digits, a point and an exponent such as `E+005`; the integers below cannot overflow then.
    if text.len() > 24 {
        return None;
    }
    let (mut whole, mut digits, mut point) = (0u64, 0usize, None);
    let mut at = 0;
    while let Some(byte) = text.get(at) {
        match byte {
            b'0'..=b'9' if digits < 18 => {
                whole = whole * 10 + u64::from(byte - b'0');
                digits += 1;
            }
            b'.' if point.is_none() => point = Some(digits),
            b'E' | b'e' => break,
            _ => return None,
        }
        at += 1;
    }
    if digits == 0 || whole > 1 << 53 {
        return None;
    }
    let fraction = point.map_or(0, |before| digits - before) as i32;
    let power = exponent(&text[at..])? - fraction;
    let scale = POWERS.get(power.unsigned_abs() as usize)?;
    let whole = whole as f64;
    Some(if power < 0 {
        whole / scale
    } else {
        whole * scale
    })
}

/// Parses an exponent such as `E+05`; an empty text gives the exponent 0.
fn exponent(text: &[u8]) -> Option<i32> {
    let Some((_, rest)) = text.split_first() else {
        return Some(0);
    };
    let (negative, digits) = match rest {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] | digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 3 {
        return None;
    }
    let mut value = 0;
    for byte in digits {
        value = value * 10 + i32::from(byte.is_ascii_digit().then(|| byte - b'0')?);
    }
    Some(if negative { -value } else { value })
}

/// Returns the length of the unsigned number at the start of `text`, including the degree suffix, or 0 if `text` begins with no number.
#[inline]
pub(crate) fn number_length(text: &[u8]) -> usize {
    let after_digits = |mut at: usize| {
        while text.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let mut at = after_digits(0);
    let mut digits = at;
    if text.get(at) == Some(&b'.') {
        let end = after_digits(at + 1);
        digits = end - 1;
        at = end;
    }
    if digits == 0 {
        return 0;
    }
    match text.get(at) {
        Some(b'E' | b'e') => {
            let sign = usize::from(matches!(text.get(at + 1), Some(b'+' | b'-')));
            let from = at + 1 + sign;
            let end = after_digits(from);
            if end > from {
                at = end;
            }
            at + usize::from(matches!(text.get(at), Some(b'D' | b'd')))
        }
        Some(b'D' | b'd') => at + 1,
        _ => at,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_real_decks_are_read() {
        // guide/formats.md 1.6: three-digit exponents, leading and trailing points, signs, the degree suffix.
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
            "", "D", ".", "inf", "NaN", "1e999", "1E", "1+2", "1D5", "3R5.0", "0x1", "1E+,",
            "1E -", "1E5,3", "1E!",
        ] {
            assert_eq!(parse_number(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn short_numbers_are_those_of_the_standard_parser() {
        let mut state = 1u64;
        for _ in 0..20_000 {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            let digits = 1 + (state >> 60) as usize;
            let text = format!("{:015}", (state >> 8) % 1_000_000_000_000_000);
            let mut text = text[..digits.min(15)].to_string();
            text.insert((state >> 40) as usize % (text.len() + 1), '.');
            if state & 1 == 0 {
                text += &format!("E{:+03}", (state >> 20) as i32 % 30);
            }
            let (value, _) = parse_number(text.as_bytes()).unwrap();
            assert_eq!(
                value.to_bits(),
                text.parse::<f64>().unwrap().to_bits(),
                "{text}"
            );
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
