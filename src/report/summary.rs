//! Short summary of a result for a terminal.

/// Summary of a result: verdict, findings, gain and next step, as sentences without line breaks.
#[derive(Clone, PartialEq, Debug)]
pub struct Summary {
    /// Overall result.
    pub verdict: String,
    /// Findings or identified values, one text each, the most important first.
    pub items: Vec<String>,
    /// Errors of prediction in the readings that no fit used, before and after, with units and in standard deviations of the noise.
    pub held_out: String,
    /// Recommended next step.
    pub next: String,
}

/// Describes the change of an rms error: `marks from 0.270 to 0.0520 mm (5.40 to 1.04 sigmas)`. `sigma` is the standard deviation of the
/// noise of one reading, in the same unit.
pub(super) fn fall(what: &str, rms: [f64; 2], unit: &str, sigma: f64) -> String {
    let three = |value: f64| super::number(value, Some(0.1 * value.abs()));
    let [before, after] = rms.map(three);
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    let [from, to] = rms.map(|value| three(value / sigma));
    format!("{what} from {before} to {after}{unit} ({from} to {to} sigmas)")
}

#[cfg(test)]
mod tests {
    use super::fall;

    #[test]
    fn an_error_is_stated_in_its_unit_and_in_sigmas() {
        let text = fall("marks", [0.2701, 0.0518], "mm", 0.05);
        assert_eq!(text, "marks from 0.27 to 0.0518 mm (5.4 to 1.04 sigmas)");
    }
}
