use admire_results::Entity;
use admire_session::{InMemoryRun, TrialInput};
use admire_solver::mechanics::{Vec3, euler313, log};
use admire_syntax::text::Source;

use super::deck::Deck;
use super::record::Record;

/// Agreement of a deck with the states of a record.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Repeat {
    /// For each state, the largest distance of a part from its position in the results, in length units; `None` without an equilibrium.
    pub places: Vec<Option<f64>>,
    /// For each state, the largest rotation of a part relative to its orientation in the results, in radians.
    pub turns_rad: Vec<Option<f64>>,
    /// Index of the body with the largest distance of all.
    pub worst: usize,
    /// Message of the first error of the solver.
    pub error: Option<String>,
}

impl Repeat {
    /// Returns the largest distance in a range of states. `None` if a state has no equilibrium.
    pub fn largest(&self, states: std::ops::Range<usize>) -> Option<f64> {
        let mut largest = 0.0_f64;
        for place in self.places.get(states)? {
            largest = largest.max((*place)?);
        }
        Some(largest)
    }
}

/// Solves all states of a record with a deck and compares the poses of all parts.
pub fn repeat(record: &Record, deck: &Deck) -> Repeat {
    let source = Source::new("model.adm", deck.text.as_bytes().to_vec());
    let commands = Source::new("states.acf", deck.commands.as_bytes().to_vec());
    let run = |columns: &[usize]| {
        InMemoryRun::run(TrialInput {
            deck: &source,
            commands: &commands,
            columns,
            ignored: &[],
        })
    };
    // In the results, the parts come first, with six columns each after the time.
    let parts = record.bodies.len() - 1;
    let columns: Vec<usize> = (2..2 + 6 * parts).collect();
    let answer = run(&columns);
    let mut found = Repeat {
        places: vec![None; record.states()],
        turns_rad: vec![None; record.states()],
        worst: 0,
        error: answer.error,
    };
    let Some(catalogue) = answer.catalogue else {
        return found;
    };
    let named = |entity: &&Entity, body: usize| {
        let name = entity.entity.as_deref().unwrap_or_default();
        entity.ent_type.as_deref() == Some("Part")
            && entity.object_id == Some(i64::from(deck.parts[body]))
            && !name.is_empty()
    };
    let mut largest = 0.0_f64;
    for (time, values) in &answer.steps {
        let state = time.round();
        if state < 0.0 || state as usize >= found.places.len() {
            continue;
        }
        let state = state as usize;
        let (mut apart, mut turned) = (0.0_f64, 0.0_f64);
        for body in 1..record.bodies.len() {
            let Some(entity) = catalogue.entities.iter().find(|e| named(e, body)) else {
                continue;
            };
            let value = |name: &str| {
                let id = entity.component(name).map_or(0, |c| c.id);
                columns
                    .iter()
                    .position(|c| *c == id)
                    .map_or(f64::NAN, |at| values[at])
            };
            let place = Vec3::new(value("X"), value("Y"), value("Z"));
            let R = euler313(value("PSI"), value("THETA"), value("PHI"));
            let pose = &record.bodies[body].poses[state];
            let distance = (place - pose.p).norm();
            let turn = log(&(R.transpose() * pose.R)).norm();
            if distance.is_nan() || distance > largest {
                largest = distance;
                found.worst = body;
            }
            apart = if distance.is_nan() {
                f64::NAN
            } else {
                apart.max(distance)
            };
            turned = turned.max(turn);
        }
        found.places[state] = apart.is_finite().then_some(apart);
        found.turns_rad[state] = apart.is_finite().then_some(turned);
    }
    found
}
