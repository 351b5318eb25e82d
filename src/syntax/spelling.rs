use super::number::parse_number;

/// Formats a number in the style of an old spelling, with the fewest digits that read back as the same double.
///
/// The style comprises the exponent letter, sign and width, the decimal point, the leading zero, the plus sign and the degree suffix.
/// `value` is always in radians; if the old spelling has the degree suffix, the text is in degrees. If no text in degrees reads back as the
/// same double, the suffix is dropped and the text is in radians.
pub fn spell_like(value: f64, old: &[u8]) -> String {
    let mut style = NumberSpelling::of(old);
    let value = if value == 0.0 { 0.0 } else { value };
    let in_degrees = if style.suffix.is_empty() {
        None
    } else {
        degree_digits(value.abs())
    };
    let (digits, exponent) = in_degrees.unwrap_or_else(|| {
        style.suffix = "";
        decimal(&format!("{:e}", value.abs()))
    });
    let fixed = (-5..16)
        .contains(&exponent)
        .then(|| style.fixed(&digits, exponent));
    let scientific = style.scientific(&digits, exponent);
    let text = match fixed {
        Some(fixed) if style.exponent.is_none() && exponent < 10 => fixed,
        Some(fixed) if style.exponent.is_none() && fixed.len() <= scientific.len() => fixed,
        Some(fixed) if fixed.len() < scientific.len() || value == 0.0 => fixed,
        _ => scientific,
    };
    let sign = match (value < 0.0, style.plus) {
        (true, _) => "-",
        (false, true) => "+",
        (false, false) => "",
    };
    let suffix = style.suffix;
    format!("{sign}{text}{suffix}")
}

/// Style in which a number is written.
struct NumberSpelling {
    plus: bool,
    /// True if the mantissa has a decimal point.
    point: bool,
    /// True if the mantissa ends with the decimal point: `1.`
    bare_point: bool,
    /// True if the mantissa begins with the decimal point: `.5`
    no_leading_zero: bool,
    exponent: Option<Exponent>,
    /// Degree suffix of the number: `D`, `d` or empty.
    suffix: &'static str,
}

struct Exponent {
    letter: char,
    plus: bool,
    width: usize,
}

impl NumberSpelling {
    fn of(old: &[u8]) -> Self {
        let text = String::from_utf8_lossy(old);
        let text = text.trim();
        let (text, suffix) = match text.char_indices().last() {
            Some((at, 'D')) => (&text[..at], "D"),
            Some((at, 'd')) => (&text[..at], "d"),
            _ => (text, ""),
        };
        let plus = text.starts_with('+');
        let text = text.trim_start_matches(['+', '-']).trim();
        let (mantissa, exponent) = match text.find(['E', 'e']) {
            Some(at) => {
                let power = &text[at + 1..];
                let digits = power.trim_start_matches(['+', '-']);
                let exponent = Exponent {
                    letter: if text[at..].starts_with('e') {
                        'e'
                    } else {
                        'E'
                    },
                    plus: power.starts_with('+') || power.starts_with('-'),
                    width: digits.len(),
                };
                (&text[..at], Some(exponent))
            }
            None => (text, None),
        };
        Self {
            plus,
            point: mantissa.contains('.'),
            bare_point: mantissa.ends_with('.'),
            no_leading_zero: mantissa.starts_with('.'),
            exponent,
            suffix,
        }
    }

    /// Returns the text that follows the digits of a whole mantissa: a point, `.0` or nothing.
    const fn end(&self) -> &'static str {
        match (self.point, self.bare_point) {
            (true, true) => ".",
            (true, false) => ".0",
            (false, _) => "",
        }
    }

    fn fixed(&self, digits: &str, exponent: i32) -> String {
        if exponent < 0 {
            let zeros = "0".repeat((-exponent - 1) as usize);
            let lead = if self.no_leading_zero { "" } else { "0" };
            return format!("{lead}.{zeros}{digits}");
        }
        let whole = exponent as usize + 1;
        if digits.len() > whole {
            return format!("{}.{}", &digits[..whole], &digits[whole..]);
        }
        let zeros = "0".repeat(whole - digits.len());
        format!("{digits}{zeros}{}", self.end())
    }

    fn scientific(&self, digits: &str, exponent: i32) -> String {
        // The default is the style of ADAMS/View: an exponent with its sign and at least two digits.
        let (letter, plus, width) = self.exponent.as_ref().map_or(('E', true, 2), |style| {
            (style.letter, style.plus, style.width)
        });
        let (first, rest) = digits.split_at(1);
        let mantissa = if rest.is_empty() {
            format!("{first}{}", self.end())
        } else {
            format!("{first}.{rest}")
        };
        let sign = match (exponent < 0, plus) {
            (true, _) => "-",
            (false, true) => "+",
            (false, false) => "",
        };
        format!("{mantissa}{letter}{sign}{:0width$}", exponent.abs())
    }
}

