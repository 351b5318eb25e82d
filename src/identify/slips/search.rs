//! Search for the single change that corrects a study.

use super::bench::{Bench, Trial};
use super::candidate::{Candidate, Family, acting, families};
use super::thinned::thinned;
use crate::LoadedStudy;

/// An input slip that explains readings which neither the unknowns nor tolerances can explain.
#[derive(Clone, PartialEq, Debug)]
pub struct Slip {
    /// Descriptions of the correction; several if the readings do not distinguish them.
    pub remedies: Vec<String>,
    /// Rms of the residuals beyond tolerances, over their noise: for the unchanged study (`None` without equilibria), and for the corrected
    /// one.
    pub left: (Option<f64>, f64),
    /// True if the slip is certain; otherwise it only improves the fit.
    pub is_sure: bool,
}

/// Minimum surplus of cases over the coefficients of a linear function of the loads.
const SPARE: usize = 4;
/// Result of the search.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Search {
    /// Slip that explains the readings, if there is one.
    pub slip: Option<Slip>,
    /// True if the unchanged study explains its readings; anomalies at its starting values are then irrelevant.
    pub is_explained: bool,
}

/// Maximum number of steps in the fit of the unchanged study.
const STEPS: usize = 40;
/// Rounds of candidate fits: maximum number of candidates and of steps in each round.
const ROUNDS: [(usize, usize); 3] = [(usize::MAX, 3), (12, 4), (4, 20)];
/// Minimum fraction of the residual squares that a factor near one must explain for a slip to be tried; used if the fit follows the
/// readings.
const LEAST_GAIN: f64 = 0.1;
/// Maximum number of bushing slips tried if the fit does not follow the readings, where the predicted gain is unreliable.
const BUSHINGS: usize = 8;
/// Effort limit of the search: number of equilibria solved after the fit of the study itself. Beyond it, no further candidate is fitted.
const MAX_EQUILIBRIA: usize = 6_000;
/// Rms of the residuals beyond tolerances, over their noise, below which they count as explained and no slip is searched.
const EXPLAINED: f64 = 1.1;
/// Rms of the residuals beyond tolerances, over their noise, that an understated noise level still explains.
const NOISE: f64 = 2.0;
/// Ratio of the corrected to the original rms below which a slip is certain; half of the squares remain. Effects that a model lacks are not
/// affected by a unit factor and would remain in full.
const MENDED: f64 = 0.7;
/// Ratio of the corrected to the original rms below which a slip is reported as possible.
const BETTER: f64 = 0.9;
/// Residual rms below which a fit follows the readings, relative to their movement, see [`Bench::movement`].
const FOLLOWS: f64 = 0.05;
/// Residual rms below which a fit follows the readings, relative to their noise.
const NEARLY: f64 = 10.0;
/// Residual rms below which a corrected study fits, relative to the movement of the readings, see [`Bench::movement`].
const FITS: f64 = 0.25;
/// Ratio to the lowest residual rms up to which other corrections count as equally good.
const ALIKE: f64 = 1.1;

/// Searches for the slip of a study.
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

/// Returns the change that explains the residuals of the unchanged study; `before` is their rms beyond tolerances.
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
    // A fit that ended before its minimum may end elsewhere after any change.
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

/// Returns the candidates that may explain the residuals of a fit; `before` is their rms beyond tolerances.
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
