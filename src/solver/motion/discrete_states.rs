//! The regimes of a motion: pieces of functions that are not smooth, surfaces that stick or slide; and how often they change.

use std::collections::VecDeque;

use super::error::MotionFailure;
use crate::system::{Parameters, Scratch, State, System};

/// More changes of one function than this within so many steps: they are not looked for until it is silent for as many.
const MANY: usize = 50;
const STEPS: usize = 100;
/// More changes of one function than this between two outputs end the motion.
const MOST: usize = 1000;

/// What changes where.
pub(super) enum Change {
    /// A friction, by its number.
    Grip(usize),
    /// A function with pieces, and the piece it goes on with.
    Switch(usize, i64),
}

/// What is known of one function with pieces.
#[derive(Clone, Debug, Default)]
struct History {
    /// Steps after which it changed last.
    recent: VecDeque<usize>,
    /// Changes since the last output.
    count: usize,
    /// It changes too often: its piece is that of its arguments. The piece seen last, and since which step that is so.
    suspended: Option<(Option<i64>, usize)>,
}

/// The regimes of a motion. Which they are stands in its state.
#[derive(Debug)]
pub(super) struct Regimes {
    pub(super) scratch: Scratch,
    /// Surface speeds of frictions less those of stiction.
    pub(super) slips: Vec<f64>,
    switches: Vec<History>,
    /// The output interval that changes are counted in.
    interval: f64,
    /// When the motion began.
    start: f64,
    /// The function that changed last, and when.
    last: Option<(f64, usize)>,
}

impl Regimes {
    /// Nothing, if the system has no regimes; else the state is put on the pieces of its functions.
    pub(super) fn new(
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Option<Box<Self>> {
        if !system.has_friction() && system.switches.is_empty() {
            return None;
        }
        state.pieces = vec![None; system.switches.len()];
        let mut new = Box::new(Self {
            scratch: Scratch::new(system),
            slips: Vec::new(),
            switches: vec![History::default(); system.switches.len()],
            interval: 0.0,
            start: state.time,
            last: None,
        });
        new.hold(system, parameters, state);
        Some(new)
    }

    /// Holds functions that were not held on the pieces of their arguments, and lets those go that are not evaluated.
    pub(super) fn hold(&mut self, system: &System, parameters: &Parameters, state: &mut State) {
        if system
            .evaluate(parameters, state, &mut self.scratch)
            .is_err()
        {
            return;
        }
        self.keep(state);
    }

    /// The same by what was seen last.
    fn keep(&self, state: &mut State) {
        let all = state.pieces.iter_mut().zip(&self.scratch.seen);
        for ((piece, seen), history) in all.zip(&self.switches) {
            *piece = match (history.suspended, seen.piece) {
                (Some(_), _) | (_, None) => None,
                (None, Some(natural)) => Some(piece.unwrap_or(natural)),
            };
        }
    }

    /// A step is done in which nothing changed: functions that were let go and are silent since long are held again.
    pub(super) fn step_done(&mut self, state: &mut State, steps: usize) {
        for (history, seen) in self.switches.iter_mut().zip(&self.scratch.seen) {
            if let Some((piece, since)) = &mut history.suspended {
                if *piece != seen.piece {
                    (*piece, *since) = (seen.piece, steps);
                } else if steps - *since >= STEPS {
                    history.suspended = None;
                }
            }
        }
        self.keep(state);
    }

    /// Takes functions that changed as their arguments have them, until they are silent; false if none did.
    pub(super) fn suspend(&mut self, changed: &[Change], steps: usize) -> bool {
        for change in changed {
            if let Change::Switch(k, _) = change {
                self.switches[*k].suspended = Some((None, steps));
            }
        }
        changed
            .iter()
            .any(|change| matches!(change, Change::Switch(..)))
    }

    /// Counts a change of a function.
    pub(super) fn count_switches(
        &mut self,
        system: &System,
        k: usize,
        (time, output): (f64, f64),
        steps: usize,
    ) -> Result<(), MotionFailure> {
        let interval = ((time - self.start) / output).floor();
        if interval != self.interval {
            self.interval = interval;
            for history in &mut self.switches {
                history.count = 0;
            }
        }
        self.last = Some((time, k));
        // The time goes on whatever the function does: what it alone chooses does not chatter.
        if system.switches[k].of_time {
            return Ok(());
        }
        let history = &mut self.switches[k];
        history.count += 1;
        if history.count > MOST {
            return Err(MotionFailure::Chatter {
                function: owner(system, k),
                count: MOST,
            });
        }
        history.recent.push_back(steps);
        if history.recent.len() > MANY {
            let first = history.recent.pop_front().unwrap_or(0);
            if steps - first < STEPS {
                history.suspended = Some((None, steps));
                history.recent.clear();
            }
        }
        Ok(())
    }

    /// What changed last, for messages.
    pub(super) fn told(&self, system: &System) -> String {
        let Some((time, k)) = self.last else {
            return String::new();
        };
        let name = owner(system, k);
        if self.switches[k].suspended.is_some() {
            format!("; the function of {name} switches over and over, last at time {time}")
        } else {
            format!("; the function of {name} switched at time {time}")
        }
    }
}

/// The statement of a function with pieces.
fn owner(system: &System, k: usize) -> String {
    let function = system.switches[k].function;
    system.functions[function].owner.to_string()
}
