//! The deck with the statements of some causes, compiled.

use std::sync::Arc;

use super::diagnosis_problem::DiagnosisProblem;
use super::hypothesis::{Change, Hypothesis};
use admire_identify::Problem;
use admire_identify::global::Prepared;
use admire_solver::model::Model;
use admire_solver::system::State;
use admire_syntax::Dataset;

/// A deck extended by some hypotheses, compiled.
#[derive(Debug)]
pub struct ExtendedDeck {
    /// The deck, its numbers as they were.
    pub dataset: Dataset,
    /// The same, lowered.
    pub model: Model,
    /// The same, compiled.
    pub prepared: Arc<Prepared>,
    /// Ids of parts that were pieces of others, and of those.
    pieces: Vec<(u32, u32)>,
}

/// The deck with the statements of some hypotheses, that of another fit where it is the same.
pub(super) fn deck_of(
    subject: &DiagnosisProblem<'_>,
    chosen: &[(Hypothesis, Vec<f64>)],
    warm: Option<(&[Hypothesis], &Arc<ExtendedDeck>)>,
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

/// The part that a change splits off, and that it is a piece of.
fn piece(change: &Change) -> Option<(u32, u32)> {
    match change {
        Change::Piece(part, of) => part.id.map(|part| (part, *of)),
        Change::Add(_) | Change::Text(..) => None,
    }
}

/// A state of one deck as a first guess for another that has the same parts and joints and perhaps some more parts. A piece is where
/// the same piece was, or where the part was that it belongs to: anywhere else its stiff bushing would pull with more than any load.
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
    use super::super::cause::Cause;
    use super::super::scan::Catalogue;
    use super::super::sought::tests::{of_the_axle, shipped_axle};
    use super::*;

    /// The angles of this deck are in degrees. The piece is written in radians, whose last digits are cut off.
    #[test]
    fn a_piece_begins_where_its_part_is() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = of_the_axle(&problem);
        let links = Catalogue::new(&subject, &none).hypotheses;
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
