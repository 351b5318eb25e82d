//! Formatting of numbers and headings for the older text files, in the columns of their FORTRAN formats.

use admire_syntax::units::{Unit, Units};

/// Formats a number as FORTRAN `1PEw.d`: right-justified, with one digit before the point and an exponent of at least two digits.
pub(super) fn exponential(value: f64, width: usize, decimals: usize) -> String {
    let value = if value == 0.0 { 0.0 } else { value };
    let text = format!("{value:.decimals$e}");
    let spelled = match text.split_once('e') {
        Some((mantissa, exponent)) => {
            let (sign, digits) = match exponent.strip_prefix('-') {
                Some(digits) => ('-', digits),
                None => ('+', exponent),
            };
            format!("{mantissa}E{sign}{digits:0>2}")
        }
        // Infinity and NaN have no exponent.
        None => text,
    };
    format!("{spelled:>width$}")
}

/// Formats up to six values as one line of a request or graphics file, in the FORTRAN format `1X,6E13.5`.
///
/// A negative number with a three-digit exponent fills its field completely. A blank is then inserted before the number, to separate it
/// from the preceding one.
pub(super) fn line_of(values: &[f64]) -> String {
    let mut line = String::from(" ");
    for &value in values {
        let field = exponential(value, 13, 5);
        if !field.starts_with(' ') {
            line.push(' ');
        }
        line.push_str(&field);
    }
    line.push('\n');
    line
}

/// Returns the 12-letter code of the units, such as `MMKGS_N_RACA`: two letters each for length, mass, time, force, angle and coordinates.
///
/// The letters for mm, metre, inch, kg, pound, second, newton and pound-force come from real files. The letters for other units are formed
/// in the same way.
pub(super) fn unit_code(units: &Units) -> String {
    let force = match units.force.keyword {
        "POUND_FORCE" => "PF".to_string(),
        "KILOGRAM_FORCE" => "KF".to_string(),
        "OUNCE_FORCE" => "OF".to_string(),
        "KPOUND_FORCE" => "KP".to_string(),
        "KNEWTON" => "KN".to_string(),
        _ => one_letter(units.force),
    };
    let mass = match units.mass.keyword {
        "KILOGRAM" => "KG".to_string(),
        "POUND_MASS" => "LB".to_string(),
        "SLUG" => "SL".to_string(),
        _ => one_letter(units.mass),
    };
    let length = match units.length.keyword {
        "MILLIMETER" => "MM".to_string(),
        "CENTIMETER" => "CM".to_string(),
        "KILOMETER" => "KM".to_string(),
        "INCH" => "IN".to_string(),
        "FOOT" => "FT".to_string(),
        "MILE" => "MI".to_string(),
        _ => one_letter(units.length),
    };
    let time = match units.time.keyword {
        "MILLISECOND" => "MS".to_string(),
        _ => one_letter(units.time),
    };
    format!("{length}{mass}{time}{force}RACA")
}

fn one_letter(unit: Unit) -> String {
    format!("{}_", &unit.keyword[..1])
}

/// Formats a title as a FORTRAN A80 field: it is cut or padded to 80 characters, and control characters become blanks.
pub(super) fn title_line(title: &str) -> String {
    let title: String = title
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(80)
        .collect();
    format!("{title:<80}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_have_the_columns_of_real_files() {
        assert_eq!(exponential(-1.22465e-16, 13, 5), " -1.22465E-16");
        assert_eq!(exponential(-0.0, 13, 5), "  0.00000E+00");
        assert_eq!(exponential(1.0 / 0.0254, 21, 15), "3.937007874015748E+01");
        assert_eq!(exponential(1e-300, 13, 5), " 1.00000E-300");
        assert_eq!(line_of(&[0.01]), "   1.00000E-02\n");
        assert_eq!(unit_code(&Units::default()), "MMKGS_N_RACA");
    }
}
