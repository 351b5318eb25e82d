//! The search for the one change that mends a study.

use super::bench::{Bench, Trial};
use super::candidate::{Candidate, Family, families};
use super::thinned::thinned;
use crate::identify::LoadedStudy;

/// A slip that explains what no value of the unknowns and no tolerance can.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Slip {
    /// What mends it; several where the readings do not tell them apart.
    pub remedies: Vec<String>,
    /// Root mean square of the residuals beyond tolerances in units of their noise: as the study stands, where it has equilibria at all,
    /// and mended.
    pub left: (Option<f64>, f64),
    /// True where nothing but this slip can be meant; else it only explains more.
    pub is_sure: bool,
}

/// Steps of the fit of the study as it stands.
const STEPS: usize = 40;
/// Steps of the first fit of each candidate, and of those that go on.
const FIRST: usize = 3;
const FURTHER: usize = 20;
/// Where a fit follows the readings, only slips are tried that could explain this part of what is left, near a factor of one.
const LEAST_GAIN: f64 = 0.1;
/// Where it does not, that tells little; of bushings so many are tried.
const BUSHINGS: usize = 8;
/// So many candidates go on.
const GO_ON: usize = 5;
/// Residuals beyond tolerances up to this times their noise, rms, are explained: no slip is looked for.
const EXPLAINED: f64 = 1.1;
/// Up to this, a wrong statement of the noise explains them.
const NOISE: f64 = 2.0;
/// A slip is sure where mending it leaves half of the squares; worth a look where it leaves less than the second part, rms. Causes that a model
/// lacks move with no factor of units: they leave all.
const MENDED: f64 = 0.7;
const BETTER: f64 = 0.9;
/// A fit follows the movement of the readings to this part of it, rms.
const FOLLOWS: f64 = 0.1;
/// Changes that leave less than this times the best one, rms, are not told apart from it.
const ALIKE: f64 = 1.1;

/// The slip of a study, if one explains it.
pub(crate) fn slip(loaded: &LoadedStudy) -> Option<Slip> {
    let bench = Bench::new(thinned(loaded))?;
    let now = bench.fit(None, None, STEPS);
    let before = now
        .as_ref()
        .and_then(|now| bench.beyond_tolerances(None, &now.x));
    if before.is_some_and(|before| before < EXPLAINED) {
        return None;
    }
    let first = promising(&bench, now.as_ref(), before).into_iter();
    let first = first.filter_map(|candidate| {
        let trial = bench.fit(Some(&candidate.change), None, FIRST)?;
        Some((trial, candidate))
    });
    let mut first: Vec<(Trial, Candidate)> = first.collect();
    first.sort_by(|a, b| a.0.objective.total_cmp(&b.0.objective));
    first.truncate(GO_ON);
    let go_on = |(first, candidate): (Trial, Candidate)| {
        let further = bench.fit(Some(&candidate.change), Some(&first.x), FURTHER);
        let x = further.unwrap_or(first).x;
        let left = bench.beyond_tolerances(Some(&candidate.change), &x)?;
        Some((left, candidate.remedy))
    };
    let mut left: Vec<(f64, String)> = first.into_iter().filter_map(go_on).collect();
    left.sort_by(|a, b| a.0.total_cmp(&b.0));
    let after = left.first()?.0;
    // What ended before its minimum may end elsewhere by any change.
    let is_minimum = now.is_some_and(|now| now.is_minimum);
    let fits = is_minimum || after < FOLLOWS * bench.movement();
    let is_sure = fits && before.is_none_or(|before| before > NOISE && after < MENDED * before);
    let is_better = before.is_some_and(|before| after < BETTER * before);
    let alike = left
        .into_iter()
        .take_while(|(other, _)| *other <= ALIKE * after);
    (is_sure || is_better).then(|| Slip {
        remedies: alike.map(|(_, remedy)| remedy).collect(),
        left: (before, after),
        is_sure,
    })
}

/// Candidates that may explain what a fit left, `before` beyond tolerances.
fn promising(bench: &Bench, now: Option<&Trial>, before: Option<f64>) -> Vec<Candidate> {
    let families = families(bench.study());
    let gains = now.and_then(|now| bench.gains(&families, &now.x));
    let gains = gains.unwrap_or_else(|| vec![f64::INFINITY; families.len()]);
    let follows = before.is_some_and(|before| before < FOLLOWS * bench.movement());
    let mut all: Vec<(f64, Family)> = gains.into_iter().zip(families).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut bushings = 0;
    all.retain(|(gain, family)| {
        bushings += usize::from(family.is_of_a_bushing);
        if follows {
            *gain > LEAST_GAIN
        } else {
            !family.is_of_a_bushing || bushings <= BUSHINGS
        }
    });
    let families = all.into_iter();
    families.flat_map(|(_, family)| family.candidates).collect()
}
