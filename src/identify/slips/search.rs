//! The search for the one change that mends a study.

use super::bench::{Bench, Trial};
use super::candidate::{Candidate, Family, acting, families};
use super::thinned::thinned;
use crate::LoadedStudy;

/// A slip that explains what no value of the unknowns and no tolerance can.
#[derive(Clone, PartialEq, Debug)]
pub struct Slip {
    /// What mends it; several where the readings do not tell them apart.
    pub remedies: Vec<String>,
    /// Root mean square of the residuals beyond tolerances in units of their noise: as the study stands, where it has equilibria at all,
    /// and mended.
    pub left: (Option<f64>, f64),
    /// True where nothing but this slip can be meant; else it only explains more.
    pub is_sure: bool,
}

/// So many more cases than a line through the loads has numbers tell a slip.
const SPARE: usize = 4;
/// What the search found.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Search {
    /// The slip, if one explains the readings.
    pub slip: Option<Slip>,
    /// True where the study as it stands explains them: nothing odd at its start values says anything.
    pub is_explained: bool,
}

/// Steps of the fit of the study as it stands.
const STEPS: usize = 40;
/// Steps of the fits of candidates, round after round, and how many of them go on into each.
const ROUNDS: [(usize, usize); 3] = [(usize::MAX, 3), (12, 4), (4, 20)];
/// Where a fit follows the readings, only slips are tried that could explain this part of what is left, near a factor of one.
const LEAST_GAIN: f64 = 0.1;
/// Where it does not, that tells little; of bushings so many are tried.
const BUSHINGS: usize = 8;
/// Effort limit of the search: equilibria solved after the fit of the study itself. Beyond it no further candidate is fitted.
const MAX_EQUILIBRIA: usize = 6_000;
/// Residuals beyond tolerances up to this times their noise, rms, are explained: no slip is looked for.
const EXPLAINED: f64 = 1.1;
/// Up to this, a wrong statement of the noise explains them.
const NOISE: f64 = 2.0;
/// A slip is sure where mending it leaves half of the squares; worth a look where it leaves less than the second part, rms. Causes that a model
/// lacks move with no factor of units: they leave all.
const MENDED: f64 = 0.7;
const BETTER: f64 = 0.9;
/// A fit that leaves less than this part of the movement of the readings, rms, follows them, and so does one that leaves less than so many times
/// their noise.
const FOLLOWS: f64 = 0.05;
const NEARLY: f64 = 10.0;
/// A mended study fits if it leaves less than this part of the movement.
const FITS: f64 = 0.25;
/// Changes that leave less than this times the best one, rms, are not told apart from it.
const ALIKE: f64 = 1.1;

/// Looks for the slip of a study.
pub fn search(loaded: &LoadedStudy) -> Search {
    let cases = loaded.measurement.fitted_cases().count();
    if cases < acting(&loaded.programme).len() + 1 + SPARE {
        return Search::default();
    }
    let Some(bench) = Bench::new(thinned(loaded)) else {
        return Search::default();
    };
    let now = bench.fit(None, None, STEPS);
    let before = now
        .as_ref()
        .and_then(|now| bench.beyond_tolerances(None, &now.x));
    let is_below = |most: f64| before.is_some_and(|before| before < most);
    Search {
        slip: if is_below(EXPLAINED) {
            None
        } else {
            slip(&bench, now.as_ref(), before)
        },
        is_explained: is_below(NOISE),
    }
}

/// The change that explains what the fit of the study as it stands left, `before` beyond tolerances.
fn slip(bench: &Bench, now: Option<&Trial>, before: Option<f64>) -> Option<Slip> {
    let candidates = promising(bench, now, before).into_iter();
    let mut tried: Vec<(Option<Trial>, Candidate)> = candidates.map(|c| (None, c)).collect();
    let most_solved = bench.solved() + MAX_EQUILIBRIA;
    for (most, steps) in ROUNDS {
        tried.truncate(most);
        let go_on = |(known, candidate): (Option<Trial>, Candidate)| {
            if bench.solved() > most_solved {
                return Some((Some(known?), candidate));
            }
            let start = known.as_ref().map(|known| known.x.as_slice());
            let further = bench.fit(Some(&candidate.change), start, steps);
            Some((Some(further.or(known)?), candidate))
        };
        tried = tried.into_iter().filter_map(go_on).collect();
        let objective = |trial: &Option<Trial>| {
            let of = |trial: &Trial| trial.objective;
            trial.as_ref().map_or(f64::INFINITY, of)
        };
        tried.sort_by(|a, b| objective(&a.0).total_cmp(&objective(&b.0)));
    }
    let left = |(trial, candidate): (Option<Trial>, Candidate)| {
        let left = bench.beyond_tolerances(Some(&candidate.change), &trial?.x)?;
        Some((left, candidate.remedy))
    };
    let mut left: Vec<(f64, String)> = tried.into_iter().filter_map(left).collect();
    left.sort_by(|a, b| a.0.total_cmp(&b.0));
    let after = left.first()?.0;
    // What ended before its minimum may end elsewhere by any change.
    let is_minimum = now.is_some_and(|now| now.is_minimum);
    let fits = is_minimum || after < FITS * bench.movement();
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
    let follows = before.is_some_and(|before| before < NEARLY.max(FOLLOWS * bench.movement()));
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
