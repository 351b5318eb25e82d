//! Search for the single change of the input that makes a study fit its readings.

use super::bench::{Bench, Trial};
use super::candidate::{Candidate, Family, acting, families};
use super::thinned::thinned;
use crate::LoadedStudy;
use crate::settings::{
    SLIP_CERTAIN_RATIO, SLIP_EQUAL_RATIO, SLIP_EXPLAINED_RMS_SIGMA, SLIP_FITS_MOVEMENT,
    SLIP_FOLLOWS_MOVEMENT, SLIP_FOLLOWS_RMS_SIGMA, SLIP_MAX_BUSHINGS, SLIP_MAX_EQUILIBRIA,
    SLIP_MIN_GAIN, SLIP_MIN_SPARE_CASES, SLIP_NOISE_RMS_SIGMA, SLIP_POSSIBLE_RATIO,
    SLIP_ROUND_CANDIDATES, SLIP_ROUND_STEPS, SLIP_UNCHANGED_MAX_STEPS,
};

/// A slip in the input that explains the residuals of a study. Neither the unknowns nor tolerances can explain these residuals.
#[derive(Clone, PartialEq, Debug)]
pub struct Slip {
    /// Descriptions of the correction. There are several if the readings cannot distinguish between several possible corrections.
    pub remedies: Vec<String>,
    /// Rms of the residuals that tolerances cannot absorb, in units of their noise: first for the unchanged study (`None` without equilibria),
    /// then for the corrected study.
    pub left: (Option<f64>, f64),
    /// True if the slip is certain; false if its correction merely improves the fit.
    pub is_sure: bool,
}

/// Result of the search for a slip.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Search {
    /// Slip that explains the residuals, if there is one.
    pub slip: Option<Slip>,
    /// True if the unchanged study can explain its readings. Anomalies at its starting values are then irrelevant.
    pub is_explained: bool,
}

/// Searches a study for a slip in its input.
pub fn search(loaded: &LoadedStudy) -> Search {
    let cases = loaded.measurement.fitted_cases().count();
    if cases < acting(&loaded.programme).len() + 1 + SLIP_MIN_SPARE_CASES {
        return Search::default();
    }
    let Some(bench) = Bench::new(thinned(loaded)) else {
        return Search::default();
    };
    let now = bench.fit(None, None, SLIP_UNCHANGED_MAX_STEPS);
    let before = now
        .as_ref()
        .and_then(|now| bench.beyond_tolerances(None, &now.x));
    let is_below = |most: f64| before.is_some_and(|before| before < most);
    Search {
        slip: if is_below(SLIP_EXPLAINED_RMS_SIGMA) {
            None
        } else {
            slip(&bench, now.as_ref(), before)
        },
        is_explained: is_below(SLIP_NOISE_RMS_SIGMA),
    }
}

/// Returns the slip whose correction explains the residuals of the unchanged study. `now` is the fit of the unchanged study, `before` the rms
/// of its residuals that tolerances cannot absorb.
fn slip(bench: &Bench, now: Option<&Trial>, before: Option<f64>) -> Option<Slip> {
    let candidates = promising(bench, now, before).into_iter();
    let mut tried: Vec<(Option<Trial>, Candidate)> = candidates.map(|c| (None, c)).collect();
    let most_solved = bench.solved() + SLIP_MAX_EQUILIBRIA;
    for (most, steps) in SLIP_ROUND_CANDIDATES.into_iter().zip(SLIP_ROUND_STEPS) {
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
    // A fit that ended before its minimum may improve by chance after any change, so the corrected study must also fit in absolute terms.
    let is_minimum = now.is_some_and(|now| now.is_minimum);
    let fits = is_minimum || after < SLIP_FITS_MOVEMENT * bench.movement();
    let is_sure = fits
        && before.is_none_or(|before| {
            before > SLIP_NOISE_RMS_SIGMA && after < SLIP_CERTAIN_RATIO * before
        });
    let is_better = before.is_some_and(|before| after < SLIP_POSSIBLE_RATIO * before);
    let alike = left
        .into_iter()
        .take_while(|(other, _)| *other <= SLIP_EQUAL_RATIO * after);
    (is_sure || is_better).then(|| Slip {
        remedies: alike.map(|(_, remedy)| remedy).collect(),
        left: (before, after),
        is_sure,
    })
}

/// Returns the candidates that may explain the residuals of the fit `now`, most promising first. `before` is the rms of these residuals that
/// tolerances cannot absorb.
fn promising(bench: &Bench, now: Option<&Trial>, before: Option<f64>) -> Vec<Candidate> {
    let families = families(bench.study());
    let gains = now.and_then(|now| bench.gains(&families, &now.x));
    let gains = gains.unwrap_or_else(|| vec![f64::INFINITY; families.len()]);
    let follows = before.is_some_and(|before| {
        before < SLIP_FOLLOWS_RMS_SIGMA.max(SLIP_FOLLOWS_MOVEMENT * bench.movement())
    });
    let mut all: Vec<(f64, Family)> = gains.into_iter().zip(families).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut bushings = 0;
    all.retain(|(gain, family)| {
        bushings += usize::from(family.is_of_a_bushing);
        if follows {
            *gain > SLIP_MIN_GAIN
        } else {
            !family.is_of_a_bushing || bushings <= SLIP_MAX_BUSHINGS
        }
    });
    let families = all.into_iter();
    families.flat_map(|(_, family)| family.candidates).collect()
}
