use std::io::Write;

/// Format of the numbers in an XRF file.
#[derive(Clone, Copy, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub enum NumberStyle {
    /// Format of ADAMS since 2017, with the given number of decimals (RESULTS/DECIMALPLACES, default 17).
    ///
    /// Numbers with a magnitude from 1e-3 to below 1e5 are written in fixed point, others with an exponent of two digits. Trailing zeros
    /// are trimmed.
    Decimals(u8),
    /// Format of ADAMS before 2017: 17 significant digits. An exponent of three digits is used below 1e-4 and from 1e17 on.
    SeventeenDigits,
}

impl Default for NumberStyle {
    fn default() -> Self {
        Self::Decimals(17)
    }
}

/// Appends a finite number to `out`. Positive and negative zero are both written as `0`.
///
/// The exact decimal value of the double is rounded half to even, as C's printf does (guide/formats.md 12: verified on 154,582 real
/// values).
pub(crate) fn write_number(out: &mut Vec<u8>, value: f64, style: NumberStyle) {
    if value == 0.0 {
        out.push(b'0');
        return;
    }
    let magnitude = value.abs();
    match style {
        NumberStyle::Decimals(decimals) => {
            if (1e-3..1e5).contains(&magnitude) {
                if decimals == 17 {
                    fixed_seventeen(out, value);
                } else {
                    fixed(out, value, usize::from(decimals));
                }
            } else {
                exponential(out, value, usize::from(decimals));
            }
        }
        NumberStyle::SeventeenDigits => seventeen_digits(out, value),
    }
}

/// Prints a number with 1e-3 <= |value| < 1e5 as `%.17f` and trims trailing zeros, in integer arithmetic.
///
/// The value is m 2^-s with m < 2^53 and 36 <= s <= 62. Its fraction times 10^17 therefore fits into 128 bits, and the rounding is exact.
fn fixed_seventeen(out: &mut Vec<u8>, value: f64) {
    const TEN_17: u64 = 100_000_000_000_000_000;
    let bits = value.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let mantissa = (bits & ((1 << 52) - 1)) | (1 << 52);
    let shift = (1075 - exponent) as u32;
    let mut whole = mantissa >> shift;
    let rest = mantissa & ((1 << shift) - 1);
    let scaled = u128::from(rest) * u128::from(TEN_17);
    let mut fraction = (scaled >> shift) as u64;
    let lost = (scaled & ((1 << shift) - 1)) as u64;
    let half = 1_u64 << (shift - 1);
    if lost > half || (lost == half && fraction % 2 == 1) {
        fraction += 1;
        if fraction == TEN_17 {
            fraction = 0;
            whole += 1;
        }
    }
    if value < 0.0 {
        out.push(b'-');
    }
    let mut digits = [b'0'; 24];
    let mut at = 6;
    loop {
        at -= 1;
        digits[at] = b'0' + (whole % 10) as u8;
        whole /= 10;
        if whole == 0 {
            break;
        }
    }
    digits[6] = b'.';
    for place in (7..24).rev() {
        digits[place] = b'0' + (fraction % 10) as u8;
        fraction /= 10;
    }
    let mut end = digits.len();
    while digits[end - 1] == b'0' {
        end -= 1;
    }
    if end == 7 {
        end = 6;
    }
    out.extend_from_slice(&digits[at..end]);
}

fn fixed(out: &mut Vec<u8>, value: f64, decimals: usize) {
    let start = out.len();
    write!(out, "{value:.decimals$}").expect("writing to memory does not fail");
    trim_fraction(out, start);
    if matches!(&out[start..], b"-0") {
        out.truncate(start);
        out.push(b'0');
    }
}

/// Trims trailing zeros after the decimal point, and also the point if no digit follows it.
fn trim_fraction(out: &mut Vec<u8>, start: usize) {
    if !out[start..].contains(&b'.') {
        return;
    }
    while out.last() == Some(&b'0') {
        out.pop();
    }
    if out.last() == Some(&b'.') {
        out.pop();
    }
}

