//! Deck extended by the statements of some causes, and compiled.

use std::sync::Arc;

use super::candidate_effect::{CandidateEffect, Change};
use super::diagnosis_problem::DiagnosisProblem;
use admire_identify::Problem;
use admire_identify::global::Prepared;
use admire_solver::model::Model;
use admire_solver::system::State;
use admire_syntax::Dataset;

/// Deck extended by the statements of some effects, and its compiled model.
#[derive(Debug)]
pub struct ExtendedDeck {
    /// Statements of the extended deck, before its parameters are fitted.
    pub dataset: Dataset,
    /// Model lowered from the statements.
    pub model: Model,
    /// Compiled model.
    pub prepared: Arc<Prepared>,
    /// Pairs of part ids: a split-off part, and the part it was split from.
    pieces: Vec<(u32, u32)>,
}

/// Returns the deck extended by the `chosen` effects, or `None` if that deck cannot be compiled. Reuses the deck of `warm` if both have the
/// same extensions.
pub(super) fn deck_of(
    subject: &DiagnosisProblem<'_>,
    chosen: &[(CandidateEffect, Vec<f64>)],
    warm: Option<(&[CandidateEffect], &Arc<ExtendedDeck>)>,
) -> Option<Arc<ExtendedDeck>> {
    let changes = || chosen.iter().flat_map(|(h, _)| &h.changes);
    let plans = || chosen.iter().filter_map(|(h, _)| h.memory.as_ref());
    let same = warm.filter(|(theirs, _)| {
        let theirs = theirs.iter();
        changes().eq(theirs.clone().flat_map(|h| &h.changes))
            && plans().eq(theirs.filter_map(|h| h.memory.as_ref()))
    });
    if let Some((_, deck)) = same {
        return Some(Arc::clone(deck));
    }
    let mut dataset = subject.problem.dataset.clone();
    for change in changes() {
        let edits = match change {
            Change::Add(statement) | Change::Piece(statement, _) => dataset.add(statement),
            Change::Text(address, text) => dataset.set_text(address, text).ok()?,
        };
        dataset = dataset.edited(&edits).ok()?.value;
    }
    let model = admire_solver::model::lower(&dataset).value;
    let extended = Problem {
        dataset: &dataset,
        model: &model,
        ..subject.problem.clone()
    };
    let measures: Vec<String> = plans().map(|plan| plan.measure.clone()).collect();
    let prepared = Prepared::with(&extended, &measures).ok()?;
    Some(Arc::new(ExtendedDeck {
        dataset,
        model,
        prepared: Arc::new(prepared),
        pieces: changes().filter_map(piece).collect(),
    }))
}

/// Returns the ids of the part that a change splits off and of the part it is split from.
fn piece(change: &Change) -> Option<(u32, u32)> {
    match change {
        Change::Piece(part, of) => part.id.map(|part| (part, *of)),
        Change::Add(_) | Change::Text(..) => None,
    }
}

/// Converts `state`, a state of the deck `theirs`, to an initial state of the deck `deck`, which may have further parts. A split-off part
/// starts at its own pose in `state`, or else at the pose of the part it was split from. At any other pose its stiff bushing would exert a
/// force larger than any load.
pub(super) fn like(deck: &ExtendedDeck, state: &State, theirs: &ExtendedDeck) -> State {
    if std::ptr::eq(deck, theirs) {
        return state.clone();
    }
    let mut new = deck.prepared.system.state();
    if new.multipliers.len() != state.multipliers.len() {
        return new;
    }
    for (pose, part) in new.poses.iter_mut().zip(&deck.model.parts) {
        let id = part.header.id;
        let own = deck.pieces.iter().find(|(piece, _)| *piece == id);
        let known = match own {
            Some(piece) if !theirs.pieces.contains(piece) => piece.1,
            _ => id,
        };
        let mut parts = theirs.model.parts.iter();
        if let Some(at) = parts.position(|other| other.header.id == known) {
            *pose = state.poses[at];
        }
    }
    new.multipliers.clone_from(&state.multipliers);
    new.redundant.clone_from(&state.redundant);
    new
}

#[cfg(test)]
mod tests {
    use super::super::base_fit::tests::{axle_problem, shipped_axle};
    use super::super::cause::Cause;
    use super::super::causes;
    use super::super::operating_points::OperatingPoints;
    use super::*;

    /// Checks the start pose of a split-off part. The deck has angles in degrees; the statement of the part has angles in radians, with
    /// truncated digits.
    #[test]
    fn a_piece_begins_where_its_part_is() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = axle_problem(&problem);
        let links = causes::all(&OperatingPoints::new(&subject, &none));
        let links = links
            .iter()
            .filter(|h| h.cause == Cause::LinkCompliance || h.cause == Cause::FreePlay);
        let mut count = 0;
        for link in links {
            let guesses = vec![0.0; link.numbers.len()];
            let deck = deck_of(&subject, &[(link.clone(), guesses)], None).expect("a deck");
            let at = |id: u32| deck.model.parts.iter().position(|p| p.header.id == id);
            for state in &none.states {
                let begun = like(&deck, state, &none.deck);
                for (piece, part) in &deck.pieces {
                    let [piece, part] = [piece, part].map(|id| at(*id).expect("in the deck"));
                    assert_eq!(begun.poses[piece], state.poses[part], "{link}");
                    count += 1;
                }
            }
        }
        assert!(count > 0);
    }
}
