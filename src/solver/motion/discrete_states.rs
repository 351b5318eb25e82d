//! Discrete states of a motion: the pieces on which piecewise functions are held, and whether surfaces stick or slide.
//!
//! A function that is held on a piece uses the formula of that piece even where its arguments select another piece. Switches between pieces are
//! counted to detect chatter.

use std::collections::VecDeque;

use super::error::MotionFailure;
use crate::system::{Parameters, Scratch, State, System};

/// Number of switches of one function within [`STEPS`] time steps above which the function is suspended (no longer held on a piece).
const MANY: usize = 50;
/// Number of time steps over which switches are counted. A suspended function that does not switch during this number of time steps is held
/// again.
const STEPS: usize = 100;
/// Number of switches of one function in one output interval above which the motion ends with an error.
const MOST: usize = 1000;

/// A change of a discrete state.
pub(super) enum Change {
    /// Friction (by index) that changes between sticking and sliding.
    StickSlip(usize),
    /// Piecewise function (by index) that switches, and the piece to which it switches.
    Switch(usize, i64),
}

/// Switching history of one piecewise function.
#[derive(Clone, Debug, Default)]
struct History {
    /// Time-step counts at the latest switches.
    recent: VecDeque<usize>,
    /// Number of switches since the last output.
    count: usize,
    /// Set while the function switches too often to be held on a piece. Contains the piece that its arguments selected last, and the time-step
    /// count since which this piece has not changed.
    suspended: Option<(Option<i64>, usize)>,
}

/// Bookkeeping of the discrete states of a motion. The discrete states themselves are part of [`State`].
#[derive(Debug)]
pub(super) struct DiscreteStates {
    pub(super) scratch: Scratch,
    /// Surface speed minus stiction velocity of each friction; NaN for a friction that cannot stick.
    pub(super) slips: Vec<f64>,
    switches: Vec<History>,
    /// Index of the output interval in which switches are being counted.
    interval: f64,
    /// Start time of the motion.
    start: f64,
    /// Time of the last switch, and index of the function that switched.
    last: Option<(f64, usize)>,
}

impl DiscreteStates {
    /// Holds the piecewise functions of the state on their present pieces and creates the bookkeeping. Returns `None` if the system has no
    /// discrete states.
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

    /// Holds each function that is not yet held on the piece that its arguments select. Releases the functions that are not evaluated in this
    /// state.
    pub(super) fn hold(&mut self, system: &System, parameters: &Parameters, state: &mut State) {
        if system
            .evaluate(parameters, state, &mut self.scratch)
            .is_err()
        {
            return;
        }
        self.keep(state);
    }

    /// Holds and releases functions like [`Self::hold`], but takes the pieces from the last evaluation instead of a new one.
    fn keep(&self, state: &mut State) {
        let all = state.pieces.iter_mut().zip(&self.scratch.seen);
        for ((piece, seen), history) in all.zip(&self.switches) {
            *piece = match (history.suspended, seen.piece) {
                (Some(_), _) | (_, None) => None,
                (None, Some(natural)) => Some(piece.unwrap_or(natural)),
            };
        }
    }

    /// Records a time step in which no discrete state changed. Suspended functions that have not switched for [`STEPS`] time steps are held again.
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

    /// Suspends the changed functions: their arguments select the pieces until they stop switching. Returns false if `changed` contains no
    /// switch of a function.
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

    /// Counts a switch of function `k`, and suspends the function if it switches too often. `output` is the length of an output interval.
    ///
    /// # Errors
    /// Returns [`MotionFailure::Chatter`] if the function switches more than [`MOST`] times in one output interval.
    pub(super) fn count_switches(
        &mut self,
        system: &System,
        k: usize,
        time: f64,
        output: f64,
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
        // Switches that depend on time alone do not count as chatter, because time always advances.
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

    /// Describes the last switch, for error messages. The text is empty if no function has switched.
    pub(super) fn describe(&self, system: &System) -> String {
        let Some((time, k)) = self.last else {
            return String::new();
        };
        let name = owner(system, k);
        if self.switches[k].suspended.is_some() {
            format!("; the function of {name} switches repeatedly, last at time {time}")
        } else {
            format!("; the function of {name} switched at time {time}")
        }
    }
}

/// Returns the name of the statement that contains piecewise function `k`.
fn owner(system: &System, k: usize) -> String {
    let function = system.switches[k].function;
    system.functions[function].owner.to_string()
}