/// Prints a number as `%.{decimals}E` and trims trailing zeros; the decimal point stays (`1.E+05`).
fn exponential(out: &mut Vec<u8>, value: f64, decimals: usize) {
    let text = format!("{value:.decimals$e}");
    let (mantissa, exponent) = text.split_once('e').expect("`e` format has an exponent");
    if mantissa.contains('.') {
        out.extend_from_slice(mantissa.trim_end_matches('0').as_bytes());
    } else {
        out.extend_from_slice(mantissa.as_bytes());
        out.push(b'.');
    }
    let exponent: i32 = exponent.parse().expect("`e` format has a whole exponent");
    let sign = if exponent < 0 { '-' } else { '+' };
    write!(out, "E{sign}{:02}", exponent.abs()).expect("writing to memory does not fail");
}

/// Prints a number as `%.17G` and trims trailing zeros. As in the C libraries of Windows before 2015, an exponent has at least three
/// digits.
fn seventeen_digits(out: &mut Vec<u8>, value: f64) {
    let text = format!("{value:.16e}");
    let (mantissa, exponent) = text.split_once('e').expect("`e` format has an exponent");
    let exponent: i32 = exponent.parse().expect("`e` format has a whole exponent");
    let start = out.len();
    if (-4..17).contains(&exponent) {
        let decimals = (16 - exponent) as usize;
        write!(out, "{value:.decimals$}").expect("writing to memory does not fail");
        trim_fraction(out, start);
    } else {
        out.extend_from_slice(mantissa.as_bytes());
        trim_fraction(out, start);
        let sign = if exponent < 0 { '-' } else { '+' };
        write!(out, "E{sign}{:03}", exponent.abs()).expect("writing to memory does not fail");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn print(value: f64, style: NumberStyle) -> String {
        let mut out = Vec::new();
        write_number(&mut out, value, style);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers_are_spelled_as_in_real_files() {
        // The expected spellings are from guide/formats.md 6.1 and 12.
        let since_2017 = |value| print(value, NumberStyle::default());
        assert_eq!(since_2017(0.0), "0");
        assert_eq!(since_2017(-0.0), "0");
        assert_eq!(since_2017(-90.0), "-90");
        assert_eq!(since_2017(0.07), "0.07000000000000001");
        assert_eq!(since_2017(386.0885827), "386.08858270000001767");
        assert_eq!(since_2017(1e5), "1.E+05");
        assert_eq!(since_2017(1e-3), "0.001");
        assert_eq!(since_2017(9.9993e-4), "9.99930000000000003E-04");
        assert_eq!(since_2017(99999.99999999999), "99999.99999999998544808");
        let before_2017 = |value| print(value, NumberStyle::SeventeenDigits);
        assert_eq!(before_2017(-0.1), "-0.10000000000000001");
        assert_eq!(before_2017(9.80665), "9.8066499999999994");
        assert_eq!(before_2017(-2.189_047_554E-14), "-2.1890475540000001E-014");
        assert_eq!(print(1.0 / 3.0, NumberStyle::Decimals(5)), "0.33333");
        assert_eq!(print(-1.0e-5, NumberStyle::Decimals(0)), "-1.E-05");
        assert_eq!(print(-0.4, NumberStyle::Decimals(0)), "0");
    }

    #[test]
    fn integer_arithmetic_prints_what_exact_formatting_prints() {
        // The reference is the exact decimal expansion that Rust's standard library prints.
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for _ in 0..200_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let exponent = 1023 - 10 + (state >> 58) % 27;
            let value = f64::from_bits((exponent << 52) | (state >> 6 & ((1 << 52) - 1)));
            if !(1e-3..1e5).contains(&value) {
                continue;
            }
            let mut exact = format!("{:.17}", -value).into_bytes();
            trim_fraction(&mut exact, 0);
            assert_eq!(
                print(-value, NumberStyle::default()).as_bytes(),
                exact.as_slice()
            );
        }
    }
}
