/// Parses a tolerance: a finite number, zero or larger. NaN and infinity are refused, because they would accept any difference.
pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("a tolerance is a number, zero or larger".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_let_everything_pass_is_no_tolerance() {
        assert_eq!(tolerance("1e-6"), Ok(1e-6));
        assert_eq!(tolerance(" 0 "), Ok(0.0));
        for text in ["nan", "inf", "-1", "1e999", "", "1mm"] {
            assert!(tolerance(text).is_err(), "{text}");
        }
    }
}
