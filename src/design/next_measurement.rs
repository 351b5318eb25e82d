//! Choice of the load case for which two rival explanations predict the most different readings.

use std::collections::BTreeMap;

use super::candidate::ProposedMeasurements;
use super::load_values::in_the_file;
use super::rivals::discriminations;
use super::separator::separators;
use crate::settings::SEPARATION_CHI_SQUARE;
use admire_diagnosis::{CandidateEffect, DiagnosisProblem, FittedModel, NextMeasurement, Outcome};

/// Proposes a measurement that distinguishes a finding of the diagnosis from its rival. Proposes none if no finding has a rival.
pub fn propose(outcome: &mut Outcome<'_>) {
    let best = &*outcome.extended;
    let mut proposed = outcome.rivals.iter().filter_map(|rival| {
        let own = (best, &rival.finding);
        next_measurement(&outcome.subject, own, (&rival.fitted, &rival.instead))
    });
    outcome.diagnosis.next_measurement = proposed.next();
}

/// Returns the available load case that best distinguishes a finding from its rival. If either of them is a fault of a single case, the
/// proposal is to repeat that case. If no load distinguishes them, the proposal names an instrument that does.
fn next_measurement(
    subject: &DiagnosisProblem<'_>,
    (best, finding): (&FittedModel, &CandidateEffect),
    (other, rival): (&FittedModel, &CandidateEffect),
) -> Option<NextMeasurement> {
    let programme = subject.problem.programme;
    let case_of = |values: &[f64]| -> BTreeMap<String, f64> {
        let columns = programme.loads.iter().zip(values).enumerate();
        columns
            .map(|(k, (load, value))| (load.name.clone(), in_the_file(programme, k, *value)))
            .collect()
    };
    for hypothesis in [finding, rival] {
        if let Some(case) = hypothesis.only_case(&subject.rows) {
            return Some(NextMeasurement {
                case: case_of(&programme.cases[case].values),
                why: format!(
                    "separates {finding} from {rival}, as it repeats case {}",
                    programme.cases[case].label
                ),
                instead: None,
            });
        }
    }
    let available = &subject.problem.measurement.available;
    let candidates = ProposedMeasurements::loads(programme, available, &[1.0]);
    let fits = [best, other];
    let found = discriminations(subject, fits, &candidates)?;
    let each = found.into_iter().enumerate();
    let each = each.filter_map(|(at, found)| Some((found?, at)));
    // The first of several equally good candidates is chosen.
    let best = each.reduce(|best, next| {
        if next.0.chi_square > best.0.chi_square {
            next
        } else {
            best
        }
    });
    let case = best.map_or_else(BTreeMap::new, |(_, at)| {
        case_of(&candidates.list[at].sequence()[0])
    });
    let separates = best.filter(|(found, _)| found.chi_square > SEPARATION_CHI_SQUARE);
    if let Some((found, _)) = separates {
        return Some(NextMeasurement {
            case,
            why: format!("separates {finding} from {rival} by {found}"),
            instead: None,
        });
    }
    let most = best.map_or(0.0, |(found, _)| found.chi_square);
    let named = separators(subject, fits).into_iter().next();
    let instead = named.map_or_else(
        || format!("marks on both sides of {}", rival.address),
        |separator| separator.to_string(),
    );
    Some(NextMeasurement {
        case,
        why: format!(
            "no load in the range separates {finding} from {rival}: the chi-square is {most:.1} at most"
        ),
        instead: Some(instead),
    })
}
