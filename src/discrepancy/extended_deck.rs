//! The deck with the statements of some causes, compiled.

use std::sync::Arc;

use super::hypothesis::{Change, Hypothesis};
use super::subject::Subject;
use crate::identify::Problem;
use crate::identify::global::Prepared;
use crate::model::Model;
use crate::syntax::Dataset;
use crate::system::State;

/// A deck extended by some hypotheses, compiled.
#[derive(Debug)]
pub struct ExtendedDeck {
    /// The deck, its numbers as they were.
    pub dataset: Dataset,
    /// The same, lowered.
    pub model: Model,
    /// The same, compiled.
    pub prepared: Arc<Prepared>,
}

/// The deck with the statements of some hypotheses, that of another fit where it is the same.
pub(super) fn deck_of(
    subject: &Subject<'_>,
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
            Change::Add(statement) => dataset.add(statement),
            Change::Text(address, text) => dataset.set_text(address, text).ok()?,
        };
        dataset = dataset.edited(&edits).ok()?.value;
    }
    let model = crate::model::lower(&dataset).value;
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
    }))
}

/// A state of one deck as a first guess for another that has the same parts and joints and perhaps some more parts, which are pieces
/// of old ones and go with them.
pub(super) fn like(deck: &ExtendedDeck, state: &State, theirs: &ExtendedDeck) -> State {
    if std::ptr::eq(deck, theirs) {
        return state.clone();
    }
    let mut new = deck.prepared.system.state();
    if new.multipliers.len() != state.multipliers.len() {
        return new;
    }
    for (k, pose) in new.poses.iter_mut().enumerate() {
        let header = &deck.model.parts[k].header;
        let whole = |other: &crate::model::Part| other.pose == deck.model.parts[k].pose;
        let parts = &theirs.model.parts;
        let at = parts
            .iter()
            .position(|other| other.header.id == header.id)
            .or_else(|| parts.iter().position(whole));
        if let Some(at) = at {
            *pose = state.poses[at];
        }
    }
    new.multipliers.clone_from(&state.multipliers);
    new.redundant.clone_from(&state.redundant);
    new
}
