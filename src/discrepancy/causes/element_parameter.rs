//! `element-parameter`: a number of the deck taken as known is wrong.

use super::super::cause::Cause;
use super::super::hypothesis::Hypothesis;
use super::super::survey::Survey;
use crate::tolerance::Group;

/// Parts of themselves by which numbers may well be wrong: rates of springs, their preloads, and rubber, of which data sheets often
/// give the dynamic stiffness, which is half as large again.
const SD: (f64, f64, f64) = (0.1, 0.05, 0.4);

/// Rates and preloads of springs, and stiffnesses of bushings that are not identified.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (member, address, group, unit) in survey.numbers_of_the_deck() {
        let sd = match group {
            Group::Preloads => SD.1,
            _ if address.starts_with("SPRINGDAMPER") => SD.0,
            _ => SD.2,
        };
        let mut hypothesis = Hypothesis::outstanding(
            Cause::ElementParameter,
            address,
            "",
            [(member, "change".to_string())],
            sd,
        );
        hypothesis.numbers[0].unit = unit;
        out.push(hypothesis);
    }
}
