//! Laws outside of the catalogue that do what a finding does: rubber that flows from case to case passes for friction, play for rubber
//! that stiffens. They get no name of their own, but a name that they deserve as well is not to be trusted.

use super::cause::Cause;
use super::diagnosis::{Finding, Unexplained};
use super::effort::Effort;
use super::extended::Fitted;
use super::hypothesis::{Column, Hypothesis, Number, Unknown};
use super::screening::{penalty, promises};
use super::selection::{RIVAL, Selected, without};
use super::subject::{Data, Subject};
use super::survey::Survey;
use crate::mechanics::Vec6;
use crate::syntax::Address;

/// Rubber may well flow by these parts of its deflection in a case,
const RATES: [f64; 3] = [0.03, 0.1, 0.3];
/// and play take these parts of a deflection's range.
const PLAYS: [f64; 3] = [0.1, 0.3, 0.6];
/// The laws are drawn with the bushing's own stiffness, so that the data have to find them about once.
const WHOLE: std::ops::Range<f64> = 0.4..2.5;

/// Adds to what remains unexplained each finding of a bushing's law that such a law would explain as well.
pub fn doubted(
    subject: &Subject<'_>,
    selected: &Selected,
    (findings, order): (&[Finding], &[usize]),
    unexplained: &mut Unexplained,
) {
    for (finding, &at) in findings.iter().zip(order) {
        if finding.minor {
            continue;
        }
        let Some(base) = without(subject, &selected.fitted, at, Data::All, Effort::FULL) else {
            continue;
        };
        let rows: f64 = selected.fitted.weights.iter().sum();
        let hypothesis = &selected.fitted.chosen[at];
        let numbers = hypothesis.numbers.len() as f64;
        // Laws of one place are compared.
        let own = finding.evidence.value - penalty(numbers, rows, 1);
        let best = mimics(subject, &base, hypothesis)
            .into_iter()
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((what, _)) = best.filter(|(_, net)| *net > own - RIVAL) {
            unexplained.structured = true;
            unexplained.places.push(format!(
                "{}, where {what} follows the readings as well as {}",
                finding.address, finding.cause
            ));
        }
    }
}

/// Other laws at the place of a hypothesis that is not in the fit, with what each promises to gain less its penalty.
fn mimics(
    subject: &Subject<'_>,
    base: &Fitted,
    hypothesis: &Hypothesis,
) -> Vec<(&'static str, f64)> {
    if !matches!(
        hypothesis.cause,
        Cause::DryFriction | Cause::ProgressiveStiffness
    ) {
        return Vec::new();
    }
    let survey = Survey::new(subject, base);
    let Some((bushing, axis)) = component(&survey, &hypothesis.address) else {
        return Vec::new();
    };
    let u: Vec<f64> = survey
        .bushing_deflections(bushing)
        .iter()
        .map(|u| u[axis])
        .collect();
    let k = survey.stiffnesses(bushing)[axis];
    let law = &survey.model.bushings[bushing];
    let far = u.iter().fold(0.0_f64, |far, u| far.max(u.abs()));
    let of = |offsets: Vec<f64>| {
        let wrench = |c: f64| {
            let mut w = Vec6::zeros();
            w[axis] = k * c;
            w
        };
        let column = Column::Wrench((law.i, law.j), offsets.into_iter().map(wrench).collect());
        Hypothesis::of_numbers(vec![Number {
            name: String::new(),
            mean: 0.0,
            sd: 1.0,
            column,
            unknown: Unknown::Linear,
        }])
    };
    // The deflection at rest goes a part of the way to the deflection in every case.
    let flown = RATES.map(|rate| {
        let mut rest = 0.0;
        let follow = |u: &f64| {
            let before = rest;
            rest += rate * (u - rest);
            before
        };
        (
            "rubber that flows from case to case",
            of(u.iter().map(follow).collect()),
        )
    });
    let played = PLAYS.map(|part| {
        let half = part * far;
        let idle = u.iter().map(|u| u.clamp(-half, half)).collect();
        ("play", of(idle))
    });
    let (names, laws): (Vec<_>, Vec<_>) = flown.into_iter().chain(played).unzip();
    let scores = promises(base, &survey, &laws);
    names
        .into_iter()
        .zip(scores)
        .filter_map(|(name, score)| Some((name, score?)))
        .filter(|(_, score)| WHOLE.contains(&score.estimate[0]))
        .map(|(name, score)| (name, score.net))
        .collect()
}

/// `BUSHING/2.K.1`: which bushing, and which of its six components.
fn component(survey: &Survey<'_>, address: &str) -> Option<(usize, usize)> {
    let address = Address::parse(address, survey.subject.problem.dataset).ok()?;
    let first = match address.argument.as_deref()? {
        "K" => 0,
        "KT" => 3,
        _ => return None,
    };
    let bushings = &survey.model.bushings;
    let bushing = bushings
        .iter()
        .position(|b| Some(b.header.id) == address.id)?;
    Some((bushing, first + address.index?.checked_sub(1)?))
}
