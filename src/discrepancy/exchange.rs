//! A hypothesis makes way for two others at once.

use rayon::prelude::*;

use super::effort::Effort;
use super::extended::Fitted;
use super::hypothesis::Hypothesis;
use super::screening::screen;
use super::selection::{
    BETTER, Gained, HOPELESS, MOST, criterion, floor, polished, survivors, with, without,
};
use super::subject::{Data, Subject};

/// Others that are tried in the place of one,
const RIVALS: usize = 3;
/// each with so many companions.
const COMPANIONS: usize = 2;

/// A mimic of two causes comes in first and keeps both out, because either alone does worse in its place. So each hypothesis makes way
/// for a rival together with what then promises most; `None` where no such pair does better.
pub(super) fn exchanged(
    subject: &Subject<'_>,
    (current, best): (&Fitted, f64),
    places: usize,
    (data, gained): (Data, &Gained),
    accept: &dyn Fn(&Hypothesis) -> bool,
) -> Option<(Fitted, f64)> {
    let mut winner: Option<(Fitted, f64)> = None;
    for at in 0..current.chosen.len() {
        if subject.budget.is_spent() {
            break;
        }
        let own = &current.chosen[at];
        if own.cause.of_the_measurement() {
            continue;
        }
        let effort = Effort::candidate(current.minimum.objective);
        let Some(base) = without(subject, current, at, data, effort) else {
            continue;
        };
        let scores = screen(subject, &base);
        let promise = scores.first().map_or(0.0, |score| HOPELESS * score.net);
        let mut instead = survivors(scores, promise.max(0.0), &|h| {
            let kept = &current.chosen;
            accept(h) && !h.same_place(own) && !kept.iter().any(|c| c.same_place(h))
        });
        instead.truncate(RIVALS);
        let singles: Vec<Fitted> = instead
            .par_iter()
            .filter_map(|score| with((subject, data), &base, score, effort))
            .collect();
        let mut room = Vec::new();
        if current.chosen.len() < MOST {
            for single in &singles {
                let mut next = survivors(screen(subject, single), 0.0, &|h| {
                    accept(h) && !h.same_place(own)
                });
                next.truncate(COMPANIONS);
                room.extend(next.into_iter().map(|score| (single, score)));
            }
        }
        let pairs: Vec<Fitted> = room
            .par_iter()
            .filter_map(|(single, score)| with((subject, data), single, score, effort))
            .filter(|found| {
                let last = &found.chosen[found.chosen.len() - 1];
                let rest: Vec<_> = gained
                    .iter()
                    .filter(|(h, _)| !h.same(own))
                    .cloned()
                    .collect();
                best - criterion(found, places) > floor(&rest, last)
            })
            .collect();
        for found in singles.into_iter().chain(pairs) {
            let value = criterion(&found, places);
            if value < winner.as_ref().map_or(best - BETTER, |(_, v)| *v) {
                winner = Some((found, value));
            }
        }
    }
    let (found, _) = winner?;
    let found = polished(subject, found, data);
    let value = criterion(&found, places);
    (value < best - BETTER).then_some((found, value))
}
