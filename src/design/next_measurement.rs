//! Choice of the load case in which two rival explanations of the readings predict the most different readings.

use std::collections::BTreeMap;

use super::candidate::{ProposedMeasurements, in_the_file};
use super::information::Information;
use super::prospect::MeasurementPredictor;
use super::rivals::discrimination_chi_square;
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

/// Returns the load case within the range applied that best distinguishes a finding from its rival. If either of them is a fault of a single
/// case, the proposal is to repeat that case.
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
            });
        }
    }
    let candidates = ProposedMeasurements::loads(programme, &[1.0]);
    let mine = MeasurementPredictor::new(subject, best, &candidates)?;
    let theirs = MeasurementPredictor::new(subject, other, &candidates)?;
    let information = Information::of(best);
    let apart = |at: usize| {
        let (mine, theirs) = (mine.readings(at)?, theirs.readings(at)?);
        discrimination_chi_square(&information, &mine, &theirs)
    };
    let each = (0..candidates.list.len()).filter_map(|at| Some((apart(at)?, at)));
    // The first of several equally good candidates is chosen.
    let (separated, at) = each.reduce(|best, next| if next.0 > best.0 { next } else { best })?;
    let why = if separated > SEPARATION_CHI_SQUARE {
        format!("separates {finding} from {rival} by a chi-square of about {separated:.1}")
    } else {
        format!(
            "separates {finding} from {rival} best of all loads in the range applied, but by a chi-square of {separated:.1} \
             only: marks on both sides of {} would tell",
            rival.address
        )
    };
    Some(NextMeasurement {
        case: case_of(&candidates.list[at].sequence()[0]),
        why,
    })
}