/// Splits a number such as `1.25e-7` into its digits, without the point and without final zeros, and the power of ten of its first digit.
fn decimal(scientific: &str) -> (String, i32) {
    let (mantissa, exponent) = scientific
        .split_once('e')
        .expect("the e format writes an exponent");
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let digits = match digits.trim_end_matches('0') {
        "" => "0",
        digits => digits,
    };
    (
        digits.to_string(),
        exponent
            .parse()
            .expect("the e format writes a whole exponent"),
    )
}

/// Returns the shortest text of digits, in degrees, that reads back as this value in radians.
///
/// Returns `None` if no such text exists: neighbouring doubles in degrees may be up to two doubles apart in radians.
fn degree_digits(radians: f64) -> Option<(String, i32)> {
    let reads_back = |text: &str| {
        parse_number(format!("{text}D").as_bytes()).is_some_and(|(value, _)| value == radians)
    };
    let degrees = radians.to_degrees();
    for places in 0..17 {
        let text = format!("{degrees:.places$e}");
        if reads_back(&text) {
            return Some(decimal(&text));
        }
    }
    [degrees.next_up(), degrees.next_down()]
        .iter()
        .map(|near| format!("{near:e}"))
        .find(|text| reads_back(text))
        .map(|text| decimal(&text))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_new_number_looks_like_the_old_one() {
        for (value, old, new) in [
            (2000.0, "1500", "2000"),
            (0.25, "1500", "0.25"),
            (2000.0, "1500.0", "2000.0"),
            (2000.0, "1.", "2000."),
            (0.25, ".5", ".25"),
            (-3.0, "+1.5", "-3.0"),
            (3.5, "+1.5", "+3.5"),
            (2e5, "1.0E+05", "2.0E+05"),
            (2.07e5, "1.0E+005", "207000.0"),
            (2e9, "1.0E+005", "2.0E+009"),
            (1e-7, "1e-5", "1e-07"),
            (2e-7, "100", "2E-07"),
            (0.0, "1.0E+05", "0.0"),
            (30f64.to_radians(), "45D", "30D"),
            (-94.5f64.to_radians(), "1.0D", "-94.5D"),
            (1e5, "0.5", "100000.0"),
        ] {
            let spelled = spell_like(value, old.as_bytes());
            if old == "1e-5" {
                // The old exponent has one digit, so the new exponent has one as well.
                assert_eq!(spelled, "1e-7");
            } else {
                assert_eq!(spelled, new, "{value} like {old}");
            }
        }
    }

    proptest! {
        #[test]
        fn any_double_reads_back(value in proptest::num::f64::NORMAL | proptest::num::f64::ZERO,
                                 old in "[+-]?(0|[1-9][0-9]{0,3})(\\.[0-9]{0,3})?([Ee][+-]?[0-9]{1,3})?") {
            let text = spell_like(value, old.as_bytes());
            let digits = text.trim_start_matches('+');
            prop_assert_eq!(parse_number(digits.as_bytes()), Some((value, false)));
        }

        #[test]
        fn any_angle_reads_back(value in -10.0f64..10.0) {
            let text = spell_like(value, b"1.5D");
            let (read, _) = parse_number(text.as_bytes()).unwrap();
            prop_assert_eq!(read, value, "{}", text);
        }

        #[test]
        fn an_angle_of_a_few_digits_keeps_its_degrees(hundredths in -36_000i32..36_000) {
            let typed = format!("{}D", f64::from(hundredths) / 100.0);
            let (value, _) = parse_number(typed.as_bytes()).unwrap();
            prop_assert_eq!(spell_like(value, b"45D"), typed);
        }
    }
}
